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

    /// E over the beam's, averaged over each pixel: the midpoint rule over i with `steps` steps.
    pub fn averages(&self, picture: &ReceiverPicture, steps: usize) -> Vec<f64> {
        let mut sums = vec![0.0; picture.pixels.count()];
        let step = self.beam.asin() / steps as f64;
        for passage in self.passages() {
            for i in (0..steps).map(|k| (k as f64 + 0.5) * step) {
                let Some(radius) = self.landing(i, passage) else { continue };
                // h dh, spread over the angles of a circle; pixels have an area of 1/scale².
                let light = self.passed(i, passage) * i.sin() * i.cos() * step * picture.scale * picture.scale;
                picture.pixels.circle(picture.centre, radius.abs() * picture.scale, |pixel, angle| {
                    sums[pixel] += light * angle;
                });
            }
        }
        sums
    }
}
