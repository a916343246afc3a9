//! The neutral description that every backend is built from: one item an object, by `ObjectId`.
//!
//! Unit: metres. Frames: a mesh that one object uses is baked to world space (f32, as it is stored); a mesh that
//! several use, or that moves, is kept once in its own space and instanced; exact shapes keep their transform. Rays go into
//! an object's space in f64 with the length that the inverse transform gives their direction, so `t` keeps its unit. What
//! moves is where its one f64 motion puts it at the ray's time, in every backend; boxes are around the whole interval. A mesh
//! that changes its shape brings the vertices of all frames along, baked or in its own space as it stands.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::BackendError;
use super::triangle::{ShearedRay, TriangleHit};
use crate::math::{Bounds3, Motion, Point3, Ray, Transform};
use crate::scene::deformation::VertexFrame;
use crate::scene::{Deformation, MeshId, Object, ObjectGeometry, ObjectId, Scene, Shutter};
use crate::shape::Shape;

/// Largest |coordinate| of anything that can be hit, metres: what Embree's f32 products can carry.
pub const MAX_COORDINATE: f64 = 1e10;

/// Triangles over shared positions; no normals, no texture coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangles {
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
    /// How positions change, in the same space; `None`: not at all.
    pub deformation: Option<Arc<Deformation>>,
}

impl Triangles {
    /// The three corners of triangle `prim` at `time`.
    pub fn corners(&self, prim: u32, time: f64) -> [Point3; 3] {
        let corners = self.triangles[prim as usize];
        match &self.deformation {
            None => corners.map(|i| Point3::from_f32(self.positions[i as usize])),
            Some(deformation) => deformation.between(time).positions(corners),
        }
    }
    /// One box a triangle, around all its places.
    pub fn boxes(&self) -> impl Iterator<Item = Bounds3> {
        let of = |prim: u32| {
            let corners = self.triangles[prim as usize];
            let places =
                |positions: &[[f32; 3]]| Bounds3::from_points(corners.map(|i| Point3::from_f32(positions[i as usize])));
            match &self.deformation {
                None => places(&self.positions),
                Some(deformation) => {
                    let frames = deformation.frames.iter().map(|frame| places(&frame.positions));
                    frames.fold(Bounds3::EMPTY, Bounds3::union)
                }
            }
        };
        (0..self.triangles.len() as u32).map(of)
    }
    /// Around all places.
    pub fn bounds(&self) -> Bounds3 {
        match &self.deformation {
            None => Bounds3::from_points(self.positions.iter().map(|&p| Point3::from_f32(p))),
            Some(deformation) => deformation.bounds(),
        }
    }
}

/// An exact shape and where it stands; always on the top level.
#[derive(Clone, Debug)]
pub struct PlacedShape {
    pub shape: Shape,
    pub to_world: Transform,
    /// `None`: it stands still.
    pub motion: Option<Arc<Motion>>,
}

impl PlacedShape {
    /// t of the first hit of a world ray in (t_min, t_max).
    ///
    /// Some shapes clip their search to the interval, and the last bits of t follow the clip; so the end is applied
    /// afterwards, and every backend gets the same bits in whatever order it shortens its ray.
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        let moved;
        let to_world = match &self.motion {
            None => &self.to_world,
            Some(motion) => {
                moved = motion.at(ray.time);
                &moved
            }
        };
        let unended = Ray { t_max: f64::INFINITY, ..to_object(to_world, ray) };
        self.shape.intersect(&unended).filter(|&t| t > ray.t_min && t < ray.t_max)
    }
}

/// What one object is to a backend.
#[derive(Clone, Debug)]
pub enum Item {
    /// A mesh of its own, in world space.
    Mesh(Triangles),
    /// A use of [`Geometry::shared`]`[mesh]`.
    Instance {
        mesh: usize,
        to_world: Transform,
    },
    /// The same, moving.
    MovingMesh {
        mesh: usize,
        motion: Arc<Motion>,
    },
    Shape(PlacedShape),
}

/// All objects of a scene, as rays see them.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// Object i of the scene is item i.
    pub items: Vec<Item>,
    /// Meshes that several objects use, or that move, in their own space.
    pub shared: Vec<Triangles>,
    /// Around item i in the world while the shutter is open, not padded.
    bounds: Vec<Bounds3>,
    /// When rays fly.
    pub shutter: Shutter,
}

impl Geometry {
    /// Bakes, shares and checks.
    ///
    /// # Errors
    /// An object that reaches beyond [`MAX_COORDINATE`] or is not finite in world space.
    pub fn new(scene: &Scene) -> Result<Geometry, BackendError> {
        let mut uses: BTreeMap<MeshId, u32> = BTreeMap::new();
        for object in &scene.objects {
            if let ObjectGeometry::Mesh { mesh, .. } = object.geometry {
                *uses.entry(mesh).or_default() += if object.motion.is_some() { 2 } else { 1 };
            }
        }
        let shared_ids: Vec<MeshId> = uses.iter().filter(|&(_, &count)| count > 1).map(|(&mesh, _)| mesh).collect();
        let shared = shared_ids.iter().map(|mesh| in_own_space(scene, *mesh)).collect();
        let mut geometry = Geometry {
            items: Vec::with_capacity(scene.objects.len()),
            shared,
            bounds: Vec::new(),
            shutter: scene.shutter,
        };
        for object in &scene.objects {
            let motion = object.motion.clone();
            let item = match &object.geometry {
                ObjectGeometry::Mesh { mesh, to_world } => match (shared_ids.binary_search(mesh), motion) {
                    (Ok(mesh), Some(motion)) => Item::MovingMesh { mesh, motion },
                    (Ok(mesh), None) => Item::Instance { mesh, to_world: *to_world },
                    (Err(_), _) => Item::Mesh(baked(scene, *mesh, to_world)),
                },
                ObjectGeometry::Shape { shape, to_world } => {
                    Item::Shape(PlacedShape { shape: shape.clone(), to_world: *to_world, motion })
                }
            };
            let bounds = geometry.bounds_of(&item, scene.shutter);
            require_bounded(object, &bounds)?;
            geometry.items.push(item);
            geometry.bounds.push(bounds);
        }
        Ok(geometry)
    }

    /// Items with their ids; meshes without a triangle are left out.
    pub fn objects(&self) -> impl Iterator<Item = (ObjectId, &Item)> {
        (0..).map(ObjectId).zip(&self.items).filter(|(_, item)| self.primitives(item) > 0)
    }

    /// Triangles of a mesh or an instance, 1 for a shape.
    pub fn primitives(&self, item: &Item) -> u32 {
        match item {
            Item::Mesh(mesh) => mesh.triangles.len() as u32,
            Item::Instance { mesh, .. } | Item::MovingMesh { mesh, .. } => self.shared[*mesh].triangles.len() as u32,
            Item::Shape(_) => 1,
        }
    }

    /// Around an object in the world while the shutter is open, not padded.
    pub fn bounds(&self, object: ObjectId) -> Bounds3 {
        self.bounds[object.index()]
    }

    fn bounds_of(&self, item: &Item, shutter: Shutter) -> Bounds3 {
        let swept = |motion: &Motion, own: Bounds3| motion.bounds(&own, shutter.open, shutter.close);
        match item {
            Item::Mesh(mesh) => mesh.bounds(),
            Item::Instance { mesh, to_world } => self.shared[*mesh].bounds().transformed(to_world),
            Item::MovingMesh { mesh, motion } => swept(motion, self.shared[*mesh].bounds()),
            Item::Shape(PlacedShape { shape, motion: Some(motion), .. }) => swept(motion, shape.bounds()),
            Item::Shape(PlacedShape { shape, to_world, motion: None }) => shape.bounds().transformed(to_world),
        }
    }
}

fn require_bounded(object: &Object, bounds: &Bounds3) -> Result<(), BackendError> {
    // Written so that a NaN fails. An empty mesh has an empty box and nothing to hit.
    let bounded = bounds.is_empty() || (bounds.max_abs() <= MAX_COORDINATE && bounds.diagonal().is_finite());
    if bounded { Ok(()) } else { Err(BackendError::OutOfBounds { object: object.name.clone() }) }
}

/// A world ray in object space; `t` keeps its unit.
pub fn to_object(to_world: &Transform, ray: &Ray) -> Ray {
    Ray { origin: to_world.inverse_point(ray.origin), direction: to_world.inverse_vector(ray.direction), ..*ray }
}

/// The f64 test of one triangle for a ray that is already in the mesh's space.
pub(super) fn hit_triangle(ray: &ShearedRay, mesh: &Triangles, prim: u32, end: f64) -> Option<TriangleHit> {
    ray.intersect(mesh.corners(prim, ray.time()), end)
}

/// The smallest f32 box around an f64 one, lower and upper corner.
pub(super) fn outward(b: Bounds3) -> ([f32; 3], [f32; 3]) {
    let down = |x: f64| if f64::from(x as f32) > x { (x as f32).next_down() } else { x as f32 };
    (b.min.to_array().map(down), b.max.to_array().map(|x| -down(-x)))
}

fn in_own_space(scene: &Scene, mesh: MeshId) -> Triangles {
    let mesh = &scene.meshes[mesh.index()];
    // A mesh says at `Interaction` how its normals turn; here they are ballast.
    let bare = |deformation: &Deformation| {
        let frames =
            deformation.frames.iter().map(|frame| VertexFrame { positions: frame.positions.clone(), normals: vec![] });
        Arc::new(Deformation { frames: frames.collect(), ..*deformation })
    };
    let deformation = mesh.deformation.as_deref().map(bare);
    Triangles { positions: mesh.positions.clone(), triangles: mesh.triangles.clone(), deformation }
}

fn baked(scene: &Scene, mesh: MeshId, to_world: &Transform) -> Triangles {
    let mut triangles = in_own_space(scene, mesh);
    if !to_world.is_identity() {
        let place = |positions: &mut Vec<[f32; 3]>| {
            for p in positions {
                *p = to_world.point(Point3::from_f32(*p)).to_array().map(|x| x as f32);
            }
        };
        place(&mut triangles.positions);
        if let Some(deformation) = &mut triangles.deformation {
            Arc::make_mut(deformation).frames.iter_mut().for_each(|frame| place(&mut frame.positions));
        }
    }
    triangles
}
