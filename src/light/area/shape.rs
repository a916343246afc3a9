//! The surface of an emissive shape under any affine map · world frame, m².
//!
//! Points are drawn evenly by area in object space. The map M stretches area by |det M| |M⁻ᵀ n|, which is in the
//! Jacobian |∂p/∂u × ∂p/∂v|, so densities are exact for ellipsoids too.

use super::SurfacePoint;
use crate::light::NormalCone;
use crate::math::{Bounds3, Normal3, Point3, Transform, Vec3};
use crate::shape::Shape;

/// Steps of the quadrature of the area in each coordinate, where the stretch is not the same everywhere.
const STEPS: usize = 128;

/// Relative deviation of a map's columns, by rounding, up to which it is a similarity.
const SIMILAR: f64 = 1e-12;

#[derive(Clone, Debug, PartialEq)]
pub(super) struct ShapeSurface {
    shape: Shape,
    to_world: Transform,
    object_area: f64,
    area: f64,
}

impl ShapeSurface {
    /// `None` for a shape that has no map by area.
    pub fn new(shape: &Shape, to_world: &Transform) -> Option<ShapeSurface> {
        let object_area = shape.area()?;
        let mut surface = ShapeSurface { shape: shape.clone(), to_world: *to_world, object_area, area: 0.0 };
        surface.area = match surface.scale() {
            Some(scale) => object_area * scale * scale,
            None => super::mean_over_square(STEPS, |u| surface.sample(u).map_or(0.0, |s| s.inverse_pdf())),
        };
        (surface.area > 0.0 && surface.area.is_finite()).then_some(surface)
    }

    pub fn area(&self) -> f64 {
        self.area
    }

    /// Density by area at a surface point with the world normal `n`. With n = M⁻ᵀ n₀/|M⁻ᵀ n₀| and n₀ unit,
    /// |M⁻ᵀ n₀| = 1/|Mᵀ n|.
    pub fn pdf_at(&self, n: Normal3) -> f64 {
        let [x, y, z] = self.to_world.columns();
        let transposed = Vec3::new(x.dot(n.to_vec()), y.dot(n.to_vec()), z.dot(n.to_vec()));
        transposed.length() / (x.cross(y).dot(z).abs() * self.object_area)
    }

    /// Around it; the normals of what is flat.
    pub fn bounds(&self) -> (Bounds3, NormalCone) {
        let flat = matches!(self.shape, Shape::Disk(_) | Shape::Rectangle(_));
        let normal = self.sample([0.5; 2]).filter(|_| flat).map(|at| NormalCone::of(at.n));
        (self.shape.bounds().transformed(&self.to_world), normal.unwrap_or(NormalCone::SPHERE))
    }

    pub fn sample(&self, u: [f64; 2]) -> Option<SurfacePoint> {
        let local = self.shape.sample_area(u)?;
        let turning = self.shape.surface_at(local.p, 0.0).shape;
        let scaled = self.to_world.normal_unnormalised(local.n.to_vec());
        let length = scaled.length();
        let n = Normal3::new(scaled)?;
        // The derivative of a normalised vector: the part across it, over its length.
        let turned = |d: Vec3| {
            let change = self.to_world.normal_unnormalised(turning.apply(d)) / length;
            change - n * n.dot(change)
        };
        Some(SurfacePoint {
            p: self.to_world.point(local.p),
            n,
            dpdu: self.to_world.vector(local.dpdu),
            dpdv: self.to_world.vector(local.dpdv),
            dndu: turned(local.dpdu),
            dndv: turned(local.dpdv),
        })
    }

    pub fn inverse(&self, p: Point3) -> Option<[f64; 2]> {
        self.shape.inverse_area(self.to_world.inverse_point(p))
    }

    /// The factor of all lengths, if the map has one.
    fn scale(&self) -> Option<f64> {
        let [x, y, z] = self.to_world.columns();
        let scale2 = x.length_squared();
        let same = |v: Vec3| (v.length_squared() - scale2).abs() <= SIMILAR * scale2;
        let right = |a: Vec3, b: Vec3| a.dot(b).abs() <= SIMILAR * scale2;
        (same(y) && same(z) && right(x, y) && right(y, z) && right(z, x)).then(|| scale2.sqrt())
    }

    /// Centre and radius in the world if this is a sphere and stays one.
    pub fn sphere(&self) -> Option<(Point3, f64)> {
        let Shape::Sphere(sphere) = &self.shape else { return None };
        Some((self.to_world.point(sphere.centre()), sphere.radius() * self.scale()?))
    }
}
