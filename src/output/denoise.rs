//! The beauty without its noise, by Intel Open Image Denoise where it is installed `[OIDN-docs]`.
//!
//! Caustics are left as they are: their bright lines are what the filter takes for noise, and a photon map's own noise is low
//! already. The rest of the light is denoised, with the help of `albedo` and `N` if the picture has them, and the caustics are
//! added again. What was rendered stays in the layer `noisy`.

use crate::film::{Channel, Image};

/// Why a picture was not denoised.
#[derive(Debug, thiserror::Error)]
pub enum DenoiseError {
    #[cfg(feature = "oidn")]
    #[error(transparent)]
    Library(#[from] oidn_at_run_time::Error),
    #[cfg(not(feature = "oidn"))]
    #[error("this program was built without the feature `oidn`")]
    NotBuiltIn,
    #[error("it has no colours")]
    NoColours,
}

impl DenoiseError {
    /// Whether there is simply no such library here.
    pub fn is_absent(&self) -> bool {
        match self {
            #[cfg(feature = "oidn")]
            DenoiseError::Library(error) => matches!(error, oidn_at_run_time::Error::Absent),
            #[cfg(not(feature = "oidn"))]
            DenoiseError::NotBuiltIn => true,
            DenoiseError::NoColours => false,
        }
    }
}

/// Layers that a film should have for it, by their names.
pub const WANTED_LAYERS: [&str; 3] = ["caustic", "albedo", "N"];

/// `image` denoised; its layer `caustic`, if it has one, only if `with_caustics`.
///
/// # Errors
/// There is no library, or it failed.
pub fn denoise(image: &Image, with_caustics: bool) -> Result<Image, DenoiseError> {
    let beauty = interleaved(image, ["R", "G", "B"]).ok_or(DenoiseError::NoColours)?;
    let caustic = interleaved(image, ["caustic.R", "caustic.G", "caustic.B"]).filter(|_| !with_caustics);
    let caustic = caustic.unwrap_or_else(|| vec![0.0; beauty.len()]);
    // Rounding may leave a little less than nothing.
    let noisy: Vec<f32> = beauty.iter().zip(&caustic).map(|(all, part)| (all - part).max(0.0)).collect();
    let albedo = interleaved(image, ["albedo.R", "albedo.G", "albedo.B"]);
    let normal = interleaved(image, ["N.X", "N.Y", "N.Z"]);
    let mut smooth = filtered(image, &noisy, albedo.as_deref(), normal.as_deref())?;
    smooth.iter_mut().zip(&caustic).for_each(|(rest, part)| *rest += part);
    Ok(replaced(image, &smooth))
}

#[cfg(feature = "oidn")]
fn filtered(
    image: &Image,
    colour: &[f32],
    albedo: Option<&[f32]>,
    normal: Option<&[f32]>,
) -> Result<Vec<f32>, DenoiseError> {
    let (width, height) = (image.width as usize, image.height as usize);
    Ok(oidn_at_run_time::Library::find()?.denoise(&oidn_at_run_time::Picture {
        width,
        height,
        colour,
        albedo,
        normal,
    })?)
}

#[cfg(not(feature = "oidn"))]
fn filtered(_: &Image, _: &[f32], _: Option<&[f32]>, _: Option<&[f32]>) -> Result<Vec<f32>, DenoiseError> {
    Err(DenoiseError::NotBuiltIn)
}

/// Three numbers a pixel.
fn interleaved(image: &Image, names: [&str; 3]) -> Option<Vec<f32>> {
    let channels = names.map(|name| image.channel(name));
    let [Some(a), Some(b), Some(c)] = channels else { return None };
    Some(a.iter().zip(b).zip(c).flat_map(|((a, b), c)| [*a, *b, *c]).collect())
}

/// `image` with `rgb` for its beauty, and that in `noisy`.
fn replaced(image: &Image, rgb: &[f32]) -> Image {
    let mut denoised = image.clone();
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        if let Some(channel) = denoised.channels.iter_mut().find(|channel| channel.name == name) {
            let smooth = rgb.iter().skip(c).step_by(3).copied().collect();
            let samples = std::mem::replace(&mut channel.samples, smooth);
            denoised.channels.push(Channel { name: format!("noisy.{name}"), samples });
        }
    }
    denoised
}
