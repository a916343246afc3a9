//! Pictures inside the page, and maps of where a picture is wrong.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::ReportError;
use crate::film::Image;
use crate::output::{exr, png};
use crate::study::results::COMPARED;

/// Error, as shown, at the bright end of the maps; larger ones are as bright.
pub(super) const WORST: f64 = 0.25;

/// The colours of the maps from no error to [`WORST`], linear: black, violet, red, orange, pale yellow, so that
/// lightness rises evenly and red-green blindness loses nothing.
const COLOURS: [[f64; 3]; 5] =
    [[0.0, 0.0, 0.0], [0.08, 0.01, 0.16], [0.46, 0.03, 0.1], [0.95, 0.3, 0.02], [0.98, 0.95, 0.55]];

/// Pixels that the reference cannot hold.
const NOT_COMPARED: [f32; 3] = [0.2, 0.25, 0.3];

/// A picture file as the source of an `img`.
pub(super) fn data_uri(path: &Path) -> Result<String, ReportError> {
    let bytes = std::fs::read(path).map_err(|source| ReportError::Picture { path: path.to_owned(), source })?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(bytes)))
}

/// Writes `image`-error.png: the size of the shown difference of `image`.exr and `reference`.exr in each pixel, the mean
/// over the colours.
pub(super) fn write_error_map(image: &Path, reference: &Path, white: f64) -> Result<std::path::PathBuf, ReportError> {
    let [test, reference] = [image, reference].map(|path| exr::read_file(&with_ending(path, ".exr")));
    let (test, reference) = (test?.image, reference?.image);
    let mut name = image.as_os_str().to_owned();
    name.push("-error.png");
    let path = std::path::PathBuf::from(name);
    let (Some(a), Some(b)) = (test.rgb(""), reference.rgb("")) else {
        return Err(ReportError::SizesDiffer { path: image.to_owned() });
    };
    if [test.width, test.height] != [reference.width, reference.height] {
        return Err(ReportError::SizesDiffer { path: image.to_owned() });
    }
    let shown = |v: f32| (f64::from(v) / white).clamp(0.0, 1.0);
    let compared = |i: usize| reference.channel(COMPARED).is_none_or(|samples| samples[i] > 0.0);
    let error = |i: usize| (0..3).map(|c| (shown(a[c][i]) - shown(b[c][i])).abs()).sum::<f64>() / 3.0;
    let pixels: Vec<[f32; 3]> =
        (0..test.pixels()).map(|i| if compared(i) { colour(error(i) / WORST) } else { NOT_COMPARED }).collect();
    png::write(&path, &Image::from_rgb(test.width, test.height, &pixels), 0.0)?;
    Ok(path)
}

/// `path` with an ending behind its whole name.
pub(super) fn with_ending(path: &Path, ending: &str) -> std::path::PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

/// The colour of a share of the worst error, linear.
fn colour(share: f64) -> [f32; 3] {
    let place = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let below = (place as usize).min(COLOURS.len() - 2);
    let t = place - below as f64;
    [0, 1, 2].map(|c| (COLOURS[below][c] * (1.0 - t) + COLOURS[below + 1][c] * t) as f32)
}

/// The same colours for a style sheet.
pub(super) fn gradient() -> String {
    let byte = |v: f64| png::srgb8(v);
    let stops = (0..=16).map(|i| {
        let [r, g, b] = colour(f64::from(i) / 16.0).map(|v| byte(f64::from(v)));
        format!("rgb({r} {g} {b})")
    });
    format!("linear-gradient(to right, {})", stops.collect::<Vec<_>>().join(", "))
}
