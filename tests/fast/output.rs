//! Files of pictures: what is written is read back, and what cannot be is refused with a reason.

use std::path::Path;

use pdembree::film::{Channel, Image};
use pdembree::output::{
    BirthCertificate, DumpedPhoton, Format, ReadError, Target, WriteError, exr, photon_dump, png, sidecar,
};
use pdembree::scene::RenderSettings;
use pdembree::scene::named_settings::settings_by_name;
use pdembree::scene::settings::{Bandwidth, KernelShape, Layer};

fn gradient(width: u32, height: u32, names: &[&str]) -> Image {
    let pixels = (width * height) as usize;
    let channel = |(c, name): (usize, &&str)| Channel {
        name: (*name).to_owned(),
        samples: (0..pixels).map(|i| (i as f32 + 0.1) * (c as f32 - 0.5) * 1e3).collect(),
    };
    Image { width, height, channels: names.iter().enumerate().map(channel).collect() }
}

#[test]
fn an_exr_gives_back_the_bits_of_every_channel_and_its_attributes() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("a.exr");
    let image = gradient(37, 19, &["R", "G", "B", "A", "caustic.R", "Z"]);
    let attributes = [("seed".to_owned(), "7".to_owned()), ("command".to_owned(), "render été 光.toml".to_owned())];
    exr::write(&path, &image, &attributes).expect("written");
    let read = exr::read_file(&path).expect("read");
    assert_eq!((read.image.width, read.image.height), (37, 19));
    assert_eq!(read.image.channels.len(), 6);
    for channel in &image.channels {
        assert_eq!(read.image.channel(&channel.name), Some(channel.samples.as_slice()), "{}", channel.name);
    }
    let value = |name: &str| read.attributes.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str());
    assert_eq!(value("pdembree/seed"), Some("7"));
    assert!(value("pdembree/command").expect("command").contains(r"\u{5149}"), "what Latin-1 lacks is escaped");
    assert!(value("Software").expect("Software").starts_with("pdembree "));
}

#[test]
fn equal_pictures_are_equal_files() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let attributes: Vec<_> = (0..20).map(|i| (format!("key{i}"), format!("value {i}"))).collect();
    let written = |name: &str| {
        let path = folder.path().join(name);
        exr::write(&path, &gradient(9, 9, &["R", "G", "B"]), &attributes).expect("written");
        assert_eq!(exr::read_file(&path).expect("read").attributes.len(), 21);
        std::fs::read(&path).expect("read")
    };
    assert_eq!(written("a.exr"), written("b.exr"));
}

#[test]
fn files_that_are_no_picture_are_refused_by_kind() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = |name: &str| folder.path().join(name);
    assert!(matches!(exr::read_file(&at("none.exr")), Err(ReadError::Missing { .. })));
    std::fs::write(at("text.exr"), "not an EXR").expect("written");
    assert!(matches!(exr::read_file(&at("text.exr")), Err(ReadError::Malformed { .. })));
    std::fs::write(at("empty.exr"), "").expect("written");
    assert!(matches!(exr::read_file(&at("empty.exr")), Err(ReadError::Malformed { .. })));
    exr::write(&at("whole.exr"), &gradient(64, 64, &["R", "G", "B"]), &[]).expect("written");
    let bytes = std::fs::read(at("whole.exr")).expect("read");
    for part in [bytes.len() / 4, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(at("part.exr"), &bytes[..part]).expect("written");
        assert!(matches!(exr::read_file(&at("part.exr")), Err(ReadError::Malformed { .. })), "{part} bytes");
    }
    assert!(matches!(exr::read_file(folder.path()), Err(ReadError::Io { .. })));
}

#[test]
fn a_channel_of_the_wrong_length_is_not_written() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let mut image = gradient(4, 4, &["R", "G", "B"]);
    image.channels[1].samples.pop();
    let result = exr::write(&folder.path().join("a.exr"), &image, &[]);
    assert!(matches!(result, Err(WriteError::Unfit { .. })));
    assert_eq!(std::fs::read_dir(folder.path()).expect("folder").count(), 0);
}

#[test]
fn targets_are_checked_before_anything_is_rendered() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = |name: &str| folder.path().join(name);
    assert_eq!(Target::picture(&at("a.EXR"), false).expect("writable").format(), Format::Exr);
    assert_eq!(Target::picture(&at("a.png"), false).expect("writable").format(), Format::Png);
    for name in ["a.jpg", "a", "exr"] {
        assert!(matches!(Target::picture(&at(name), false), Err(WriteError::UnknownExtension { .. })), "{name}");
    }
    assert!(matches!(Target::picture(&at("b/c/a.exr"), false), Err(WriteError::FolderMissing { .. })));
    assert!(!at("b").exists());
    assert!(Target::picture(&at("b/c/a.exr"), true).is_ok() && at("b/c").is_dir());
    std::fs::create_dir(at("d.exr")).expect("folder");
    assert!(matches!(Target::picture(&at("d.exr"), false), Err(WriteError::IsFolder { .. })));
    assert!(matches!(Target::picture(Path::new("/proc/a.exr"), false), Err(WriteError::CannotCreate { .. })));
    assert!(!at("a.EXR").exists() && !at("a.png").exists(), "a probe leaves nothing");
}

/// 8-bit values of the sRGB curve at its ends, its break and middle grey [IEC61966].
#[test]
fn a_png_holds_clamped_srgb_with_the_exposure_applied() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("a.png");
    let values = [-1.0, 0.0, 0.0031308, 0.214_041_14, 1.0, 7.0, f32::NAN];
    let pixels: Vec<[f32; 3]> = values.iter().map(|&v| [v, v / 2.0, 0.0]).collect();
    let image = Image::from_rgb(7, 1, &pixels);
    png::write(&path, &image, 0.0).expect("written");
    let read = image::open(&path).expect("a PNG").into_rgb8();
    assert_eq!(read.pixels().map(|p| p.0[0]).collect::<Vec<_>>(), [0, 0, 10, 128, 255, 255, 0]);
    png::write(&path, &image, 1.0).expect("written");
    let read = image::open(&path).expect("a PNG").into_rgb8();
    assert_eq!(read.pixels().map(|p| p.0[1]).collect::<Vec<_>>(), [0, 0, 10, 128, 255, 255, 0]);
}

/// Read by the PLY crate that the importer uses, an implementation of its own.
#[test]
fn photons_are_dumped_as_a_ply_of_points_and_ellipses() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("map.ply");
    let photon = |x: f32, flux: [f32; 3]| DumpedPhoton {
        position: [x, 0.0, 0.0],
        normal: [0.0, 1.0, 0.0],
        flux,
        axes: [[0.5, 0.0, 0.0], [0.0, 0.0, 0.25]],
    };
    photon_dump::write(&path, &[photon(1.0, [4.0, 0.0, 2.0]), photon(2.0, [0.0; 3])], 4).expect("written");
    let mut file = std::io::BufReader::new(std::fs::File::open(&path).expect("there"));
    let ply = ply_rs_bw::parser::Parser::<ply_rs_bw::ply::DefaultElement>::new().read_ply(&mut file).expect("a PLY");
    let (vertices, faces) = (&ply.payload["vertex"], &ply.payload["face"]);
    assert_eq!((vertices.len(), faces.len()), (10, 2));
    let float = |i: usize, name: &str| match vertices[i][name] {
        ply_rs_bw::ply::Property::Float(v) => v,
        ref other => panic!("{name}: {other:?}"),
    };
    let position = |i: usize| [float(i, "x"), float(i, "y"), float(i, "z")];
    let expected = [[1.0, 0.0, 0.0], [1.5, 0.0, 0.0], [1.0, 0.0, 0.25], [0.5, 0.0, 0.0], [1.0, 0.0, -0.25]];
    for (i, corner) in expected.into_iter().enumerate() {
        for (ours, theirs) in position(i).into_iter().zip(corner) {
            assert!((ours - theirs).abs() < 1e-6, "vertex {i}: {:?}, expected {corner:?}", position(i));
        }
    }
    assert_eq!((float(3, "flux_b"), float(3, "ny")), (2.0, 1.0));
    assert!(matches!(vertices[0]["red"], ply_rs_bw::ply::Property::UChar(255)));
    // Half the brightest, sRGB-encoded.
    assert!(matches!(vertices[0]["blue"], ply_rs_bw::ply::Property::UChar(188)));
    assert!(matches!(&faces[1]["vertex_indices"], ply_rs_bw::ply::Property::ListUInt(c) if *c == [6, 7, 8, 9]));
}

#[test]
fn a_birth_certificate_is_json_beside_the_picture() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let picture = folder.path().join("a.exr");
    let settings = RenderSettings {
        kernel: KernelShape::Cone,
        bandwidth: Bandwidth::Scale(3.5),
        layers: vec![Layer::Normal],
        ..RenderSettings::default()
    };
    let certificate = BirthCertificate {
        schema: sidecar::SCHEMA,
        settings: settings_by_name(&settings),
        counters: [("degenerate_footprints".to_owned(), 3)].into(),
        seconds: 1.25,
        ..BirthCertificate::default()
    };
    certificate.write_beside(&picture).expect("written");
    let text = std::fs::read_to_string(folder.path().join("a.exr.json")).expect("beside the picture");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(json["settings"]["bandwidth"], 3.5);
    assert_eq!(json["settings"]["layers"][0], "N");
    assert_eq!(json["settings"]["kernel"], "cone");
    assert_eq!(json["counters"]["degenerate_footprints"], 3);
    // Every field of the settings has its line; layers and those of groups share one.
    let fields = format!("{settings:?}").matches(": ").count() - 1;
    assert_eq!(json["settings"].as_object().expect("a table").len(), fields);
    let has = |circumstances: bool, name: &str| certificate.attributes(circumstances).iter().any(|(n, _)| n == name);
    assert!(has(false, "seed") && has(true, "seconds") && !has(false, "seconds"));
}
