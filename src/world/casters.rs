//! Where caustics can come from: the objects that can focus light, in groups that lie together.
//!
//! Light towards the sphere around two glasses that stand a kilometre apart misses both. Light towards each one's own sphere
//! does not; and since every ray of light meets one object first, photons towards a group go on only where this is one of the
//! group's: the groups share the light out, and none of it is counted twice.

use crate::light::Aim;
use crate::math::Point3;
use crate::scene::{ObjectId, Scene};

/// Spheres around groups together have at most that part of the great circles' area of one around all that they replace;
/// with more a group would not be worth its photons' differences.
const WORTH_PARTING: f64 = 1.0 / 16.0;
/// So many times are groups parted in two at most.
const MAX_PARTINGS: u32 = 6;

/// The objects that can focus light.
#[derive(Clone, Debug, PartialEq)]
pub struct Casters {
    /// The sphere around all of them.
    pub whole: Aim,
    /// Spheres around each group; one, the whole, if there is nothing to part.
    pub groups: Vec<Aim>,
    /// Of each object; nothing for those that do not focus.
    group_of: Vec<Option<u32>>,
}

/// An object's own sphere, which for a ball is much tighter than that around its box.
#[derive(Clone, Copy)]
struct Caster {
    object: usize,
    centre: Point3,
    radius: f64,
}

/// Casters and the sphere around them.
struct Group {
    casters: Vec<Caster>,
    centre: Point3,
    radius: f64,
}

impl Group {
    fn of(casters: Vec<Caster>, scene: &Scene) -> Group {
        let bounds = casters.iter().map(|caster| scene.objects[caster.object].bounds);
        let centre = bounds.reduce(|all, bounds| all.union(bounds)).map_or(Point3::ORIGIN, |all| all.centre());
        let radius = casters.iter().map(|caster| centre.distance(caster.centre) + caster.radius).fold(0.0, f64::max);
        Group { casters, centre, radius }
    }

    /// In two where the widest gap between neighbours along the widest axis is.
    fn halves(&self, scene: &Scene) -> Option<[Group; 2]> {
        let spread = |axis: usize| {
            let (low, high) = self.casters.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), caster| {
                let x = caster.centre.to_array()[axis];
                (low.min(x), high.max(x))
            });
            high - low
        };
        let axis = (0..3).max_by(|&a, &b| spread(a).total_cmp(&spread(b)))?;
        let mut sorted = self.casters.clone();
        let at = |caster: &Caster| caster.centre.to_array()[axis];
        sorted.sort_by(|a, b| at(a).total_cmp(&at(b)));
        let gap = |i: &usize| at(&sorted[*i]) - at(&sorted[*i - 1]);
        let cut = (1..sorted.len()).max_by(|a, b| gap(a).total_cmp(&gap(b)))?;
        let upper = sorted.split_off(cut);
        Some([sorted, upper].map(|casters| Group::of(casters, scene)))
    }

    /// The groups that this one is better parted into, or itself.
    fn parted(self, scene: &Scene, partings: u32) -> Vec<Group> {
        if partings == 0 {
            return vec![self];
        }
        let Some(halves) = self.halves(scene) else { return vec![self] };
        let parts: Vec<Group> = halves.into_iter().flat_map(|half| half.parted(scene, partings - 1)).collect();
        let area: f64 = parts.iter().map(|part| part.radius * part.radius).sum();
        if area < WORTH_PARTING * self.radius * self.radius { parts } else { vec![self] }
    }

    fn aim(&self) -> Aim {
        Aim::Sphere { centre: self.centre, radius: self.radius }
    }
}

impl Casters {
    /// `None` if nothing in the scene makes caustics.
    pub fn new(scene: &Scene) -> Option<Casters> {
        let focuses = |object: &usize| {
            let object = &scene.objects[*object];
            object.caustics.cast && scene.materials[object.material.index()].can_focus()
        };
        let caster = |object: usize| {
            let (centre, radius) = scene.objects[object].bounding_sphere();
            Caster { object, centre, radius }
        };
        let all: Vec<Caster> = (0..scene.objects.len()).filter(focuses).map(caster).collect();
        if all.is_empty() {
            return None;
        }
        let whole = Group::of(all, scene);
        let aim = whole.aim();
        let groups = whole.parted(scene, MAX_PARTINGS);
        let mut group_of = vec![None; scene.objects.len()];
        for (i, group) in groups.iter().enumerate() {
            group.casters.iter().for_each(|caster| group_of[caster.object] = Some(i as u32));
        }
        Some(Casters { whole: aim, groups: groups.iter().map(Group::aim).collect(), group_of })
    }

    /// The group of an object; nothing of one that does not focus.
    pub fn group_of(&self, object: ObjectId) -> Option<u32> {
        self.group_of[object.index()]
    }
}
