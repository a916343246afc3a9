//! The metrics against independent implementations and against pictures whose differences are known by construction.

use pdembree::film::{Channel, Image};
use pdembree::study::compare::Judge;
use pdembree::study::exact::ClosedForm;
use pdembree::study::plan::{Experiment, ReferencePlan, StudyScene};
use pdembree::study::reference::Reference;
use pdembree::study::results::Metrics;
use pdembree::study::{MetricError, Options, SsimDomain, StudyError, compare};

/// Reference and test of tests/support/metric_reference.py, made by `value` of its integers (units of 1/64).
fn patterns(width: i32, height: i32, amount: i32, value: impl Fn(i32) -> f32) -> (Image, Image) {
    let at = |x: i32, y: i32, c: i32| (x * (c + 1) + 3 * y) % 65;
    let noise = |x: i32, y: i32, c: i32| (x * y + 7 * c) % 9 - 4;
    let picture = |amount: i32| {
        let pixel = |i: i32| {
            let (x, y) = (i % width, i / width);
            [0, 1, 2].map(|c| value(at(x, y, c) + amount * noise(x, y, c)))
        };
        let rgb: Vec<[f32; 3]> = (0..width * height).map(pixel).collect();
        Image::from_rgb(width as u32, height as u32, &rgb)
    };
    (picture(amount), picture(0))
}

pub fn pictures() -> (Image, Image) {
    patterns(61, 43, 1, |n| n as f32 / 64.0)
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

/// Width, height, noise, squarings and gain of pictures in linear light; their HDR FLIP by flip-evaluator 1.7, and by its
/// LDR FLIP on pictures of eight bits at each exposure.
const BRIGHT: [([i32; 4], f64, [f64; 2]); 6] = [
    ([61, 43, 1, 0], 4.0, [0.09521543249854299, 0.09542985113988817]),
    ([61, 43, 1, 2], 16.0, [0.13280565211470577, 0.13256821807813335]),
    ([64, 48, 2, 2], 16.0, [0.2547407263276303, 0.25449028582079336]),
    ([64, 48, 1, 3], 4096.0, [0.17954210793247208, 0.17949765006460439]),
    ([97, 30, 3, 1], 0.25, [0.29715245413718766, 0.29722132283899794]),
    ([30, 97, 4, 3], 100.0, [0.6106397569819619, 0.6105273749487302]),
];

/// What nv-flip's LDR FLIP is off in the parts of a picture below: 1.2e-4 to 2.2e-4.
const OLDER_FLIP: f64 = 3e-4;
/// The same of its HDR FLIP of eight bits: 0.6e-4 to 1.5e-4 over the pictures above.
const OLDER_HDR_FLIP: f64 = 2e-4;
/// nv-flip takes eight bits. Over 48 such pictures (three sizes, four amounts of noise, four ranges of brightness) that
/// alone changed flip-evaluator's mean HDR FLIP by -1.8e-3 to 2.3e-3 of the value.
const EIGHT_BITS: f64 = 3e-3;

#[test]
fn hdr_flip_agrees_with_its_authors() {
    for ([width, height, amount, squarings], gain, [theirs, of_eight_bits]) in BRIGHT {
        let value = |n: i32| ((0..squarings).fold(f64::from(n.max(0)) / 64.0, |v, _| v * v) * gain) as f32;
        let (test, reference) = patterns(width, height, amount, value);
        let found = compare(&test, &reference, &Options::default()).expect("comparable");
        if cfg!(feature = "flip") {
            let ours = found.flip_hdr.expect("in this binary");
            close("HDR FLIP", ours, theirs, EIGHT_BITS * theirs);
            close("HDR FLIP of eight bits", ours, of_eight_bits, OLDER_HDR_FLIP * of_eight_bits);
        }
    }
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

/// What a study says of `test`: white is 0.375, `region` and `mask` as given.
fn judged(
    [test, reference]: [&Image; 2],
    ssim: SsimDomain,
    region: Option<[u32; 4]>,
    mask: Option<Vec<bool>>,
) -> Result<Metrics, StudyError> {
    let scene = StudyScene {
        name: "pattern".to_owned(),
        file: "none.toml".into(),
        overrides: vec![],
        layer: String::new(),
        white: 0.375,
        ssim,
        reference: ReferencePlan::Exact(ClosedForm::Wave),
    };
    let reference = Reference {
        image: reference.clone(),
        error: vec![[0.0; 3]; reference.pixels()],
        mask,
        about: String::new(),
        seconds: 0.0,
        notes: vec![],
    };
    let experiment = Experiment {
        name: String::new(),
        about: String::new(),
        scenes: vec![0],
        methods: vec![],
        budgets: vec![],
        seeds: vec![],
        baseline: None,
        published: vec![],
        crop: None,
        region,
    };
    Judge::new(&scene, &reference, &experiment)?.metrics(test, "test")
}

/// The whole way of a study's numbers, with its white, region and mask, against tests/support/metric_reference.py.
#[test]
fn a_study_judges_as_independent_implementations_do() {
    let (test, reference) = patterns(61, 43, 1, |n| n.max(0) as f32 / 64.0);
    let region = Some([12, 8, 40, 36]);
    let mask: Vec<bool> = (0..61 * 43).map(|i| (i % 61 + 2 * (i / 61)) % 5 > 0).collect();
    // RMSE as shown, linear RMSE, relMSE, MAE, SSIM of linear values, SSIM of sRGB, FLIP, HDR FLIP.
    let expected = [
        (
            None,
            None,
            [
                0.06484708078851291,
                0.10839396512102682,
                0.057510749522622015,
                0.09344685879866298,
                0.9340224793146339,
                0.9202849764581067,
                0.09554375561070029,
                0.09521541010241868,
            ],
        ),
        (
            region,
            None,
            [
                0.06464228109786348,
                0.10812012870142963,
                0.05872658390682727,
                0.09312995907780873,
                0.940257636896493,
                0.9278994747162553,
                0.08870643672143698,
                0.0887372424678725,
            ],
        ),
        (
            region,
            Some(mask),
            [
                0.06397954824648122,
                0.10812200682538349,
                0.057692651427872096,
                0.09312422346008832,
                0.9520183317289778,
                0.9413725615433874,
                0.08589169297714909,
                0.08451894575513103,
            ],
        ),
    ];
    for (region, mask, theirs) in expected {
        let ours = judged([&test, &reference], SsimDomain::Linear, region, mask.clone()).expect("comparable");
        let srgb = judged([&test, &reference], SsimDomain::Srgb, region, mask).expect("comparable");
        let [rmse, linear, rel_mse, mae, ssim_linear, ssim_srgb, flip, flip_hdr] = theirs;
        let rounding = 1e-14;
        close("rmse shown", ours.rmse, rmse, rounding);
        close("rmse linear", ours.rmse_linear, linear, rounding);
        close("rel_mse", ours.rel_mse, rel_mse, rounding);
        close("mae", ours.mae, mae, rounding);
        close("ssim of linear values", ours.ssim.expect("large enough"), ssim_linear, 1e-9);
        close("ssim", srgb.ssim.expect("large enough"), ssim_srgb, 1e-9);
        if cfg!(feature = "flip") {
            close("FLIP", ours.flip.expect("in this binary"), flip, OLDER_FLIP * flip);
            close("HDR FLIP", ours.flip_hdr.expect("in this binary"), flip_hdr, EIGHT_BITS * flip_hdr);
        }
    }
}
