//! `--denoise` with a library that stands in for Open Image Denoise, with a broken one and without one.

use std::path::{Path, PathBuf};
use std::process::Command;

use pdembree::film::Image;
use pdembree::output::exr;

use crate::support::data::root;

/// Half of the sum of the colour it gets and the albedo: `sys/oidn/tests/stub.c`. `None`, with a note, without a C compiler.
fn stub(folder: &Path) -> Option<PathBuf> {
    let path = folder.join("stub.so");
    let source = root().join("sys/oidn/tests/stub.c");
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-DSET_FLAG=oidnSetFilter1b", "-o"]).arg(&path).arg(source);
    match compiler.status() {
        Ok(status) => {
            assert!(status.success(), "the stub does not compile");
            Some(path)
        }
        Err(error) => {
            eprintln!("skipped: cc: {error}");
            None
        }
    }
}

/// The picture of a small ball lens, and what was said.
fn rendered(folder: &Path, library: &Path, options: &[&str]) -> (Image, String) {
    let output = folder.join(format!("ball{}.exr", options.join("")));
    let mut command = Command::new(env!("CARGO_BIN_EXE_pdembree"));
    command
        .env("PDEMBREE_OIDN", library)
        .arg("render")
        .arg(root().join("scenes/tests/ball_lens.toml"))
        .arg("-o")
        .arg(&output);
    command.args(["-D", "camera.resolution=[24,16]", "--photons", "5k", "--spp", "2", "--layers", "caustic,albedo,N"]);
    let done = command.args(options).output().expect("it starts");
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.success(), "{said}");
    (exr::read_file(&output).expect("a picture").image, said)
}

#[test]
fn all_light_but_caustics_is_denoised_and_the_noisy_picture_kept() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let Some(library) = stub(folder.path()) else { return };
    let (plain, _) = rendered(folder.path(), &library, &[]);
    let (smooth, said) = rendered(folder.path(), &library, &["--denoise=on"]);
    if cfg!(not(feature = "oidn")) {
        assert!(said.contains("without the feature"), "{said}");
        return;
    }
    let (all, _) = rendered(folder.path(), &library, &["--denoise=auto", "--denoise-caustics"]);
    let layers = |image: &Image, name: &str| image.rgb(name).map(|rgb| rgb.map(<[f32]>::to_vec)).expect("the layer");
    assert_eq!(layers(&smooth, "noisy"), layers(&plain, ""));
    assert!(plain.channel("noisy.R").is_none());
    let certificate = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a certificate");
    assert!(certificate("ball--denoise=on.exr.json").contains("\"denoised\": true"));
    assert!(certificate("ball.exr.json").contains("\"denoised\": false"));
    let [beauty, caustic, albedo] = ["", "caustic", "albedo"].map(|name| layers(&plain, name));
    let lit = caustic[0].iter().filter(|c| **c > 0.0).count();
    assert!(lit > 10, "{lit} pixels with caustics");
    for c in 0..3 {
        for p in 0..plain.pixels() {
            let (b, k, a) = (beauty[c][p], caustic[c][p], albedo[c][p]);
            assert_eq!(layers(&smooth, "")[c][p], ((b - k).max(0.0) + a) / 2.0 + k, "pixel {p}");
            assert_eq!(layers(&all, "")[c][p], (b + a) / 2.0, "pixel {p}");
        }
    }
}

#[test]
fn a_library_that_is_none_is_told_and_nothing_is_lost() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let none = folder.path().join("none.so");
    let (plain, _) = rendered(folder.path(), &none, &[]);
    let (same, said) = rendered(folder.path(), &none, &["--denoise=on"]);
    assert_eq!(plain, same);
    assert_eq!(said.matches("not denoised").count(), 1, "{said}");
}
