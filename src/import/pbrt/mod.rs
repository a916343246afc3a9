//! Scenes of pbrt-v4 in its text format become part of a description.
//!
//! The words of a file (`lexer`) make directives with their parameters (`parameters`, `directive`, `directives`), which
//! change a graphics state (`state`) and add to a scene (`effects`, `reading`); shapes, textures, materials, lights and the
//! camera each have a file. The mapping is described in `crate::doc::pbrt`.

mod budget;
mod directive;
mod directives;
mod effects;
mod film;
mod lexer;
mod lights;
mod loop_subdivision;
mod materials;
mod media;
mod meshes;
mod parameters;
mod placing;
mod reading;
mod shapes;
mod spectra;
mod state;
mod textures;

use std::path::Path;

use self::reading::Reading;
use super::imported::Imported;
use super::read_text;
use crate::scene::error::{Problems, Source};
use crate::scene::texture::TextureMemory;

/// Bytes of a scene file; those of pbrt may hold their meshes.
const MAX_BYTES: u64 = 1 << 30;

/// Whether a file goes by a name that pbrt files have.
pub fn is_pbrt(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("pbrt"))
}

/// Reads the file and those that it names, textures to where `memory` has room for them. `lenient`: what cannot be rendered is left out, with a warning.
///
/// # Errors
/// Files that cannot be read, everything that is wrong in them, and without `lenient` what cannot be rendered.
pub fn read(path: &Path, lenient: bool, memory: &TextureMemory) -> Result<Imported, Problems> {
    let text = read_text(path, MAX_BYTES)?;
    parse_with(path, &text, lenient, memory)
}

/// Like [`read`] with the content of the file at hand; `path` is for messages and for finding other files.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, text: &str, lenient: bool) -> Result<Imported, Problems> {
    parse_with(path, text, lenient, &TextureMemory::default())
}

fn parse_with(path: &Path, text: &str, lenient: bool, memory: &TextureMemory) -> Result<Imported, Problems> {
    let source = Source::file(path);
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut reading = Reading::new(folder, &source, lenient, memory);
    if !reading.read_text(text, &source) {
        return Err(Problems(reading.problems));
    }
    reading.finish()
}
