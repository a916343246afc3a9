//! Exact curved shapes in their own object space: where a ray first meets them, their normals and shape operators,
//! their parametrisation by area. Intersected as such, never as facets.
//!
//! Every backend, the surface interaction and the area lights use these same functions. Shape operators by
//! PHOTON_DIFFERENTIALS 1.1; every one of them is tested against differences of its own normal.

mod cylinder;
mod disk;
mod error;
mod height_field;
mod rectangle;
mod roots;
mod sphere;
mod torus;

pub use cylinder::Cylinder;
pub use disk::Disk;
pub use error::ShapeError;
pub use height_field::{HeightField, Wave};
pub use rectangle::Rectangle;
pub use sphere::Sphere;
pub use torus::Torus;

use std::f64::consts::TAU;

use crate::differential::ShapeOperator;
use crate::math::{Bounds3, Normal3, Point3, Ray, Vec2, Vec3};
use crate::radiometry::{Area, Pdf};

/// The surface of a shape about one of its points, in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalSurface {
    /// The point, put back onto the exact surface.
    pub p: Point3,
    /// Outward normal (sphere, cylinder, torus: away from the solid; disk, rectangle: +normal; height field: +z).
    pub n: Normal3,
    /// dN/dx of `n`.
    pub shape: ShapeOperator,
}

/// A shape's own parameters at one of its points, in object space. Only textures ask for them, and angles cost more
/// than the hit itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parametrisation {
    /// In [0, 1]².
    pub uv: Vec2,
    /// ∂p/∂u and ∂p/∂v; ∂p/∂u is zero at a sphere's poles.
    pub dpdu: Vec3,
    pub dpdv: Vec3,
}

/// A point drawn uniformly by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaSample {
    pub p: Point3,
    pub n: Normal3,
    /// ∂p/∂u and ∂p/∂v of the map from the unit square; their cross product is along `n` and as long as the area.
    pub dpdu: Vec3,
    pub dpdv: Vec3,
}

/// One exact shape.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    Sphere(Sphere),
    Cylinder(Cylinder),
    Torus(Torus),
    Disk(Disk),
    Rectangle(Rectangle),
    HeightField(HeightField),
}

impl Shape {
    /// The shape's name in scene files.
    pub fn kind(&self) -> &'static str {
        match self {
            Shape::Sphere(_) => "sphere",
            Shape::Cylinder(_) => "cylinder",
            Shape::Torus(_) => "torus",
            Shape::Disk(_) => "disk",
            Shape::Rectangle(_) => "rectangle",
            Shape::HeightField(_) => "height_field",
        }
    }
    /// t of the first hit in (t_min, t_max), from either side, in units of the direction, which need not be of unit
    /// length. A NaN never comes out; a ray with one misses.
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        match self {
            Shape::Sphere(s) => s.intersect(ray),
            Shape::Cylinder(s) => s.intersect(ray),
            Shape::Torus(s) => s.intersect(ray),
            Shape::Disk(s) => s.intersect(ray),
            Shape::Rectangle(s) => s.intersect(ray),
            Shape::HeightField(s) => s.intersect(ray),
        }
    }
    /// Object-space bounds, not padded.
    pub fn bounds(&self) -> Bounds3 {
        match self {
            Shape::Sphere(s) => s.bounds(),
            Shape::Cylinder(s) => s.bounds(),
            Shape::Torus(s) => s.bounds(),
            Shape::Disk(s) => s.bounds(),
            Shape::Rectangle(s) => s.bounds(),
            Shape::HeightField(s) => s.bounds(),
        }
    }
    /// The surface at a point `p` that was hit at `time` (within rounding of the surface).
    pub fn surface_at(&self, p: Point3, time: f64) -> LocalSurface {
        match self {
            Shape::Sphere(s) => s.surface_at(p),
            Shape::Cylinder(s) => s.surface_at(p),
            Shape::Torus(s) => s.surface_at(p),
            Shape::Disk(s) => s.surface_at(p),
            Shape::Rectangle(s) => s.surface_at(p),
            Shape::HeightField(s) => s.surface_at(p, time),
        }
    }
    /// How the surface moves in its own space about its point `p` at `time`: velocity and gradient. `None`: not at all.
    pub fn velocity_at(&self, p: Point3, time: f64) -> Option<(Vec3, glam::DMat3)> {
        match self {
            Shape::HeightField(s) => s.velocity_at(p, time),
            _ => None,
        }
    }
    /// Whether it changes with time.
    pub fn changes(&self) -> bool {
        matches!(self, Shape::HeightField(field) if field.travels())
    }
    /// The shape's parameters at a point `p` that was hit at `time`.
    pub fn parametrisation_at(&self, p: Point3, time: f64) -> Parametrisation {
        match self {
            Shape::Sphere(s) => s.parametrisation_at(p),
            Shape::Cylinder(s) => s.parametrisation_at(p),
            Shape::Torus(s) => s.parametrisation_at(p),
            Shape::Disk(s) => s.parametrisation_at(p),
            Shape::Rectangle(s) => s.parametrisation_at(p),
            Shape::HeightField(s) => s.parametrisation_at(p, time),
        }
    }
    /// Object-space area in m²; `None` for a shape that cannot be sampled by area (the height field).
    pub fn area(&self) -> Option<f64> {
        match self {
            Shape::Sphere(s) => Some(s.area()),
            Shape::Cylinder(s) => Some(s.area()),
            Shape::Torus(s) => Some(s.area()),
            Shape::Disk(s) => Some(s.area()),
            Shape::Rectangle(s) => Some(s.area()),
            Shape::HeightField(_) => None,
        }
    }
    /// The point at `u` in the unit square of a map that keeps (object-space) area.
    pub fn sample_area(&self, u: [f64; 2]) -> Option<AreaSample> {
        match self {
            Shape::Sphere(s) => Some(s.sample_area(u)),
            Shape::Cylinder(s) => Some(s.sample_area(u)),
            Shape::Torus(s) => Some(s.sample_area(u)),
            Shape::Disk(s) => Some(s.sample_area(u)),
            Shape::Rectangle(s) => Some(s.sample_area(u)),
            Shape::HeightField(_) => None,
        }
    }
    /// Density of [`Shape::sample_area`] in object space: 1/area.
    pub fn pdf_area(&self) -> Option<Pdf<Area>> {
        self.area().map(|area| Pdf::new(1.0 / area))
    }
    /// The `u` that [`Shape::sample_area`] maps to the surface point `p`; `None` for a point beside the shape.
    pub fn inverse_area(&self, p: Point3) -> Option<[f64; 2]> {
        match self {
            Shape::Sphere(s) => s.inverse_area(p),
            Shape::Cylinder(s) => Some(s.inverse_area(p)),
            Shape::Torus(s) => Some(s.inverse_area(p)),
            Shape::Disk(s) => s.inverse_area(p),
            Shape::Rectangle(s) => Some(s.inverse_area(p)),
            Shape::HeightField(_) => None,
        }
    }
}

/// Where a ray crosses a plane inside (t_min, t_max); never for a ray in the plane.
fn plane_hit(ray: &Ray, on_plane: Point3, n: Vec3) -> Option<f64> {
    let t = n.dot(on_plane - ray.origin) / n.dot(ray.direction);
    (t > ray.t_min && t < ray.t_max).then_some(t)
}

/// Half the size of the box around a disc with unit normal `n`.
fn disc_half_extent(n: Vec3, radius: f64) -> Vec3 {
    (Vec3::ONE - n * n).max(Vec3::ZERO).map(f64::sqrt) * radius
}

/// The angle of (x, y) in turns, [0, 1).
fn turn(y: f64, x: f64) -> f64 {
    let turns = y.atan2(x) / TAU;
    let turns = if turns < 0.0 { turns + 1.0 } else { turns };
    // A tiny negative angle rounds to a whole turn.
    if turns < 1.0 { turns } else { 0.0 }
}

/// a bᵀ.
fn outer(a: Vec3, b: Vec3) -> glam::DMat3 {
    glam::DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
