//! A render on disk: saved in the middle, found again, and put together from parts.

use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::film::{Film, PixelBounds};
use crate::output::part::{self, Identity, Part, PartInfo};
use crate::output::sidecar::{BackendIdentity, Program, SceneIdentity};
use crate::output::{PartError, WriteError};
use crate::scene::named_settings::settings_by_name;
use crate::world::World;

use super::{RenderReport, RenderState};

/// Which pixels and passes someone renders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assignment {
    pub pixels: PixelBounds,
    pub passes: Range<u32>,
}

/// What identifies the renders of `world`, whose scene came from `path`.
pub fn identify(world: &World, path: &Path, wanted_passes: u32) -> PartInfo {
    let settings = &world.scene.settings;
    let mut by_name = settings_by_name(settings);
    by_name.remove("passes");
    PartInfo {
        identity: Identity {
            program: Program::this(),
            backend: BackendIdentity { name: settings.backend.name().to_owned(), version: world.backend.describe() },
            contents: world.scene.contents.clone(),
            resolution: world.scene.camera.resolution,
            settings: by_name,
        },
        scene: SceneIdentity { path: path.to_owned(), hash: world.scene.contents.clone() },
        wanted_passes,
        report: serde_json::Value::Null,
    }
}

/// Saves `state`, whole or not at all.
pub fn save(path: &Path, info: &PartInfo, state: &RenderState) -> Result<(), WriteError> {
    let report = serde_json::to_value(&state.report).unwrap_or_default();
    part::write(path, &PartInfo { report, ..info.clone() }, &state.film)
}

/// Why a saved render is not used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    #[error(transparent)]
    Part(#[from] PartError),
    #[error("{}: belongs to another render than {other}: {}; use what it was made with, or another file", path.display(), differences.join("; "))]
    OtherRender { path: PathBuf, other: String, differences: Vec<String> },
    #[error("{}: holds {found}, not {wanted}; give the same --tile and passes, or another file", path.display())]
    OtherAssignment { path: PathBuf, found: String, wanted: String },
    #[error("{}: holds a pass that is not finished; finish it with --resume", path.display())]
    PassUnderWay { path: PathBuf },
    #[error("{} and {}: both hold pass {pass} of the same pixels; leave one out", first.display(), second.display())]
    Overlap { first: PathBuf, second: PathBuf, pass: u32 },
    #[error("{} and {}: their tiles overlap but are not the same; cut the picture in one way", first.display(), second.display())]
    CutTwice { first: PathBuf, second: PathBuf },
    #[error("the parts are not the whole: {missing}; render what is missing, or add --partial")]
    Incomplete { missing: String },
    #[error("the tiles hold different passes ({one} and {other}); render what is missing")]
    Uneven { one: String, other: String },
}

/// A part as a render to go on with.
pub fn state_of(part: Part) -> (PartInfo, RenderState) {
    let report: RenderReport = serde_json::from_value(part.info.report.clone()).unwrap_or_default();
    (part.info, RenderState { film: part.film, report })
}

fn span(pixels: &PixelBounds) -> String {
    let PixelBounds { x0, y0, x1, y1 } = pixels;
    format!("pixels ({x0}, {y0}) to ({x1}, {y1})")
}

/// Reads a checkpoint of the render `info` that has `assignment` to do.
///
/// # Errors
/// It is not readable, or of another render; the message says in what it differs.
pub fn resume(path: &Path, info: &PartInfo, assignment: &Assignment) -> Result<RenderState, StoreError> {
    let (found, state) = state_of(part::read(path)?);
    let differences = found.identity.differences(&info.identity);
    if !differences.is_empty() {
        let other = "this one".to_owned();
        return Err(StoreError::OtherRender { path: path.to_owned(), other, differences });
    }
    if state.film.bounds() != assignment.pixels || state.film.first_pass() != assignment.passes.start {
        let tell = |pixels: &PixelBounds, first: u32| format!("{} from pass {first} on", span(pixels));
        return Err(StoreError::OtherAssignment {
            path: path.to_owned(),
            found: tell(&state.film.bounds(), state.film.first_pass()),
            wanted: tell(&assignment.pixels, assignment.passes.start),
        });
    }
    let begun = state.film.pass().saturating_add(u32::from(!state.film.is_between_passes()));
    if begun > assignment.passes.end {
        let passes = |end: u32| format!("passes {}..{end}", assignment.passes.start);
        let (found, wanted) = (passes(begun), passes(assignment.passes.end));
        return Err(StoreError::OtherAssignment { path: path.to_owned(), found, wanted });
    }
    Ok(state)
}

/// Whether `path` holds the whole of `assignment` already.
pub fn is_done(path: &Path, info: &PartInfo, assignment: &Assignment) -> bool {
    resume(path, info, assignment)
        .is_ok_and(|state| state.film.is_between_passes() && state.film.passes() as usize == assignment.passes.len())
}

/// Parts put together.
#[derive(Debug)]
pub struct Merged {
    pub info: PartInfo,
    pub state: RenderState,
    /// What is not there, if a partial picture was asked for.
    pub missing: Option<String>,
}

/// The passes of one rectangle of pixels.
struct Tile {
    state: RenderState,
    passes: Vec<(Range<u32>, PathBuf)>,
}

/// Adds up parts of one render, one after the other, in any order.
///
/// # Errors
/// Parts are unreadable, do not belong together, hold something twice, or, unless `partial`, are not the whole.
pub fn merge(paths: &[PathBuf], partial: bool) -> Result<Merged, StoreError> {
    let mut all: Option<(PartInfo, &Path)> = None;
    let mut tiles: Vec<Tile> = Vec::new();
    for path in paths {
        let (info, state) = state_of(part::read(path)?);
        if !state.film.is_between_passes() {
            return Err(StoreError::PassUnderWay { path: path.clone() });
        }
        match &mut all {
            None => all = Some((info, path)),
            Some((first, first_path)) => {
                let differences = info.identity.differences(&first.identity);
                if !differences.is_empty() {
                    let other = first_path.display().to_string();
                    return Err(StoreError::OtherRender { path: path.clone(), other, differences });
                }
                first.wanted_passes = first.wanted_passes.max(info.wanted_passes);
            }
        }
        add(&mut tiles, path, state)?;
    }
    let Some((info, _)) = all else { return Err(StoreError::Incomplete { missing: "there are none".to_owned() }) };
    let missing = missing(&tiles, &info)?;
    match missing {
        Some(missing) if !partial => Err(StoreError::Incomplete { missing }),
        missing => Ok(Merged { state: assemble(tiles, info.identity.resolution), info, missing }),
    }
}

fn add(tiles: &mut Vec<Tile>, path: &Path, state: RenderState) -> Result<(), StoreError> {
    let (bounds, range) = (state.film.bounds(), state.film.first_pass()..state.film.pass());
    for tile in &*tiles {
        let there = tile.state.film.bounds();
        let (first, second) = (tile.passes[0].1.clone(), path.to_owned());
        if there != bounds && there.overlaps(&bounds) {
            return Err(StoreError::CutTwice { first, second });
        }
        let overlaps = |(other, _): &&(Range<u32>, PathBuf)| other.start < range.end && range.start < other.end;
        if let Some((other, first)) = tile.passes.iter().find(overlaps).filter(|_| there == bounds) {
            let pass = other.start.max(range.start);
            return Err(StoreError::Overlap { first: first.clone(), second, pass });
        }
    }
    match tiles.iter_mut().find(|tile| tile.state.film.bounds() == bounds) {
        Some(tile) => {
            tile.state.add_passes(&state);
            tile.passes.push((range, path.to_owned()));
        }
        None => tiles.push(Tile { state, passes: vec![(range, path.to_owned())] }),
    }
    Ok(())
}

/// The passes as runs, in order.
fn runs(tile: &Tile) -> Vec<Range<u32>> {
    let mut ranges: Vec<Range<u32>> = tile.passes.iter().map(|(range, _)| range.clone()).collect();
    ranges.sort_by_key(|range| range.start);
    let mut runs: Vec<Range<u32>> = Vec::new();
    for range in ranges {
        match runs.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            _ => runs.push(range),
        }
    }
    runs
}

fn tell(runs: &[Range<u32>]) -> String {
    runs.iter().map(|r| format!("{}..{}", r.start, r.end)).collect::<Vec<_>>().join(", ")
}

/// What the tiles do not hold, in words.
fn missing(tiles: &[Tile], info: &PartInfo) -> Result<Option<String>, StoreError> {
    let passes: Vec<Vec<Range<u32>>> = tiles.iter().map(runs).collect();
    if let Some(other) = passes.iter().find(|other| **other != passes[0]) {
        return Err(StoreError::Uneven { one: tell(&passes[0]), other: tell(other) });
    }
    let mut found = Vec::new();
    let mut next = 0;
    for run in passes[0].iter().cloned().chain(std::iter::once(info.wanted_passes..u32::MAX)) {
        if next < run.start {
            found.push(format!("passes {next}..{} are missing", run.start));
        }
        next = run.end;
    }
    let [width, height] = info.identity.resolution;
    let pixels: usize = tiles.iter().map(|tile| tile.state.film.bounds().pixels()).sum();
    let all = width as usize * height as usize;
    if pixels < all {
        found.push(format!("tiles with {} of {all} pixels are missing", all - pixels));
    }
    Ok((!found.is_empty()).then(|| found.join("; ")))
}

/// The picture of all tiles.
fn assemble(mut tiles: Vec<Tile>, resolution: [u32; 2]) -> RenderState {
    let whole = PixelBounds::whole(resolution);
    if tiles.len() == 1 && tiles[0].state.film.bounds() == whole {
        return tiles.remove(0).state;
    }
    let mut film = Film::new(whole, 0, tiles[0].state.film.layout().clone());
    let mut report = RenderReport::default();
    for (i, tile) in tiles.iter().enumerate() {
        film.paste(&tile.state.film);
        report.paste(&tile.state.report, i == 0);
    }
    RenderState { film, report }
}
