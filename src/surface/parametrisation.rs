//! Where a point lies in its texture, and a ray's footprint there · PHOTON_DIFFERENTIALS 1.5, `[Igehy99]`.

use super::interaction::Interaction;
use super::triangle;
use crate::differential::Differential;
use crate::math::{Frame, Normal3, Vec2, Vec3};
use crate::radiometry::Spectrum;
use crate::scene::{ObjectGeometry, Scene};
use crate::shape::Parametrisation;

impl Interaction {
    /// Texture coordinates and tangents, in world space. The tangents are never parallel: unit ones where the
    /// parametrisation has none (poles, meshes whose texture coordinates are constant).
    pub fn parametrisation(&self, scene: &Scene) -> Parametrisation {
        let object = &scene.objects[self.object.index()];
        let to_world = object.to_world(self.time);
        let local = match &object.geometry {
            ObjectGeometry::Mesh { mesh, .. } => {
                triangle::parametrisation(&scene.meshes[mesh.index()], self.primitive, self.barycentric, self.time)
            }
            ObjectGeometry::Shape { shape, .. } => shape.parametrisation_at(to_world.inverse_point(self.p), self.time),
        };
        let (dpdu, dpdv) = spanning(to_world.vector(local.dpdu), to_world.vector(local.dpdv), self.ng);
        Parametrisation { uv: local.uv, dpdu, dpdv }
    }
}

impl Interaction {
    /// The colour of the mesh's vertices here, if they have one.
    pub fn vertex_colour(&self, scene: &Scene) -> Option<Spectrum> {
        match &scene.objects[self.object.index()].geometry {
            ObjectGeometry::Mesh { mesh, .. } => {
                triangle::colour(&scene.meshes[mesh.index()], self.primitive, self.barycentric)
            }
            ObjectGeometry::Shape { .. } => None,
        }
    }
}

/// The given tangents, or two unit ones if they span no plane (the sine of their angle is below 1e-6: its square
/// still stands well above the rounding of their Gram matrix).
fn spanning(dpdu: Vec3, dpdv: Vec3, ng: Normal3) -> (Vec3, Vec3) {
    let cross = dpdu.cross(dpdv).length();
    // Written so that a NaN is replaced too.
    if cross > 1e-6 * dpdu.length() * dpdv.length() && cross.is_finite() {
        (dpdu, dpdv)
    } else {
        let frame = Frame::from_unit(ng);
        (frame.t, frame.b)
    }
}

/// What a texture is asked for: a point, and the parallelogram to filter over.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Lookup {
    pub uv: Vec2,
    /// ∂(u, v)/∂x and ∂(u, v)/∂y of the pixel; zero for a lookup at a point.
    pub footprint: [Vec2; 2],
    /// What the base colour is multiplied by.
    pub tint: Option<Spectrum>,
}

impl Lookup {
    /// At a point.
    pub fn point(at: &Parametrisation) -> Lookup {
        Lookup { uv: at.uv, footprint: [Vec2::ZERO; 2], tint: None }
    }

    /// Over the footprint of a camera ray that was transferred to the surface: ∂(u, v)/∂k of each column is the
    /// least-squares solution of [∂p/∂u ∂p/∂v] (du, dv) = ∂p/∂k. Columns that are not finite give zero, the unfiltered
    /// texture.
    pub fn filtered(at: &Parametrisation, columns: &Differential<2>) -> Lookup {
        // The normal equations with the tangents' Gram matrix, which is regular: the tangents are never parallel.
        let (e, f, g) = (at.dpdu.length_squared(), at.dpdu.dot(at.dpdv), at.dpdv.length_squared());
        let determinant = e * g - f * f;
        let footprint = columns.dx.to_array().map(|dx| {
            let (along_u, along_v) = (at.dpdu.dot(dx), at.dpdv.dot(dx));
            let uv = Vec2::new(g * along_u - f * along_v, e * along_v - f * along_u) / determinant;
            if uv.is_finite() { uv } else { Vec2::ZERO }
        });
        Lookup { uv: at.uv, footprint, tint: None }
    }
}
