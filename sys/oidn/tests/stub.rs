//! The binding against a library of its own interface, compiled here, under the names of either version; and against the
//! real one where there is one.

use std::path::{Path, PathBuf};
use std::process::Command;

use oidn_at_run_time::{Error, Library, Picture};

/// The stub with the function of a version; `None`, with a note, without a C compiler.
fn stub(folder: &Path, set_flag: &str) -> Option<PathBuf> {
    let path = folder.join(format!("{set_flag}.so"));
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/stub.c");
    let built = Command::new("cc")
        .args(["-shared", "-fPIC", "-o"])
        .arg(&path)
        .arg(format!("-DSET_FLAG={set_flag}"))
        .arg(source)
        .status();
    match built {
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

#[test]
fn both_versions_get_every_image_and_give_the_result() {
    let folder = tempfile::tempdir().expect("temporary folder");
    for version in ["oidnSetFilter1b", "oidnSetFilterBool"] {
        let Some(path) = stub(folder.path(), version) else { return };
        let library = Library::open(&path).unwrap_or_else(|error| panic!("{version}: {error}"));
        let colour: Vec<f32> = (0..3 * 5 * 4).map(|i| i as f32).collect();
        let albedo = vec![1.0f32; colour.len()];
        let plain = Picture { width: 5, height: 4, colour: &colour, albedo: None, normal: None };
        let doubled: Vec<f32> = colour.iter().map(|c| 2.0 * c).collect();
        assert_eq!(library.denoise(&plain).expect("a picture"), doubled);
        let with_albedo = Picture { albedo: Some(&albedo), normal: Some(&albedo), ..plain };
        let mean: Vec<f32> = colour.iter().map(|c| (c + 1.0) / 2.0).collect();
        assert_eq!(library.denoise(&with_albedo).expect("a picture"), mean);
        let dark = vec![-1.0f32; colour.len()];
        let error = library.denoise(&Picture { colour: &dark, ..plain }).expect_err("the library's message");
        assert_eq!(error.to_string(), "Open Image Denoise: negative light");
        assert!(matches!(library.denoise(&Picture { width: 6, ..plain }), Err(Error::Size { wanted: 72, .. })));
        assert!(matches!(
            library.denoise(&Picture { normal: Some(&[0.0]), ..plain }),
            Err(Error::Size { found: 1, .. })
        ));
    }
}

#[test]
fn what_is_no_such_library_is_told() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let text = folder.path().join("text.so");
    std::fs::write(&text, "text").expect("written");
    for path in [text, folder.path().join("none.so")] {
        assert!(matches!(Library::open(&path), Err(Error::Unusable { .. })));
    }
    let Some(path) = stub(folder.path(), "somethingElse") else { return };
    let error = Library::open(&path).expect_err("a function is missing").to_string();
    assert!(error.contains("oidnSetFilterBool") && error.contains("oidnSetFilter1b"), "{error}");
}

/// Noise of a fifth around an even grey goes by nine tenths; an edge stays. Skipped where the library is not installed.
#[test]
fn the_real_library_takes_noise_away() {
    let Ok(library) = Library::find() else { return eprintln!("skipped: Open Image Denoise is not installed") };
    let (width, height) = (96, 64);
    let mut state = 1u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(u32::MAX) - 0.5
    };
    let truth = |i: usize| if i / 3 % width < width / 2 { 0.2 } else { 2.0 };
    let colour: Vec<f32> = (0..3 * width * height).map(|i| (truth(i) * (1.0 + 0.7 * noise())) as f32).collect();
    let smooth =
        library.denoise(&Picture { width, height, colour: &colour, albedo: None, normal: None }).expect("a picture");
    let error = |picture: &[f32]| {
        let square = |(i, v): (usize, &f32)| (f64::from(*v) / truth(i) - 1.0).powi(2);
        (picture.iter().enumerate().map(square).sum::<f64>() / picture.len() as f64).sqrt()
    };
    assert!(error(&smooth) < 0.2 * error(&colour), "{} of {}", error(&smooth), error(&colour));
}
