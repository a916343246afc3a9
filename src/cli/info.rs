//! `pdembree info FILE`

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use pdembree::import::is_foreign;
use pdembree::output::exr;
use pdembree::scene::Scene;
use pdembree::scene::named_settings::settings_by_name;

use super::check::triangles;
use super::console::{Verbosity, print, print_json};
use super::failure::Failure;
use super::scene::SceneArgs;

/// Describe a picture (EXR) or a scene (TOML, glTF, pbrt)
///
/// Of a scene it prints what it holds and the settings that a render of it would use, the command line's among them.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    file: SceneArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What is known about a channel without looking at the picture.
#[derive(serde::Serialize)]
struct ChannelInfo {
    name: String,
    /// Over the finite samples; none if there are none.
    minimum: Option<f64>,
    maximum: Option<f64>,
    mean: Option<f64>,
    not_finite: u64,
}

#[derive(serde::Serialize)]
struct PictureInfo {
    file: PathBuf,
    width: u32,
    height: u32,
    channels: Vec<ChannelInfo>,
    attributes: BTreeMap<String, String>,
}

#[derive(serde::Serialize)]
struct SceneInfo {
    file: PathBuf,
    hash: String,
    width: u32,
    height: u32,
    objects: usize,
    triangles: usize,
    materials: usize,
    textures: usize,
    lights: usize,
    /// Corners of the box around everything, metres.
    bounds: [[f64; 3]; 2],
    settings: BTreeMap<String, serde_json::Value>,
}

pub fn run(args: &Args, verbosity: Verbosity) -> Result<ExitCode, Failure> {
    let path = &args.file.scene;
    let is_toml = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    let is_scene = is_toml || is_foreign(path);
    if is_scene {
        let info = describe_scene(path, &args.file.load(verbosity)?.scene);
        if args.json {
            print_json(&info)?
        } else {
            print(&scene_table(&info))?
        }
        return Ok(ExitCode::SUCCESS);
    }
    let exr::ExrFile { image, attributes } = exr::read_file(path)?;
    let info = PictureInfo {
        file: path.clone(),
        width: image.width,
        height: image.height,
        channels: image.channels.iter().map(|channel| describe(&channel.name, &channel.samples)).collect(),
        attributes: attributes.into_iter().collect(),
    };
    if args.json {
        print_json(&info)?
    } else {
        print(&table(&info))?
    }
    Ok(ExitCode::SUCCESS)
}

fn describe_scene(path: &Path, scene: &Scene) -> SceneInfo {
    let [width, height] = scene.camera.resolution;
    SceneInfo {
        file: path.to_owned(),
        hash: scene.hash.clone(),
        width,
        height,
        objects: scene.objects.len(),
        triangles: triangles(scene),
        materials: scene.materials.len(),
        textures: scene.textures.len(),
        lights: scene.lights.len(),
        bounds: [scene.bounds.min.to_array(), scene.bounds.max.to_array()],
        settings: settings_by_name(&scene.settings),
    }
}

fn scene_table(info: &SceneInfo) -> String {
    let corner = |[x, y, z]: [f64; 3]| format!("({x:.4}, {y:.4}, {z:.4})");
    let [low, high] = info.bounds.map(corner);
    let mut text = format!(
        "{}: {} x {} pixels\n{} objects, {} triangles, {} materials, {} textures, {} lights\nbounds {low} to {high} m\n\
         hash {}\n",
        info.file.display(),
        info.width,
        info.height,
        info.objects,
        info.triangles,
        info.materials,
        info.textures,
        info.lights,
        info.hash
    );
    info.settings.iter().for_each(|(name, value)| text += &format!("{name}: {value}\n"));
    text
}

fn describe(name: &str, samples: &[f32]) -> ChannelInfo {
    let finite = || samples.iter().filter(|v| v.is_finite()).map(|&v| f64::from(v));
    let count = finite().count();
    ChannelInfo {
        name: name.to_owned(),
        minimum: finite().reduce(f64::min),
        maximum: finite().reduce(f64::max),
        mean: (count > 0).then(|| finite().sum::<f64>() / count as f64),
        not_finite: (samples.len() - count) as u64,
    }
}

fn table(info: &PictureInfo) -> String {
    let number = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.6}"));
    let mut text = format!("{}: {} x {} pixels\n", info.file.display(), info.width, info.height);
    text += &format!("{:<18}{:>16}{:>16}{:>16}{:>12}\n", "channel", "minimum", "mean", "maximum", "not finite");
    for c in &info.channels {
        let (low, mean, high) = (number(c.minimum), number(c.mean), number(c.maximum));
        text += &format!("{:<18}{low:>16}{mean:>16}{high:>16}{:>12}\n", c.name, c.not_finite);
    }
    info.attributes.iter().for_each(|(name, value)| text += &format!("{name}: {value}\n"));
    text
}
