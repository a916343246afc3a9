//! Textures within bounds: where texels lie changes none of them, and no picture.

use std::path::Path;

use assert_cmd::Command;
use pdembree::math::Vec2;
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::texture::{Curve, ImageTexture, Placement, Raster, Samples, Texels, TextureMemory, Wrap};
use pdembree::surface::mipmap::MipMap;
use serde_json::Value;

/// Room for four tiles of colours in bytes.
const TIGHT: u64 = 50_000;

/// One of each kind of samples, of these sides.
fn rasters(width: usize, height: usize) -> Vec<Raster> {
    let mut stream = Stream::new(31, Purpose::Test, 0, 0);
    let texels = width * height;
    let numbers: Vec<f32> = (0..3 * texels).map(|_| stream.uniform() as f32).collect();
    let bytes: Vec<u8> = numbers.iter().map(|x| (x * 256.0) as u8).collect();
    let curve = Curve::new(|c, byte| (f32::from(byte) / 255.0).powi(2 + c as i32));
    let of_bytes = |samples| Raster::of_bytes(width, height, samples, curve.clone());
    vec![
        of_bytes(Samples::GreyBytes(bytes[..texels].to_vec())),
        of_bytes(Samples::Bytes(bytes.as_chunks().0.to_vec())),
        Raster::of_numbers(width, height, Samples::Grey(numbers[..texels].to_vec())),
        Raster::of_colours(width, height, numbers.as_chunks().0.to_vec()),
    ]
}

/// The same texels whole and in tiles.
fn both(raster: &Raster) -> [Texels; 2] {
    [TextureMemory::unlimited(), TextureMemory::new(TIGHT / 4)]
        .map(|memory| raster.clone().placed(&memory).expect("a temporary file"))
}

/// Sides that are and are not whole numbers of tiles, and long strips.
const SIDES: [(usize, usize); 4] = [(256, 256), (300, 130), (9000, 3), (1, 8200)];

#[test]
fn tiles_hold_the_texels_of_the_image() {
    for (width, height) in SIDES {
        for raster in rasters(width, height) {
            let [whole, tiled] = both(&raster);
            let reports = [&whole, &tiled].map(|texels| texels.memory().report());
            assert!(reports[0].file_bytes == 0 && reports[1].file_bytes > 0, "{reports:?}");
            let expected: Vec<[f32; 3]> = raster.texels().collect();
            for texels in [&whole, &tiled] {
                let (mut rows, mut cursor) = (texels.rows(), texels.cursor());
                for j in 0..height {
                    assert_eq!(rows.row(j), &expected[j * width..][..width], "row {j} of {width} × {height}");
                }
                for k in (0..width * height).step_by(7).chain((0..width * height).rev().step_by(31)) {
                    assert_eq!(cursor.texel(k % width, k / width), expected[k], "texel {k} of {width} × {height}");
                }
            }
            assert_eq!(whole, tiled);
            let changed = |c: usize, x: f32| x * (1.0 + c as f32);
            assert_eq!(whole.mapped(changed), tiled.mapped(changed));
            let mapped = raster.clone().mapped(changed);
            assert!(mapped.texels().eq(expected.iter().map(|t| [0, 1, 2].map(|c| changed(c, t[c])))));
            assert_ne!(whole, whole.mapped(changed));
        }
    }
}

/// Every bit of lookups at all levels, with every wrap.
#[test]
fn lookups_do_not_depend_on_where_the_texels_lie() {
    let mut stream = Stream::new(32, Purpose::Test, 0, 0);
    for (width, height) in SIDES {
        for raster in rasters(width, height) {
            for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
                let map =
                    |texels| MipMap::new(&ImageTexture { texels, wrap: [wrap; 2], placement: Placement::IDENTITY });
                let [whole, tiled] = both(&raster).map(map);
                for _ in 0..200 {
                    let uv = Vec2::from_array(stream.uniform2()) * 3.0 - 1.0;
                    let size = 10f64.powf(4.0 * stream.uniform() - 4.0);
                    let d = [Vec2::from_array(stream.uniform2()) * size, Vec2::from_array(stream.uniform2()) * size];
                    assert_eq!(whole.filtered(uv, d), tiled.filtered(uv, d), "{width} × {height} {uv} {d:?}");
                }
            }
        }
    }
}

/// What is held stays within the limit, whichever tiles are asked for; what finds room is held whole.
#[test]
fn memory_is_bounded_by_the_limit() {
    let memory = TextureMemory::new(400_000);
    let raster = || rasters(256, 256).swap_remove(1);
    // 196 608 bytes and 262 144 for coarser levels: too much for three quarters.
    let texels = raster().placed(&memory).expect("a temporary file");
    assert_eq!((memory.report().held_bytes, memory.report().file_bytes), (0, 196_608));
    let mut stream = Stream::new(33, Purpose::Test, 0, 0);
    for _ in 0..2000 {
        texels.texel((stream.uniform() * texels.len() as f64) as usize);
    }
    let report = memory.report();
    assert_eq!(report.tile_lookups, 2000);
    assert_eq!(report.tile_misses, 16, "all sixteen tiles have room: {report:?}");
    assert_eq!(report.peak_bytes, 196_608);

    let tight = TextureMemory::new(TIGHT);
    let texels = raster().placed(&tight).expect("a temporary file");
    for _ in 0..2000 {
        texels.texel((stream.uniform() * texels.len() as f64) as usize);
    }
    let report = tight.report();
    // At most four of the sixteen are there, so that three in four are read; the one that is read comes on top.
    assert!(report.tile_misses > 1300 && report.tile_misses < 2000, "{report:?}");
    assert!(report.peak_bytes <= TIGHT + 12_288, "{report:?}");

    let ample = TextureMemory::new(700_000);
    let (first, second) = (raster().placed(&ample).expect("held"), raster().placed(&ample).expect("a temporary file"));
    let report = ample.report();
    assert_eq!((report.held_bytes, report.file_bytes), (196_608 + 262_144, 196_608));
    drop(first);
    assert_eq!(ample.report().held_bytes, 0);
    drop(second);
}

fn command(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pdembree"));
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("PDEMBREE_")) {
        command.env_remove(name);
    }
    command.current_dir(folder).args(arguments.split_whitespace());
    command
}

/// A glass ball over a floor of an 8-bit image, before a rough wall whose roughness is one, and a painted picture in floats.
const SCENE: &str = r#"
format = 1
[camera]
type = "perspective"
position = [0, -4, 2]
target = [0, 0, 0.5]
up = [0, 0, 1]
fov_degrees = 50
resolution = [48, 32]
[render]
photons = 20000
spp = 4
passes = 2
[materials.floor]
type = "lambert"
albedo = { image = "floor.png", factor = 0.9 }
[materials.wall]
type = "rough_conductor"
preset = "copper"
roughness = { image = "rough.png" }
[materials.picture]
type = "lambert"
albedo = { image = "picture.exr", wrap = "clamp" }
[materials.glass]
type = "dielectric"
ior = 1.5
[[objects]]
shape = "rectangle"
centre = [0, 0, 0]
a = [3, 0, 0]
b = [0, 3, 0]
material = "floor"
[[objects]]
shape = "rectangle"
centre = [0, 2, 1.5]
a = [3, 0, 0]
b = [0, 0, 1.5]
material = "wall"
[[objects]]
shape = "rectangle"
centre = [-2, 0, 1]
a = [0, 1, 0]
b = [0, 0, 1]
material = "picture"
[[objects]]
shape = "sphere"
centre = [0, 0, 0.8]
radius = 0.6
material = "glass"
[[lights]]
type = "point"
position = [1, -1, 4]
intensity = [30, 30, 30]
"#;

fn textured_scene(folder: &Path) {
    std::fs::write(folder.join("s.toml"), SCENE).expect("written");
    let hash = |x: u32, y: u32| (x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35);
    image::RgbImage::from_fn(512, 400, |x, y| image::Rgb(hash(x / 9, y / 9).to_le_bytes()[1..].try_into().expect("3")))
        .save(folder.join("floor.png"))
        .expect("written");
    image::GrayImage::from_fn(300, 300, |x, y| image::Luma([(hash(x / 20, y / 20) >> 25) as u8 + 20]))
        .save(folder.join("rough.png"))
        .expect("written");
    let number = |x: usize, y: usize| hash(x as u32 / 5, y as u32 / 5) as f32 / 5e9;
    exr::prelude::write_rgb_file(folder.join("picture.exr"), 200, 200, |x, y| (number(x, y), number(y, x), 0.3))
        .expect("written");
}

/// Pixels and textures of the sidecar.
fn rendered(folder: &Path, name: &str, arguments: &str) -> (Vec<u8>, Value) {
    let all = format!("render s.toml -o {name}.exr --no-timestamps --progress none {arguments}");
    let output = command(folder, &all).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let sidecar = std::fs::read(folder.join(format!("{name}.exr.json"))).expect("a sidecar");
    let sidecar: Value = serde_json::from_slice(&sidecar).expect("JSON");
    (std::fs::read(folder.join(format!("{name}.exr"))).expect("a picture"), sidecar["textures"].clone())
}

#[test]
fn the_limit_changes_no_bit_of_a_picture() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    textured_scene(folder.path());
    let (expected, whole) = rendered(folder.path(), "whole", "--nthreads 2");
    assert_eq!((&whole["file_bytes"], &whole["limit_bytes"]), (&Value::from(0), &Value::from(2u64 << 30)));
    for threads in [1, 2] {
        let arguments = format!("--nthreads {threads} --texture-memory 100K");
        let (found, tiles) = rendered(folder.path(), &format!("tight{threads}"), &arguments);
        assert!(found == expected, "other pixels on {threads} threads");
        // Many more than there are tiles: they came and went.
        assert!(tiles["tile_misses"].as_u64() > Some(1000), "{tiles}");
        assert!(
            tiles["file_bytes"].as_u64() > Some(614_400) && tiles["peak_bytes"].as_u64() < Some(300_000),
            "{tiles}"
        );
    }
}

#[test]
fn a_temporary_file_that_cannot_be_is_one_clear_error() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    textured_scene(folder.path());
    let arguments = "render s.toml -o a.exr --progress none --texture-memory 100K";
    let output = command(folder.path(), arguments).env("TMPDIR", "no such folder").output().expect("it starts");
    let told = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(output.status.code(), Some(65), "{told}");
    for words in ["cannot make the temporary file of textures in no such folder", "--texture-memory", "TMPDIR"] {
        assert!(told.contains(words), "{told}");
    }
    assert!(!folder.path().join("a.exr").exists());
}
