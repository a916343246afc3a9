//! The project's own scene file: TOML, every value typed, every problem with its line and column.
//!
//! The format is described in [`crate::doc::scene_format`].

mod camera;
mod included;
mod lights;
mod materials;
mod media;
mod objects;
mod overrides;
mod writing;

pub use overrides::Override;
pub use writing::scene_file;

use std::path::Path;

use toml::de::DeTable;

use self::included::Included;
use super::assets::Assets;
use super::imported::Wanted;
use super::keyed::convert::{Boolean, Integer};
use super::keyed::reader::{Reader, Section};
use super::keyed::syntax_problems;
use super::keyed::texts::Texts;
use crate::scene::description::SceneDescription;
use crate::scene::error::Problems;
use crate::scene::settings::RenderSettings;
use crate::scene::texture::TextureMemory;

/// The version of the format that this program reads.
const FORMAT: u64 = 1;

/// Reads `text`, the content of `path`, with `overrides` laid over it; files that it names are found beside `path`, textures find room in `memory`.
///
/// The problems are those of the text and of the files it names. Unless the text is no TOML at all there is a
/// description too, with placeholders where values were wrong, so that assembly can go on to find the other problems.
pub fn describe(
    path: &Path,
    text: &str,
    overrides: &[Override],
    memory: &TextureMemory,
) -> (Option<SceneDescription>, Problems) {
    describe_with(path, text, overrides, None, memory)
}

/// A glTF or pbrt file as if a scene file had nothing in it but that.
pub fn describe_foreign(
    path: &Path,
    overrides: &[Override],
    memory: &TextureMemory,
) -> (Option<SceneDescription>, Problems) {
    describe_with(path, "format = 1", overrides, Some(path), memory)
}

fn describe_with(
    path: &Path,
    text: &str,
    overrides: &[Override],
    foreign: Option<&Path>,
    memory: &TextureMemory,
) -> (Option<SceneDescription>, Problems) {
    let mut texts = Texts::new(path, text);
    let statements = overrides::statements(overrides, &mut texts);
    let (document, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        return (None, syntax_problems(&errors, &texts));
    }
    let mut problems = Problems::default();
    let span = document.span();
    let mut table = document.into_inner();
    overrides::apply(&mut table, &statements, &texts, &mut problems);
    let reader = Reader::new(&texts, problems);
    let description = read_scene(Section::new(&reader, "the scene", &table, span), path, foreign, memory);
    (description, reader.into_problems())
}

fn read_scene(
    root: Section<'_>,
    path: &Path,
    foreign: Option<&Path>,
    memory: &TextureMemory,
) -> Option<SceneDescription> {
    let folder = super::folder_of(path);
    let mut assets = Assets::new(folder, memory.clone());
    let camera = root.table("camera");
    let wanted = Wanted {
        camera: camera.as_ref().and_then(|section| media::reference(section, "from")),
        variant: media::reference(&root, "variant"),
        lenient: root.or("lenient", Boolean, false),
        memory: memory.clone(),
    };
    let included = match foreign {
        Some(path) => {
            Some(included::read_file(path, &wanted).map_err(|problems| root.reader.report_all(problems)).ok()?)
        }
        None => included::read(&root, folder, &wanted),
    };
    let included = included.map(|imported| Included::into_assets(imported, &mut assets));
    let file = root.reader.texts.file().clone();

    let version = Integer { min: FORMAT, max: FORMAT, help: Some("this program reads version 1 of the format") };
    root.required("format", version, FORMAT);
    let own_camera = included.as_ref().map(|i| &i.camera);
    let camera = camera.map(|section| camera::read(section, own_camera)).or(own_camera.cloned());
    let render = root.table("render");
    let settings_source = render.as_ref().map_or(file.clone(), Section::source);
    let own_settings = included.as_ref().map_or_else(RenderSettings::default, |i| i.settings.clone());
    let settings = match render {
        Some(section) => camera::read_settings(section, own_settings),
        None => own_settings,
    };
    let mut materials = materials::read(&root, &mut assets);
    let mut objects = objects::read(&root, &mut assets);
    let mut lights = lights::read(&root, &mut assets);
    let mut media = media::read(&root, &assets);
    let atmosphere = media::reference(&root, "atmosphere");
    // A free table that closed-form tests read.
    root.get("expect");
    root.finish();
    let mut warnings = Vec::new();
    if let Some(included) = included {
        let camera_is_given = root.get("camera").is_some();
        warnings = included.add_to(&mut materials, &mut media, &mut objects, &mut lights, camera_is_given);
    }

    Some(SceneDescription {
        source: file,
        camera,
        settings,
        settings_source,
        materials: materials.into_iter().chain(assets.materials).collect(),
        textures: assets.textures,
        media,
        atmosphere,
        meshes: assets.meshes,
        objects,
        lights,
        warnings,
    })
}
