//! Scene files become descriptions; [`load`] goes on to the assembled scene.
//!
//! The parsers of this module end at the description: only [`load`], the one door for everybody who renders a file,
//! knows assembly too.

mod animated;
mod assets;
pub mod gltf;
mod ignored;
pub mod image;
pub mod imported;
pub(crate) mod keyed;
pub mod mesh_file;
mod names;
pub mod native;
pub mod obj;
pub mod pbrt;
pub mod ply;
pub mod volume;

pub use native::Override;

use std::path::Path;

use crate::scene::Scene;
use crate::scene::assemble::assemble;
use crate::scene::description::SceneDescription;
use crate::scene::error::{Problem, Problems};
use crate::scene::texture::TextureMemory;

/// A scene file is text that somebody wrote; anything this long is something else.
const MAX_SCENE_BYTES: u64 = 16 << 20;

/// Bytes of a mesh file.
const MAX_MESH_BYTES: u64 = 8 << 30;

/// A scene ready to be rendered.
#[derive(Clone, Debug)]
pub struct Loaded {
    pub scene: Scene,
    /// What is probably not meant, but can be rendered.
    pub warnings: Vec<Problem>,
}

/// Reads the scene file `path`, TOML, glTF or pbrt by its name, with `overrides` laid over it, the files that it names, and
/// assembles the scene. Textures have the usual memory.
///
/// # Errors
/// Everything that is wrong with the scene, each with its file, line and column where there is one.
pub fn load(path: &Path, overrides: &[Override]) -> Result<Loaded, Problems> {
    load_within(path, overrides, &TextureMemory::default())
}

/// Like [`load`] with textures within `memory`.
///
/// # Errors
/// As [`load`]; and the textures' temporary file may fail.
pub fn load_within(path: &Path, overrides: &[Override], memory: &TextureMemory) -> Result<Loaded, Problems> {
    if is_foreign(path) {
        return finish(native::describe_foreign(path, overrides, memory));
    }
    let text = read_scene_text(path)?;
    finish(native::describe(path, &text, overrides, memory))
}

/// Whether a file goes by a name of scene files of other programs.
pub fn is_foreign(path: &Path) -> bool {
    gltf::is_gltf(path) || pbrt::is_pbrt(path)
}

/// Like [`load`] with the content of the scene file at hand; `path` is for messages and for finding other files.
///
/// # Errors
/// As [`load`].
pub fn load_text(path: &Path, text: &str, overrides: &[Override]) -> Result<Loaded, Problems> {
    finish(native::describe(path, text, overrides, &TextureMemory::default()))
}

/// A scene file made of a file of another program.
#[derive(Clone, Debug)]
pub struct Converted {
    pub text: String,
    /// What is probably not meant in the file.
    pub warnings: Vec<Problem>,
}

/// The text of a scene file at `output` that takes the glTF or pbrt file `input` in and repeats its camera, settings,
/// materials and lights.
///
/// # Errors
/// Everything that is wrong with the file; or what is written would not be the same scene.
pub fn convert(input: &Path, output: &Path, lenient: bool) -> Result<Converted, Problems> {
    let overrides: Vec<Override> = lenient.then(|| Override::new("lenient", "true")).into_iter().collect();
    let (description, problems) = native::describe_foreign(input, &overrides, &TextureMemory::default());
    let text = description.as_ref().map(|scene| native::scene_file(scene, input, folder_of(output), lenient));
    let loaded = finish((description, problems))?;
    let text = text.unwrap_or_default();
    let again = load_text(output, &text, &[])?;
    if again.scene.hash != loaded.scene.hash {
        let problem = Problem::new(format!("{}: as a scene file it is not the same scene", input.display()));
        return Err(problem.help("render the file itself, and please report this").into());
    }
    Ok(Converted { text, warnings: loaded.warnings })
}

/// Where the files that a scene file names are looked for.
fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// Assembles what was described, and puts the problems of both together.
fn finish((description, mut problems): (Option<SceneDescription>, Problems)) -> Result<Loaded, Problems> {
    let Some(description) = description else { return Err(problems) };
    let assembled = match assemble(description) {
        Ok((scene, warnings)) => Some(Loaded { scene, warnings }),
        Err(more) => {
            problems.append(more);
            None
        }
    };
    match assembled {
        Some(loaded) if problems.is_empty() => Ok(loaded),
        _ => Err(problems.sorted()),
    }
}

/// The content of a scene or study file.
pub(crate) fn read_scene_text(path: &Path) -> Result<String, Problem> {
    read_text(path, MAX_SCENE_BYTES)
}

/// The content of a text file of at most `limit` bytes.
fn read_text(path: &Path, limit: u64) -> Result<String, Problem> {
    String::from_utf8(read_bytes(path, limit)?).map_err(|error| {
        let line = 1 + error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count();
        let source = crate::scene::error::Source::file(path).at_line(u32::try_from(line).unwrap_or(0));
        Problem::new("not UTF-8 text").help("save the file as UTF-8").at(&source)
    })
}

/// The content of a file of at most `limit` bytes.
fn read_bytes(path: &Path, limit: u64) -> Result<Vec<u8>, Problem> {
    use std::io::Read;
    let unreadable = |error: std::io::Error| Problem::unreadable(path, &error);
    let file = std::fs::File::open(path).map_err(unreadable)?;
    if file.metadata().is_ok_and(|m| m.is_dir()) {
        return Err(unreadable(std::io::ErrorKind::IsADirectory.into()));
    }
    let mut bytes = Vec::new();
    // Pipes have no length, so the limit is put on what is read.
    file.take(limit + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > limit {
        let problem = Problem::new(format!("{} is longer than {} MiB", path.display(), limit >> 20));
        return Err(problem.help("is this the right file?"));
    }
    Ok(bytes)
}
