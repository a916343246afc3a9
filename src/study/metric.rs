//! Differences between a picture and its reference, as numbers.
//!
//! All are means over pixels and the three colour channels of linear values, unless a line says otherwise. A picture
//! with NaN or infinite pixels, or of another size, has no metric: such pictures are refused, never skipped over.

use super::flip::{Rgb, flip_hdr, flip_ldr};
use super::ssim::ssim;
use crate::film::Image;
use crate::output::png::srgb_encode;

/// Which numbers SSIM sees; both are clamped to [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SsimDomain {
    /// The sRGB-encoded picture, as one looks at it.
    #[default]
    Srgb,
    /// Linear values.
    Linear,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Layer that is compared, by its prefix; empty: the beauty `R G B`.
    pub layer: String,
    /// Both pictures are multiplied by 2^`exposure` for SSIM and FLIP, which look at the displayable range only.
    pub exposure: f64,
    pub ssim_domain: SsimDomain,
    /// Leave FLIP out, which takes longer than all the rest together.
    pub no_flip: bool,
}

/// What a comparison found. `test` is the picture that is judged.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Comparison {
    pub width: u32,
    pub height: u32,
    /// Mean |test − reference|.
    pub mae: f64,
    /// √ of the mean (test − reference)².
    pub rmse: f64,
    /// The same of the values that a display shows: times 2^exposure, clamped to [0, 1], linear.
    pub rmse_shown: f64,
    /// Mean of (test − reference)² / (reference² + 0.01).
    pub rel_mse: f64,
    /// The same without the worst 0.1 % of the pixels, so that a few fireflies cannot speak for the picture.
    pub rel_mse_trimmed: f64,
    /// Largest |test − reference| of any channel.
    pub max_error: f64,
    /// Pixel (x, y) of the largest error, the first in reading order.
    pub max_error_at: [u32; 2],
    /// Mean test − reference.
    pub bias: f64,
    /// The same for R, G and B alone.
    pub bias_rgb: [f64; 3],
    /// Mean SSIM over R, G and B; none if a side is shorter than 11 pixels.
    pub ssim: Option<f64>,
    /// Mean LDR FLIP `[Andersson20]` of the 8-bit sRGB pictures at 67 pixels per degree; none without the feature `flip`.
    pub flip: Option<f64>,
    /// Mean HDR FLIP `[Andersson21]`: the largest LDR FLIP over the exposures that the reference asks for; needs no
    /// exposure of ours.
    pub flip_hdr: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MetricError {
    #[error("the sizes differ: {test:?} and {reference:?} pixels; compare pictures of the same size")]
    SizesDiffer { test: [u32; 2], reference: [u32; 2] },
    #[error("the {which} has no channels {}; choose a layer that both have", channels(.layer))]
    LayerMissing { which: Which, layer: String },
    #[error(
        "the {which} has values that are NaN or infinite: {counts:?} in R, G, B, the first in pixel {first:?}; no \
         difference is defined for them"
    )]
    NotFinite { which: Which, counts: [u64; 3], first: [u32; 2] },
    #[error("there are no pixels to compare")]
    Empty,
}

/// Which of the two pictures an error is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    Test,
    Reference,
}

impl std::fmt::Display for Which {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Which::Test => "picture",
            Which::Reference => "reference",
        })
    }
}

fn channels(layer: &str) -> String {
    if layer.is_empty() { "R G B".to_owned() } else { format!("{layer}.R {layer}.G {layer}.B") }
}

/// Compares `test` with `reference`.
pub fn compare(test: &Image, reference: &Image, options: &Options) -> Result<Comparison, MetricError> {
    compare_masked(test, reference, None, options)
}

/// Compares the pixels that `mask` holds, row by row; the others count for nothing. SSIM and FLIP look at the
/// surroundings of a pixel, too: there the others are taken to be the same in both pictures.
pub fn compare_masked(
    test: &Image,
    reference: &Image,
    mask: Option<&[bool]>,
    options: &Options,
) -> Result<Comparison, MetricError> {
    let size = |image: &Image| [image.width, image.height];
    if size(test) != size(reference) {
        return Err(MetricError::SizesDiffer { test: size(test), reference: size(reference) });
    }
    let held: Vec<usize> = (0..test.pixels()).filter(|&i| mask.is_none_or(|mask| mask[i])).collect();
    if held.is_empty() {
        return Err(MetricError::Empty);
    }
    let rgb = |image, which| finite_rgb(image, which, &options.layer);
    let (a, b) = (rgb(test, Which::Test)?, rgb(reference, Which::Reference)?);
    let pixels = held.len();
    let samples = 3.0 * pixels as f64;
    let shown = |v: f64| (v * options.exposure.exp2()).clamp(0.0, 1.0);

    let (mut absolute, mut square, mut square_shown) = (0.0, 0.0, 0.0);
    let (mut bias_rgb, mut max_error, mut max_at) = ([0.0; 3], 0.0, held[0]);
    let mut relative = vec![0.0; pixels];
    for c in 0..3 {
        for (place, &i) in held.iter().enumerate() {
            let (t, r) = (f64::from(a[c][i]), f64::from(b[c][i]));
            let error = t - r;
            absolute += error.abs();
            square += error * error;
            square_shown += (shown(t) - shown(r)).powi(2);
            bias_rgb[c] += error;
            relative[place] += error * error / (r * r + 0.01) / 3.0;
            if error.abs() > max_error || error.abs() == max_error && i < max_at {
                (max_error, max_at) = (error.abs(), i);
            }
        }
    }
    // What is not compared shall make no difference to its neighbours.
    let patched = mask.map(|mask| patched(a, b, mask));
    let a = patched.as_ref().map_or(a, |channels| channels.each_ref().map(Vec::as_slice));
    let rel_mse = relative.iter().sum::<f64>() / pixels as f64;
    let width = test.width as usize;
    Ok(Comparison {
        width: test.width,
        height: test.height,
        mae: absolute / samples,
        rmse: (square / samples).sqrt(),
        rmse_shown: (square_shown / samples).sqrt(),
        rel_mse,
        rel_mse_trimmed: trimmed_mean(relative),
        max_error,
        max_error_at: [(max_at % width) as u32, (max_at / width) as u32],
        bias: bias_rgb.iter().sum::<f64>() / samples,
        bias_rgb: bias_rgb.map(|sum| sum / pixels as f64),
        ssim: mean_ssim(a, b, width, mask, options),
        flip: if options.no_flip { None } else { flip_ldr(a, b, size(test), mask, options.exposure) },
        flip_hdr: if options.no_flip { None } else { flip_hdr(a, b, size(test), mask) },
    })
}

fn finite_rgb<'a>(image: &'a Image, which: Which, layer: &str) -> Result<Rgb<'a>, MetricError> {
    let rgb = image.rgb(layer).ok_or_else(|| MetricError::LayerMissing { which, layer: layer.to_owned() })?;
    let counts = rgb.map(|channel| channel.iter().filter(|v| !v.is_finite()).count() as u64);
    let first = (0..image.pixels()).find(|&i| rgb.iter().any(|channel| !channel[i].is_finite()));
    match first {
        None => Ok(rgb),
        Some(i) => {
            let width = image.width as usize;
            Err(MetricError::NotFinite { which, counts, first: [(i % width) as u32, (i / width) as u32] })
        }
    }
}

/// Mean without the largest 0.1 % (rounded down) of the values.
fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let kept = values.len() - values.len() / 1000;
    values[..kept].iter().sum::<f64>() / kept as f64
}

/// `a` with the pixels of `b` where `mask` does not hold.
fn patched(a: Rgb, b: Rgb, mask: &[bool]) -> [Vec<f32>; 3] {
    let channel = |c: usize| (0..mask.len()).map(|i| if mask[i] { a[c][i] } else { b[c][i] }).collect();
    [channel(0), channel(1), channel(2)]
}

fn mean_ssim(a: Rgb, b: Rgb, width: usize, mask: Option<&[bool]>, options: &Options) -> Option<f64> {
    let gain = options.exposure.exp2();
    let view = |channel: &[f32]| -> Vec<f64> {
        let clamped = channel.iter().map(|&v| (f64::from(v) * gain).clamp(0.0, 1.0));
        match options.ssim_domain {
            SsimDomain::Srgb => clamped.map(srgb_encode).collect(),
            SsimDomain::Linear => clamped.collect(),
        }
    };
    let one = |c: usize| ssim(&view(a[c]), &view(b[c]), width, mask);
    Some((one(0)? + one(1)? + one(2)?) / 3.0)
}
