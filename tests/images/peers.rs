//! Scenes that other renderers were measured on, against their converged pictures in the optional shared data.
//!
//! Measured as their README does: relMSE, the mean of the squared error over (reference² + 0.01) in the region that the
//! caustic lights, the worst 0.1 % of the pixels left out. The best of the other renderers reaches 0.0084 on S1 within ten
//! seconds.

use std::path::Path;

use pdembree::film::Image;
use pdembree::import::{Override, load};
use pdembree::output::exr;
use pdembree::render::progress::Silent;
use pdembree::render::render;
use pdembree::world::World;

use crate::support::data::{root, shared};

fn read(path: &Path) -> Image {
    exr::read_file(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).image
}

/// relMSE of the caustic layer, and its flux over the reference's.
fn caustic_errors(scene: &str) -> Option<[f64; 2]> {
    let [reference, mask] = ["caustic_only", "maskC"].map(|kind| shared(&format!("peers/{scene}_{kind}.exr")));
    let (reference, mask) = (read(&reference?), read(&mask?));
    let overrides = [("render.max_bounces", "0"), ("render.spp", "4")].map(|(k, v)| Override::new(k, v));
    let path = root().join(format!("tests/images/peers/{scene}.toml"));
    let loaded = load(&path, &overrides).unwrap_or_else(|problems| panic!("{problems}"));
    let world = World::new(loaded.scene).expect("a world");
    let image = render(&world, &Silent).expect("a render").film.resolve();

    let green = |image: &Image, layer: &str| -> Vec<f64> {
        let [_, green, _] = image.rgb(layer).unwrap_or_else(|| panic!("no layer `{layer}`"));
        green.iter().map(|&v| f64::from(v)).collect()
    };
    let (ours, theirs) = (green(&image, "caustic"), green(&reference, ""));
    let lit = &mask.channels[0].samples;
    assert!(ours.len() == theirs.len() && ours.len() == lit.len(), "pictures of one size");
    let inside = (0..ours.len()).filter(|&i| lit[i] > 0.5);
    let mut errors: Vec<f64> =
        inside.clone().map(|i| (ours[i] - theirs[i]).powi(2) / (theirs[i].powi(2) + 0.01)).collect();
    errors.sort_by(f64::total_cmp);
    errors.truncate(errors.len() - errors.len() / 1000);
    let flux = |picture: &[f64]| inside.clone().map(|i| picture[i]).sum::<f64>();
    Some([errors.iter().sum::<f64>() / errors.len() as f64, flux(&ours) / flux(&theirs)])
}

fn check(scene: &str) {
    if let Some([error, flux]) = caustic_errors(scene) {
        println!("{scene}: relMSE {error:.5}, flux {flux:.4} of the reference's");
        assert!(error <= 0.0084, "{scene}: relMSE {error}");
    }
}

#[test]
#[ignore = "a goal not reached yet: relMSE 0.030 with the automatic bandwidth, 0.0104 with 5; 2 minutes"]
fn s1_caustic_is_as_near_as_the_best_of_its_peers() {
    check("S1");
}

#[test]
#[ignore = "a goal not reached yet: relMSE 0.030, and 2.6 % less flux than the reference, as light tracing; 2 minutes"]
fn s3_caustic_is_as_near_as_the_best_of_its_peers_on_s1() {
    check("S3");
}
