//! From a raw hit to a point that can be shaded: position, normals, derivatives, BSDF.

pub mod adjoint;
pub mod bsdf;
mod bsdfs;
pub mod event;
pub mod footprint_uv;
pub mod fresnel;
pub mod interaction;
pub mod microfacet;
pub mod mipmap;
mod pyramid;
pub mod texture;
mod triangle;

pub use bsdf::Bsdf;
pub use event::{BsdfSample, DeltaBranch, DeltaBranches, Event, TransportMode};
pub use interaction::Interaction;
pub use texture::Textures;

/// Surfaces for the unit tests of other modules.
#[cfg(test)]
pub(crate) mod test_support {
    use super::{Bsdf, Interaction, Textures};
    use crate::differential::ShapeOperator;
    use crate::math::{Frame, Normal3, Point3, Vec2};
    use crate::radiometry::Spectrum;
    use crate::scene::{Material, MaterialId, ObjectId, Textured};

    /// A flat diffuser of the given albedo.
    pub fn lambert_at(p: Point3, n: Normal3, albedo: f64) -> Bsdf {
        let frame = Frame::from_unit(n);
        let si = Interaction {
            p,
            error: 1e-9,
            t: 1.0,
            wo: n.as_dir(),
            ng: n,
            ns: n,
            uv: Vec2::ZERO,
            dpdu: frame.t,
            dpdv: frame.b,
            shape: ShapeOperator::FLAT,
            object: ObjectId(0),
            primitive: 0,
            material: MaterialId(0),
            exact: true,
        };
        let material = Material::Lambert { albedo: Textured::Constant(Spectrum::splat(albedo)) };
        Bsdf::new(&material, &Textures::new(&[]), &si, [Vec2::ZERO; 2])
    }
}
