//! The files that a render leaves: checked before the work, written after it.

use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use pdembree::film::Image;
use pdembree::output::denoise::{WANTED_LAYERS, denoise};
use pdembree::output::exr::Window;
use pdembree::output::part::EXTENSION;
use pdembree::output::target::probe;
use pdembree::output::{BirthCertificate, ChannelNames, Format, PartInfo, Target, WriteError, cryptomatte, exr, png};
use pdembree::render::RenderState;
use pdembree::render::progress::Progress;
use pdembree::render::store;
use pdembree::scene::settings::Layer;

use super::failure::{Failure, code};
use super::number::finite;

/// Options of every command that writes a picture.
#[derive(clap::Args)]
pub struct OutputArgs {
    /// Picture to write; .exr: linear light and all layers, .png: 8-bit sRGB, .pdpart: sums, for `pdembree merge`
    #[arg(short, long, visible_alias = "outfile", value_name = "FILE")]
    pub output: PathBuf,
    /// Write a PNG of the beauty too
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// Multiply PNGs by 2^STOPS
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = finite, allow_negative_numbers = true)]
    pub exposure: f64,
    /// Names of the EXR's channels: our own, or those that pbrt's imgtool or Blender look for
    #[arg(long, value_name = "NAMES", default_value = "own", value_parser = PossibleValuesParser::new(ChannelNames::NAMES))]
    pub exr_names: String,
    /// Take the noise of the picture away by Intel Open Image Denoise, if it is installed; `on` says so if it is not.
    /// Caustics stay as they are; what was rendered is kept in the layer `noisy`
    #[arg(long, value_name = "WHEN", default_value = "off", value_parser = PossibleValuesParser::new(["auto", "on", "off"]))]
    pub denoise: String,
    /// Denoise caustics, too
    #[arg(long)]
    pub denoise_caustics: bool,
    /// Make the folders of the outputs
    #[arg(long)]
    pub make_path: bool,
    /// Leave times, threads and the command out of the EXR's header, so that equal renders are equal files
    #[arg(long)]
    pub no_timestamps: bool,
    /// Write what happened (times, counters by light, refused samples, hashes) as JSON to this file too
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,
}

impl OutputArgs {
    /// The same as arguments of `merge`, but for the picture itself; `absolute` makes paths mean the same everywhere.
    pub fn merge_arguments(
        &self,
        absolute: impl Fn(&Path) -> Result<PathBuf, Failure>,
    ) -> Result<Vec<String>, Failure> {
        let mut all = vec![format!("--exposure={}", self.exposure), format!("--exr-names={}", self.exr_names)];
        all.push(format!("--denoise={}", self.denoise));
        for (name, path) in [("--png", &self.png), ("--stats", &self.stats)] {
            if let Some(path) = path {
                all.push(format!("{name}={}", absolute(path)?.display()));
            }
        }
        let flags = [
            ("--make-path", self.make_path),
            ("--no-timestamps", self.no_timestamps),
            ("--denoise-caustics", self.denoise_caustics),
        ];
        all.extend(flags.iter().filter(|(_, given)| *given).map(|(name, _)| (*name).to_owned()));
        Ok(all)
    }
}

impl OutputArgs {
    /// Layers that denoising needs, if it is wanted.
    pub fn add_layers(&self, layers: &mut Vec<Layer>) {
        let wanted = WANTED_LAYERS.iter().filter_map(|name| Layer::from_name(name)).filter(|_| self.denoise != "off");
        let missing: Vec<Layer> = wanted.filter(|layer| !layers.contains(layer)).collect();
        layers.extend(missing);
    }

    /// The picture as it is wanted, and what is to be said about it. A picture that cannot be denoised is a picture.
    pub fn finished(&self, picture: Image) -> (Image, Option<String>) {
        if self.denoise == "off" {
            return (picture, None);
        }
        match denoise(&picture, self.denoise_caustics) {
            Ok(smooth) => (smooth, None),
            Err(error) if error.is_absent() && self.denoise == "auto" => (picture, None),
            Err(error) => (picture, Some(format!("not denoised: {error}"))),
        }
    }
}

/// Files that can be written, as far as one can know before the work.
pub struct Outputs<'a> {
    args: &'a OutputArgs,
    /// None if only the sums are wanted.
    picture: Option<Target>,
    /// The sums, where this is a part of a render.
    part: Option<PathBuf>,
    png: Option<Target>,
}

/// `a.exr` → `a.pdpart`.
pub fn part_beside(path: &Path) -> PathBuf {
    path.with_extension(EXTENSION)
}

/// `a.exr` → `a.snapshot.exr`.
pub fn snapshot_beside(path: &Path) -> PathBuf {
    path.with_extension("snapshot.exr")
}

impl<'a> Outputs<'a> {
    /// Checks the names only.
    pub fn check_names(args: &OutputArgs) -> Result<(), Failure> {
        if !is_part(&args.output) {
            Format::of(&args.output)?;
        }
        Ok(())
    }

    /// `is_part`: what is rendered is not the whole picture, and its sums are kept.
    pub fn check(args: &'a OutputArgs, is_a_part: bool) -> Result<Outputs<'a>, Failure> {
        let make = args.make_path;
        let (picture, part) = if is_part(&args.output) {
            probe(&args.output, make)?;
            (None, Some(args.output.clone()))
        } else {
            let picture = Target::picture(&args.output, make)?;
            let part = is_a_part.then(|| part_beside(&args.output));
            (Some(picture), part)
        };
        for path in part.iter().chain(&args.stats).chain([&BirthCertificate::path_beside(&args.output)]) {
            probe(path, make)?;
        }
        let png = args.png.as_deref().map(|path| Target::picture(path, make)).transpose()?;
        match png {
            Some(png) if png.format() != Format::Png => {
                let message = format!("{}: --png writes PNG; end the name in .png", png.path().display());
                Err(Failure::new(code::USAGE, message))
            }
            png => Ok(Outputs { args, picture, part, png }),
        }
    }

    /// The file with the sums, where one is wanted.
    pub fn part(&self) -> Option<&Path> {
        self.part.as_deref()
    }

    /// Whether all files but the sums are there.
    pub fn exist(&self) -> bool {
        let pictures = self.picture.iter().chain(&self.png).map(Target::path);
        pictures.chain(self.args.stats.as_deref()).all(Path::is_file)
    }

    /// The sums and the picture first: they are what cannot be made again in a second.
    pub fn write(
        &self,
        info: &PartInfo,
        state: &RenderState,
        image: &Image,
        certificate: &BirthCertificate,
        progress: &dyn Progress,
    ) -> Result<(), WriteError> {
        progress.phase("write", 1);
        if let Some(part) = &self.part {
            store::save(part, info, state)?;
        }
        let bounds = state.film.bounds();
        let window = Window { origin: [bounds.x0, bounds.y0], whole: info.identity.resolution };
        let attributes = certificate.attributes(!self.args.no_timestamps);
        let names = ChannelNames::from_name(&self.args.exr_names).unwrap_or_default();
        let mattes = cryptomatte::attributes(state.film.layout(), names);
        for target in self.picture.iter().chain(&self.png) {
            match target.format() {
                Format::Exr => exr::write_named(target.path(), image, window, &attributes, (names, &mattes))?,
                Format::Png => png::write(target.path(), image, self.args.exposure)?,
            }
        }
        certificate.write_beside(&self.args.output)?;
        if let Some(stats) = &self.args.stats {
            certificate.write(stats)?;
        }
        progress.finish();
        Ok(())
    }
}

fn is_part(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(EXTENSION))
}

/// The failure of a write at the end of the work, after the sums were saved where there is room.
pub fn rescued(error: WriteError, info: &PartInfo, state: &RenderState) -> Failure {
    let name = format!("pdembree-rescued-{}.{EXTENSION}", std::process::id());
    let path = std::env::temp_dir().join(name);
    let mut failure = Failure::from(error);
    failure.message += &match store::save(&path, info, state) {
        Ok(()) => {
            let path = path.display();
            format!(
                "; the work is not lost: `pdembree merge --partial {path} -o PLACE.exr` writes the picture elsewhere"
            )
        }
        Err(error) => format!("; saving the work elsewhere failed too: {error}"),
    };
    failure
}
