//! The reference of the travelling wave, light paths at random times, against the closed form at 480 in-between frames.

use pdembree::output::exr;

use crate::support::closed_form::wave;
use crate::support::data::root;
use crate::support::statistics::Moments;

/// How far the wave goes while the shutter is open, and the picture's pixels and width.
const WAY: f64 = 0.15;
const PIXELS: usize = 162;
const HALF_VIEW: f64 = 0.5;

/// E/E⊥ of each column of pixels, the mean of 480 frames: light that enters at x of the wave that has gone s lands at
/// X(x − s) + s.
fn in_between_frames() -> Vec<f64> {
    const FRAMES: u32 = 480;
    const RAYS: u32 = 44_000;
    const HALF_BEAM: f64 = 1.1;
    let mut columns = vec![0.0; PIXELS];
    let pixel = 2.0 * HALF_VIEW / PIXELS as f64;
    let ray = 2.0 * HALF_BEAM / f64::from(RAYS);
    for frame in 0..FRAMES {
        let gone = WAY * ((f64::from(frame) + 0.5) / f64::from(FRAMES) - 0.5);
        for i in 0..RAYS {
            let x = -HALF_BEAM + (f64::from(i) + 0.5) * ray;
            let place = (wave::landing(x - gone) + gone + HALF_VIEW) / pixel;
            if (0.0..PIXELS as f64).contains(&place) {
                columns[place as usize] += ray / (pixel * f64::from(FRAMES));
            }
        }
    }
    columns
}

/// In each column the mean over its rows, whose scatter says how sure it is; the frames' own grid of rays adds five parts in 10⁴ at most.
#[test]
fn the_reference_of_the_travelling_wave_is_the_mean_of_480_frames() {
    let folder = root().join("scenes/blur/references");
    let files = std::fs::read_dir(&folder).expect("references").map(|entry| entry.expect("an entry").path());
    let is_wave = |path: &std::path::PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        name.starts_with("wave-") && name.ends_with(".exr")
    };
    let path = files.into_iter().find(is_wave).expect("the wave's");
    let image = exr::read_file(&path).expect("readable").image;
    let [red, ..] = image.rgb("caustic").or_else(|| image.rgb("")).expect("the caustic");
    let (width, height) = (image.width as usize, image.height as usize);
    assert_eq!(width, PIXELS);
    let (mut worst, mut squares) = (0.0_f64, 0.0);
    for (x, expected) in in_between_frames().into_iter().enumerate() {
        let rows = (0..height).map(|y| f64::from(red[y * width + x]) * std::f64::consts::PI);
        let column: Moments = rows.collect();
        let error = column.standard_error() + 5e-4 * expected;
        let off = (column.mean - expected) / error;
        worst = worst.max(off.abs());
        squares += off * off / PIXELS as f64;
    }
    println!("{:.3} and at most {worst:.2} standard errors", squares.sqrt());
    // Of 162 columns of 27 rows by chance beyond 6, by Student's t: 4e-4. Together they know the mean square to a tenth.
    assert!(worst < 6.0 && squares < 2.0, "{worst}, {squares}");
}
