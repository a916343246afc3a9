//! The spotlight · W/sr · columns: no position, directions of the narrower of its own cone and the aim's.

use std::f64::consts::{FRAC_PI_2, PI};

use super::aim::{self, Cone, Directions};
use super::{Aim, Emission, Light, LightBounds, LightSample, NormalCone, direction_columns};
use crate::differential::Column;
use crate::math::{Bounds3, Dir3, Frame, Normal3, Point3, Vec3};
use crate::radiometry::{Flux, Intensity, Pdf, Radiance, SolidAngle};
use crate::sampling::warp::UniformCone;

/// Full intensity inside the inner cone, falling to zero at the outer one by t²(3 − 2t), t linear in the cosine.
///
/// Directions are drawn uniformly, the falloff is in the flux: even cells keep photons' footprints even.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLight {
    position: Point3,
    intensity: Intensity,
    cos_inner: f64,
    cos_outer: f64,
    cone: Cone,
}

impl SpotLight {
    /// Cosines of half angles, −1 < `cos_outer` ≤ `cos_inner` ≤ 1, `cos_outer` < 1.
    pub fn new(position: Point3, direction: Dir3, intensity: Intensity, cos_inner: f64, cos_outer: f64) -> SpotLight {
        let cone = Cone { frame: Frame::from_unit(direction), warp: UniformCone::from_cos(cos_outer) };
        SpotLight { position, intensity, cos_inner, cos_outer, cone }
    }

    fn falloff(&self, cos: f64) -> f64 {
        if cos >= self.cos_inner {
            1.0
        } else if cos <= self.cos_outer {
            0.0
        } else {
            let t = (cos - self.cos_outer) / (self.cos_inner - self.cos_outer);
            t * t * (3.0 - 2.0 * t)
        }
    }

    /// The map that directions are drawn by, and the cone that they must lie in to matter, if that is another one.
    fn directions(&self, aim: &Aim) -> (Cone, Option<Cone>) {
        match Directions::towards(self.position, aim) {
            Directions::Sphere => (self.cone, None),
            Directions::Cone(aimed) if aimed.warp.height() < self.cone.warp.height() => (aimed, None),
            Directions::Cone(aimed) => (self.cone, Some(aimed)),
        }
    }

    /// ∫ falloff dω = 2π ((1 − cos inner) + (cos inner − cos outer)/2): the falloff's mean over its range of cosines
    /// is ½.
    fn integral(&self) -> f64 {
        2.0 * PI * (1.0 - 0.5 * (self.cos_inner + self.cos_outer))
    }

    /// ∫ falloff dω over the part of the own cone inside `aimed`, by circles about the own axis: each lies within
    /// `aimed` over an arc that follows from the spherical law of cosines.
    fn integral_within(&self, aimed: &Cone) -> f64 {
        let cos_between = self.cone.frame.n.dot(aimed.frame.n).clamp(-1.0, 1.0);
        let sin_between = self.cone.frame.n.cross(aimed.frame.n).length();
        let between = sin_between.atan2(cos_between);
        let cos_aim = 1.0 - aimed.warp.height();
        let aim_angle = cos_aim.acos();
        let arc = |theta: f64| {
            let (sin, cos) = theta.sin_cos();
            let lack = cos_aim - cos * cos_between;
            let denominator = sin * sin_between;
            // On a common axis the whole circle is in or out.
            let c = if denominator > 0.0 { (lack / denominator).clamp(-1.0, 1.0) } else { lack.signum() };
            2.0 * c.acos()
        };
        let outer = self.cos_outer.acos();
        // One within the other, where the integral is known.
        if between + aim_angle <= self.cos_inner.acos() {
            return aimed.warp.solid_angle();
        }
        if between + outer <= aim_angle {
            return self.integral();
        }
        let mut ends = [
            0.0,
            self.cos_inner.acos(),
            (between - aim_angle).abs(),
            between + aim_angle,
            2.0 * PI - between - aim_angle,
            outer,
        ]
        .map(|end| end.clamp(0.0, outer));
        ends.sort_by(f64::total_cmp);
        ends.windows(2)
            .map(|piece| integrate(piece[0], piece[1], |theta| self.falloff(theta.cos()) * arc(theta) * theta.sin()))
            .sum()
    }
}

/// ∫ f over [low, high] where f may start or end like a square root, by the double-exponential rule `[Takahasi74]`.
fn integrate(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    // x = tanh((π/2) sinh s) has reached ±1 to rounding at |s| = 3.2.
    const STEPS: i32 = 64;
    const STEP: f64 = 0.05;
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let term = |i: i32| {
        let s = STEP * f64::from(i);
        let inner = FRAC_PI_2 * s.sinh();
        f(middle + half * inner.tanh()) * FRAC_PI_2 * s.cosh() / inner.cosh().powi(2)
    };
    (-STEPS..=STEPS).map(term).sum::<f64>() * half * STEP
}

impl Light for SpotLight {
    fn power(&self) -> Flux {
        Flux(self.intensity.0 * self.integral())
    }

    /// `None` where the own cone and the aim's do not overlap: what is drawn from the narrower one is lost there.
    fn emit(&self, u: [f64; 4], aim: &Aim) -> Option<Emission> {
        let (cone, required) = self.directions(aim);
        let (direction, columns) = cone.sample_with_jacobian([u[2], u[3]]);
        let falloff = self.falloff(direction.dot(self.cone.frame.n));
        if falloff <= 0.0 || required.is_some_and(|c| !c.contains(direction)) {
            return None;
        }
        Some(Emission {
            origin: self.position,
            direction,
            normal: None,
            flux: Flux(self.intensity.0 * (falloff * cone.warp.solid_angle())),
            pdf_a: None,
            pdf_w: Some(cone.pdf()),
            jacobian: direction_columns(columns),
            motion: Column::ZERO,
        })
    }

    fn following(&self, u: [f64; 4], aim: &Aim, step: Vec3) -> Column {
        match Directions::towards(self.position, aim) {
            Directions::Cone(aimed) if self.directions(aim).0 == aimed => {
                aim::following(self.position, aim, [u[2], u[3]], step)
            }
            _ => Column::ZERO,
        }
    }

    fn emission_inverse(&self, _: Point3, direction: Dir3, aim: &Aim) -> Option<[f64; 4]> {
        let u = self.directions(aim).0.inverse(direction)?;
        Some([0.0, 0.0, u[0], u[1]])
    }

    fn emitted_flux(&self, aim: &Aim) -> Flux {
        match Directions::towards(self.position, aim) {
            Directions::Sphere => self.power(),
            Directions::Cone(aimed) => Flux(self.intensity.0 * self.integral_within(&aimed)),
        }
    }

    fn sample_li(&self, p: Point3, _: [f64; 2]) -> Option<LightSample> {
        let wi = Dir3::new(self.position - p)?;
        let falloff = self.falloff(-wi.dot(self.cone.frame.n));
        if falloff <= 0.0 {
            return None;
        }
        let distance = p.distance(self.position);
        let weight = Radiance(self.intensity.0 * (falloff / (distance * distance)));
        Some(LightSample { wi, distance, weight, pdf: None })
    }

    fn pdf_li(&self, _: Point3, _: Dir3, _: Point3, _: Normal3) -> Pdf<SolidAngle> {
        Pdf::ZERO
    }

    /// As if the inner cone were normals, and the rim the directions about them; its power is that of a point without a cone,
    /// since it is the intensity that arrives.
    fn bounds(&self) -> Option<LightBounds> {
        let [inner, outer] = [self.cos_inner, self.cos_outer].map(f64::acos);
        Some(LightBounds {
            bounds: Bounds3::EMPTY.including(self.position),
            normals: NormalCone { axis: Dir3::from_unit(self.cone.frame.n), spread: inner },
            reach: outer - inner,
            power: 4.0 * PI * self.intensity.0.luminance(),
            two_sided: false,
        })
    }

    fn is_delta(&self) -> bool {
        true
    }
}
