//! Derivative columns of a ray · metres and radians per unit of the parameter · world frame · [Igehy99 (1)–(4)].

use super::lanes::{Lanes, Vectors};
use crate::math::Vec3;

/// dN/dx of the shading normal that an event uses, as the columns of a 3×3 matrix, 1/m. Only tangent vectors may be
/// applied; what it does to the normal itself is unspecified (usually zero).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeOperator(glam::DMat3);

impl ShapeOperator {
    pub const FLAT: ShapeOperator = ShapeOperator(glam::DMat3::ZERO);

    pub const fn from_matrix(m: glam::DMat3) -> Self {
        ShapeOperator(m)
    }
    pub fn matrix(&self) -> glam::DMat3 {
        self.0
    }
    /// The change of the normal for a step `dx` on the surface.
    pub fn apply(&self, dx: Vec3) -> Vec3 {
        self.0 * dx
    }
    /// The same for every column.
    pub fn apply_each<const N: usize>(&self, dx: &Vectors<N>) -> Vectors<N> {
        dx.transformed(&self.0)
    }
    /// The operator of the opposite normal.
    pub fn flipped(&self) -> ShapeOperator {
        ShapeOperator(-self.0)
    }
}

/// One parameter's derivatives of a ray (x, ω).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// ∂x/∂k.
    pub dx: Vec3,
    /// ∂ω/∂k, perpendicular to ω.
    pub dw: Vec3,
}

impl Column {
    pub const ZERO: Column = Column { dx: Vec3::ZERO, dw: Vec3::ZERO };

    pub fn position(dx: Vec3) -> Column {
        Column { dx, dw: Vec3::ZERO }
    }
    pub fn direction(dw: Vec3) -> Column {
        Column { dx: Vec3::ZERO, dw }
    }
}

/// The columns of a ray: N = 4 for photons (u, v, θ, φ: where and whither it was emitted), N = 2 for camera rays
/// (raster x, y). Kept component by component: an event does the same to every column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differential<const N: usize> {
    /// ∂x/∂k.
    pub dx: Vectors<N>,
    /// ∂ω/∂k, perpendicular to ω.
    pub dw: Vectors<N>,
}

impl<const N: usize> Differential<N> {
    pub const ZERO: Differential<N> = Differential { dx: Vectors::ZERO, dw: Vectors::ZERO };

    pub fn new(columns: [Column; N]) -> Differential<N> {
        Differential { dx: Vectors::new(columns.map(|c| c.dx)), dw: Vectors::new(columns.map(|c| c.dw)) }
    }
    pub fn column(&self, k: usize) -> Column {
        Column { dx: self.dx.get(k), dw: self.dw.get(k) }
    }
    pub fn columns(&self) -> [Column; N] {
        std::array::from_fn(|k| self.column(k))
    }
    /// The first M ≤ N of them.
    pub fn first<const M: usize>(&self) -> Differential<M> {
        Differential { dx: self.dx.first(), dw: self.dw.first() }
    }
    /// Every column times `s`: a change of the cell's size.
    pub fn scaled(&self, s: f64) -> Differential<N> {
        Differential { dx: self.dx * s, dw: self.dw * s }
    }
    /// Each column times its own number: a change of one side of the cell.
    pub fn scaled_each(&self, s: [f64; N]) -> Differential<N> {
        Differential { dx: self.dx.scaled_each(Lanes(s)), dw: self.dw.scaled_each(Lanes(s)) }
    }
    /// Every vector through a linear map.
    pub fn mapped(&self, map: impl Fn(Vec3) -> Vec3) -> Differential<N> {
        Differential::new(self.columns().map(|c| Column { dx: map(c.dx), dw: map(c.dw) }))
    }
    pub fn is_finite(&self) -> bool {
        self.dx.is_finite() && self.dw.is_finite()
    }
}
