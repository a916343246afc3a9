//! Curves across a picture: how much of a line or of a circle lies in each pixel.
//! · pixels from the top left corner

use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A picture's pixels, numbered row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pixels {
    pub width: u32,
    pub height: u32,
}

impl Pixels {
    pub fn count(self) -> usize {
        self.width as usize * self.height as usize
    }

    fn at(self, [x, y]: [f64; 2]) -> Option<usize> {
        let inside = x >= 0.0 && y >= 0.0 && x < f64::from(self.width) && y < f64::from(self.height);
        inside.then(|| y as usize * self.width as usize + x as usize)
    }

    /// Visits the pixels that the straight line meets, with the part of its length in each.
    pub fn line(self, from: [f64; 2], to: [f64; 2], mut visit: impl FnMut(usize, f64)) {
        let along = [to[0] - from[0], to[1] - from[1]];
        let mut cuts = vec![0.0, 1.0];
        for (axis, size) in [self.width, self.height].into_iter().enumerate() {
            cuts.extend(borders(from[axis], to[axis], size).map(|border| (border - from[axis]) / along[axis]));
        }
        // The borders of an axis come in order: the stable sort only merges them.
        cuts.sort_by(f64::total_cmp);
        for part in cuts.windows(2) {
            let middle = 0.5 * (part[0] + part[1]);
            if let Some(pixel) = self.at([from[0] + middle * along[0], from[1] + middle * along[1]]) {
                visit(pixel, part[1] - part[0]);
            }
        }
    }

    /// Visits the pixels that the circle meets, with its angle in each.
    pub fn circle(self, centre: [f64; 2], radius: f64, mut visit: impl FnMut(usize, f64)) {
        let [columns, rows] = [self.width, self.height];
        let cosines = borders(centre[0] - radius, centre[0] + radius, columns).map(|x| (x - centre[0]) / radius);
        let sines = borders(centre[1] - radius, centre[1] + radius, rows).map(|y| (y - centre[1]) / radius);
        let right: Vec<f64> = cosines.map(|cos| cos.clamp(-1.0, 1.0).acos()).collect();
        let down: Vec<f64> = sines.map(|sin| sin.clamp(-1.0, 1.0).asin()).collect();
        let mut cuts: Vec<f64> = right.iter().map(|a| -a).chain(right.iter().copied()).collect();
        cuts.extend(&down);
        cuts.extend(down.iter().map(|&a| if a > 0.0 { PI - a } else { -PI - a }));
        if cuts.is_empty() {
            // Any angle at which the circle is closed.
            cuts.push(FRAC_PI_2);
        }
        cuts.sort_by(f64::total_cmp);
        cuts.push(cuts[0] + TAU);
        for part in cuts.windows(2) {
            let (sin, cos) = (0.5 * (part[0] + part[1])).sin_cos();
            if let Some(pixel) = self.at([centre[0] + radius * cos, centre[1] + radius * sin]) {
                visit(pixel, part[1] - part[0]);
            }
        }
    }
}

/// The borders of `size` pixels between `a` and `b`.
fn borders(a: f64, b: f64, size: u32) -> impl Iterator<Item = f64> {
    let (low, high) = (a.min(b).max(0.0), a.max(b).min(f64::from(size)));
    let first = low.ceil();
    let count = if high < first { 0 } else { (high - first) as usize + 1 };
    (0..count).map(move |i| first + i as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIXELS: Pixels = Pixels { width: 3, height: 2 };

    fn line(from: [f64; 2], to: [f64; 2]) -> Vec<f64> {
        let mut parts = vec![0.0; PIXELS.count()];
        PIXELS.line(from, to, |pixel, part| parts[pixel] += part);
        parts
    }

    fn circle(centre: [f64; 2], radius: f64) -> Vec<f64> {
        let mut angles = vec![0.0; PIXELS.count()];
        PIXELS.circle(centre, radius, |pixel, angle| angles[pixel] += angle);
        angles
    }

    #[track_caller]
    fn close(found: &[f64], expected: &[f64]) {
        let worst = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-14, "{found:?} is not {expected:?}");
    }

    #[test]
    fn a_line_is_parted_at_the_borders() {
        close(&line([0.5, 0.5], [2.5, 0.5]), &[0.25, 0.5, 0.25, 0.0, 0.0, 0.0]);
        close(&line([2.5, 0.5], [0.5, 0.5]), &[0.25, 0.5, 0.25, 0.0, 0.0, 0.0]);
        close(&line([0.5, 0.5], [0.5, 1.5]), &[0.5, 0.0, 0.0, 0.5, 0.0, 0.0]);
        close(&line([0.1, 0.2], [0.3, 0.9]), &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        // Half of it is outside.
        close(&line([-3.0, 0.5], [3.0, 0.5]), &[1.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0, 0.0, 0.0, 0.0]);
        close(&line([-3.0, -0.5], [3.0, -0.5]), &[0.0; 6]);
        close(&line([0.5, 0.0], [2.5, 2.0]), &[0.25, 0.25, 0.0, 0.0, 0.25, 0.25]);
    }

    #[test]
    fn a_circle_is_parted_at_the_borders() {
        close(&circle([1.5, 0.5], 0.4), &[0.0, TAU, 0.0, 0.0, 0.0, 0.0]);
        close(&circle([1.0, 1.0], 0.5), &[FRAC_PI_2, FRAC_PI_2, 0.0, FRAC_PI_2, FRAC_PI_2, 0.0]);
        close(&circle([1.0, 0.0], 0.5), &[FRAC_PI_2, FRAC_PI_2, 0.0, 0.0, 0.0, 0.0]);
        close(&circle([1.5, 1.0], 9.0), &[0.0; 6]);
        // x = 1 + r cos crosses 2 at ±60 degrees, y = 0.5 + r sin crosses 1 at 14.5 degrees.
        let r = 2.0;
        let sixty = PI / 3.0;
        let low = (0.25f64).asin();
        close(&circle([1.0, 0.5], r)[2..3], &[low + low]);
        assert!((circle([1.0, 0.5], r)[5] - (f64::asin(0.75) - low)).abs() < 1e-14 && sixty > f64::asin(0.75));
    }
}
