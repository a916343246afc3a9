//! Image textures: PNG, JPEG, TIFF and Radiance HDR through `image`, OpenEXR through `exr`, decoded to linear Rec.709.
//!
//! Eight bits stay bytes with what they stand for. Alpha is left out. Sizes are checked before anything is allocated for them.

use std::io::Cursor;
use std::path::Path;

use ::image::{DynamicImage, ImageBuffer, ImageFormat, ImageReader, Limits, Luma, Pixel, Rgb, Rgba};

use super::read_bytes;
use crate::scene::error::{Problem, Source};
use crate::scene::texture::{Curve, ImageTexture, Placement, Raster, Samples, TextureMemory, Wrap};

/// Bytes of an image file.
const MAX_FILE: u64 = 2 << 30;
/// Texels along one side.
const MAX_SIDE: u32 = 65_536;
/// Texels of one image, of at most twelve bytes each.
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

/// Reads an image to where `memory` has room for it. Without `space` integers are taken as sRGB and floating-point numbers as
/// linear.
///
/// # Errors
/// A file that cannot be read, is no such image, is truncated, too large, or has a texel that is negative or not finite.
pub fn read(
    path: &Path,
    space: Option<ColourSpace>,
    wrap: Wrap,
    memory: &TextureMemory,
) -> Result<ImageTexture, Problem> {
    placed(from_bytes(path, &read_file(path)?, space)?, [wrap; 2], Placement::IDENTITY, memory)
}

/// An image that is decoded, in its place.
///
/// # Errors
/// The file of textures that have no room fails.
pub(super) fn placed(
    raster: Raster,
    wrap: [Wrap; 2],
    placement: Placement,
    memory: &TextureMemory,
) -> Result<ImageTexture, Problem> {
    let texels = raster.placed(memory).map_err(|error| Problem::new(error.to_string()))?;
    Ok(ImageTexture { texels, wrap, placement })
}

/// The bytes of an image file.
///
/// # Errors
/// A file that cannot be read or is too long.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, Problem> {
    read_bytes(path, MAX_FILE)
}

/// Decodes the content of an image file.
///
/// # Errors
/// As [`read`].
pub(super) fn from_bytes(path: &Path, bytes: &[u8], space: Option<ColourSpace>) -> Result<Raster, Problem> {
    decode(path, bytes, space).map_err(|what| unusable(path, &what))
}

/// The opacity of an image's texels, in all three components; 1 where it has none.
///
/// # Errors
/// As [`read`].
pub(super) fn opacity(path: &Path, bytes: &[u8]) -> Result<Raster, Problem> {
    let image = decode_dynamic(path, bytes).map_err(|what| unusable(path, &what))?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    Ok(Raster::of_bytes(width, height, opacity_samples(image), curve_of_opacity()))
}

fn unusable(path: &Path, what: &str) -> Problem {
    let problem = Problem::new(format!("cannot use the image: {what}")).at(&Source::file(path));
    problem.help("images are whole PNG, JPEG, TIFF, Radiance HDR or OpenEXR files of at most 2^27 texels")
}

fn decode(path: &Path, bytes: &[u8], space: Option<ColourSpace>) -> Result<Raster, String> {
    const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
    let decoded = if bytes.starts_with(&EXR_MAGIC) { decode_exr(bytes)? } else { decode_other(path, bytes)? };
    let Decoded { width, height, samples, default_space } = decoded;
    if width == 0 || height == 0 {
        return Err("it is empty".to_owned());
    }
    let space = space.unwrap_or(default_space);
    let Samples::Colours(mut texels) = samples else {
        let curve = curve_of(&samples, space);
        return Ok(Raster::of_bytes(width, height, samples, curve));
    };
    if let Some(i) = texels.iter().position(|texel| !texel.iter().all(|c| *c >= 0.0 && c.is_finite())) {
        return Err(format!("texel {} of row {} is {:?}", i % width, i / width, texels[i]));
    }
    if space == ColourSpace::Srgb {
        texels.as_flattened_mut().iter_mut().for_each(|c| *c = srgb_to_linear(*c));
    }
    Ok(Raster::of_colours(width, height, texels))
}

struct Decoded {
    width: usize,
    height: usize,
    /// Bytes, or colours, all encoded.
    samples: Samples,
    default_space: ColourSpace,
}

/// Every byte once.
fn all_bytes<P: Pixel<Subpixel = u8>>(pixel: impl Fn(u8) -> P) -> ImageBuffer<P, Vec<u8>> {
    ImageBuffer::from_fn(256, 1, |x, _| pixel(x as u8))
}

/// What bytes stand for: the numbers that `image` makes of them, which for grey are not quite 255ths, decoded.
fn curve_of(samples: &Samples, space: ColourSpace) -> Curve {
    let every = match samples {
        Samples::GreyBytes(_) => DynamicImage::ImageLuma8(all_bytes(|byte| Luma([byte]))),
        _ => DynamicImage::ImageRgb8(all_bytes(|byte| Rgb([byte; 3]))),
    };
    let numbers = every.into_rgb32f();
    Curve::new(|c, byte| {
        let encoded = numbers.get_pixel(byte.into(), 0).0[c];
        if space == ColourSpace::Srgb { srgb_to_linear(encoded) } else { encoded }
    })
}

/// What bytes of opacity stand for.
fn curve_of_opacity() -> Curve {
    let numbers = DynamicImage::ImageRgba8(all_bytes(|byte| Rgba([0, 0, 0, byte]))).into_rgba32f();
    Curve::new(|_, byte| numbers.get_pixel(byte.into(), 0).0[3])
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
    Ok(Decoded {
        width: image.width() as usize,
        height: image.height() as usize,
        samples: encoded_samples(image),
        default_space: if floating { ColourSpace::Linear } else { ColourSpace::Srgb },
    })
}

fn encoded_samples(image: DynamicImage) -> Samples {
    match image {
        DynamicImage::ImageLuma8(image) => Samples::GreyBytes(image.into_raw()),
        DynamicImage::ImageLumaA8(image) => Samples::GreyBytes(image.pixels().map(|p| p.0[0]).collect()),
        DynamicImage::ImageRgb8(image) => Samples::Bytes(image.pixels().map(|p| p.0).collect()),
        DynamicImage::ImageRgba8(image) => Samples::Bytes(image.pixels().map(|p| [p.0[0], p.0[1], p.0[2]]).collect()),
        image => Samples::Colours(image.into_rgb32f().pixels().map(|p| p.0).collect()),
    }
}

fn opacity_samples(image: DynamicImage) -> Samples {
    match image {
        DynamicImage::ImageRgba8(image) => Samples::GreyBytes(image.pixels().map(|p| p.0[3]).collect()),
        image => Samples::Grey(image.into_rgba32f().pixels().map(|p| p.0[3]).collect()),
    }
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
            |size, _| (size, vec![[0.0; 3]; size.x() * size.y()]),
            |(size, texels), position, (r, g, b): (f32, f32, f32)| {
                texels[position.y() * size.x() + position.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    let (size, texels) = image.layer_data.channel_data.pixels;
    let (samples, default_space) = (Samples::Colours(texels), ColourSpace::Linear);
    Ok(Decoded { width: size.x(), height: size.y(), samples, default_space })
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

    /// Bytes of every kind and value stand for the very number that `image` makes of them, in both spaces.
    #[test]
    fn bytes_are_decoded_to_the_same_bits_as_numbers() {
        let texel = |x: u32| [x as u8, 255 - x as u8, (x * 7) as u8, (x * 3) as u8];
        let rgba = ::image::RgbaImage::from_fn(256, 1, |x, _| ::image::Rgba(texel(x)));
        let rgba = DynamicImage::ImageRgba8(rgba);
        for image in [
            rgba.clone(),
            DynamicImage::ImageRgb8(rgba.to_rgb8()),
            DynamicImage::ImageLuma8(rgba.to_luma8()),
            DynamicImage::ImageLumaA8(rgba.to_luma_alpha8()),
        ] {
            for space in [ColourSpace::Srgb, ColourSpace::Linear] {
                let samples = encoded_samples(image.clone());
                let curve = curve_of(&samples, space);
                let raster = Raster::of_bytes(256, 1, samples, curve);
                let decode = |c: f32| if space == ColourSpace::Srgb { srgb_to_linear(c) } else { c };
                let numbers = image.to_rgb32f();
                assert!(!matches!(raster.samples, Samples::Colours(_) | Samples::Grey(_)), "{space:?}");
                assert_eq!(raster.texels().count(), 256);
                for (texel, number) in raster.texels().zip(numbers.pixels()) {
                    assert_eq!(texel.map(f32::to_bits), number.0.map(|c| decode(c).to_bits()), "{space:?}");
                }
            }
            let raster = Raster::of_bytes(256, 1, opacity_samples(image.clone()), curve_of_opacity());
            for (texel, number) in raster.texels().zip(image.to_rgba32f().pixels()) {
                assert_eq!(texel.map(f32::to_bits), [number.0[3].to_bits(); 3]);
            }
        }
    }
}
