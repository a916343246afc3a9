//! Shading normals from images · tangent space: x along ∂p/∂u, y along ∂p/∂v, z the shading normal without the image; a
//! component c of the image stands for 2c − 1.
//!
//! The image is not filtered, so that the eye and photons see the same surface. How a bent normal turns from place to place
//! is left out of the shape operator: footprints of photons over such a surface are those of the surface without the image.
//!
//! A normal that faces away from where the ray came from is not taken, as if a facet in front hid it: black patches would show
//! instead. There alone, at grazing, the two ends of a path do not see the same normal.

use super::interaction::Interaction;
use crate::math::{Normal3, Vec3};
use crate::radiometry::Spectrum;
use crate::shape::Parametrisation;

/// Of a bent normal against the geometric one at least; steeper ones would show the surface its own back.
const LEAST_COSINE: f64 = 0.01;

/// The shading normal at `si` as the image's `colour` there bends it, its slopes multiplied by `scale`; the one that it has
/// where the image or the tangents say nothing.
pub fn bent(si: &Interaction, at: &Parametrisation, colour: Spectrum, scale: f64) -> Normal3 {
    let [x, y, z] = colour.to_array().map(|c| 2.0 * c - 1.0);
    let ns = si.ns.to_vec();
    let across = |v: Vec3| v - ns * ns.dot(v);
    let tangent = across(at.dpdu).normalize_or_zero();
    let mut bitangent = ns.cross(tangent);
    if bitangent.dot(at.dpdv) < 0.0 {
        bitangent = -bitangent;
    }
    let bent = Normal3::new(tangent * (scale * x) + bitangent * (scale * y) + ns * z);
    let faces_the_ray = |n: &Normal3| n.dot(si.wo) * si.ng.dot(si.wo) > 0.0;
    bent.filter(|n| n.dot(si.ng) > LEAST_COSINE && faces_the_ray(n) && tangent != Vec3::ZERO).unwrap_or(si.ns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Point3, Vec2};
    use crate::surface::test_support::flat_at;

    fn colour(n: [f64; 3]) -> Spectrum {
        Spectrum::from(n.map(|c| 0.5 * (c + 1.0)))
    }

    /// The image's axes follow the texture coordinates, mirrored ones too; the scale changes slopes.
    #[test]
    fn normals_bend_along_the_texture_coordinates() {
        let si = flat_at(Point3::ORIGIN, Normal3::Z);
        let image = colour([0.6, 0.0, 0.8]);
        for (dpdu, dpdv, expected) in [
            (Vec3::X * 3.0, Vec3::Y, [0.6, 0.0, 0.8]),
            (-Vec3::X, Vec3::Y, [-0.6, 0.0, 0.8]),
            (-Vec3::Y, Vec3::X * 0.1, [0.0, -0.6, 0.8]),
            (Vec3::X + Vec3::Z, Vec3::Y, [0.6, 0.0, 0.8]),
        ] {
            let at = Parametrisation { uv: Vec2::ZERO, dpdu, dpdv };
            let n = bent(&si, &at, image, 1.0).to_vec();
            assert!((n - Vec3::from_array(expected)).length() < 1e-12, "{n:?}");
        }
        let at = |dpdv| Parametrisation { uv: Vec2::ZERO, dpdu: Vec3::X, dpdv };
        let up = colour([0.0, 0.6, 0.8]);
        assert!((bent(&si, &at(Vec3::Y), up, 1.0).to_vec() - Vec3::new(0.0, 0.6, 0.8)).length() < 1e-12);
        assert!((bent(&si, &at(-Vec3::Y), up, 1.0).to_vec() - Vec3::new(0.0, -0.6, 0.8)).length() < 1e-12);
        let flatter = bent(&si, &at(Vec3::Y), up, 0.5).to_vec();
        assert!((flatter.y / flatter.z - 0.5 * 0.6 / 0.8).abs() < 1e-12, "{flatter:?}");
        assert_eq!(bent(&si, &at(Vec3::Y), colour([0.0, 1.0, -0.5]), 1.0), si.ns, "behind the surface");
        assert_eq!(bent(&si, &at(Vec3::Y), colour([0.0; 3]), 1.0), si.ns, "no normal at all");
        let wo = crate::math::Dir3::new(Vec3::new(-0.9, 0.0, 0.3)).expect("non-zero");
        assert_eq!(bent(&Interaction { wo, ..si }, &at(Vec3::Y), image, 1.0), si.ns, "it faces away");
    }
}
