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

/// One comparison with a reference picture: which layer of ours with which picture, and how many of the reference's
/// pixels make one of ours, which is exact for their box filter.
struct Comparison {
    scene: &'static str,
    layer: &'static str,
    reference: &'static str,
    block: usize,
    overrides: &'static [(&'static str, &'static str)],
}

struct Errors {
    rel_mse: f64,
    /// Our flux over the reference's, and its standard error from the scatter of the pixels.
    flux: f64,
    flux_error: f64,
}

/// `None` without the shared data.
fn errors(comparison: &Comparison) -> Option<Errors> {
    let &Comparison { scene, layer, reference, block, overrides } = comparison;
    let [reference, mask] = [reference, "maskC"].map(|kind| shared(&format!("peers/{scene}_{kind}.exr")));
    let (reference, mask) = (read(&reference?), read(&mask?));
    let overrides: Vec<Override> = overrides.iter().map(|&(k, v)| Override::new(k, v)).collect();
    let path = root().join(format!("tests/images/peers/{scene}.toml"));
    let loaded = load(&path, &overrides).unwrap_or_else(|problems| panic!("{problems}"));
    let world = World::new(loaded.scene).expect("a world");
    let image = render(&world, &Silent).expect("a render").film.resolve();

    let ours = green(&image, layer);
    let theirs = block_means(&green(&reference, ""), reference.width as usize, block);
    let lit: Vec<f64> = mask.channels[0].samples.iter().map(|&v| f64::from(v)).collect();
    // Pixels that the caustic lights as a whole.
    let lit = block_means(&lit, mask.width as usize, block);
    assert!(ours.len() == theirs.len() && ours.len() == lit.len(), "pictures of one size");
    let pairs: Vec<[f64; 2]> = (0..ours.len()).filter(|&i| lit[i] > 0.999).map(|i| [ours[i], theirs[i]]).collect();
    let mut squares: Vec<f64> = pairs.iter().map(|[a, b]| (a - b).powi(2) / (b * b + 0.01)).collect();
    squares.sort_by(f64::total_cmp);
    squares.truncate(squares.len() - squares.len() / 1000);
    let n = pairs.len() as f64;
    let total = |k: usize| pairs.iter().map(|pair| pair[k]).sum::<f64>();
    let variance = pairs.iter().map(|[a, b]| (a - b).powi(2)).sum::<f64>() / n - ((total(0) - total(1)) / n).powi(2);
    Some(Errors {
        rel_mse: squares.iter().sum::<f64>() / squares.len() as f64,
        flux: total(0) / total(1),
        flux_error: (variance * n).sqrt() / total(1),
    })
}

fn green(image: &Image, layer: &str) -> Vec<f64> {
    let [_, green, _] = image.rgb(layer).unwrap_or_else(|| panic!("no layer `{layer}`"));
    green.iter().map(|&v| f64::from(v)).collect()
}

fn block_means(samples: &[f64], width: usize, block: usize) -> Vec<f64> {
    let (columns, rows) = (width / block, samples.len() / width / block);
    let mean = |x: usize, y: usize| {
        let row = |dy: usize| &samples[(y * block + dy) * width + x * block..][..block];
        (0..block).flat_map(row).sum::<f64>() / (block * block) as f64
    };
    (0..columns * rows).map(|i| mean(i % columns, i / columns)).collect()
}

/// The flux may err by the reference's own uncertainty and by four of our standard errors.
fn check(comparison: &Comparison, reference_error: f64) {
    let Some(Errors { rel_mse, flux, flux_error }) = errors(comparison) else { return };
    println!("{}: relMSE {rel_mse:.5}, flux {flux:.4} ± {flux_error:.4} of the reference's", comparison.scene);
    assert!(rel_mse <= 0.0084, "{}: relMSE {rel_mse}", comparison.scene);
    assert!(
        (flux - 1.0).abs() < reference_error + 4.0 * flux_error,
        "{}: flux {flux} ± {flux_error}",
        comparison.scene
    );
}

#[test]
fn s1_caustic_is_nearer_than_the_best_of_its_peers() {
    let overrides = &[("render.max_bounces", "0"), ("render.spp", "2"), ("render.photons", "100000")];
    let comparison = Comparison { scene: "S1", layer: "caustic", reference: "caustic_only", block: 1, overrides };
    check(&comparison, 0.0014);
}

/// One pass of S1 as its file has it, in the caustic: what ten other renderers do not reach in ten seconds, 0.0084, 0.031 and
/// 0.86 at their best, none of them all at once. It takes 9.6 s on the slower of this machine's clocks.
#[test]
fn s1_is_right_in_three_measures_at_once() {
    let [Some(reference), Some(mask)] = ["ref", "maskC"].map(|kind| shared(&format!("peers/S1_{kind}.exr"))) else {
        return;
    };
    let (reference, mask) = (read(&reference), read(&mask));
    let loaded = load(&root().join("tests/images/peers/S1.toml"), &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let world = World::new(loaded.scene).expect("a world");
    let image = render(&world, &Silent).expect("a render").film.resolve();

    let lit: Vec<usize> = (0..image.pixels()).filter(|&i| mask.channels[0].samples[i] > 0.0).collect();
    let planes = |image: &Image| image.rgb("").expect("a colour picture").map(<[f32]>::to_vec);
    let (ours, theirs) = (planes(&image), planes(&reference));
    let pairs = || lit.iter().flat_map(|&i| (0..3).map(move |k| (k, i)));
    let mean = |of: &dyn Fn(f64, f64) -> f64| {
        pairs().map(|(k, i)| of(f64::from(ours[k][i]), f64::from(theirs[k][i]))).sum::<f64>() / (3 * lit.len()) as f64
    };
    let rel_mse = mean(&|a, b| (a - b).powi(2) / (b * b + 0.01));
    let rel_rmse = (mean(&|a, b| (a - b).powi(2)) / mean(&|_, b| b * b)).sqrt();
    let seen = |planes: &[Vec<f32>; 3]| planes.each_ref().map(|plane| plane.iter().map(|&v| srgb(v)).collect());
    let (ours, theirs): ([Vec<f64>; 3], [Vec<f64>; 3]) = (seen(&ours), seen(&theirs));
    let width = image.width as usize;
    let similarity = pairs().map(|(k, i)| structural_similarity(&ours[k], &theirs[k], width, i)).sum::<f64>()
        / (3 * lit.len()) as f64;
    println!("S1: relMSE {rel_mse:.5}, relative RMSE {rel_rmse:.4}, SSIM {similarity:.4}");
    assert!(rel_mse <= 0.0010 && rel_rmse <= 0.010 && similarity >= 0.96, "{rel_mse}, {rel_rmse}, {similarity}");
}

/// As a display shows it, 0 to 1.
fn srgb(linear: f32) -> f64 {
    let x = f64::from(linear).clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// SSIM of Wang, Bovik, Sheikh and Simoncelli 2004 in the window of 7 × 7 pixels around pixel `i`, which is that far from the
/// pictures' edges, evenly weighed.
fn structural_similarity(a: &[f64], b: &[f64], width: usize, i: usize) -> f64 {
    const SIDE: usize = 7;
    const C1: f64 = 0.01 * 0.01;
    const C2: f64 = 0.03 * 0.03;
    let first = i - SIDE / 2 * (width + 1);
    let window = || (0..SIDE * SIDE).map(|j| first + j / SIDE * width + j % SIDE);
    let n = (SIDE * SIDE) as f64;
    let mean = |of: &dyn Fn(usize) -> f64| window().map(of).sum::<f64>() / n;
    let (ma, mb) = (mean(&|j| a[j]), mean(&|j| b[j]));
    let covariance = |x: &[f64], mx: f64, y: &[f64], my: f64| mean(&|j| (x[j] - mx) * (y[j] - my)) * n / (n - 1.0);
    let (va, vb, ab) = (covariance(a, ma, a, ma), covariance(b, mb, b, mb), covariance(a, ma, b, mb));
    (2.0 * ma * mb + C1) * (2.0 * ab + C2) / ((ma * ma + mb * mb + C1) * (va + vb + C2))
}

/// The whole picture, since the reference's caustic layer holds also what the lit floor sends back to the walls. Blocks
/// of four pixels, so that path tracing's noise is small enough.
#[test]
fn s3_is_as_the_others_see_it() {
    let overrides = &[("camera.resolution", "[128, 128]"), ("render.spp", "32"), ("render.photons", "100000")];
    let comparison = Comparison { scene: "S3", layer: "", reference: "ref", block: 4, overrides };
    check(&comparison, 0.007);
}
