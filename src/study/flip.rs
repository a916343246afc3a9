//! FLIP: how different two pictures look to somebody who flips between them `[Andersson20]`, and its extension to linear
//! light, the worst over all exposures that one could look at `[Andersson21]`.
//!
//! The LDR difference itself is the crate nv-flip's, on 8-bit sRGB at 67 pixels per degree; without the feature `flip`
//! there is none.

use crate::output::png::srgb8;

/// Three channels, row by row.
pub(super) type Rgb<'a> = [&'a [f32]; 3];

/// Mean LDR FLIP of the pictures times 2^`exposure` over the pixels that `mask` holds.
pub(super) fn flip_ldr(a: Rgb, b: Rgb, size: [u32; 2], mask: Option<&[bool]>, exposure: f64) -> Option<f64> {
    let gain = exposure.exp2();
    Some(mean(&difference(a, b, size, |v| v * gain)?, mask))
}

/// Mean HDR FLIP: the pixel's largest LDR FLIP over exposures a stop or less apart, tone-mapped as films are.
pub(super) fn flip_hdr(a: Rgb, b: Rgb, size: [u32; 2], mask: Option<&[bool]>) -> Option<f64> {
    let [start, stop] = exposures(b)?;
    let count = number(start, stop);
    let mut worst = vec![0.0f32; b[0].len()];
    for i in 0..count {
        let gain = (start + (stop - start) * i as f64 / (count - 1) as f64).exp2();
        let map = difference(a, b, size, |v| tone(v.max(0.0) * gain))?;
        worst.iter_mut().zip(map).for_each(|(worst, v)| *worst = worst.max(v));
    }
    Some(mean(&worst, mask))
}

fn mean(map: &[f32], mask: Option<&[bool]>) -> f64 {
    let held = |i: &usize| mask.is_none_or(|mask| mask[*i]);
    let (mut sum, mut count) = (0.0, 0u64);
    for i in (0..map.len()).filter(held) {
        sum += f64::from(map[i]);
        count += 1;
    }
    sum / count.max(1) as f64
}

/// A rational curve (A x² + B x + C)/(D x² + E x + F): the film curve of `[Narkowicz15]` with its x scaled by 0.6, as
/// `[Andersson21]` takes it.
const CURVE: [f64; 6] = [0.36 * 2.51, 0.6 * 0.03, 0.0, 0.36 * 2.43, 0.6 * 0.59, 0.14];

fn tone(x: f64) -> f64 {
    let [a, b, c, d, e, f] = CURVE;
    ((a * x * x + b * x + c) / (d * x * x + e * x + f)).clamp(0.0, 1.0)
}

/// The tone-mapped value that the brightest and the median pixel are brought to.
const TARGET: f64 = 0.85;
/// A median below this is taken for it: black pictures have no exposure.
const DARKEST: f64 = f32::EPSILON as f64;

/// First and last exposure, in stops: that which brings the reference's brightest pixel to [`TARGET`], and that which
/// does so with its median (the upper one of an even number, as flip-evaluator 1.7 has it). `None` where the reference is black.
fn exposures(reference: Rgb) -> Option<[f64; 2]> {
    let [a, b, c, d, e, f] = CURVE;
    // tone(x) = t.
    let (a, b, c) = (a - d * TARGET, b - e * TARGET, c - f * TARGET);
    let half = -b / (2.0 * a);
    let x = half + (half * half - c / a).sqrt();
    let [r, g, b] = reference;
    // [BT709]
    let luminance = |i: usize| 0.2126 * f64::from(r[i]) + 0.7152 * f64::from(g[i]) + 0.0722 * f64::from(b[i]);
    let mut all: Vec<f64> = (0..r.len()).map(luminance).collect();
    all.sort_by(f64::total_cmp);
    let brightest = *all.last()?;
    let median = all[all.len() / 2].max(DARKEST);
    (brightest > 0.0).then(|| [(x / brightest).log2(), (x / median).log2()])
}

/// How many exposures there are from `start` to `stop`.
fn number(start: f64, stop: f64) -> usize {
    ((stop - start).ceil() as usize).max(2)
}

#[cfg(not(feature = "flip"))]
fn difference(_a: Rgb, _b: Rgb, _size: [u32; 2], _view: impl Fn(f64) -> f64) -> Option<Vec<f32>> {
    let _ = srgb8;
    None
}

/// LDR FLIP of each pixel; `view` turns linear values into those that are shown.
#[cfg(feature = "flip")]
fn difference(a: Rgb, b: Rgb, [width, height]: [u32; 2], view: impl Fn(f64) -> f64) -> Option<Vec<f32>> {
    let encode = |rgb: Rgb| {
        let bytes: Vec<u8> =
            (0..rgb[0].len()).flat_map(|i| rgb.map(|channel| srgb8(view(f64::from(channel[i]))))).collect();
        nv_flip::FlipImageRgb8::with_data(width, height, &bytes)
    };
    Some(nv_flip::flip(encode(b), encode(a), nv_flip::DEFAULT_PIXELS_PER_DEGREE).to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_is_inverted() {
        // Exposed by its own start, the brightest pixel is shown as TARGET; so is the median by the stop.
        let grey = [0.5f32, 8.0, 2.0, 0.25];
        let [start, stop] = exposures([&grey; 3]).expect("not black");
        assert!((tone(8.0 * start.exp2()) - TARGET).abs() < 1e-12);
        // Of four values the third one is the median.
        assert!((tone(2.0 * stop.exp2()) - TARGET).abs() < 1e-12);
        assert_eq!(exposures([&[0.0f32; 4]; 3]), None);
    }

    /// Width, height, squarings and gain of the pictures of tests/support/metric_reference.py, and what flip-evaluator 1.7
    /// looks at; it prints f32.
    #[test]
    fn exposures_are_those_of_the_authors() {
        let theirs = [
            ([61, 43, 0], 4.0, [-0.89398, 0.08457], 2),
            ([61, 43, 2], 16.0, [-2.82582, -0.01494], 3),
            ([64, 48, 2], 16.0, [-2.91670, 0.00398], 3),
            ([64, 48, 3], 4096.0, [-10.91670, -6.37998], 5),
            ([97, 30, 1], 0.25, [3.12222, 4.91418], 2),
            ([30, 97, 3], 100.0, [-5.56056, -0.97941], 5),
        ];
        for ([width, height, squarings], gain, expected, count) in theirs {
            let value = |i: i32, c: i32| {
                let v = f64::from((i % width * (c + 1) + 3 * (i / width)) % 65) / 64.0;
                ((0..squarings).fold(v, |v, _| v * v) * gain) as f32
            };
            let channels = [0, 1, 2].map(|c| (0..width * height).map(|i| value(i, c)).collect::<Vec<f32>>());
            let [start, stop] = exposures(channels.each_ref().map(Vec::as_slice)).expect("not black");
            let miss = (start - expected[0]).abs().max((stop - expected[1]).abs());
            assert!(miss < 1e-5 && number(start, stop) == count, "{start} to {stop} is not {expected:?}");
        }
    }
}
