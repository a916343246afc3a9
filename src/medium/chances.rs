//! How likely a place on a way is drawn, by the path itself as its next event and for a light, both per metre: what the two ways
//! to the same light, over the phase function and along a shadow ray, are weighed by `[Veach97 9.2.4]`.

use super::equiangular::Equiangular;
use crate::math::{Dir3, Point3};

/// The densities of one place on a way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chances {
    pub(super) origin: Point3,
    pub(super) w: Dir3,
    pub(super) within: [f64; 2],
    /// The place, as a distance from the origin, m.
    pub t: f64,
    /// As [`super::Way::draw`] finds it, 1/m.
    pub event: f64,
    /// As [`super::Way::draw_within`] finds it, 1/m.
    pub(super) on_the_way: f64,
}

impl Chances {
    /// As [`super::Way::draw_towards`] finds it for light that comes from `point`, or from infinitely far away, 1/m.
    pub fn towards(&self, point: Option<Point3>) -> f64 {
        let angles = point.and_then(|point| Equiangular::new(self.origin, self.w, self.within, point));
        angles.map_or(self.on_the_way, |angles| 0.5 * (angles.pdf(self.t) + self.on_the_way))
    }

    /// How many times as likely the place is drawn for light that comes from `point` as by the path.
    pub fn odds(&self, point: Option<Point3>) -> f64 {
        if self.event > 0.0 { self.towards(point) / self.event } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::{Transform, Vec3};
    use crate::medium::Way;
    use crate::radiometry::Spectrum;
    use crate::sampling::{Purpose, Stream};
    use crate::scene::Medium;
    use crate::scene::density::{DensityGrid, Interpolation};

    const STEPS: u32 = 2000;
    const DRAWS: u32 = 20_000;

    /// Of as many draws as there are of each kind, those that lie in each eighth of the way are as many as the densities'
    /// integrals say; the integrals by the midpoint rule.
    fn assert_found_as_said(way: &Way, beta: Spectrum, point: Option<Point3>, seed: u64) {
        let mut stream = Stream::new(seed, Purpose::Test, 0, 0);
        let (mut found, mut said) = ([[0.0; 8]; 2], [[0.0; 8]; 2]);
        let eighth = |t: f64| ((t - way.from) / (way.to - way.from) * 8.0).min(7.0) as usize;
        for _ in 0..DRAWS {
            if let (Some(t), _) = way.draw(beta, stream.uniform2()) {
                found[0][eighth(t)] += 1.0;
            }
            let u = [stream.uniform(), stream.uniform(), stream.uniform()];
            let (place, _) = way.draw_towards(point, beta, u).expect("something can happen");
            found[1][eighth(place.t)] += 1.0;
        }
        for k in 0..STEPS {
            let width = (way.to - way.from) / f64::from(STEPS);
            let t = way.from + (f64::from(k) + 0.5) * width;
            let chances = way.chances(beta, t);
            said[0][eighth(t)] += chances.event * width;
            said[1][eighth(t)] += chances.towards(point) * width;
        }
        let total: f64 = said[1].iter().sum();
        assert!((total - 1.0).abs() < 1e-4, "{total}: every draw towards a point finds a place");
        for (found, said) in found.into_iter().flatten().zip(said.into_iter().flatten()) {
            let (n, error) = (f64::from(DRAWS), (said * (1.0 - said) / f64::from(DRAWS)).sqrt());
            // Five standard errors of sixty-four numbers.
            assert!((found / n - said).abs() < 5.0 * error, "seed {seed}: {} of the draws, not {said}", found / n);
        }
    }

    #[test]
    fn densities_are_those_of_the_draws() {
        let place = Transform::scale(Vec3::splat(3.0)).expect("no factor is zero");
        let samples = vec![0.3, 1.0, 0.2, 0.7, 0.9, 0.1, 0.4, 0.8];
        let grid = DensityGrid { place, counts: [2, 2, 2], samples, between: Interpolation::Linear };
        let (origin, w) = (Point3::new(0.2, 0.4, 0.1), Dir3::new(Vec3::new(2.0, 1.0, 2.0)).expect("a direction"));
        for (seed, density) in [(1, None), (2, Some(Arc::new(grid)))] {
            let (absorption, scattering) = (Spectrum::rgb(0.2, 0.1, 1.0), Spectrum::rgb(0.5, 0.0, 3.0));
            let medium = Medium { absorption, scattering, asymmetry: 0.0, density };
            let way = Way { medium: &medium, origin, w, from: 0.3, to: 2.5 };
            let beta = Spectrum::rgb(1.0, 0.5, 0.1);
            for point in [Some(Point3::new(1.0, 0.9, 0.8)), None] {
                assert_found_as_said(&way, beta, point, seed);
            }
            // A point on the way itself: found by a path next to never.
            assert!(way.chances(beta, 1.1).odds(Some(origin + w * 1.1)) > 1e5);
        }
    }
}
