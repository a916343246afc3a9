//! One render of a study: done once, kept on disk, found there the next time.
//!
//! A finished render is `renders/NAME.exr`, `NAME.png` and, written last, `NAME.json`. The name ends in a digest of all
//! that the picture and its time depend on: the scene with its settings, the budget, the program.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::error::StudyError;
use crate::film::Image;
use crate::import::{self, Override};
use crate::output::sidecar::Program;
use crate::output::{atomic, exr, png};
use crate::render::progress::Silent;
use crate::render::render_while;
use crate::scene::Scene;
use crate::scene::settings::Method;
use crate::world::World;

/// Folder of the renders below that of the report.
const FOLDER: &str = "renders";

/// What is rendered.
#[derive(Clone, Debug)]
pub struct Order<'a> {
    pub scene: &'a Path,
    pub overrides: Vec<Override>,
    /// Layer that is kept; empty: the beauty.
    pub layer: &'a str,
    /// Passes are rendered until this time is over, instead of the number that the settings say.
    pub seconds: Option<f64>,
    /// The linear value that the PNG shows as white.
    pub white: f64,
    /// What the file's name starts with.
    pub label: String,
}

/// A render that is on disk.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The layer as `R G B`.
    pub image: Image,
    pub record: Record,
    /// Below the report's folder, without ending.
    pub path: PathBuf,
}

/// What is known of a render beside its picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    pub seconds: f64,
    pub passes: u32,
    /// Photons or light paths of all passes; none for eye paths.
    pub photons: Option<u64>,
    /// Photons in the maps of all passes; none without maps.
    pub photons_stored: Option<u64>,
    pub backend: String,
}

/// The program as certificates and digests name it.
pub fn program() -> String {
    Program::this().to_string()
}

/// A render and where it is kept.
pub struct Wanted<'a> {
    order: &'a Order<'a>,
    scene: Scene,
    /// Below the report's folder, without ending.
    path: PathBuf,
}

impl<'a> Wanted<'a> {
    pub fn new(order: &'a Order<'a>, threads: usize) -> Result<Wanted<'a>, StudyError> {
        let mut overrides = order.overrides.clone();
        if !order.layer.is_empty() {
            overrides.push(Override::new("render.layers", format!("[{:?}]", order.layer)));
        }
        let scene = import::load(order.scene, &overrides)?.scene;
        let name = format!("{}-{}", file_stem(&order.label), &digest(order, &scene.hash, threads)[..12]);
        Ok(Wanted { order, scene, path: Path::new(FOLDER).join(name) })
    }

    /// The render in the report's `folder`; anything less than a whole one is rendered again.
    pub fn find(&self, folder: &Path) -> Option<Finished> {
        let path = folder.join(&self.path);
        let record = std::fs::read(path.with_extension("json")).ok()?;
        let record = serde_json::from_slice(&record).ok()?;
        let image = exr::read_file(&path.with_extension("exr")).ok()?.image;
        Some(Finished { image, record, path: self.path.clone() })
    }

    /// Renders it and puts it into `folder`.
    pub fn make(self, folder: &Path) -> Result<Finished, StudyError> {
        let (image, record) = rendered(self.order, World::new(self.scene)?)?;
        keep(&folder.join(&self.path), &image, &record, self.order.white)?;
        Ok(Finished { image, record, path: self.path })
    }
}

/// `text` as a file's name: what is no letter, digit, point or underscore becomes a dash.
pub fn file_stem(text: &str) -> String {
    text.chars().map(|c| if c.is_alphanumeric() || ".-_".contains(c) { c } else { '-' }).collect()
}

fn digest(order: &Order, scene_hash: &str, threads: usize) -> String {
    // The number of threads changes no pixel, but what fits into a time.
    let timed = order.seconds.map(|seconds| (seconds, threads));
    let all = format!("{} {scene_hash} {} {timed:?}", program(), order.layer);
    blake3::hash(all.as_bytes()).to_hex().to_string()
}

fn rendered(order: &Order, world: World) -> Result<(Image, Record), StudyError> {
    let settings = &world.scene.settings;
    let start = Instant::now();
    let rendered = match order.seconds {
        None => render_while(&world, &Silent, |state| state.film.passes() < settings.passes),
        Some(seconds) => {
            let end = start + Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX / 2);
            // The pass that is likely to overrun the time is not begun.
            render_while(&world, &Silent, |state| {
                let now = Instant::now();
                let pass = (now - start) / state.film.passes();
                now + pass / 2 < end
            })
        }
    }?;
    let [caustic, bounced] = [&rendered.report.photons, &rendered.report.bounced_photons];
    let record = Record {
        seconds: start.elapsed().as_secs_f64(),
        passes: rendered.film.passes(),
        photons: match settings.method {
            Method::Path => None,
            Method::PhotonMap => Some(caustic.photons_emitted + bounced.photons_emitted),
            Method::LightTrace => Some(settings.photons * u64::from(rendered.film.passes())),
        },
        photons_stored: (settings.method == Method::PhotonMap)
            .then_some(caustic.photons_stored + bounced.photons_stored),
        backend: world.backend.describe(),
    };
    Ok((layer(&rendered.film.resolve(), order.layer), record))
}

/// A layer of a picture as a picture of its own.
pub fn layer(image: &Image, layer: &str) -> Image {
    let black = vec![0.0; image.pixels()];
    let [r, g, b] = image.rgb(layer).unwrap_or([&black; 3]);
    let pixels: Vec<[f32; 3]> = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect();
    Image::from_rgb(image.width, image.height, &pixels)
}

fn keep(path: &Path, image: &Image, record: &Record, white: f64) -> Result<(), StudyError> {
    write_pictures(path, image, white, &[])?;
    let text = serde_json::to_vec_pretty(record).unwrap_or_default();
    Ok(atomic::write(&path.with_extension("json"), &text)?)
}

/// `path`.exr and `path`.png with `white` shown as white; makes the folder.
pub fn write_pictures(
    path: &Path,
    image: &Image,
    white: f64,
    attributes: &[(String, String)],
) -> Result<(), StudyError> {
    let exr = path.with_extension("exr");
    crate::output::target::probe(&exr, true)?;
    exr::write(&exr, image, attributes)?;
    Ok(png::write(&path.with_extension("png"), image, -white.log2())?)
}
