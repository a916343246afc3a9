//! Rays through participating media: from one surface that light notices to the next, medium by medium.

use std::ops::ControlFlow;

use super::World;
use crate::math::float::origin_offset;
use crate::math::{Dir3, Point3, Ray};
use crate::medium::{Inside, Regions, Stretch};
use crate::radiometry::Spectrum;
use crate::scene::MediumId;
use crate::surface::Interaction;

/// Surfaces that a ray goes through at most, as through nothing, before it counts as caught in them.
const MAX_CROSSINGS: u32 = 1000;

/// How a flight ended.
#[expect(clippy::large_enum_variant, reason = "it is looked at where it is made, and most flights end at a surface")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flown<T> {
    /// At a surface; its `t` is the distance from where the flight began.
    Surface(Interaction),
    /// Out of the scene.
    Escaped,
    /// In a medium, where the visitor said so.
    Stopped(T),
}

impl World {
    /// Leads `visit` along the ray, stretch by stretch of media and with what the ray is inside of there, to the first
    /// surface that light notices. `inside` is what the ray is inside of, at its start and then at its end.
    pub fn fly<T>(
        &self,
        regions: &Regions,
        ray: &Ray,
        inside: &mut Inside,
        mut visit: impl FnMut(&Stretch, Inside) -> ControlFlow<T>,
    ) -> Flown<T> {
        let w = Dir3::from_unit(ray.direction);
        let mut leg = *ray;
        let mut flown = 0.0;
        for _ in 0..MAX_CROSSINGS {
            let si = self.intersect(&leg);
            let length = si.as_ref().map_or(leg.t_max, |si| si.t);
            if let Some(stretch) = regions.stretch(*inside, leg.origin, w, length) {
                let stretch = Stretch { from: flown + stretch.from, to: flown + stretch.to, ..stretch };
                if let ControlFlow::Break(stopped) = visit(&stretch, *inside) {
                    return Flown::Stopped(stopped);
                }
            }
            let Some(mut si) = si else { return Flown::Escaped };
            if !regions.is_interface(si.object) {
                si.t += flown;
                return Flown::Surface(si);
            }
            *inside = regions.beyond(*inside, &si, w);
            let origin = si.ray_origin(w);
            flown = (origin - ray.origin).dot(ray.direction);
            leg = Ray { origin, t_max: ray.t_max - flown, ..leg };
        }
        regions.note_caught();
        Flown::Escaped
    }

    /// The first surface along the ray that light notices, and what of the light gets there, or out of the scene.
    pub fn cross(&self, regions: &Regions, ray: &Ray, inside: &mut Inside) -> (Option<Interaction>, Spectrum) {
        let (mut left, w) = (Spectrum::ONE, Dir3::from_unit(ray.direction));
        let flown = self.fly(regions, ray, inside, |stretch, _| {
            left *= regions.way(stretch, ray.origin, w).transmittance();
            ControlFlow::<()>::Continue(())
        });
        match flown {
            Flown::Surface(si) => (Some(si), left),
            Flown::Escaped | Flown::Stopped(()) => (None, left),
        }
    }

    /// The first surface along the ray that light notices.
    pub fn first_surface(&self, ray: &Ray) -> Option<Interaction> {
        match &self.regions {
            Some(regions) if regions.has_interfaces => self.cross(regions, ray, &mut Inside::default()).0,
            _ => self.intersect(ray),
        }
    }

    /// What of the light gets along a shadow ray to its end; `None`: something is in between.
    pub fn transmittance(&self, regions: &Regions, ray: &Ray, mut inside: Inside) -> Option<Spectrum> {
        if ray.t_max <= 0.0 {
            return None;
        }
        if !regions.has_interfaces {
            let open = !self.backend.occluded(ray);
            return open.then(|| self.left_of(regions, ray, inside));
        }
        match self.cross(regions, ray, &mut inside) {
            (None, left) => Some(left),
            (Some(_), _) => None,
        }
    }

    /// What of the light is left at the end of a ray on which there is no surface.
    fn left_of(&self, regions: &Regions, ray: &Ray, inside: Inside) -> Spectrum {
        let w = Dir3::from_unit(ray.direction);
        let stretch = regions.stretch(inside, ray.origin, w, ray.t_max);
        stretch.map_or(Spectrum::ONE, |s| regions.way(&s, ray.origin, w).transmittance())
    }

    /// What a surface point sees of a light `distance` along `wi`: nothing, or what of its light gets there. `inside` is
    /// what the ray that came to the point was inside of.
    pub fn seen(&self, from: &Interaction, wi: Dir3, distance: f64, inside: Inside) -> Option<Spectrum> {
        match &self.regions {
            None => self.visible(from, wi, distance).then_some(Spectrum::ONE),
            Some(regions) => {
                let ray = World::shadow_ray(from, wi, distance);
                self.transmittance(regions, &ray, regions.beyond(inside, from, wi))
            }
        }
    }

    /// What a point at `time` is inside of: the objects that a ray from it upwards, as the camera has it, leaves without
    /// having entered them. An open surface bounds a medium as far as such rays meet it.
    pub fn inside(&self, p: Point3, time: f64) -> Inside {
        let up = Dir3::new(self.scene.camera.up).unwrap_or(Dir3::Z);
        let Some(regions) = self.regions.as_ref().filter(|regions| regions.may_hold(p, up)) else {
            return Inside::NOTHING;
        };
        let mut left = Vec::new();
        let mut entered = Vec::new();
        let mut ray = Ray::new(p, up).at_time(time);
        for _ in 0..MAX_CROSSINGS {
            let Some(si) = self.intersect(&ray) else { break };
            let outward = si.ng.dot(up) > 0.0;
            if regions.has_inside(si.object) {
                match entered.iter().position(|&object| object == si.object) {
                    Some(i) if outward => drop(entered.swap_remove(i)),
                    None if outward => left.push(si.object),
                    _ if !outward => entered.push(si.object),
                    _ => {}
                }
            }
            ray = si.ray(up);
        }
        // The outermost is left last, and was entered first.
        left.into_iter().rev().fold(Inside::NOTHING, Inside::entered)
    }
}

/// A place in a medium at which light is scattered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumPoint {
    pub p: Point3,
    /// Distance along the ray that came here, m.
    pub t: f64,
    /// s.
    pub time: f64,
    pub medium: MediumId,
}

impl MediumPoint {
    /// The ray to what lies `distance` along `wi`, as [`World::shadow_ray`] from a surface; it stops short of the light's own
    /// surface by what rounding may have moved that.
    pub fn shadow_ray(&self, wi: Dir3, distance: f64) -> Ray {
        let ray = Ray::new(self.p, wi).at_time(self.time);
        if distance.is_infinite() {
            return ray;
        }
        let farthest = self.p.abs().max((self.p + wi * distance).abs()).max_element();
        Ray { t_max: distance * (1.0 - 1e-6) - 2.0 * origin_offset(farthest), ..ray }
    }
}
