//! From a raw hit to a point that can be shaded: position, normals, derivatives, BSDF.

pub mod adjoint;
pub mod bsdf;
mod bsdfs;
pub mod event;
pub mod facet_albedo;
pub mod facet_loss;
pub mod fresnel;
pub mod interaction;
pub mod microfacet;
pub mod mipmap;
pub mod normal_map;
pub mod parametrisation;
mod pyramid;
mod rest;
pub mod texture;
mod triangle;

pub use bsdf::Bsdf;
pub use event::{BsdfSample, DeltaBranch, DeltaBranches, Event, Passage, TransportMode};
pub use interaction::Interaction;
pub use parametrisation::Lookup;
pub use rest::ToRest;
pub use texture::Textures;

/// Surfaces for the unit tests of other modules.
#[cfg(test)]
pub(crate) mod test_support {
    use super::{Bsdf, Interaction, Lookup, Textures};
    use crate::differential::ShapeOperator;
    use crate::math::{Normal3, Point3};
    use crate::radiometry::Spectrum;
    use crate::scene::{Material, MaterialId, ObjectId, Textured};

    /// A flat surface, met from above.
    pub fn flat_at(p: Point3, n: Normal3) -> Interaction {
        Interaction {
            p,
            error: 1e-9,
            t: 1.0,
            time: 0.0,
            wo: n.as_dir(),
            ng: n,
            ns: n,
            shape: ShapeOperator::FLAT,
            barycentric: [0.0; 2],
            object: ObjectId(0),
            primitive: 0,
            material: MaterialId(0),
            exact: true,
        }
    }

    /// A flat diffuser of the given albedo.
    pub fn lambert_at(p: Point3, n: Normal3, albedo: f64) -> Bsdf {
        let material = Material::Lambert { albedo: Textured::Constant(Spectrum::splat(albedo)) };
        Bsdf::new(&material, &Textures::new(&[]), &flat_at(p, n), &Lookup::default())
    }
}
