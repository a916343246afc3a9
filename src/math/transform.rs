//! Affine maps object → world with their inverse.

use super::vector::{Dir3, Normal3, Point3, Vec3};

/// An invertible affine map x ↦ M x + t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    linear: glam::DMat3,
    translation: Vec3,
    inverse: glam::DMat3,
    /// M is the identity. Most shapes stand where their numbers say, and rays ask for them more than for anything else.
    only_moves: bool,
}

impl Transform {
    pub const IDENTITY: Transform = Transform {
        linear: glam::DMat3::IDENTITY,
        translation: Vec3::ZERO,
        inverse: glam::DMat3::IDENTITY,
        only_moves: true,
    };

    fn of(linear: glam::DMat3, translation: Vec3, inverse: glam::DMat3) -> Transform {
        let only_moves = linear == glam::DMat3::IDENTITY && inverse == glam::DMat3::IDENTITY;
        Transform { linear, translation, inverse, only_moves }
    }

    /// From the columns of M and the translation; `None` if M is singular or not finite.
    pub fn new(columns: [Vec3; 3], translation: Vec3) -> Option<Transform> {
        let linear = glam::DMat3::from_cols(columns[0], columns[1], columns[2]);
        let inverse = linear.inverse();
        let sound = linear.determinant() != 0.0 && inverse.is_finite() && linear.is_finite() && translation.is_finite();
        sound.then_some(Transform::of(linear, translation, inverse))
    }
    pub fn translate(t: Vec3) -> Transform {
        Transform { translation: t, ..Transform::IDENTITY }
    }
    /// `None` if a factor is zero or not finite.
    pub fn scale(s: Vec3) -> Option<Transform> {
        Transform::new([Vec3::X * s.x, Vec3::Y * s.y, Vec3::Z * s.z], Vec3::ZERO)
    }
    /// Right-handed rotation about `axis` by `radians`.
    pub fn rotate(axis: Dir3, radians: f64) -> Transform {
        let linear = glam::DMat3::from_axis_angle(axis.to_vec(), radians);
        Transform::of(linear, Vec3::ZERO, linear.transpose())
    }
    /// x ↦ R P x + t of a rotation R and a regular P.
    pub(super) fn of_product(rotation: glam::DMat3, p: glam::DMat3, translation: Vec3) -> Transform {
        Transform::of(rotation * p, translation, p.inverse() * rotation.transpose())
    }
    /// First `inner`, then `self`.
    pub fn compose(&self, inner: &Transform) -> Transform {
        Transform::of(
            self.linear * inner.linear,
            self.linear * inner.translation + self.translation,
            inner.inverse * self.inverse,
        )
    }
    pub fn inverse(&self) -> Transform {
        Transform::of(self.inverse, -(self.inverse * self.translation), self.linear)
    }
    pub fn is_identity(&self) -> bool {
        *self == Transform::IDENTITY
    }
    /// Whether M is the identity.
    pub fn only_moves(&self) -> bool {
        self.only_moves
    }
    /// Whether the map turns right-handed frames into left-handed ones.
    pub fn flips_handedness(&self) -> bool {
        self.linear.determinant() < 0.0
    }
    pub fn point(&self, p: Point3) -> Point3 {
        Point3::from_vec(self.vector(p.to_vec()) + self.translation)
    }
    pub fn vector(&self, v: Vec3) -> Vec3 {
        if self.only_moves { v } else { self.linear * v }
    }
    pub fn inverse_point(&self, p: Point3) -> Point3 {
        Point3::from_vec(self.inverse_vector(p.to_vec() - self.translation))
    }
    pub fn inverse_vector(&self, v: Vec3) -> Vec3 {
        if self.only_moves { v } else { self.inverse * v }
    }
    /// M⁻ᵀ A M⁻¹ of a bilinear form A.
    pub fn form(&self, a: glam::DMat3) -> glam::DMat3 {
        if self.only_moves { a } else { self.inverse.transpose() * a * self.inverse }
    }
    /// M A M⁻¹ of a linear map A.
    pub fn carried(&self, a: glam::DMat3) -> glam::DMat3 {
        if self.only_moves { a } else { self.linear * a * self.inverse }
    }
    /// M⁻ᵀ n, not normalised.
    pub fn normal_unnormalised(&self, n: Vec3) -> Vec3 {
        self.inverse.transpose() * n
    }
    pub fn normal(&self, n: Normal3) -> Normal3 {
        Normal3::from_unit(self.normal_unnormalised(n.to_vec()).normalize())
    }
    pub fn columns(&self) -> [Vec3; 3] {
        [self.linear.x_axis, self.linear.y_axis, self.linear.z_axis]
    }
    pub fn translation(&self) -> Vec3 {
        self.translation
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn composing_with_the_inverse_is_the_identity() {
        let axis = Dir3::new(Vec3::new(1.0, 2.0, -0.5)).expect("non-zero");
        let t = Transform::translate(Vec3::new(1.0, 2.0, 3.0))
            .compose(&Transform::rotate(axis, 0.7))
            .compose(&Transform::scale(Vec3::new(2.0, -0.5, 3.0)).expect("invertible"));
        let p = Point3::new(0.3, -0.2, 0.9);
        assert!(t.inverse().point(t.point(p)).distance(p) < 1e-15);
        assert!(t.inverse_point(t.point(p)).distance(p) < 1e-15);
        assert!(t.flips_handedness());
        assert!(Transform::scale(Vec3::new(1.0, 0.0, 1.0)).is_none());
    }
}
