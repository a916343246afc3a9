//! The time column: how a ray changes while surfaces move · metres and radians per unit of time · world frame ·
//! PHOTON_DIFFERENTIALS 7, after `[Igehy99]`.
//!
//! The same path taken a moment later meets each surface where that has moved to. On the surface F(x, t) = 0 with normal n,
//! ∂F/∂t = −n·v where the surface's own point there has the velocity v, so that with q = ∂x/∂t + s ∂ω/∂t
//!
//!   dx/dt = q − ((q − v)·n / (ω·n)) ω,   that is   dx/dt − v = (q − v) − ((q − v)·n / (ω·n)) ω:
//!
//! seen from the surface, the ray's q − v is transferred as any other column is. The normal that it meets there changes with
//! S (dx/dt − v), and by its own turning. [`arrive`] gives the column as the surface sees it, which is what a receiver is
//! asked for; [`reflect`] and [`refract`] take that and give the column of the ray that leaves, seen from the world.

use super::lanes::{Lanes, Vectors};
use super::reflect::reflect_about;
use super::refract::{Refraction, refract_about};
use super::state::{Differential, ShapeOperator};
use super::transfer::transfer;
use crate::math::{Dir3, Normal3, Vec3};

/// How a surface moves about one of its points: as x ↦ v + L (x − p).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceMotion {
    /// v, of the surface's own point, m per unit of time.
    pub velocity: Vec3,
    /// L, ω× for a rigid body, per unit of time.
    pub gradient: glam::DMat3,
}

impl SurfaceMotion {
    pub const STILL: SurfaceMotion = SurfaceMotion { velocity: Vec3::ZERO, gradient: glam::DMat3::ZERO };

    /// A body that turns by the vector `omega`, radians per unit of time.
    pub fn rigid(velocity: Vec3, omega: Vec3) -> SurfaceMotion {
        let gradient = glam::DMat3::from_cols(omega.cross(Vec3::X), omega.cross(Vec3::Y), omega.cross(Vec3::Z));
        SurfaceMotion { velocity, gradient }
    }
    /// In a unit of time that is `unit` times as long.
    pub fn per(&self, unit: f64) -> SurfaceMotion {
        SurfaceMotion { velocity: self.velocity * unit, gradient: self.gradient * unit }
    }
    /// dN/dt at the same point of the surface: N is carried by M⁻ᵀ and normalised, so −(I − N Nᵀ) Lᵀ N; ω × N for a rigid
    /// body.
    pub fn turning(&self, n: Normal3) -> Vec3 {
        let n = n.to_vec();
        let carried = self.gradient.transpose() * n;
        n * n.dot(carried) - carried
    }
}

/// Moves time columns a distance `s` along `w` onto a moving surface, as [`transfer()`] does others. What comes out is
/// relative to the surface's own point.
pub fn arrive<const N: usize>(
    d: &Differential<N>,
    w: Dir3,
    s: f64,
    ng: Normal3,
    surface: &SurfaceMotion,
) -> Differential<N> {
    let relative = d.dx - each(surface.velocity);
    transfer(&Differential { dx: relative, dw: d.dw }, w, s, ng)
}

/// The time columns of the ray that a moving mirror reflects; see [`super::reflect()`] for the arguments.
pub fn reflect<const N: usize>(
    arrived: &Differential<N>,
    w: Dir3,
    n: Normal3,
    shape: &ShapeOperator,
    surface: &SurfaceMotion,
) -> Differential<N> {
    let dn = shape.apply_each(&arrived.dx) + each(surface.turning(n));
    leaving(reflect_about(arrived, w, n, dn).1, surface)
}

/// The time columns of the ray that a moving interface refracts or totally reflects; see [`super::refract()`] for the
/// arguments.
pub fn refract<const N: usize>(
    arrived: &Differential<N>,
    w: Dir3,
    n: Normal3,
    shape: &ShapeOperator,
    eta: f64,
    surface: &SurfaceMotion,
) -> Differential<N> {
    let dn = shape.apply_each(&arrived.dx) + each(surface.turning(n));
    match refract_about(arrived, w, n, dn, eta) {
        Refraction::Transmitted(_, columns) | Refraction::TotalReflection(_, columns) => leaving(columns, surface),
    }
}

/// The time columns of a ray that leaves the surface into a direction of its own.
pub fn scatter<const N: usize>(arrived: &Differential<N>, surface: &SurfaceMotion) -> Differential<N> {
    leaving(Differential { dx: arrived.dx, dw: Vectors::ZERO }, surface)
}

fn leaving<const N: usize>(columns: Differential<N>, surface: &SurfaceMotion) -> Differential<N> {
    Differential { dx: columns.dx + each(surface.velocity), dw: columns.dw }
}

fn each<const N: usize>(v: Vec3) -> Vectors<N> {
    Vectors::multiples(v, Lanes([1.0; N]))
}
