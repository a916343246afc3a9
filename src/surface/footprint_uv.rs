//! From a ray's footprint on a surface to its footprint in the texture · PHOTON_DIFFERENTIALS 1.5, `[Igehy99]`.

use super::interaction::Interaction;
use crate::differential::Differential;
use crate::math::Vec2;

impl Interaction {
    /// ∂(u, v)/∂k of both columns of a camera ray that was transferred to this point: the least-squares solution of
    /// [∂p/∂u ∂p/∂v] (du, dv) = ∂p/∂k. Columns that are not finite give zero, the unfiltered texture.
    pub fn uv_derivatives(&self, columns: &Differential<2>) -> [Vec2; 2] {
        // The normal equations with the tangents' Gram matrix, which is regular: the tangents are never parallel.
        let (e, f, g) = (self.dpdu.length_squared(), self.dpdu.dot(self.dpdv), self.dpdv.length_squared());
        let determinant = e * g - f * f;
        columns.columns.each_ref().map(|column| {
            let (along_u, along_v) = (self.dpdu.dot(column.dx), self.dpdv.dot(column.dx));
            let uv = Vec2::new(g * along_u - f * along_v, e * along_v - f * along_u) / determinant;
            if uv.is_finite() { uv } else { Vec2::ZERO }
        })
    }
}
