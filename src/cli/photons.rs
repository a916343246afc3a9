//! `pdembree photons SCENE -o map.ply`

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use pdembree::output::target::probe;
use pdembree::output::{DumpedPhoton, photon_dump};
use pdembree::photon::Photon;
use pdembree::render::photon_map::shoot_all;
use pdembree::render::progress::Progress;

use super::console::{Verbosity, note};
use super::failure::{Failure, code};
use super::scene::SceneArgs;
use super::work::{WorkArgs, world};

/// Write the photon map of the first pass as PLY: positions and footprint ellipses
///
/// Blender and MeshLab open the file: a point for each photon and a polygon for the footprint that its differentials
/// span, widened as the estimate does it.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// File to write, .ply
    #[arg(short, long, visible_alias = "outfile", value_name = "FILE")]
    output: PathBuf,
    /// Corners of an ellipse
    #[arg(long, value_name = "N", default_value = "12", value_parser = clap::value_parser!(u8).range(3..))]
    segments: u8,
    /// Write only one photon of N
    #[arg(long, value_name = "N", default_value = "1")]
    every: NonZeroUsize,
    /// Make the folder of the output
    #[arg(long)]
    make_path: bool,
    #[command(flatten)]
    work: WorkArgs,
}

pub fn run(args: &Args, verbosity: Verbosity) -> Result<ExitCode, Failure> {
    if args.output.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("ply")) {
        let message = format!("{}: photons are written as PLY; end the name in .ply", args.output.display());
        return Err(Failure::new(code::USAGE, message));
    }
    args.work.start_threads()?;
    let loaded = args.scene.load(verbosity)?;
    probe(&args.output, args.make_path)?;
    let reporter = args.work.reporter(verbosity);
    let world = world(loaded.scene)?;
    let map = shoot_all(&world, 0, &reporter);
    world.textures.check().map_err(|error| Failure::new(code::FAILED, error.to_string()))?;
    reporter.phase("write", 1);
    let dumped: Vec<DumpedPhoton> = map.photons.iter().step_by(args.every.get()).map(dump).collect();
    photon_dump::write(&args.output, &dumped, args.segments.into())?;
    reporter.finish();
    reporter.end();
    let (stored, emitted) = (map.counts.photons_stored, map.counts.photons_emitted);
    let message = format!("{} with {} of {stored} photons, {emitted} emitted", args.output.display(), dumped.len());
    note(verbosity, "done", &message);
    Ok(ExitCode::SUCCESS)
}

fn dump(photon: &Photon) -> DumpedPhoton {
    let frame = photon.frame();
    let ([minor, major], direction) = photon.form().principal();
    let along =
        |x: f64, y: f64, squared: f64| ((frame.t * x + frame.b * y) * squared.sqrt()).to_array().map(|v| v as f32);
    DumpedPhoton {
        position: photon.position().to_array().map(|v| v as f32),
        normal: photon.normal().to_array().map(|v| v as f32),
        flux: photon.flux().0.to_array().map(|v| v as f32),
        axes: [along(direction.x, direction.y, major), along(-direction.y, direction.x, minor)],
    }
}
