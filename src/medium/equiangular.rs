//! Places on a ray spread evenly over the angles under which a point sees them, for light that falls off like 1/r² from there ·
//! metres · p(t) = D/((θ_b − θ_a)(D² + (t − δ)²)), δ being the place nearest to the point and D its distance `[Kulla12]`.

use crate::math::{Dir3, Point3};

/// Of the point's distance from the ray's origin: nearer than that to the ray it counts as so near.
const NEAREST: f64 = 1e-6;

/// The angles of a part of a ray as a point sees them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equiangular {
    nearest: f64,
    distance: f64,
    angles: [f64; 2],
}

impl Equiangular {
    /// Of the part of the ray between two distances, the second of which may be infinite; `None` where all of it is seen
    /// under one angle.
    pub fn new(origin: Point3, w: Dir3, within: [f64; 2], point: Point3) -> Option<Equiangular> {
        let to_point = point - origin;
        let nearest = to_point.dot(w.to_vec());
        let distance = (to_point - w * nearest).length().max(NEAREST * to_point.length());
        let angles = within.map(|t| ((t - nearest) / distance).atan());
        (angles[1] > angles[0]).then_some(Equiangular { nearest, distance, angles })
    }

    pub fn sample(&self, u: f64) -> f64 {
        let [a, b] = self.angles;
        self.nearest + self.distance * (a + u * (b - a)).tan()
    }

    /// Of places within the part, 1/m.
    pub fn pdf(&self, t: f64) -> f64 {
        let ([a, b], off) = (self.angles, t - self.nearest);
        self.distance / ((b - a) * (self.distance * self.distance + off * off))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    /// The sampler's slope is 1/p, and its ends are those of the part.
    #[test]
    fn the_density_is_that_of_the_samples() {
        let w = Dir3::new(Vec3::new(1.0, 2.0, -2.0)).expect("not zero");
        let origin = Point3::new(0.3, -0.2, 0.1);
        for (point, within) in [
            (Point3::new(1.0, 0.5, 0.0), [0.2, 4.0]),
            (Point3::new(-3.0, 1.0, 2.0), [0.0, 1.0]),
            (origin + w * 2.0 + Vec3::new(0.01, 0.0, 0.005), [1.0, 3.0]),
            (Point3::new(1.0, 0.0, 0.0), [0.5, f64::INFINITY]),
        ] {
            let angles = Equiangular::new(origin, w, within, point).expect("two angles");
            assert!((angles.sample(0.0) - within[0]).abs() < 1e-9);
            assert!(within[1].is_infinite() || (angles.sample(1.0) - within[1]).abs() < 1e-9);
            let h = 1e-5;
            for u in [0.1, 0.3, 0.5, 0.8] {
                let slope = (angles.sample(u + h) - angles.sample(u - h)) / (2.0 * h);
                assert!((slope * angles.pdf(angles.sample(u)) - 1.0).abs() < 1e-6, "{point:?} {u}");
            }
        }
        // A point on the ray.
        let angles = Equiangular::new(origin, w, [1.0, 3.0], origin + w * 2.0).expect("two angles");
        assert!((angles.sample(0.5) - 2.0).abs() < 1e-6 && angles.pdf(2.0).is_finite());
        assert_eq!(Equiangular::new(origin, w, [1.0, 1.0], Point3::ORIGIN), None);
    }
}
