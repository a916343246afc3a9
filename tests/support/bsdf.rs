//! Points with materials on them, and directions about them.

use pdembree::differential::ShapeOperator;
use pdembree::math::{Dir3, Normal3, Point3, Vec3};
use pdembree::radiometry::Spectrum;
use pdembree::scene::material::{Coat, Specular};
use pdembree::scene::{Material, MaterialId, ObjectId, Textured};
use pdembree::surface::{Bsdf, Interaction, Lookup, Textures};

/// A point at the origin with these normals.
pub fn point(ng: Normal3, ns: Normal3) -> Interaction {
    Interaction {
        p: Point3::ORIGIN,
        error: 0.0,
        t: 1.0,
        time: 0.0,
        wo: ng.as_dir(),
        ng,
        ns,
        shape: ShapeOperator::FLAT,
        barycentric: [0.0; 2],
        object: ObjectId(0),
        primitive: 0,
        material: MaterialId(0),
        exact: true,
    }
}

/// The BSDF of an untextured material with both normals along z.
pub fn flat(material: &Material) -> Bsdf {
    bent(material, Normal3::Z, Normal3::Z)
}

/// The BSDF of an untextured material.
pub fn bent(material: &Material, ng: Normal3, ns: Normal3) -> Bsdf {
    Bsdf::new(material, &Textures::new(&[]), &point(ng, ns), &Lookup::default())
}

/// A direction by its cosine against z and its azimuth.
pub fn direction(cos: f64, phi: f64) -> Dir3 {
    let sin = (1.0 - cos * cos).sqrt();
    Dir3::new(Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)).expect("unit")
}

pub fn lambert(albedo: [f64; 3]) -> Material {
    Material::Lambert { albedo: Textured::Constant(Spectrum::from(albedo)) }
}
pub fn mirror(reflectance: f64) -> Material {
    Material::Mirror { reflectance: Textured::Constant(Spectrum::splat(reflectance)) }
}
pub fn glass(ior: f64) -> Material {
    Material::Dielectric { ior, exterior: 1.0, fresnel: true }
}
pub fn gold() -> Material {
    Material::Conductor { eta: GOLD[0].into(), k: GOLD[1].into() }
}
pub fn rough_glass(ior: f64, alpha: f64) -> Material {
    Material::RoughDielectric { ior, exterior: 1.0, alpha: Textured::Constant(alpha) }
}
pub fn rough_gold(alpha: f64) -> Material {
    Material::RoughConductor { eta: GOLD[0].into(), k: GOLD[1].into(), alpha: Textured::Constant(alpha) }
}
pub fn plastic(albedo: [f64; 3], ior: f64) -> Material {
    Material::Plastic { albedo: Textured::Constant(Spectrum::from(albedo)), ior }
}

/// A principled material of which there is only a part.
pub fn holed(material: Material, part: f64) -> Material {
    let Material::Principled { base_colour, metalness, transmission, alpha, ior, thin, .. } = material else {
        panic!("{material:?}")
    };
    let coverage = Textured::Constant(part);
    Material::Principled {
        base_colour,
        metalness,
        transmission,
        coverage,
        alpha,
        ior,
        thin,
        normal: None,
        specular: None,
        coat: None,
    }
}

/// A principled material of one colour: metalness, transmission, GGX width, index, whether glass is thin.
pub fn principled(colour: [f64; 3], [metalness, transmission, alpha, ior]: [f64; 4], thin: bool) -> Material {
    let [metalness, transmission, alpha] = [metalness, transmission, alpha].map(Textured::Constant);
    let base_colour = Textured::Constant(Spectrum::from(colour));
    let coverage = Textured::Constant(1.0);
    Material::Principled {
        base_colour,
        metalness,
        transmission,
        coverage,
        alpha,
        ior,
        thin,
        normal: None,
        specular: None,
        coat: None,
    }
}

/// A principled material under a coat: the part of it that is there, GGX width, index.
pub fn coated(mut material: Material, [part, alpha, ior]: [f64; 3]) -> Material {
    let Material::Principled { coat, .. } = &mut material else { panic!("{material:?}") };
    *coat = Some(Coat { weight: Textured::Constant(part), alpha: Textured::Constant(alpha), ior });
    material
}

/// A principled material whose reflectance over the diffuse base is multiplied.
pub fn with_specular(mut material: Material, part: f64, tint: [f64; 3]) -> Material {
    let Material::Principled { specular, .. } = &mut material else { panic!("{material:?}") };
    *specular = Some(Specular { weight: Textured::Constant(part), colour: Textured::Constant(Spectrum::from(tint)) });
    material
}

/// A coat over each kind of lobe, smooth and rough ones of both; and a reflectance that is multiplied.
pub fn layered_mixtures() -> Vec<Material> {
    let colour = [0.9, 0.5, 0.2];
    let of = |numbers, thin| principled(colour, numbers, thin);
    vec![
        coated(of([0.0, 0.0, 0.3, 1.5], false), [0.8, 0.1, 1.5]),
        coated(of([1.0, 0.0, 0.3, 1.5], false), [1.0, 0.0, 1.5]),
        coated(of([1.0, 0.0, 0.0, 1.5], false), [1.0, 0.2, 2.0]),
        coated(of([0.1, 0.7, 0.2, 1.5], false), [1.0, 0.4, 1.5]),
        coated(holed(of([0.2, 0.6, 0.2, 1.5], true), 0.6), [0.7, 0.1, 1.5]),
        with_specular(of([0.1, 0.0, 0.3, 1.5], false), 0.7, [3.0, 1.0, 0.2]),
    ]
}

/// Every kind of lobe and mixture with facets of the width `alpha`.
pub fn principled_mixtures(alpha: f64) -> Vec<Material> {
    let colour = [0.9, 0.5, 0.2];
    let of = |metalness: f64, transmission: f64, thin| principled(colour, [metalness, transmission, alpha, 1.5], thin);
    vec![
        of(0.0, 0.0, false),
        of(1.0, 0.0, false),
        of(0.0, 1.0, false),
        of(0.0, 1.0, true),
        of(0.5, 0.0, false),
        of(0.3, 0.4, false),
        of(0.2, 0.6, true),
        holed(of(0.2, 0.0, false), 0.7),
        holed(of(1.0, 0.0, false), 0.4),
        holed(of(0.2, 0.6, true), 0.4),
    ]
}

/// Numbers of the size of gold's index; what they are exactly does not matter to the tests.
const GOLD: [[f64; 3]; 2] = [[0.14, 0.37, 1.44], [3.98, 2.39, 1.60]];
