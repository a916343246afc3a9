//! Lights that move as rigid bodies · world frame, metres, seconds · columns: also that of time.
//!
//! A light stands where it is in the middle of the shutter's interval; the rigid map M(t) takes it from there to its place at
//! t. Seen from the light it is the aim and the lit points that move, and solid angles, areas and fluxes are the same: what it
//! emits at t over the sample u towards an aim about c is M(t) E(u; M(t)⁻¹ c) of what it emits at rest. The emission's time
//! column, at a fixed u, is therefore
//!
//!   dx/dt = v(x) + R ∂x_E/∂c ċ,   dω/dt = Ω × ω + R ∂ω_E/∂c ċ,   ċ = −R⁻¹ v(c),
//!
//! with the velocity v and the turn Ω of the body, R the linear part of M, and what [`Light::following`] says of the aim:
//! rays that are drawn towards a lens stay on it while the lamp goes by.

use std::sync::Arc;

use super::{Aim, Emission, Light, LightSample, SceneSphere};
use crate::differential::Column;
use crate::math::{Dir3, Motion, Normal3, Point3, Transform, Vec3};
use crate::radiometry::{Pdf, SolidAngle};

/// How a light moves.
#[derive(Clone, Debug)]
pub(super) struct LightMotion {
    motion: Arc<Motion>,
    /// From the light's place in the world at rest to the body's own space.
    to_own: Transform,
    /// Light from everywhere along one direction only turns, about the middle of what it lights.
    about: Option<Point3>,
}

impl LightMotion {
    /// At rest at the time `rest`; `unbounded` light turns about the scene's middle.
    pub fn new(motion: Arc<Motion>, rest: f64, unbounded: Option<SceneSphere>) -> LightMotion {
        let to_own = motion.at(rest).inverse();
        LightMotion { motion, to_own, about: unbounded.map(|scene| scene.centre) }
    }

    /// M(t).
    fn at(&self, time: f64) -> Transform {
        let map = self.motion.at(time).compose(&self.to_own);
        match self.about {
            None => map,
            Some(centre) => {
                let shift = centre - map.point(centre);
                Transform::translate(shift).compose(&map)
            }
        }
    }

    /// v(p) and Ω× at a time.
    fn velocity(&self, time: f64, p: Point3) -> (Vec3, glam::DMat3) {
        match self.about {
            None => self.motion.velocity(time, p),
            Some(centre) => {
                let gradient = self.motion.velocity(time, centre).1;
                (gradient * (p - centre), gradient)
            }
        }
    }

    /// [`Light::emit`] of the light at `time`.
    #[inline(never)]
    pub fn emit(&self, light: &dyn Light, u: [f64; 4], aim: &Aim, time: f64) -> Option<Emission> {
        let map = self.at(time);
        let rest = light.emit(u, &seen(aim, &map))?;
        let (origin, direction) = (map.point(rest.origin), carried(&map, rest.direction));
        let (velocity, gradient) = self.velocity(time, origin);
        let follows = match *aim {
            Aim::Everywhere => Column::ZERO,
            Aim::Sphere { centre, .. } => {
                let approach = -map.inverse_vector(self.velocity(time, centre).0);
                light.following(u, &seen(aim, &map), approach)
            }
        };
        Some(Emission {
            origin,
            direction,
            normal: rest.normal.map(|n| map.normal(n)),
            jacobian: rest.jacobian.mapped(|v| map.vector(v)),
            motion: Column {
                dx: velocity + map.vector(follows.dx),
                dw: gradient * direction.to_vec() + map.vector(follows.dw),
            },
            ..rest
        })
    }

    /// [`Light::sample_li`] of the light at `time`.
    #[inline(never)]
    pub fn sample_li(&self, light: &dyn Light, p: Point3, u: [f64; 2], time: f64) -> Option<LightSample> {
        let map = self.at(time);
        let rest = light.sample_li(map.inverse_point(p), u)?;
        Some(LightSample { wi: carried(&map, rest.wi), ..rest })
    }

    /// [`Light::pdf_li`] of the light at `time`.
    #[inline(never)]
    pub fn pdf_li(
        &self,
        light: &dyn Light,
        p: Point3,
        wi: Dir3,
        (p_on_light, n_on_light): (Point3, Normal3),
        time: f64,
    ) -> Pdf<SolidAngle> {
        let map = self.at(time);
        let back = map.inverse();
        let [p, p_on_light] = [p, p_on_light].map(|p| back.point(p));
        light.pdf_li(p, carried(&back, wi), p_on_light, back.normal(n_on_light))
    }
}

/// An aim as the light at rest sees it.
fn seen(aim: &Aim, map: &Transform) -> Aim {
    match *aim {
        Aim::Everywhere => Aim::Everywhere,
        Aim::Sphere { centre, radius } => Aim::Sphere { centre: map.inverse_point(centre), radius },
    }
}

/// Turned; made unit again, since products of rotations are only nearly rotations.
fn carried(map: &Transform, w: Dir3) -> Dir3 {
    Dir3::new(map.vector(w.to_vec())).unwrap_or(w)
}
