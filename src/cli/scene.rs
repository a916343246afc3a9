//! The scene argument and the settings that go over it, the same for every command that reads a scene.
//!
//! Options become overrides of the scene file's `[render]` table, so that one place knows what is allowed.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser};
use pdembree::import::{self, Loaded, Override};
use pdembree::scene::settings::{
    BackendKind, BounceFootprint, Caustics, EmissionPattern, Estimator, FootprintRule, Guiding, Indirect, KernelShape,
    Layer, Method,
};
use pdembree::scene::spelling::nearest;
use pdembree::scene::{GroupLayer, TextureMemory};

use super::console::Verbosity;
use super::failure::Failure;
use super::number::{bytes, count, finite, small_count};
use super::problems;

#[derive(clap::Args)]
pub struct SceneArgs {
    /// Scene file (TOML, glTF, pbrt)
    pub scene: PathBuf,
    /// Override one value of the scene file, for example -D materials.glass.ior=1.33 (repeatable)
    #[arg(short = 'D', long = "define", value_name = "KEY=VALUE", value_parser = define)]
    define: Vec<Override>,
    /// Of a pbrt file leave out what cannot be rendered, with a warning
    #[arg(long)]
    lenient: bool,
    /// Take this camera of a glTF file that has several
    #[arg(short = 'c', long, value_name = "NAME")]
    camera: Option<String>,
    /// Show this variant of a glTF file's materials
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// Memory for textures: what finds no room in it lies in tiles in a temporary file, and no pixel changes. Suffixes K, M, G for
    /// powers of 1024 [default: 2G]
    #[arg(long, env = "PDEMBREE_TEXTURE_MEMORY", value_name = "BYTES", value_parser = bytes)]
    texture_memory: Option<u64>,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Each wins over the scene file and over -D.
#[derive(clap::Args)]
#[command(next_help_heading = "Settings (default: what the scene file says)")]
struct SettingsArgs {
    /// What renders: photon_map, path or light (both unbiased references)
    #[arg(long, env = "PDEMBREE_METHOD", value_parser = PossibleValuesParser::new(Method::NAMES))]
    method: Option<String>,
    /// Library that finds the hits
    #[arg(long, env = "PDEMBREE_BACKEND", value_parser = PossibleValuesParser::new(BackendKind::NAMES))]
    backend: Option<String>,
    /// Seed of all random numbers
    #[arg(long, env = "PDEMBREE_SEED", value_name = "N")]
    seed: Option<u64>,
    /// Passes that the picture is the mean of
    #[arg(long, env = "PDEMBREE_PASSES", value_name = "N", value_parser = small_count)]
    passes: Option<u32>,
    /// Eye samples in a pixel, in each pass
    #[arg(long, env = "PDEMBREE_SPP", value_name = "N", value_parser = small_count)]
    spp: Option<u32>,
    /// Photons emitted in each pass; suffixes K, M, G
    #[arg(long, env = "PDEMBREE_PHOTONS", value_name = "N", value_parser = count)]
    photons: Option<u64>,
    /// How the lights' sample squares are filled
    #[arg(long, env = "PDEMBREE_EMISSION", value_parser = PossibleValuesParser::new(EmissionPattern::NAMES))]
    emission: Option<String>,
    /// Whether pilot photons learn where a light's photons are worth sending
    #[arg(long, env = "PDEMBREE_GUIDING", value_parser = PossibleValuesParser::new(Guiding::NAMES))]
    guiding: Option<String>,
    /// Photon differentials, k nearest neighbours or progressive photon mapping
    #[arg(long, env = "PDEMBREE_ESTIMATOR", value_parser = PossibleValuesParser::new(Estimator::NAMES))]
    estimator: Option<String>,
    /// Ellipse that a photon's differentials span
    #[arg(long, env = "PDEMBREE_FOOTPRINT", value_parser = PossibleValuesParser::new(FootprintRule::NAMES))]
    footprint: Option<String>,
    /// What finds caustics: photons, or both photons and eye paths where lamps are wide
    #[arg(long, env = "PDEMBREE_CAUSTICS", value_parser = PossibleValuesParser::new(Caustics::NAMES))]
    caustics: Option<String>,
    /// What finds the light between surfaces that scatter: eye paths, photons, or photons behind one bounce of the eye
    #[arg(long, env = "PDEMBREE_INDIRECT", value_parser = PossibleValuesParser::new(Indirect::NAMES))]
    indirect: Option<String>,
    /// What a photon stands for after a surface has scattered it
    #[arg(long, env = "PDEMBREE_BOUNCE_FOOTPRINT", value_parser = PossibleValuesParser::new(BounceFootprint::NAMES))]
    bounce_footprint: Option<String>,
    /// Shape of the kernel over a footprint
    #[arg(long, env = "PDEMBREE_KERNEL", value_parser = kernels())]
    kernel: Option<String>,
    /// Width of the footprints: auto, or S or scale:S times the photon's own share of the light
    #[arg(long, env = "PDEMBREE_BANDWIDTH", value_name = "auto|S", value_parser = bandwidth)]
    bandwidth: Option<String>,
    /// Neighbours of the knn estimate
    #[arg(long, env = "PDEMBREE_K", value_name = "N", value_parser = small_count)]
    k: Option<u32>,
    /// Disc of the first pass of sppm: auto or metres
    #[arg(long, env = "PDEMBREE_RADIUS", value_name = "auto|M", value_parser = radius)]
    radius: Option<String>,
    /// Edges of a path at most
    #[arg(long, env = "PDEMBREE_MAX_DEPTH", value_name = "N", value_parser = small_count)]
    max_depth: Option<u32>,
    /// Diffuse bounces of a path at most
    #[arg(long, env = "PDEMBREE_MAX_BOUNCES", value_name = "N")]
    max_bounces: Option<u32>,
    /// EXR layers beside the beauty, separated by commas; with caustic_G, direct_G, indirect_G, G a group of lights or *
    #[arg(long, env = "PDEMBREE_LAYERS", value_delimiter = ',', value_name = "LAYER,...", value_parser = layer)]
    layers: Option<Vec<String>>,
}

/// A layer or a group's share of one, as the scene file spells it.
fn layer(text: &str) -> Result<String, String> {
    if Layer::from_name(text).is_some() || GroupLayer::from_name(text).is_some() {
        return Ok(text.to_owned());
    }
    Err(match nearest(text, Layer::NAMES) {
        Some(near) => format!("did you mean {near}?"),
        None => format!(
            "layers are {}, and direct_G, caustic_G, indirect_G for a group G of lights",
            Layer::NAMES.join(", ")
        ),
    })
}

fn define(text: &str) -> Result<Override, String> {
    text.parse().map_err(|problem: pdembree::scene::error::Problem| problem.to_string())
}

fn kernels() -> PossibleValuesParser {
    let value = |name: &'static str| {
        let value = PossibleValue::new(name);
        if name == KernelShape::Biweight.name() { value.alias("silverman") } else { value }
    };
    PossibleValuesParser::new(KernelShape::NAMES.iter().map(|&name| value(name)))
}

/// The value as the scene file spells it.
fn bandwidth(text: &str) -> Result<String, String> {
    if text == "auto" {
        return Ok("\"auto\"".to_owned());
    }
    match finite(text.strip_prefix("scale:").unwrap_or(text)) {
        // `{:?}` keeps the point of a whole number and every digit.
        Ok(scale) if scale > 0.0 => Ok(format!("{scale:?}")),
        _ => Err("write auto, a number above 0, or scale: and a number".to_owned()),
    }
}

/// The value as the scene file spells it.
fn radius(text: &str) -> Result<String, String> {
    match text {
        "auto" => Ok("\"auto\"".to_owned()),
        _ => match finite(text) {
            Ok(metres) if metres > 0.0 => Ok(format!("{metres:?}")),
            _ => Err("write auto or a number of metres above 0".to_owned()),
        },
    }
}

impl SettingsArgs {
    fn overrides(&self) -> Vec<Override> {
        let word = |value: &Option<String>| value.as_ref().map(|name| format!("{name:?}"));
        let number = |value: Option<u32>| value.map(|n| n.to_string());
        let layers = self.layers.as_ref().map(|names| format!("{names:?}"));
        let all = [
            ("method", word(&self.method)),
            ("backend", word(&self.backend)),
            ("seed", self.seed.map(|n| n.to_string())),
            ("passes", number(self.passes)),
            ("spp", number(self.spp)),
            ("photons", self.photons.map(|n| n.to_string())),
            ("emission", word(&self.emission)),
            ("estimator", word(&self.estimator)),
            ("guiding", word(&self.guiding)),
            ("footprint", word(&self.footprint)),
            ("caustics", word(&self.caustics)),
            ("indirect", word(&self.indirect)),
            ("bounce_footprint", word(&self.bounce_footprint)),
            ("kernel", word(&self.kernel)),
            ("bandwidth", self.bandwidth.clone()),
            ("k", number(self.k)),
            ("radius", self.radius.clone()),
            ("max_depth", number(self.max_depth)),
            ("max_bounces", number(self.max_bounces)),
            ("layers", layers),
        ];
        let given = |(name, value): (&str, Option<String>)| Some(Override::new(format!("render.{name}"), value?));
        all.into_iter().filter_map(given).collect()
    }
}

impl SceneArgs {
    /// Whether the command line or the environment, and not only the scene file, says how many passes there are.
    pub fn gives_passes(&self) -> bool {
        self.settings.passes.is_some()
    }

    /// What the command line and the environment put over the scene file, the strongest last.
    pub fn overrides(&self) -> Vec<Override> {
        let lenient = self.lenient.then(|| Override::new("lenient", "true"));
        let named =
            |key: &str, name: &Option<String>| name.as_ref().map(|name| Override::new(key, format!("{name:?}")));
        let chosen = [lenient, named("camera.from", &self.camera), named("variant", &self.variant)];
        [self.define.clone(), chosen.into_iter().flatten().collect(), self.settings.overrides()].concat()
    }

    /// Those that say how a task works and not what it renders.
    pub fn working_arguments(&self) -> Vec<String> {
        self.texture_memory.map_or_else(Vec::new, |bytes| vec!["--texture-memory".to_owned(), bytes.to_string()])
    }

    /// Reads and assembles the scene; prints its warnings, or everything that is wrong with it.
    pub fn load(&self, verbosity: Verbosity) -> Result<Loaded, Failure> {
        let memory = self.texture_memory.map_or_else(TextureMemory::default, TextureMemory::new);
        let loaded =
            import::load_within(&self.scene, &self.overrides(), &memory).map_err(|all| problems::failure(&all))?;
        if !verbosity.quiet {
            problems::print(&loaded.warnings, miette::Severity::Warning);
        }
        Ok(loaded)
    }
}
