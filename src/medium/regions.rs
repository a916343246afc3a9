//! Which medium is where along a ray.
//!
//! A ray is inside of a set of objects, which changes as it goes through their surfaces. The medium about it is that of
//! the object of the highest priority in the set, of equal ones the last that was entered; out in the open it is the
//! atmosphere, which ends at the sphere around the scene's objects. An object whose material has an inside but no medium
//! in it, clear glass, keeps the atmosphere out.

use super::inside::Inside;
use super::lost::{Losses, LostCount};
use super::way::Way;
use crate::math::{Bounds3, Dir3, Point3};
use crate::scene::medium::Interior;
use crate::scene::{Medium, MediumId, ObjectId, Scene};
use crate::surface::Interaction;

/// What fills the objects of a scene and what is around them.
#[derive(Debug)]
pub struct Regions {
    media: Vec<Medium>,
    /// Of each object.
    interiors: Vec<Option<Interior>>,
    interfaces: Vec<bool>,
    pub has_interfaces: bool,
    /// Around every object that has an inside.
    solids: Vec<Bounds3>,
    /// Around all objects; no medium reaches farther.
    whole: Sphere,
    atmosphere: Option<MediumId>,
    losses: Losses,
}

#[derive(Clone, Copy, Debug)]
struct Sphere {
    centre: Point3,
    radius: f64,
}

/// A part of a ray that lies in one medium, between two distances, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    pub medium: MediumId,
    pub from: f64,
    pub to: f64,
}

impl Stretch {
    pub fn length(&self) -> f64 {
        self.to - self.from
    }
}

impl Regions {
    /// `None` where light goes through the scene as through nothing.
    pub fn new(scene: &Scene) -> Option<Regions> {
        let media = &scene.media;
        if media.is_empty() {
            return None;
        }
        let interiors: Vec<_> = scene.objects.iter().map(|object| media.interior(object.material)).collect();
        let of_material = |object: &crate::scene::Object| &scene.materials[object.material.index()];
        let interfaces = scene.objects.iter().map(|object| of_material(object).is_interface()).collect();
        let solids = scene.objects.iter().zip(&interiors).filter(|(_, interior)| interior.is_some());
        let (centre, radius) = scene.bounds.bounding_sphere();
        Some(Regions {
            media: media.media.clone(),
            interfaces,
            has_interfaces: media.has_interfaces,
            solids: solids.map(|(object, _)| object.bounds).collect(),
            interiors,
            whole: Sphere { centre, radius },
            atmosphere: media.atmosphere,
            losses: Losses::default(),
        })
    }

    pub fn get(&self, id: MediumId) -> &Medium {
        &self.media[id.index()]
    }

    /// All media, by their ids.
    pub fn media(&self) -> &[Medium] {
        &self.media
    }

    /// A stretch of a ray with what is in it.
    pub fn way(&self, stretch: &Stretch, origin: Point3, w: Dir3) -> Way<'_> {
        Way { medium: self.get(stretch.medium), origin, w, from: stretch.from, to: stretch.to }
    }

    /// What rays lost count of so far.
    pub fn lost_count(&self) -> LostCount {
        self.losses.count()
    }

    /// A ray that went through too many surfaces is given up.
    pub fn note_caught(&self) {
        self.losses.note_caught();
    }

    /// Whether some medium scatters.
    pub fn scatter(&self) -> bool {
        let filled = self.interiors.iter().filter_map(|interior| interior.as_ref()?.medium).chain(self.atmosphere);
        filled.into_iter().any(|id| self.get(id).scatters())
    }

    /// Whether the object is nothing but the boundary of a medium.
    pub fn is_interface(&self, object: ObjectId) -> bool {
        self.interfaces[object.index()]
    }

    /// Whether light gets into the object.
    pub fn has_inside(&self, object: ObjectId) -> bool {
        self.interiors[object.index()].is_some()
    }

    /// Whether a ray from the point along `up` may get out of some object: a solid one around it, or an open one above it.
    pub fn may_hold(&self, p: Point3, up: Dir3) -> bool {
        let (p, up) = (p.to_array(), up.to_vec().to_array());
        let above = |bounds: &Bounds3| {
            let (lo, hi) = (bounds.min.to_array(), bounds.max.to_array());
            let (mut near, mut far) = (0.0f64, f64::INFINITY);
            for k in 0..3 {
                if up[k] == 0.0 {
                    if p[k] < lo[k] || p[k] > hi[k] {
                        return false;
                    }
                    continue;
                }
                let [a, b] = [(lo[k] - p[k]) / up[k], (hi[k] - p[k]) / up[k]];
                (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
            }
            near <= far
        };
        self.solids.iter().any(above)
    }

    /// What a ray is inside of that came to `si` being inside of `inside` and leaves it towards `wi`.
    pub fn beyond(&self, inside: Inside, si: &Interaction, wi: Dir3) -> Inside {
        let (before, after) = (si.ng.dot(si.wo), si.ng.dot(wi));
        if before * after >= 0.0 || !self.has_inside(si.object) {
            return inside;
        }
        if after > 0.0 {
            return inside.left(si.object);
        }
        if inside.left(si.object).is_full() {
            self.losses.note_nested();
        }
        inside.entered(si.object)
    }

    /// What of the first `length` metres of a ray that is inside of `inside` lies in a medium.
    pub fn stretch(&self, inside: Inside, origin: Point3, w: Dir3, length: f64) -> Option<Stretch> {
        let mut about: Option<Interior> = None;
        for object in inside.objects() {
            let interior = self.interiors[object.index()];
            if interior.is_some_and(|i| about.is_none_or(|a| i.priority >= a.priority)) {
                about = interior;
            }
        }
        let stretch = match (about, self.atmosphere) {
            // An open surface's inside ends with the scene.
            (Some(interior), _) if length.is_infinite() => {
                let [_, to] = self.whole.chord(origin, w)?;
                Stretch { medium: interior.medium?, from: 0.0, to }
            }
            (Some(interior), _) => Stretch { medium: interior.medium?, from: 0.0, to: length },
            (None, Some(medium)) => {
                let [from, to] = self.whole.chord(origin, w)?;
                Stretch { medium, from: from.max(0.0), to: to.min(length) }
            }
            (None, None) => return None,
        };
        (stretch.to > stretch.from).then_some(stretch)
    }
}

impl Sphere {
    /// The distances at which a ray enters and leaves it.
    fn chord(&self, origin: Point3, w: Dir3) -> Option<[f64; 2]> {
        let to_centre = self.centre - origin;
        let along = to_centre.dot(w.to_vec());
        let off = (to_centre - w * along).length_squared();
        let half = (self.radius * self.radius - off).sqrt();
        // Not a number beside the sphere.
        (half > 0.0).then_some([along - half, along + half])
    }
}
