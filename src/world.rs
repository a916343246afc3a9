//! What rays fly through: the scene, a backend over its geometry, its lights and its textures.

mod casters;
mod flight;

use std::sync::atomic::{AtomicU64, Ordering};

use crate::backend::{self, Backend, BackendError};
use crate::differential::Differential;
use crate::light::{Aim, LightError, Lights};
use crate::math::{Dir3, Ray};
use crate::medium::{LostCount, Regions};
use crate::sampling::Stream;
use crate::scene::Scene;
use crate::scene::texture::TextureError;
use crate::shape::Parametrisation;
use crate::surface::{Bsdf, Interaction, Lookup, Textures, normal_map};

pub use casters::Casters;
pub use flight::{Flown, MediumPoint};

/// Why a scene cannot be traced.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    #[error(transparent)]
    Backend(#[from] BackendError),
    #[error(transparent)]
    Textures(#[from] TextureError),
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Lights(Vec<LightError>),
}

/// A scene ready to be traced.
pub struct World {
    pub scene: Scene,
    pub backend: Box<dyn Backend>,
    pub lights: Lights,
    pub textures: Textures,
    /// Where participating media are, if there are any.
    pub regions: Option<Regions>,
    /// Where caustics can come from: around all objects that can focus light.
    pub aim: Option<Aim>,
    /// The objects that can, in groups.
    pub casters: Option<Casters>,
    /// Whether any material bends normals by an image.
    bends_normals: bool,
    /// Hits so far that could not be found again in `f64`.
    inexact: AtomicU64,
}

impl World {
    pub fn new(scene: Scene) -> Result<World, WorldError> {
        let backend = backend::build(scene.settings.backend, &scene)?;
        let lights = Lights::new(&scene).map_err(WorldError::Lights)?;
        let textures = Textures::new(&scene.textures);
        textures.check()?;
        let regions = Regions::new(&scene);
        let casters = Casters::new(&scene);
        let aim = casters.as_ref().map(|casters| casters.whole);
        let bends_normals = scene.materials.iter().any(|material| material.normal_map().is_some());
        Ok(World { scene, backend, lights, textures, regions, aim, casters, bends_normals, inexact: AtomicU64::new(0) })
    }

    /// A time at which the shutter is open, drawn from `stream` if anything moves meanwhile.
    pub fn draw_time(&self, stream: &mut Stream) -> f64 {
        let shutter = self.scene.shutter;
        if shutter.is_instant() { shutter.open } else { shutter.time(stream.uniform()) }
    }

    /// The first surface along a ray of unit direction.
    pub fn intersect(&self, ray: &Ray) -> Option<Interaction> {
        let hit = self.backend.intersect(ray)?;
        let mut si = Interaction::from_hit(&self.scene, ray, &hit);
        if self.bends_normals {
            self.bend_normal(&mut si);
        }
        if !si.exact {
            self.inexact.fetch_add(1, Ordering::Relaxed);
        }
        Some(si)
    }

    fn bend_normal(&self, si: &mut Interaction) {
        let Some(map) = self.scene.materials[si.material.index()].normal_map() else { return };
        let at = si.parametrisation(&self.scene);
        let image = self.textures.with_slopes(map.texture, at.uv);
        (si.ns, si.shape) = normal_map::bent(si, &at, &image, map.scale);
    }

    /// Hits so far whose place is the backend's own, in its precision ([`Interaction::exact`]).
    pub fn inexact_hits(&self) -> u64 {
        self.inexact.load(Ordering::Relaxed)
    }

    /// What rays through media lost count of so far.
    pub fn lost_count(&self) -> LostCount {
        self.regions.as_ref().map_or(LostCount::default(), Regions::lost_count)
    }

    /// The BSDF with textures filtered over the footprint of a camera ray's columns, transferred to the surface.
    pub fn bsdf(&self, si: &Interaction, columns: &Differential<2>) -> Bsdf {
        self.bsdf_with(si, |at| Lookup::filtered(at, columns))
    }

    /// The BSDF with textures read at a point.
    pub fn bsdf_unfiltered(&self, si: &Interaction) -> Bsdf {
        self.bsdf_with(si, Lookup::point)
    }

    fn bsdf_with(&self, si: &Interaction, lookup: impl FnOnce(&Parametrisation) -> Lookup) -> Bsdf {
        let material = &self.scene.materials[si.material.index()];
        let mut lookup =
            if material.has_image() { lookup(&si.parametrisation(&self.scene)) } else { Lookup::default() };
        if material.is_tinted_by_vertices() {
            lookup.tint = si.vertex_colour(&self.scene);
        }
        Bsdf::new(material, &self.textures, si, &lookup)
    }

    /// The ray from the point to what lies `distance` along `wi`; an infinite distance, the environment's, stays infinite.
    ///
    /// It starts off the surface and is aimed anew from there. A parallel ray would pass a curved light's limb on the
    /// wrong side, and the light would shadow itself: 2 % of a 3 mm lamp's light at half a metre, measured.
    pub fn shadow_ray(from: &Interaction, wi: Dir3, distance: f64) -> Ray {
        let origin = from.ray_origin(wi);
        if distance.is_infinite() {
            return Ray::new(origin, wi).at_time(from.time);
        }
        // The far end stops short of the light's own surface by what rounding may have moved either point.
        let mut ray = Ray::between(origin, from.p + wi * distance, 1e-6).unwrap_or(Ray::new(origin, wi));
        ray.time = from.time;
        ray.t_max = ray.t_max.min(distance) - 2.0 * from.error;
        ray
    }

    /// Whether nothing lies between the point and `distance` along `wi`.
    pub fn visible(&self, from: &Interaction, wi: Dir3, distance: f64) -> bool {
        let ray = World::shadow_ray(from, wi, distance);
        ray.t_max > 0.0 && !self.backend.occluded(&ray)
    }
}
