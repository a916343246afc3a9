//! `pdembree render SCENE -o out.exr`

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use pdembree::output::sidecar::Phase;
use pdembree::output::target::probe;
use pdembree::output::{BirthCertificate, Format, Target, exr, png};
use pdembree::render::progress::Progress;
use pdembree::render::{RenderState, render};
use pdembree::scene::RenderSettings;
use pdembree::scene::settings::Method;
use pdembree::world::World;

use super::certificate::{Circumstances, certificate};
use super::console::{Verbosity, note};
use super::failure::{Failure, code};
use super::number::finite;
use super::progress::duration;
use super::scene::SceneArgs;
use super::work::{WorkArgs, world};

/// Render a scene into a picture
///
/// Beside the picture out.exr stands its birth certificate, out.exr.json: what made it, from what, with which settings
/// and seed, and what happened on the way. Files are written whole or not at all.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Picture to write; .exr: linear light and all layers, .png: 8-bit sRGB
    #[arg(short, long, visible_alias = "outfile", value_name = "FILE")]
    output: PathBuf,
    /// Write a PNG of the beauty too
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Multiply PNGs by 2^STOPS
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = finite, allow_negative_numbers = true)]
    exposure: f64,
    /// Make the folders of the outputs
    #[arg(long)]
    make_path: bool,
    /// Leave times, threads and the command out of the EXR's header, so that equal renders are equal files
    #[arg(long)]
    no_timestamps: bool,
    #[command(flatten)]
    work: WorkArgs,
}

pub fn run(args: &Args, verbosity: Verbosity) -> Result<ExitCode, Failure> {
    let start = Instant::now();
    // A wrong name is told before a large scene is read; folders are made only for a good scene.
    Format::of(&args.output)?;
    let loaded = args.scene.load(verbosity)?;
    let outputs = Outputs::check(args)?;
    let threads = args.work.start_threads()?;
    let reporter = args.work.reporter(verbosity, phases(&loaded.scene.settings));

    reporter.phase("scene", 1);
    let world = world(loaded.scene)?;
    reporter.finish();
    let rendered = render(&world, &reporter).map_err(|error| Failure::new(code::BAD_DATA, error.to_string()))?;

    let mut warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    let found = findings(&world, &rendered);
    warnings.extend(found.iter().cloned());
    let circumstances = |phases: Vec<Phase>| Circumstances {
        scene: args.scene.scene.clone(),
        threads,
        seconds: start.elapsed().as_secs_f64(),
        phases,
        warnings,
    };
    let certificate = certificate(&world, &rendered, circumstances(reporter.phases()));
    outputs.write(args, &rendered, &certificate, &reporter)?;
    reporter.end();

    found.iter().for_each(|warning| note(verbosity, "warning", warning));
    note(verbosity, "done", &farewell(&args.output, &certificate));
    if verbosity.verbose {
        details(&certificate, verbosity);
    }
    Ok(ExitCode::SUCCESS)
}

/// How many phases a render announces: the scene, those of each pass, the writing.
fn phases(settings: &RenderSettings) -> u64 {
    let in_a_pass = match settings.method {
        Method::PhotonMap => 2,
        Method::LightTrace => 3,
        Method::Path => 1,
    };
    2 + in_a_pass * u64::from(settings.passes)
}

/// Files that can be written, as far as one can know before the work.
struct Outputs {
    picture: Target,
    png: Option<Target>,
}

impl Outputs {
    fn check(args: &Args) -> Result<Outputs, Failure> {
        let picture = Target::picture(&args.output, args.make_path)?;
        probe(&BirthCertificate::path_beside(&args.output), args.make_path)?;
        let png = args.png.as_deref().map(|path| Target::picture(path, args.make_path)).transpose()?;
        match png {
            Some(png) if png.format() != Format::Png => {
                let message = format!("{}: --png writes PNG; end the name in .png", png.path().display());
                Err(Failure::new(code::USAGE, message))
            }
            png => Ok(Outputs { picture, png }),
        }
    }

    /// The picture first: it is what cannot be made again in a second.
    fn write(
        &self,
        args: &Args,
        rendered: &RenderState,
        certificate: &BirthCertificate,
        progress: &dyn Progress,
    ) -> Result<(), Failure> {
        progress.phase("write", 1);
        let image = rendered.film.resolve();
        let path = self.picture.path();
        match self.picture.format() {
            Format::Exr => exr::write(path, &image, &certificate.attributes(!args.no_timestamps))?,
            Format::Png => png::write(path, &image, args.exposure)?,
        }
        if let Some(png) = &self.png {
            png::write(png.path(), &image, args.exposure)?;
        }
        certificate.write_beside(path)?;
        progress.finish();
        Ok(())
    }
}

/// What happened that the user should know: every fallback is told.
fn findings(world: &World, rendered: &RenderState) -> Vec<String> {
    let refused = rendered.film.refused();
    let photons = &rendered.report.photons;
    let mut found = Vec::new();
    if refused.total() > 0 {
        let first = refused
            .first
            .first()
            .map_or_else(String::new, |r| format!("; the first in pixel ({}, {}) of pass {}", r.x, r.y, r.pass));
        found.push(format!(
            "{} eye samples were left out: {} not a number, {} too large, {} negative{first}",
            refused.total(),
            refused.not_a_number,
            refused.too_large,
            refused.negative
        ));
    }
    if rendered.report.invalid_rays > 0 {
        found.push(format!("{} rays were not finite and hit nothing", rendered.report.invalid_rays));
    }
    let broken = photons.broken_columns + photons.broken_flux;
    if broken > 0 {
        found.push(format!("{broken} photons were dropped because their differentials or flux were not finite"));
    }
    if world.scene.settings.method == Method::PhotonMap && world.aim.is_some() && photons.photons_stored == 0 {
        found.push("no photon was stored: no light reaches a matt surface over a specular one".to_owned());
    }
    found
}

fn farewell(output: &Path, certificate: &BirthCertificate) -> String {
    let photons = match certificate.photons_emitted {
        0 => String::new(),
        emitted => format!(", {} of {emitted} photons stored", certificate.photons_stored),
    };
    let memory = certificate.peak_memory_bytes.map_or_else(String::new, |b| format!(", {} MiB", b >> 20));
    format!("{} in {}{photons}{memory}", output.display(), duration(certificate.seconds))
}

fn details(certificate: &BirthCertificate, verbosity: Verbosity) {
    let tell = |kind: &str, text: String| note(verbosity, kind, &text);
    tell("backend", certificate.backend.version.clone());
    tell("threads", certificate.threads.to_string());
    certificate.phases.iter().for_each(|phase| tell("time", format!("{} {}", phase.name, duration(phase.seconds))));
    certificate.counters.iter().for_each(|(name, count)| tell("count", format!("{name} {count}")));
}
