//! Shading normals from images · tangent space: x along ∂p/∂u, y along ∂p/∂v, z the shading normal without the image; a
//! component c of the image stands for 2c − 1.
//!
//! The image is not filtered, so that the eye and photons see the same surface. How the bent normal turns from place to place
//! is the shape operator there, that of the surface and the image's slope together, so that what such a surface focuses has
//! the footprints of what it looks like. Coordinate lines are taken to be straight: exact on triangles; how those of a sphere
//! turn about its normal is left out.
//!
//! A normal that faces away from where the ray came from is not taken, as if a facet in front hid it: black patches would show
//! instead. There alone, at grazing, the two ends of a path do not see the same normal.

use super::interaction::Interaction;
use crate::differential::ShapeOperator;
use crate::math::{Normal3, Vec3};
use crate::radiometry::Spectrum;
use crate::shape::Parametrisation;

/// Of a bent normal against the geometric one at least; steeper ones would show the surface its own back.
const LEAST_COSINE: f64 = 0.01;

/// What an image says at a point: its colour, and ∂/∂u and ∂/∂v of that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Image {
    pub colour: Spectrum,
    pub du: Spectrum,
    pub dv: Spectrum,
}

/// Tangents and bent normal, none of unit length but the first two and ns.
struct Bend {
    tangent: Vec3,
    bitangent: Vec3,
    ns: Vec3,
    /// Of the bent normal along these three.
    slopes: Vec3,
    /// Whether the texture coordinates are mirrored, −1, or not.
    hand: f64,
    /// Length and component along ns of ∂p/∂u, the former of what is across ns.
    along_u: [f64; 2],
}

/// The shading normal at `si` as the image there bends it, its slopes multiplied by `scale`, and its derivative; those that
/// it has where the image or the tangents say nothing.
pub fn bent(si: &Interaction, at: &Parametrisation, image: &Image, scale: f64) -> (Normal3, ShapeOperator) {
    let unbent = (si.ns, si.shape);
    let Some(bend) = Bend::new(si.ns.to_vec(), at, slopes(image.colour, scale)) else { return unbent };
    let faces_the_ray = |n: &Normal3| n.dot(si.wo) * si.ng.dot(si.wo) > 0.0;
    let normal = Normal3::new(bend.normal()).filter(|n| n.dot(si.ng) > LEAST_COSINE && faces_the_ray(n));
    normal.map_or(unbent, |n| (n, bend.operator(si, at, image, scale).unwrap_or(si.shape)))
}

fn slopes(colour: Spectrum, scale: f64) -> Vec3 {
    let [x, y, z] = colour.to_array().map(|c| 2.0 * c - 1.0);
    Vec3::new(scale * x, scale * y, z)
}

impl Bend {
    fn new(ns: Vec3, at: &Parametrisation, slopes: Vec3) -> Option<Bend> {
        let up = ns.dot(at.dpdu);
        let across = at.dpdu - ns * up;
        let tangent = across.try_normalize()?;
        let bitangent = ns.cross(tangent);
        let hand = if bitangent.dot(at.dpdv) < 0.0 { -1.0 } else { 1.0 };
        Some(Bend { tangent, bitangent: bitangent * hand, ns, slopes, hand, along_u: [across.length(), up] })
    }

    fn normal(&self) -> Vec3 {
        self.tangent * self.slopes.x + self.bitangent * self.slopes.y + self.ns * self.slopes.z
    }

    /// dN/dx of the normalised normal, column by column.
    fn operator(&self, si: &Interaction, at: &Parametrisation, image: &Image, scale: f64) -> Option<ShapeOperator> {
        let n = self.normal();
        let (length, unit) = (n.length(), n.normalize());
        let [u, v] = gradients(at);
        let [du, dv] = [image.du, image.dv].map(|d| 2.0 * Vec3::new(scale * d.r(), scale * d.g(), d.b()));
        let column = |dx: Vec3| {
            let turned = self.turned(si.shape.apply(dx));
            let slope = du * u.dot(dx) + dv * v.dot(dx);
            let along = self.tangent * slope.x + self.bitangent * slope.y + self.ns * slope.z;
            let change = turned + along;
            (change - unit * unit.dot(change)) / length
        };
        let operator = glam::DMat3::from_cols(column(Vec3::X), column(Vec3::Y), column(Vec3::Z));
        operator.is_finite().then(|| ShapeOperator::from_matrix(operator))
    }

    /// How the bent normal changes with the normal under it, its slopes staying what they are: the tangent is what of ∂p/∂u
    /// is across ns, so it turns with it, and about it where ∂p/∂u is not across.
    fn turned(&self, dns: Vec3) -> Vec3 {
        let [across, up] = self.along_u;
        let moved = -(dns * up + self.ns * (dns.dot(self.tangent) * across)) / across
            - self.ns * (dns.dot(self.ns) * up / across);
        let dt = moved - self.tangent * self.tangent.dot(moved);
        let db = (dns.cross(self.tangent) + self.ns.cross(dt)) * self.hand;
        dt * self.slopes.x + db * self.slopes.y + dns * self.slopes.z
    }
}

/// ∂u/∂x and ∂v/∂x on the surface: the dual basis of the tangents.
fn gradients(at: &Parametrisation) -> [Vec3; 2] {
    let (e, f, g) = (at.dpdu.length_squared(), at.dpdu.dot(at.dpdv), at.dpdv.length_squared());
    let determinant = e * g - f * f;
    [(at.dpdu * g - at.dpdv * f) / determinant, (at.dpdv * e - at.dpdu * f) / determinant]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Point3, Vec2};
    use crate::surface::test_support::flat_at;

    fn colour(n: [f64; 3]) -> Image {
        Image { colour: Spectrum::from(n.map(|c| 0.5 * (c + 1.0))), du: Spectrum::BLACK, dv: Spectrum::BLACK }
    }
    fn bent(si: &Interaction, at: &Parametrisation, image: Image, scale: f64) -> Normal3 {
        super::bent(si, at, &image, scale).0
    }

    /// A triangle between whose corners the normal turns, met at (x, y): with an image of waves on skew coordinates, mirrored
    /// ones too, the operator is the central difference of the normal.
    #[test]
    fn the_operator_is_the_derivative_of_the_bent_normal() {
        for (dpdu, dpdv) in [
            (Vec3::new(0.7, 0.2, 0.0), Vec3::new(-0.3, 0.5, 0.0)),
            (Vec3::new(0.1, 0.9, 0.0), Vec3::new(0.4, 0.2, 0.0)),
        ] {
            let normal_at = |x: f64, y: f64| -> (Normal3, ShapeOperator) {
                // ns = m/|m|, m = (a x + b y + c, …, 1).
                let m = Vec3::new(0.3 * x - 0.2 * y + 0.1, 0.1 * x + 0.4 * y - 0.2, 1.0);
                let ns = m.normalize();
                let across = |d: Vec3| (d - ns * ns.dot(d)) / m.length();
                let [dx, dy] = [Vec3::new(0.3, 0.1, 0.0), Vec3::new(-0.2, 0.4, 0.0)].map(across);
                let shape = ShapeOperator::from_matrix(glam::DMat3::from_cols(dx, dy, Vec3::ZERO));
                let si = Interaction {
                    ns: Normal3::new(ns).expect("not zero"),
                    shape,
                    ..flat_at(Point3::ORIGIN, Normal3::Z)
                };
                let [u, v] = gradients(&Parametrisation { uv: Vec2::ZERO, dpdu, dpdv }).map(|g| g.x * x + g.y * y);
                let at = Parametrisation { uv: Vec2::new(u, v), dpdu, dpdv };
                let image = Image {
                    colour: Spectrum::rgb(
                        0.5 + 0.2 * (2.0 * u + v).sin(),
                        0.5 + 0.1 * (u - 3.0 * v).cos(),
                        0.9 + 0.05 * u.sin(),
                    ),
                    du: Spectrum::rgb(0.4 * (2.0 * u + v).cos(), -0.1 * (u - 3.0 * v).sin(), 0.05 * u.cos()),
                    dv: Spectrum::rgb(0.2 * (2.0 * u + v).cos(), 0.3 * (u - 3.0 * v).sin(), 0.0),
                };
                super::bent(&si, &at, &image, 0.8)
            };
            for [x, y] in [[0.0, 0.0], [0.4, -0.3], [-0.6, 0.5]] {
                let h = 1e-5;
                for (step, axis) in [([h, 0.0], Vec3::X), ([0.0, h], Vec3::Y)] {
                    let [ahead, behind] = [1.0, -1.0].map(|s| normal_at(x + s * step[0], y + s * step[1]).0.to_vec());
                    let difference = (ahead - behind) / (2.0 * h);
                    let found = normal_at(x, y).1.apply(axis);
                    assert!(difference.length() > 0.1, "the normal turns: {difference}");
                    assert!((found - difference).length() < 1e-8, "at {x} {y}: {found}, not {difference}");
                }
            }
        }
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
