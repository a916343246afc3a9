//! The metrics against independent implementations and against pictures whose differences are known by construction.

use pdembree::film::{Channel, Image};
use pdembree::study::{MetricError, Options, SsimDomain, compare};

/// The pictures of tests/support/metric_reference.py; every value is a multiple of 1/64.
pub fn pictures() -> (Image, Image) {
    let (width, height) = (61, 43);
    let at = |x: i32, y: i32, c: i32| ((x * (c + 1) + 3 * y) % 65) as f32 / 64.0;
    let noise = |x: i32, y: i32, c: i32| ((x * y + 7 * c) % 9 - 4) as f32 / 64.0;
    let picture = |amount: f32| {
        let pixel = |i: i32| {
            let (x, y) = (i % width, i / width);
            [0, 1, 2].map(|c| at(x, y, c) + amount * noise(x, y, c))
        };
        let rgb: Vec<[f32; 3]> = (0..width * height).map(pixel).collect();
        Image::from_rgb(width as u32, height as u32, &rgb)
    };
    (picture(1.0), picture(0.0))
}

fn close(name: &str, ours: f64, theirs: f64, tolerance: f64) {
    assert!((ours - theirs).abs() <= tolerance, "{name}: {ours}, the reference implementation gives {theirs}");
}

/// Numbers printed by tests/support/metric_reference.py (scikit-image 0.26.0, flip-evaluator 1.7, numpy).
#[test]
fn metrics_agree_with_independent_implementations() {
    let (test, reference) = pictures();
    let found = compare(&test, &reference, &Options::default()).expect("comparable");
    // Sums of some thousand f64 in another order.
    let rounding = 1e-14;
    close("mae", found.mae, 0.03556876667937476, rounding);
    close("rmse", found.rmse, 0.041074082891479874, rounding);
    close("bias", found.bias, -1.7870758673274875e-05, rounding);
    close("max_error", found.max_error, 0.0625, 0.0);
    close("rel_mse", found.rel_mse, 0.025835945411106814, rounding);
    close("rel_mse_trimmed", found.rel_mse_trimmed, 0.02569612756769188, rounding);
    close("ssim", found.ssim.expect("large enough"), 0.9293082273816212, 1e-9);
    // nv-flip carries an older release of FLIP: over fifteen such pictures (three sizes, five amounts of noise) its mean
    // was 1.1e-4 to 1.6e-4 of the value above that of flip-evaluator 1.7.
    if cfg!(feature = "flip") {
        let flip = found.flip.expect("in this binary");
        close("flip", flip, 0.08230885118246078, 2e-4 * 0.08230885118246078);
    }
    let linear = Options { ssim_domain: SsimDomain::Linear, ..Options::default() };
    let found = compare(&test, &reference, &linear).expect("comparable");
    close("ssim of linear values", found.ssim.expect("large enough"), 0.9380685542349907, 1e-9);
}

#[test]
fn equal_pictures_have_no_difference() {
    let (picture, _) = pictures();
    let found = compare(&picture, &picture, &Options::default()).expect("comparable");
    let zeros = [found.mae, found.rmse, found.rel_mse, found.max_error, found.bias];
    assert_eq!(zeros, [0.0; 5]);
    assert_eq!(found.flip, cfg!(feature = "flip").then_some(0.0));
    assert!((found.ssim.expect("large enough") - 1.0).abs() < 1e-12);
}

/// One pixel of 20 × 20 is brighter by (3, 0, 4), over a reference of 0: every sum is known.
#[test]
fn one_bright_pixel_gives_the_numbers_it_must() {
    let black = Image::from_rgb(20, 20, &[[0.0; 3]; 400]);
    let mut pixels = [[0.0; 3]; 400];
    pixels[7 * 20 + 11] = [3.0, 0.0, 4.0];
    let found = compare(&Image::from_rgb(20, 20, &pixels), &black, &Options::default()).expect("comparable");
    close("mae", found.mae, 7.0 / 1200.0, 1e-15);
    close("rmse", found.rmse, (25.0f64 / 1200.0).sqrt(), 1e-15);
    close("rel_mse", found.rel_mse, 2500.0 / 1200.0, 1e-12);
    assert_eq!(found.bias_rgb, [3.0 / 400.0, 0.0, 4.0 / 400.0]);
    assert_eq!((found.max_error, found.max_error_at), (4.0, [11, 7]));
    assert_eq!(found.rel_mse_trimmed, found.rel_mse, "0.1 % of 400 pixels is none");
}

#[test]
fn the_trimmed_mean_drops_one_pixel_in_a_thousand() {
    let black = Image::from_rgb(50, 20, &[[0.0; 3]; 1000]);
    let mut pixels = [[0.1; 3]; 1000];
    pixels[3] = [1e4; 3];
    let found = compare(&Image::from_rgb(50, 20, &pixels), &black, &Options::default()).expect("comparable");
    let one = f64::from(0.1f32).powi(2) / 0.01;
    close("rel_mse_trimmed", found.rel_mse_trimmed, one, 1e-12);
    assert!(found.rel_mse > 1e6);
}

#[test]
fn pictures_that_cannot_be_compared_are_refused() {
    let (picture, _) = pictures();
    let small = Image::from_rgb(2, 1, &[[0.0; 3]; 2]);
    let default = Options::default();
    assert!(matches!(compare(&picture, &small, &default), Err(MetricError::SizesDiffer { .. })));
    assert_eq!(compare(&small, &small, &default).expect("comparable").ssim, None, "no window fits");
    let layer = Options { layer: "caustic".to_owned(), ..Options::default() };
    assert!(matches!(compare(&small, &small, &layer), Err(MetricError::LayerMissing { .. })));
    let mut bad = picture.clone();
    bad.channels[1].samples[61 + 5] = f32::NAN;
    bad.channels[2].samples[61 + 7] = f32::INFINITY;
    for (test, reference) in [(&bad, &picture), (&picture, &bad)] {
        let error = compare(test, reference, &default).expect_err("not finite");
        let MetricError::NotFinite { counts, first, .. } = error else { panic!("{error}") };
        assert_eq!((counts, first), ([0, 1, 1], [5, 1]));
    }
    let empty = Image { width: 0, height: 0, channels: vec![] };
    assert_eq!(compare(&empty, &empty, &default), Err(MetricError::Empty));
}

#[test]
fn a_layer_and_a_grey_picture_are_compared_too() {
    let grey = |name: &str, value: f32| Image {
        width: 11,
        height: 11,
        channels: vec![Channel { name: name.to_owned(), samples: vec![value; 121] }],
    };
    let found = compare(&grey("Y", 0.5), &grey("Y", 0.25), &Options::default()).expect("comparable");
    assert_eq!((found.rmse, found.bias_rgb), (0.25, [0.25; 3]));
    let layer = Options { layer: "depth".to_owned(), ..Options::default() };
    assert_eq!(compare(&grey("depth.Y", 1.0), &grey("depth.Y", 3.0), &layer).expect("comparable").bias, -2.0);
}
