//! Our EXR files as OpenImageIO sees them.

use std::path::Path;
use std::process::Command;

use pdembree::film::{Channel, Image};
use pdembree::output::exr;

/// Runs a tool of OpenImageIO and returns its exit code and what it printed; `None`, with a note, if it is not installed.
/// With `PDEMBREE_REQUIRE_OIIO=1` a missing tool is a failure.
fn oiio(tool: &str, arguments: &[&str]) -> Option<(i32, String)> {
    match Command::new(tool).args(arguments).output() {
        Ok(output) => {
            let text = [output.stdout, output.stderr].concat();
            Some((output.status.code().expect("an exit code"), String::from_utf8_lossy(&text).into_owned()))
        }
        Err(error) => {
            assert!(std::env::var_os("PDEMBREE_REQUIRE_OIIO").is_none_or(|v| v != "1"), "{tool}: {error}");
            eprintln!("skipped: {tool} is not installed (Debian package openimageio-tools)");
            None
        }
    }
}

fn utf8(path: &Path) -> &str {
    path.to_str().expect("a UTF-8 path")
}

fn picture(scale: f32) -> Image {
    let names =
        ["R", "G", "B", "A", "caustic.R", "caustic.G", "caustic.B", "N.X", "N.Y", "N.Z", "Z", "photons.density"];
    let channel = |(c, name): (usize, &&str)| Channel {
        name: (*name).to_owned(),
        samples: (0..48 * 31).map(|i| scale * (c as f32 + i as f32 / 7.0)).collect(),
    };
    Image { width: 48, height: 31, channels: names.iter().enumerate().map(channel).collect() }
}

#[test]
fn oiiotool_reads_one_flat_scan_line_part_with_all_layers() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("a.exr");
    exr::write(&path, &picture(1.0), &[("seed".to_owned(), "42".to_owned())]).expect("written");
    let Some((code, text)) = oiio("oiiotool", &["--info", "-v", utf8(&path)]) else { return };
    assert_eq!(code, 0, "{text}");
    let expected = [
        "48 x   31, 12 channel, float openexr",
        "R, G, B, A, Z, N.X, N.Y, N.Z",
        "caustic.R, caustic.G, caustic.B",
        "photons.density",
        "compression: \"zip\"",
        "chromaticities: 0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329",
        "Software: \"pdembree ",
        "pdembree/seed: \"42\"",
        "oiio:subimages: 1",
    ];
    for line in expected {
        assert!(text.contains(line), "no {line:?} in\n{text}");
    }
    assert!(!text.contains("tile size") && !text.contains(" subimages"), "{text}");
}

#[test]
fn idiff_finds_equal_files_equal_and_others_not() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = |name: &str| folder.path().join(name);
    exr::write(&at("a.exr"), &picture(1.0), &[]).expect("written");
    exr::write(&at("b.exr"), &picture(1.0), &[("seed".to_owned(), "1".to_owned())]).expect("written");
    exr::write(&at("c.exr"), &picture(1.001), &[]).expect("written");
    let diff = |other: &str| oiio("idiff", &["-q", utf8(&at("a.exr")), utf8(&at(other))]);
    let Some((same, text)) = diff("b.exr") else { return };
    assert_eq!(same, 0, "{text}");
    assert_ne!(diff("c.exr").expect("idiff is there").0, 0);
}

/// oiiotool writes half floats with another compression, tiled; we read the same picture.
#[test]
fn files_of_others_are_read() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = |name: &str| folder.path().join(name);
    exr::write(&at("a.exr"), &picture(0.25), &[]).expect("written");
    let arguments =
        [utf8(&at("a.exr")).to_owned(), "-d".into(), "half".into(), "--tile".into(), "16".into(), "16".into()];
    let tail = ["--compression".to_owned(), "piz".into(), "-o".into(), utf8(&at("b.exr")).to_owned()];
    let all: Vec<&str> = arguments.iter().chain(&tail).map(String::as_str).collect();
    let Some((code, text)) = oiio("oiiotool", &all) else { return };
    assert_eq!(code, 0, "{text}");
    let (ours, theirs) = (exr::read_file(&at("a.exr")).expect("ours"), exr::read_file(&at("b.exr")).expect("theirs"));
    for channel in &ours.image.channels {
        let other = theirs.image.channel(&channel.name).expect("the same channels");
        for (a, b) in channel.samples.iter().zip(other) {
            // Half floats round to 11 significant bits.
            assert!((a - b).abs() <= a.abs() / 2048.0, "{}: {a} {b}", channel.name);
        }
    }
}
