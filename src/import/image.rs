//! Image textures: PNG, JPEG, TIFF and Radiance HDR through `image`, OpenEXR through `exr`, decoded to linear Rec.709.
//!
//! Alpha is left out. Sizes are checked before anything is allocated for them.

use std::io::Cursor;
use std::path::Path;

use ::image::{DynamicImage, ImageFormat, ImageReader, Limits};

use super::read_bytes;
use crate::scene::error::{Problem, Source};
use crate::scene::texture::{ImageTexture, Placement, Wrap};

/// Bytes of an image file.
const MAX_FILE: u64 = 2 << 30;
/// Texels along one side.
const MAX_SIDE: u32 = 65_536;
/// Texels of one image, twelve bytes each.
const MAX_TEXELS: u64 = 1 << 27;

/// How the numbers of an image file encode light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColourSpace {
    /// The sRGB curve over Rec.709 primaries.
    Srgb,
    Linear,
}

impl ColourSpace {
    pub const NAMES: &'static [&'static str] = &["srgb", "linear"];

    pub fn from_name(name: &str) -> Option<ColourSpace> {
        match name {
            "srgb" => Some(ColourSpace::Srgb),
            "linear" => Some(ColourSpace::Linear),
            _ => None,
        }
    }
}

/// Reads an image. Without `space` integers are taken as sRGB and floating-point numbers as linear.
///
/// # Errors
/// A file that cannot be read, is no such image, is truncated, too large, or has a texel that is negative or not finite.
pub fn read(path: &Path, space: Option<ColourSpace>, wrap: Wrap) -> Result<ImageTexture, Problem> {
    from_bytes(path, &read_file(path)?, space, [wrap; 2])
}

/// The bytes of an image file.
///
/// # Errors
/// A file that cannot be read or is too long.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, Problem> {
    read_bytes(path, MAX_FILE)
}

/// Like [`read`] with the content of the file at hand.
///
/// # Errors
/// As [`read`].
pub(super) fn from_bytes(
    path: &Path,
    bytes: &[u8],
    space: Option<ColourSpace>,
    wrap: [Wrap; 2],
) -> Result<ImageTexture, Problem> {
    decode(path, bytes, space, wrap).map_err(|what| unusable(path, &what))
}

/// The opacity of an image's texels, in all three components; 1 where it has none.
///
/// # Errors
/// As [`read`].
pub(super) fn opacity(path: &Path, bytes: &[u8], wrap: [Wrap; 2]) -> Result<ImageTexture, Problem> {
    let image = decode_dynamic(path, bytes).map_err(|what| unusable(path, &what))?.into_rgba32f();
    let (width, height) = (image.width() as usize, image.height() as usize);
    let texels = image.pixels().map(|p| [p.0[3]; 3]).collect();
    Ok(ImageTexture { width, height, texels, wrap, placement: Placement::IDENTITY })
}

fn unusable(path: &Path, what: &str) -> Problem {
    let problem = Problem::new(format!("cannot use the image: {what}")).at(&Source::file(path));
    problem.help("images are whole PNG, JPEG, TIFF, Radiance HDR or OpenEXR files of at most 2^27 texels")
}

fn decode(path: &Path, bytes: &[u8], space: Option<ColourSpace>, wrap: [Wrap; 2]) -> Result<ImageTexture, String> {
    const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
    let decoded = if bytes.starts_with(&EXR_MAGIC) { decode_exr(bytes)? } else { decode_other(path, bytes)? };
    let Decoded { width, height, mut texels, default_space } = decoded;
    if width == 0 || height == 0 {
        return Err("it is empty".to_owned());
    }
    if let Some(i) = texels.iter().position(|texel| !texel.iter().all(|c| *c >= 0.0 && c.is_finite())) {
        return Err(format!("texel {} of row {} is {:?}", i % width, i / width, texels[i]));
    }
    if space.unwrap_or(default_space) == ColourSpace::Srgb {
        texels.as_flattened_mut().iter_mut().for_each(|c| *c = srgb_to_linear(*c));
    }
    Ok(ImageTexture { width, height, texels, wrap, placement: Placement::IDENTITY })
}

struct Decoded {
    width: usize,
    height: usize,
    texels: Vec<[f32; 3]>,
    default_space: ColourSpace,
}

// The inverse of the sRGB curve [IEC61966].
fn srgb_to_linear(encoded: f32) -> f32 {
    let x = f64::from(encoded);
    let linear = if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

fn check_size(width: u64, height: u64) -> Result<(), String> {
    let side = u64::from(MAX_SIDE);
    if width > side || height > side || width * height > MAX_TEXELS {
        return Err(format!("{width} × {height} texels are too many"));
    }
    Ok(())
}

fn decode_other(path: &Path, bytes: &[u8]) -> Result<Decoded, String> {
    let image = decode_dynamic(path, bytes)?;
    let floating = matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let rgb = image.into_rgb32f();
    Ok(Decoded {
        width: rgb.width() as usize,
        height: rgb.height() as usize,
        texels: rgb.pixels().map(|p| p.0).collect(),
        default_space: if floating { ColourSpace::Linear } else { ColourSpace::Srgb },
    })
}

fn decode_dynamic(path: &Path, bytes: &[u8]) -> Result<DynamicImage, String> {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(16 * MAX_TEXELS);
    let reader = || -> Result<_, String> {
        let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
        // Formats without a magic number of their own go by the name.
        if let (None, Ok(format)) = (reader.format(), ImageFormat::from_path(path)) {
            reader.set_format(format);
        }
        reader.limits(limits.clone());
        Ok(reader)
    };
    let (width, height) = reader()?.into_dimensions().map_err(|e| e.to_string())?;
    check_size(width.into(), height.into())?;
    reader()?.decode().map_err(|e| e.to_string())
}

fn decode_exr(bytes: &[u8]) -> Result<Decoded, String> {
    use exr::prelude::{ReadChannels, ReadLayers, read};
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    for header in &meta.headers {
        check_size(header.layer_size.x() as u64, header.layer_size.y() as u64)?;
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| Decoded {
                width: size.x(),
                height: size.y(),
                texels: vec![[0.0; 3]; size.x() * size.y()],
                default_space: ColourSpace::Linear,
            },
            |pixels, position, (r, g, b): (f32, f32, f32)| {
                let index = position.y() * pixels.width + position.x();
                pixels.texels[index] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    Ok(image.layer_data.channel_data.pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_srgb_curve_hits_its_published_points() {
        // Ends, the joint of its two pieces, and mid grey: 0.5 ↦ 0.21404114.
        assert_eq!(srgb_to_linear(0.0), 0.0);
        assert_eq!(srgb_to_linear(1.0), 1.0);
        assert!((srgb_to_linear(0.5) - 0.214_041_14).abs() < 1e-7);
        assert!((srgb_to_linear(0.04045) - 0.003_130_8).abs() < 1e-7);
    }
}
