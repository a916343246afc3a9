//! The ball lens: a glass ball of radius 1 in a beam, a plane behind it across the beam.
//! · irradiance in units of the beam's · lengths in radii · distances from the ball's centre
//!
//! A ray at height h meets the ball under sin i = h and is refracted to sin r = h/n. The points where it meets the
//! sphere from inside are π − 2r apart, each turns it by as much, the two refractions by i − r: after m inner
//! reflections it leaves at the angle θ = i + (m + 1)(π − 2r) from where the beam first meets the ball, turned by
//! D = 2(i − r) + m(π − 2r) towards the axis, with T² R^m of its light. What the ball's outside mirrors is turned by
//! π − 2i away from the axis. The light of h is spread evenly over a circle.
//!
//! PHOTON_DIFFERENTIALS 12, items 1 to 4.

use std::f64::consts::PI;

use super::numerics::transmittance;
use super::pixels::Pixels;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallLens {
    /// Index of the ball over that around it, more than 1.
    pub index: f64,
    /// Distance of the plane.
    pub receiver: f64,
    /// Radius of the beam, at most 1.
    pub beam: f64,
    /// Whether light is reflected where it could be refracted.
    pub fresnel: bool,
    /// Paths with more reflections inside are left out.
    pub most_inner: u32,
}

/// Parts of the beam in which light that lands in the picture is looked for.
const CELLS: usize = 4096;

/// How light goes by the ball.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passage {
    /// Mirrored by the outside.
    Outside,
    /// Through it, with so many reflections inside.
    Through { inner: u32 },
}

/// Where a picture shows the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverPicture {
    pub pixels: Pixels,
    /// The axis, in pixels.
    pub centre: [f64; 2],
    /// Pixels a radius.
    pub scale: f64,
}

impl ReceiverPicture {
    /// Radii from the axis to the farthest corner.
    fn reach(&self) -> f64 {
        let far = |centre: f64, size: u32| centre.abs().max((f64::from(size) - centre).abs());
        far(self.centre[0], self.pixels.width).hypot(far(self.centre[1], self.pixels.height)) / self.scale
    }
}

impl BallLens {
    /// Signed distance from the axis at which the ray with the angle of incidence `i` lands; none if it misses the plane.
    pub fn landing(&self, i: f64, passage: Passage) -> Option<f64> {
        let r = (i.sin() / self.index).asin();
        let (theta, turn) = match passage {
            Passage::Outside => (i, 2.0 * i - PI),
            Passage::Through { inner } => {
                let inside = PI - 2.0 * r;
                (i + f64::from(inner + 1) * inside, 2.0 * (i - r) + f64::from(inner) * inside)
            }
        };
        let (sin, cos) = theta.sin_cos();
        (turn.cos() > 0.0).then(|| sin - (self.receiver + cos) * turn.tan())
    }

    /// Fraction of the light that goes this way.
    pub fn passed(&self, i: f64, passage: Passage) -> f64 {
        let t = if self.fresnel { transmittance(i.cos(), self.index) } else { 1.0 };
        match passage {
            Passage::Outside => 1.0 - t,
            Passage::Through { inner } => t * t * (1.0 - t).powi(inner as i32),
        }
    }

    fn passages(&self) -> Vec<Passage> {
        let through = |inner| Passage::Through { inner };
        if self.fresnel {
            std::iter::once(Passage::Outside).chain((0..=self.most_inner).map(through)).collect()
        } else {
            vec![through(0)]
        }
    }

    /// Intervals of i that hold all light that lands within `reach` of the axis.
    fn reaching(&self, passage: Passage, reach: f64) -> Vec<[f64; 2]> {
        let border = |cell: usize| self.beam.asin() * cell as f64 / CELLS as f64;
        let landings: Vec<Option<f64>> = (0..=CELLS).map(|cell| self.landing(border(cell), passage)).collect();
        // A cell that crosses the picture may have both ends outside; a fold may dip in between: the neighbours count.
        let near = |cell: usize| match (landings[cell], landings[cell + 1]) {
            (Some(a), Some(b)) => a.min(b) <= reach && a.max(b) >= -reach,
            (a, b) => a.is_some() != b.is_some(),
        };
        let near_or_beside = |cell: usize| (cell.saturating_sub(1)..(cell + 2).min(CELLS)).any(near);
        (0..CELLS).filter(|&cell| near_or_beside(cell)).map(|cell| [border(cell), border(cell + 1)]).collect()
    }

    /// E over the beam's, averaged over each pixel: the midpoint rule over i with about `steps` steps for each passage.
    pub fn averages(&self, picture: &ReceiverPicture, steps: usize) -> Vec<f64> {
        let mut sums = vec![0.0; picture.pixels.count()];
        for passage in self.passages() {
            let cells = self.reaching(passage, picture.reach());
            let each = steps.div_ceil(cells.len().max(1));
            for [from, to] in cells {
                let step = (to - from) / each as f64;
                for i in (0..each).map(|k| from + (k as f64 + 0.5) * step) {
                    self.add_circle(i, step, passage, picture, &mut sums);
                }
            }
        }
        sums
    }

    /// Adds the light of the heights between i ± step/2 to the pixels that its circle meets.
    fn add_circle(&self, i: f64, step: f64, passage: Passage, picture: &ReceiverPicture, sums: &mut [f64]) {
        let Some(radius) = self.landing(i, passage) else { return };
        // h dh, spread over the angles of a circle; pixels have an area of 1/scale².
        let light = self.passed(i, passage) * i.sin() * i.cos() * step * picture.scale * picture.scale;
        picture
            .pixels
            .circle(picture.centre, radius.abs() * picture.scale, |pixel, angle| sums[pixel] += light * angle);
    }
}
