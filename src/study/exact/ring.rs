//! The ring: a mirror cylinder of radius 1 stands on a floor, parallel light falls over its rim towards +x.
//! · irradiance in units of that at the rim's plane · lengths in radii
//!
//! Seen from above, a ray is a path of length ℓ, the wall's height over the tangent of the light's elevation. One at
//! y = sin φ meets the wall at the angle φ; all of its chords are 2 cos φ long, and every bounce turns it by π + 2φ. The
//! rays of one y that fall over the rim go along the same path, each ℓ farther than where it started: their light lies on
//! the path's chords with the density that it had along the rim, and the picture is a sum of lines of constant density.
//! Rays before the ring are mirrored by the wall's outside, once, and make such a line, too.
//!
//! PHOTON_DIFFERENTIALS 5.4.

use std::f64::consts::PI;

use super::numerics::metal_reflectance;
use super::pixels::Pixels;

/// The wall's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wall {
    Mirror {
        reflectance: [f64; 3],
    },
    /// Index eta + i k; `level`: cosine of the light's elevation.
    Metal {
        eta: [f64; 3],
        k: [f64; 3],
        level: f64,
    },
}

impl Wall {
    /// Fraction of the light at φ that a bounce leaves.
    fn reflectance(&self, phi: f64) -> [f64; 3] {
        match *self {
            Wall::Mirror { reflectance } => reflectance,
            Wall::Metal { eta, k, level } => [0, 1, 2].map(|i| metal_reflectance(level * phi.cos(), eta[i], k[i])),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// ℓ.
    pub travel: f64,
    /// The light's part of the rim's plane: [from, to] in x and in y.
    pub source: [[f64; 2]; 2],
    /// Paths of more bounces are left out.
    pub most_bounces: u32,
    pub wall: Wall,
}

/// Where a picture shows the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloorPicture {
    pub pixels: Pixels,
    /// The ring's centre, in pixels.
    pub centre: [f64; 2],
    /// One radius along x and along y, in pixels.
    pub axes: [[f64; 2]; 2],
}

impl FloorPicture {
    fn raster(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| self.centre[i] + x * self.axes[0][i] + y * self.axes[1][i])
    }

    /// Pixels a radius.
    fn scale(&self) -> f64 {
        self.axes[0][0].hypot(self.axes[0][1])
    }
}

/// A straight line of light on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    pub bounces: u32,
    pub from: [f64; 2],
    pub to: [f64; 2],
}

impl Line {
    /// From one distance to the other along the direction `angle` from the wall's point at `wall`.
    fn new(bounces: u32, wall: f64, angle: f64, [from, to]: [f64; 2]) -> Line {
        let (w, d) = (wall.sin_cos(), angle.sin_cos());
        let at = |t: f64| [w.1 + t * d.1, w.0 + t * d.0];
        Line { bounces, from: at(from), to: at(to) }
    }
}

impl Ring {
    /// The lines on which the light of y = sin φ lands after a bounce.
    pub fn lines(&self, phi: f64) -> Vec<Line> {
        let half = phi.cos();
        let [from, to] = self.source[0];
        let mut lines = Vec::new();
        // Distances along the path from the first wall point (-cos φ, sin φ).
        let (first, last) = (from.max(-half) + half + self.travel, to.min(half) + half + self.travel);
        let chord = 2.0 * half;
        let mut bounces = ((first / chord).floor() as u32).max(1);
        while bounces <= self.most_bounces && f64::from(bounces) * chord < last && first < last {
            let before = f64::from(bounces) * chord;
            let turned = f64::from(bounces) * (PI + 2.0 * phi);
            // W₀ is at the angle π − φ, the chord after it runs along +x.
            let ends = [(first - before).max(0.0), (last - before).min(chord)];
            lines.push(Line::new(bounces, PI - phi + turned, turned, ends));
            bounces += 1;
        }
        lines.extend(self.outer_line(phi));
        lines
    }

    /// Light that the wall's outside mirrors.
    fn outer_line(&self, phi: f64) -> Option<Line> {
        let [from, to] = self.source[0];
        let wall = -phi.cos();
        let ends = [(self.travel - (wall - from)).max(0.0), self.travel - (wall - to.min(wall))];
        (self.most_bounces >= 1 && ends[0] < ends[1]).then(|| Line::new(1, PI - phi, PI - 2.0 * phi, ends))
    }

    /// E over that at the rim, averaged over each pixel: the midpoint rule over φ with `steps` steps.
    pub fn averages(&self, picture: &FloorPicture, steps: usize) -> Vec<[f64; 3]> {
        let mut sums = vec![[0.0; 3]; picture.pixels.count()];
        let [from, to] = self.source[1].map(|y| y.clamp(-1.0, 1.0).asin());
        let step = (to - from) / steps as f64;
        for i in 0..steps {
            let phi = from + (i as f64 + 0.5) * step;
            let reflectance = self.wall.reflectance(phi);
            for line in self.lines(phi) {
                let [a, b] = [line.from, line.to].map(|p| picture.raster(p));
                // dy times a length is an area; pixels have one of 1/scale².
                let light = phi.cos() * step * (b[0] - a[0]).hypot(b[1] - a[1]) * picture.scale();
                let left = reflectance.map(|r| r.powi(line.bounces as i32) * light);
                picture.pixels.line(a, b, |pixel, part| add(&mut sums[pixel], left, part));
            }
        }
        sums
    }
}

fn add(sum: &mut [f64; 3], colour: [f64; 3], factor: f64) {
    for (sum, c) in sum.iter_mut().zip(colour) {
        *sum += c * factor;
    }
}
