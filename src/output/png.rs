//! PNG for the eye: 8-bit sRGB of the beauty, clamped; A is left out, as the background is part of the picture.

use std::io::Cursor;
use std::path::Path;

use image::{ImageFormat, RgbImage};

use super::atomic;
use super::error::WriteError;
use crate::film::Image;

/// The sRGB curve `[IEC61966]`: linear light in [0, 1] to the encoded value in [0, 1].
pub fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// 8-bit sRGB of a linear value; NaN and everything below 0 is 0.
pub fn srgb8(linear: f64) -> u8 {
    // A cast saturates and makes 0 of NaN.
    (srgb_encode(linear.clamp(0.0, 1.0)) * 255.0).round() as u8
}

/// 8-bit pixels `R G B` of a layer (`""`: the beauty), multiplied by 2^`exposure`.
pub fn to_rgb8(image: &Image, layer: &str, exposure: f64) -> Option<Vec<u8>> {
    let rgb = image.rgb(layer)?;
    let gain = exposure.exp2();
    Some((0..image.pixels()).flat_map(|i| rgb.map(|channel| srgb8(f64::from(channel[i]) * gain))).collect())
}

/// Writes the beauty, multiplied by 2^`exposure` (stops), whole or not at all.
pub fn write(path: &Path, image: &Image, exposure: f64) -> Result<(), WriteError> {
    let unfit = |reason: &str| WriteError::Unfit { path: path.to_owned(), reason: reason.to_owned() };
    let pixels = to_rgb8(image, "", exposure).ok_or_else(|| unfit("it has no channels R G B"))?;
    let png = RgbImage::from_raw(image.width, image.height, pixels).ok_or_else(|| unfit("it is too large"))?;
    let mut bytes = Cursor::new(Vec::new());
    png.write_to(&mut bytes, ImageFormat::Png).map_err(|e| unfit(&e.to_string()))?;
    atomic::write(path, &bytes.into_inner())
}
