//! From derivative columns to the ellipse that a photon covers · m² · frame of the receiving surface.
//!
//! The kernel's support is { d : dᵀ Q⁻¹ d ≤ 1 }, its area π √det Q.

use crate::differential::{Differential, ShapeOperator};
use crate::math::{Frame, Vec2, Vec3};
use crate::scene::settings::FootprintRule;

/// Semi-axes at most, in radii of curvature: a surface rises by half the square of it over its tangent plane, which is as
/// high as a photon's light reaches ([`super::Photon::thickness`]).
const MAX_BEND: f64 = 0.2;

/// A symmetric positive semi-definite form on a tangent plane, in the axes (t, b) of a [`Frame`].
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct TangentForm {
    pub xx: f64,
    pub xy: f64,
    pub yy: f64,
}

impl TangentForm {
    /// Σ aᵢ aᵢᵀ over tangent vectors.
    pub fn from_axes(frame: &Frame, axes: impl IntoIterator<Item = Vec3>) -> TangentForm {
        axes.into_iter().fold(TangentForm::default(), |form, axis| {
            let a = frame.project(axis);
            TangentForm { xx: form.xx + a.x * a.x, xy: form.xy + a.x * a.y, yy: form.yy + a.y * a.y }
        })
    }
    pub fn scaled(self, s: f64) -> TangentForm {
        TangentForm { xx: self.xx * s, xy: self.xy * s, yy: self.yy * s }
    }
    pub fn plus(self, other: TangentForm) -> TangentForm {
        TangentForm { xx: self.xx + other.xx, xy: self.xy + other.xy, yy: self.yy + other.yy }
    }
    pub fn determinant(&self) -> f64 {
        self.xx * self.yy - self.xy * self.xy
    }
    pub fn trace(&self) -> f64 {
        self.xx + self.yy
    }
    /// eᵀ Q e for a unit tangent vector e: the square of how far the ellipse reaches along it.
    pub fn along(&self, e: Vec2) -> f64 {
        self.xx * e.x * e.x + 2.0 * self.xy * e.x * e.y + self.yy * e.y * e.y
    }
    /// cᵀ Q d.
    pub fn between(&self, c: Vec2, d: Vec2) -> f64 {
        self.xx * c.x * d.x + self.xy * (c.x * d.y + c.y * d.x) + self.yy * c.y * d.y
    }
    /// The ellipse with no semi-axis longer than this.
    pub fn at_most(self, semi_axis: f64) -> TangentForm {
        let limit = semi_axis * semi_axis;
        if self.trace() <= limit {
            return self;
        }
        let ([minor, major], along) = self.principal();
        let (a, b) = (major.min(limit), minor.min(limit));
        let (x, y) = (along.x, along.y);
        TangentForm { xx: a * x * x + b * y * y, xy: (a - b) * x * y, yy: a * y * y + b * x * x }
    }
    /// The ellipse on a surface that bends by `shape`: (Q⁻¹ + B)⁻¹, B = SᵀS/c², so that no semi-axis is longer than c times
    /// the surface's radius of curvature along it, and what is much shorter stays as it is.
    pub fn on_curved(self, frame: &Frame, shape: &ShapeOperator) -> TangentForm {
        let [t, b] = [frame.t, frame.b].map(|axis| frame.project(shape.apply(axis)) / MAX_BEND);
        let bend = TangentForm { xx: t.length_squared(), xy: t.dot(b), yy: b.length_squared() };
        // Without inverses, which a fold does not have: (Q + det Q · adj B)/det(1 + Q B).
        let determinant = self.determinant().max(0.0);
        let product = self.xx * bend.xx + 2.0 * self.xy * bend.xy + self.yy * bend.yy;
        let adjugate = TangentForm { xx: bend.yy, xy: -bend.xy, yy: bend.xx };
        let limited = self.plus(adjugate.scaled(determinant));
        limited.scaled(1.0 / (1.0 + product + determinant * bend.determinant().max(0.0)))
    }
    /// R Q Rᵀ, R the mirror image across the line at right angles to the unit vector `e`.
    pub fn mirrored(&self, e: Vec2) -> TangentForm {
        let q = Vec2::new(self.xx * e.x + self.xy * e.y, self.xy * e.x + self.yy * e.y);
        let twice = 4.0 * self.along(e);
        TangentForm {
            xx: self.xx - 4.0 * q.x * e.x + twice * e.x * e.x,
            xy: self.xy - 2.0 * (q.x * e.y + q.y * e.x) + twice * e.x * e.y,
            yy: self.yy - 4.0 * q.y * e.y + twice * e.y * e.y,
        }
    }
    /// dᵀ Q⁻¹ d · det Q.
    pub fn adjugate_form(&self, d: Vec2) -> f64 {
        self.yy * d.x * d.x - 2.0 * self.xy * d.x * d.y + self.xx * d.y * d.y
    }
    /// cᵀ Q⁻¹ d · det Q.
    pub fn adjugate_between(&self, c: Vec2, d: Vec2) -> f64 {
        self.yy * c.x * d.x - self.xy * (c.x * d.y + c.y * d.x) + self.xx * c.y * d.y
    }
    /// Squared semi-axes, ascending, and the direction of the longer one in (t, b). In closed form: every photon that is
    /// splatted asks for it. The smaller one comes from the determinant, where their difference would have cancelled.
    pub fn principal(&self) -> ([f64; 2], Vec2) {
        let half = 0.5 * (self.xx - self.yy);
        let radius = (half * half + self.xy * self.xy).sqrt();
        let major = 0.5 * self.trace() + radius;
        let minor = if major > 0.0 { (self.determinant() / major).max(0.0) } else { 0.0 };
        let along = if half >= 0.0 { Vec2::new(half + radius, self.xy) } else { Vec2::new(self.xy, radius - half) };
        ([minor, major], along.normalize_or(Vec2::X))
    }
    /// Half extents of the ellipse along the world axes: √(eᵀ Q e) for each axis e.
    pub fn world_half_extents(&self, frame: &Frame) -> Vec3 {
        let along = |t: f64, b: f64| (self.xx * t * t + 2.0 * self.xy * t * b + self.yy * b * b).max(0.0).sqrt();
        Vec3::new(along(frame.t.x, frame.b.x), along(frame.t.y, frame.b.y), along(frame.t.z, frame.b.z))
    }
}

/// How wide a photon's light is spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// By its own columns, widened by `scale`.
    Columns { rule: FootprintRule, scale: f64 },
    /// Over a disc of this radius, the same for all photons.
    Disc { radius: f64 },
}

impl Spread {
    /// The footprint of a photon whose columns [`crate::differential::transfer()`] has put on the surface with tangent
    /// frame `frame`.
    pub fn footprint<const N: usize>(&self, columns: &Differential<N>, frame: &Frame) -> TangentForm {
        match *self {
            Spread::Columns { rule, scale } => footprint(columns, rule, scale, frame),
            Spread::Disc { radius } => TangentForm { xx: radius * radius, xy: 0.0, yy: radius * radius },
        }
    }
}

/// The footprint of columns that [`crate::differential::transfer()`] has put on the surface with tangent frame `frame`,
/// widened by `scale`.
///
/// A column is the full width of its cell, so semi-axes are halves of columns.
/// * Quadratic: Q = ¼ Σ_k P'_k P'_kᵀ over u, v, θ, φ: covariances of independent parameters add.
/// * Parallelogram: the slides' (D_u + D_θ, D_v + D_φ), which depends on the bases' relative turn and can vanish.
pub fn footprint<const N: usize>(
    columns: &Differential<N>,
    rule: FootprintRule,
    scale: f64,
    frame: &Frame,
) -> TangentForm {
    let dx = columns.dx.to_array();
    let form = match rule {
        FootprintRule::Quadratic => TangentForm::from_axes(frame, dx),
        FootprintRule::Parallelogram => {
            let (positions, directions) = dx.split_at(N / 2);
            TangentForm::from_axes(frame, positions.iter().zip(directions).map(|(&x, &w)| x + w))
        }
    };
    form.scaled(0.25 * scale * scale)
}

/// Half extents along the world's axes of the ellipse with these semi-axes.
pub fn half_extents([a, b]: [Vec3; 2]) -> Vec3 {
    let along = |a: f64, b: f64| (a * a + b * b).sqrt();
    Vec3::new(along(a.x, b.x), along(a.y, b.y), along(a.z, b.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::differential::Column;
    use crate::math::Normal3;

    fn columns(dx: [Vec3; 4]) -> Differential<4> {
        Differential::new(dx.map(Column::position))
    }

    /// With one pair of columns both rules are the inscribed ellipse: π √det Q = (π/4)|D_u × D_v|.
    #[test]
    fn one_pair_gives_the_inscribed_ellipse() {
        let frame = Frame::from_unit(Normal3::Z);
        let (a, b) = (Vec3::new(0.3, 0.1, 0.0), Vec3::new(-0.2, 0.4, 0.0));
        for rule in [FootprintRule::Quadratic, FootprintRule::Parallelogram] {
            let q = footprint(&columns([a, b, Vec3::ZERO, Vec3::ZERO]), rule, 1.0, &frame);
            let expected = 0.25 * a.cross(b).length();
            assert!((q.determinant().sqrt() - expected).abs() < 1e-15);
        }
    }

    /// Turning the basis of the directional disc by 90° changes nothing in the quadratic rule and destroys the
    /// parallelogram's footprint.
    #[test]
    fn only_the_quadratic_rule_is_invariant() {
        let frame = Frame::from_unit(Normal3::Z);
        let [u, v] = [Vec3::X * 0.02, Vec3::Y * 0.02];
        let area =
            |rule, theta, phi| footprint(&columns([u, v, theta, phi]), rule, 1.0, &frame).determinant().max(0.0).sqrt();
        let (x, y) = (Vec3::X * 0.02, Vec3::Y * 0.02);
        assert!((area(FootprintRule::Quadratic, x, y) - area(FootprintRule::Quadratic, y, -x)).abs() < 1e-18);
        assert!(area(FootprintRule::Parallelogram, -x, -y) < 1e-18);
        assert!(area(FootprintRule::Parallelogram, x, y) > 1e-4);
    }

    #[test]
    fn principal_axes_and_world_extents_agree_with_a_known_ellipse() {
        let frame = Frame { t: Vec3::X, b: Vec3::Y, n: Vec3::Z };
        let (s, c) = 0.5f64.sin_cos();
        let q = TangentForm::from_axes(&frame, [Vec3::new(3.0 * c, 3.0 * s, 0.0), Vec3::new(-s, c, 0.0)]);
        let (values, major) = q.principal();
        assert!((values[0] - 1.0).abs() < 1e-12 && (values[1] - 9.0).abs() < 1e-12);
        assert!((major.dot(Vec2::new(c, s))).abs() > 1.0 - 1e-12);
        let extents = q.world_half_extents(&frame);
        assert!((extents.x - (9.0 * c * c + s * s).sqrt()).abs() < 1e-12 && extents.z == 0.0);
    }

    /// Q = Σ λ a aᵀ of what `principal` says, in all directions, for thin and for round ellipses.
    #[test]
    fn principal_axes_make_the_form_again() {
        for k in 0..64 {
            let (turn, thin) = (f64::from(k) * 0.1, 10f64.powi(-(k % 8)));
            let (sin, cos) = turn.sin_cos();
            let [major, minor] = [2.0, 2.0 * thin];
            let q = TangentForm {
                xx: major * cos * cos + minor * sin * sin,
                xy: (major - minor) * sin * cos,
                yy: major * sin * sin + minor * cos * cos,
            };
            let ([low, high], a) = q.principal();
            assert!((low / minor - 1.0).abs() < 1e-8 && (high / major - 1.0).abs() < 1e-14, "{low} {high}");
            assert!((a.length() - 1.0).abs() < 1e-14);
            let again = high * a.x * a.y - low * a.x * a.y;
            assert!((again - q.xy).abs() < 1e-14, "{again} against {}", q.xy);
        }
        let point = TangentForm::default().principal();
        assert_eq!(point, ([0.0, 0.0], Vec2::X));
    }

    /// On a cylinder the ellipse is limited across it and not along it; a small one is not, nor one without area; on a plane
    /// none is.
    #[test]
    fn bent_surfaces_limit_footprints_along_their_bend() {
        let frame = Frame::from_unit(Normal3::Z);
        let radius = 2.0;
        let across = frame.t;
        let bend = |v: Vec3| across * (across.dot(v) / radius);
        let shape = ShapeOperator::from_matrix(glam::DMat3::from_cols(bend(Vec3::X), bend(Vec3::Y), bend(Vec3::Z)));
        let form = |a: f64, b: f64| TangentForm::from_axes(&frame, [frame.t * a, frame.b * b]);
        let wide = form(100.0, 3.0).on_curved(&frame, &shape);
        assert!((wide.along(Vec2::X).sqrt() - MAX_BEND * radius).abs() < 1e-4, "{wide:?}");
        assert!((wide.along(Vec2::Y) - 9.0).abs() < 1e-12 && wide.xy.abs() < 1e-12, "{wide:?}");
        let narrow = form(1e-3, 1e-3).on_curved(&frame, &shape);
        assert!((narrow.determinant().sqrt() / 1e-6 - 1.0).abs() < 1e-5, "{narrow:?}");
        let fold = form(100.0, 0.0).on_curved(&frame, &shape);
        assert!((fold.along(Vec2::X).sqrt() - MAX_BEND * radius).abs() < 1e-4 && fold.determinant().abs() < 1e-12);
        assert_eq!(form(3.0, 2.0).on_curved(&frame, &ShapeOperator::FLAT), form(3.0, 2.0));
    }

    #[test]
    fn forms_are_mirrored_and_limited() {
        let frame = Frame::from_unit(Normal3::Z);
        let e = Vec2::new(0.6, 0.8);
        let mirror = |v: Vec3| v - (frame.t * e.x + frame.b * e.y) * (2.0 * frame.project(v).dot(e));
        let axes = [frame.t * 0.3 + frame.b * 0.1, frame.b * 0.2 - frame.t * 0.7];
        let (form, image) = (TangentForm::from_axes(&frame, axes), TangentForm::from_axes(&frame, axes.map(mirror)));
        let mirrored = form.mirrored(e);
        let near =
            |a: TangentForm, b: TangentForm| (a.xx - b.xx).abs() + (a.xy - b.xy).abs() + (a.yy - b.yy).abs() < 1e-14;
        assert!(near(mirrored, image), "{mirrored:?}, not {image:?}");
        assert!((form.along(e) - mirrored.along(e)).abs() < 1e-15);
        let ([minor, major], along) = form.principal();
        for limit in [2.0, 0.9 * major.sqrt(), 0.5 * minor.sqrt()] {
            let (limited, squared) = (form.at_most(limit), limit * limit);
            let [a, b] = [major.min(squared), minor.min(squared)];
            assert!((limited.along(along) - a).abs() < 1e-14 && (limited.determinant() - a * b).abs() < 1e-14);
        }
        assert_eq!(form.at_most(2.0), form);
    }
}
