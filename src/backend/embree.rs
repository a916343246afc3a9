//! The installed Embree through `embree4_sys`: robust scenes, single rays. World frame, metres.
//!
//! Triangles are hit in f32, so their t and (u, v) carry f32 rounding and of coplanar triangles any may be first;
//! exact shapes are user geometries that see the f64 ray. Embree's intervals are closed: (t_min, t_max) goes in one
//! f64 step narrower at both ends.

use std::sync::Arc;
use std::time::Duration;

use embree4_sys::{CommittedScene, Device, SceneBuilder, SceneError, UserGeometry, UserHit, UserRay};

use super::geometry::{Geometry, Item, PlacedShape, Triangles, to_object};
use super::nearest::{Gate, MAX_DIRECTION, MIN_DIRECTION};
use super::{Backend, BackendError, Query, RawHit, geometry};
use crate::math::{Bounds3, Motion, Point3, Ray, Transform, Vec3};
use crate::scene::{ObjectId, Shutter, deformation};

// The gate refuses exactly what Embree's safe layer refuses.
const _: () = assert!(
    geometry::MAX_COORDINATE == embree4_sys::MAX_COORDINATE
        && MAX_DIRECTION == embree4_sys::MAX_DIRECTION
        && MIN_DIRECTION == embree4_sys::MIN_DIRECTION
        && deformation::MAX_STEPS == embree4_sys::MAX_TIME_STEPS
);

/// A committed Embree scene; geometry ids are object ids.
#[derive(Debug)]
pub struct EmbreeBackend {
    scene: CommittedScene,
    version: embree4_sys::Version,
    gate: Gate,
}

impl EmbreeBackend {
    /// # Errors
    /// What Embree refuses: memory, a transform that is singular in f32, too many objects.
    pub fn new(geometry: &Arc<Geometry>) -> Result<EmbreeBackend, BackendError> {
        let device = Device::new().map_err(SceneError::from)?;
        let shared = geometry
            .shared
            .iter()
            .map(|mesh| one_mesh(&device, mesh, geometry.shutter).map(Arc::new))
            .collect::<Result<Vec<_>, _>>()?;
        let mut builder = over(SceneBuilder::new(&device)?, geometry.shutter);
        for (object, item) in geometry.objects() {
            match item {
                Item::Mesh(mesh) => add_triangles(&mut builder, object.0, mesh)?,
                Item::Instance { mesh, to_world } => {
                    builder.add_instance(object.0, &shared[*mesh], &rows(to_world))?;
                }
                Item::MovingMesh { mesh, motion } => {
                    let (scene, motion) = (shared[*mesh].clone(), motion.clone());
                    builder.add_user(object.0, MovingMesh { scene, motion, bounds: geometry.bounds(object) })?;
                }
                Item::Shape(placed) => {
                    builder
                        .add_user(object.0, UserShape { placed: placed.clone(), bounds: geometry.bounds(object) })?;
                }
            }
        }
        Ok(EmbreeBackend { scene: builder.commit()?, version: device.version(), gate: Gate::default() })
    }
}

impl Backend for EmbreeBackend {
    fn intersect(&self, ray: &Ray) -> Option<RawHit> {
        let Ok(hit) = self.scene.intersect(&narrowed(ray)) else {
            self.gate.refuse();
            return None;
        };
        hit.map(|hit| RawHit {
            t: hit.t,
            object: ObjectId(hit.instance.unwrap_or(hit.geometry)),
            // User geometries have one primitive, 0, and number what is in it.
            primitive: hit.primitive + hit.part,
            uv: [hit.u, hit.v],
        })
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.scene.occluded(&narrowed(ray)).unwrap_or_else(|_| {
            self.gate.refuse();
            false
        })
    }

    fn describe(&self) -> String {
        format!("Embree {}", self.version)
    }

    fn invalid_rays(&self) -> u64 {
        self.gate.refused()
    }

    fn time(&self, query: Query, rays: &[Ray]) -> Duration {
        let rays: Vec<embree4_sys::Ray> = rays.iter().map(narrowed).collect();
        let query = match query {
            Query::Intersect => embree4_sys::Query::Intersect,
            Query::Occluded => embree4_sys::Query::Occluded,
        };
        self.scene.time(query, &rays)
    }
}

impl From<SceneError> for BackendError {
    fn from(error: SceneError) -> BackendError {
        BackendError::Embree { message: error.to_string() }
    }
}

/// The open interval as a closed one. Steps keep a NaN, and a negative start negative, so both are still refused.
fn narrowed(ray: &Ray) -> embree4_sys::Ray {
    embree4_sys::Ray {
        origin: ray.origin.to_array(),
        direction: ray.direction.to_array(),
        t_near: if ray.t_min < 0.0 { ray.t_min } else { ray.t_min.next_up() },
        t_far: ray.t_max.next_down(),
        time: ray.time,
    }
}

/// A mesh as a scene of its own, for instances.
fn one_mesh(device: &Device, mesh: &Triangles, shutter: Shutter) -> Result<CommittedScene, SceneError> {
    let mut builder = over(SceneBuilder::new(device)?, shutter);
    if !mesh.triangles.is_empty() {
        add_triangles(&mut builder, 0, mesh)?;
    }
    builder.commit()
}

fn over(builder: SceneBuilder, shutter: Shutter) -> SceneBuilder {
    builder.over(shutter.open, shutter.close)
}

/// A mesh that changes its shape is Embree's own geometry with a buffer of vertices for each frame.
fn add_triangles(builder: &mut SceneBuilder, id: u32, mesh: &Triangles) -> Result<(), SceneError> {
    let Some(deformation) = &mesh.deformation else { return builder.add_mesh(id, &mesh.positions, &mesh.triangles) };
    let frames: Vec<&[[f32; 3]]> = deformation.frames.iter().map(|frame| frame.positions.as_slice()).collect();
    builder.add_moving_mesh(id, &frames, [deformation.start, deformation.end()], &mesh.triangles)
}

/// Object → world as three rows.
fn rows(to_world: &Transform) -> [[f64; 4]; 3] {
    let [x, y, z] = to_world.columns().map(|column| column.to_array());
    let shift = to_world.translation().to_array();
    std::array::from_fn(|row| [x[row], y[row], z[row], shift[row]])
}

/// An exact shape, tested in f64.
struct UserShape {
    placed: PlacedShape,
    bounds: Bounds3,
}

impl UserGeometry for UserShape {
    fn primitives(&self) -> u32 {
        1
    }

    fn bounds(&self, _: u32) -> ([f32; 3], [f32; 3]) {
        geometry::outward(self.bounds)
    }

    fn intersect(&self, _: u32, ray: &UserRay) -> Option<UserHit> {
        self.placed.intersect(&opened(ray)).map(|t| UserHit { t, u: 0.0, v: 0.0, part: 0 })
    }
}

/// A mesh that moves: a scene of its own, asked in the mesh's space at the ray's time. Embree's own motion blur would round
/// the motion to f32 and wants keys at equal intervals.
struct MovingMesh {
    scene: Arc<CommittedScene>,
    motion: Arc<Motion>,
    bounds: Bounds3,
}

impl UserGeometry for MovingMesh {
    fn primitives(&self) -> u32 {
        1
    }

    fn bounds(&self, _: u32) -> ([f32; 3], [f32; 3]) {
        geometry::outward(self.bounds)
    }

    fn intersect(&self, _: u32, ray: &UserRay) -> Option<UserHit> {
        let own = to_object(&self.motion.at(ray.time), &opened(ray));
        // A ray that only the mesh's own space cannot hold misses.
        let hit = self.scene.intersect(&narrowed(&own)).ok()??;
        Some(UserHit { t: hit.t, u: hit.u, v: hit.v, part: hit.primitive })
    }
}

/// The closed interval of a callback as an open one.
fn opened(ray: &UserRay) -> Ray {
    Ray {
        origin: Point3::from(ray.origin),
        direction: Vec3::from_array(ray.direction),
        t_min: ray.t_near.next_down(),
        t_max: ray.t_far.next_up(),
        time: ray.time,
    }
}
