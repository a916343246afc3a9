//! Scenes of other programs on both backends, every glTF file of the shared data and pbrt files for all that is read of them:
//! no panic, something to see, the same picture; and contact sheets of them all to look at, `gltf.png` and `pbrt.png` in the
//! target folder's `tmp`.

use std::path::{Path, PathBuf};

use image::RgbImage;
use pdembree::film::Image;
use pdembree::import::{Override, convert, load};
use pdembree::output::png::to_rgb8;
use pdembree::render::progress::Silent;
use pdembree::render::render;
use pdembree::scene::settings::BackendKind;
use pdembree::world::World;

use crate::support::data::{root, shared};

const SIZE: [u32; 2] = [160, 120];
const COLUMNS: usize = 6;

/// What lies in a folder.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("readable");
    entries.map(|entry| entry.expect("an entry").path()).collect()
}

/// Files of these kinds, in the order of their names.
fn of_kind(mut files: Vec<PathBuf>, extensions: &[&str]) -> Vec<PathBuf> {
    files.retain(|path| path.extension().is_some_and(|e| extensions.iter().any(|wanted| e == *wanted)));
    files.sort();
    files
}

fn picture(path: &Path, backend: BackendKind) -> Image {
    let overrides = [
        Override::new("camera.resolution", format!("{SIZE:?}")),
        Override::new("render.backend", backend.name()),
        Override::new("render.spp", "4"),
        Override::new("render.photons", "20000"),
    ];
    let loaded = load(path, &overrides).unwrap_or_else(|problems| panic!("{problems}"));
    let world = World::new(loaded.scene).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    render(&world, &Silent).unwrap_or_else(|error| panic!("{}: {error}", path.display())).film.resolve()
}

/// Mean over the picture of all channels.
fn mean(image: &Image) -> f64 {
    let rgb = image.rgb("").expect("a beauty");
    let sum: f64 = rgb.iter().flat_map(|channel| channel.iter()).map(|v| f64::from(*v)).sum();
    sum / (3 * image.pixels()) as f64
}

fn paste(sheet: &mut RgbImage, index: usize, image: &Image) {
    let pixels = to_rgb8(image, "", 0.0).expect("a beauty");
    let tile = RgbImage::from_raw(image.width, image.height, pixels).expect("of this size");
    let [x, y] = [index % COLUMNS, index / COLUMNS];
    image::imageops::replace(sheet, &tile, x as i64 * i64::from(SIZE[0]), y as i64 * i64::from(SIZE[1]));
}

/// Renders all of `files` into the sheet of that name.
fn contact_sheet(name: &str, files: &[PathBuf]) {
    let rows = files.len().div_ceil(COLUMNS) as u32;
    let mut sheet = RgbImage::new(COLUMNS as u32 * SIZE[0], rows * SIZE[1]);
    for (index, path) in files.iter().enumerate() {
        let image = picture(path, BackendKind::Obvhs);
        let seen = mean(&image);
        assert!(seen.is_finite() && seen > 0.0, "{}: {seen}", path.display());
        if cfg!(feature = "embree") {
            // The same numbers are drawn; only rays within rounding of an edge may meet something else.
            let other = mean(&picture(path, BackendKind::Embree));
            assert!((other - seen).abs() < 0.01 * seen, "{}: {seen} and {other}", path.display());
        }
        paste(&mut sheet, index, &image);
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    sheet.save(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    println!("{} files, top left to bottom right in the order of their names: {}", files.len(), path.display());
}

#[test]
fn every_shared_gltf_file_renders_alike_on_both_backends() {
    let Some(folder) = shared("gltf") else { return };
    // Those that are broken on purpose are left out.
    let sound = entries(&folder).into_iter().filter(|path| path.is_dir() && !path.ends_with("invalid"));
    let files = of_kind(sound.flat_map(|folder| entries(&folder)).collect(), &["gltf", "glb"]);
    assert!(files.len() > 20, "{files:?}");
    contact_sheet("gltf.png", &files);
}

/// As `convert` writes it, a scene file gives the bits of the file that it was made from.
#[test]
fn a_converted_file_renders_the_same_bits() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let mut files = vec![root().join("tests/corpus/pbrt/materials.pbrt"), root().join("tests/corpus/pbrt/lights.pbrt")];
    files.extend(shared("gltf/16_volume").map(|folder| folder.join("16_volume.gltf")));
    for file in files {
        let place = folder.path().join("converted.toml");
        let converted = convert(&file, &place, false).unwrap_or_else(|problems| panic!("{problems}"));
        std::fs::write(&place, converted.text).expect("written");
        let [own, other] = [&place, &file].map(|path| picture(path, BackendKind::Obvhs));
        assert!(own == other, "{}: other bits", file.display());
    }
}

#[test]
fn pbrt_files_render_alike_on_both_backends() {
    let files = of_kind(entries(&root().join("tests/corpus/pbrt")), &["pbrt"]);
    assert_eq!(files.len(), 4, "{files:?}");
    contact_sheet("pbrt.png", &files);
}
