//! Orthonormal right-handed frames (t, b, n); local z is the third axis.

use super::vector::{Dir3, Normal3, Vec2, Vec3};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub t: Vec3,
    pub b: Vec3,
    pub n: Vec3,
}

impl Frame {
    /// A frame about the unit vector `n`, the same for the same bits of `n` `[Duff17]`.
    pub fn from_unit(n: impl Into<Vec3>) -> Frame {
        let n = n.into();
        let sign = 1.0f64.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Frame {
            t: Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            b: Vec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// Derivatives of the three axes of [`Frame::from_unit`] when the unit vector `n` changes by `dn` ⟂ n. On the seam
    /// n.z = 0 that of the upper side.
    pub fn from_unit_derivative(n: impl Into<Vec3>, dn: Vec3) -> [Vec3; 3] {
        let n = n.into();
        let sign = 1.0f64.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let da = a * a * dn.z;
        let dxy = dn.x * n.y + n.x * dn.y;
        let db = dxy * a + n.x * n.y * da;
        [
            Vec3::new(sign * (2.0 * n.x * dn.x * a + n.x * n.x * da), sign * db, -sign * dn.x),
            Vec3::new(db, 2.0 * n.y * dn.y * a + n.y * n.y * da, -dn.y),
            dn,
        ]
    }

    /// A frame about `n` whose first axis is as near to `x` as it can be; falls back to [`Frame::from_unit`]
    /// where `x` is parallel to `n` or zero.
    pub fn from_normal_and_x(n: Normal3, x: Vec3) -> Frame {
        let projected = x - n.to_vec() * n.dot(x);
        match Dir3::new(projected) {
            Some(t) if projected.length_squared() > 1e-24 * x.length_squared() => {
                Frame { t: t.to_vec(), b: n.cross(t), n: n.to_vec() }
            }
            _ => Frame::from_unit(n),
        }
    }

    /// World → local.
    pub fn to_local(&self, v: impl Into<Vec3>) -> Vec3 {
        let v = v.into();
        Vec3::new(v.dot(self.t), v.dot(self.b), v.dot(self.n))
    }
    /// Local → world.
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.t * v.x + self.b * v.y + self.n * v.z
    }
    /// Local unit vector → world direction.
    pub fn to_world_dir(&self, v: Vec3) -> Dir3 {
        Dir3::from_unit(self.to_world(v))
    }
    /// Tangent-plane coordinates of `v`, the normal component dropped.
    pub fn project(&self, v: Vec3) -> Vec2 {
        Vec2::new(v.dot(self.t), v.dot(self.b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_orthonormal_and_right_handed_at_both_poles_too() {
        for v in [Vec3::Z, -Vec3::Z, Vec3::new(1e-9, 0.0, -1.0), Vec3::new(0.3, -0.5, 0.2), -Vec3::X] {
            let n = Normal3::new(v).expect("non-zero");
            let f = Frame::from_unit(n);
            assert!((f.t.cross(f.b) - f.n).length() < 1e-15, "{v}");
            assert!(f.t.dot(f.b).abs() < 1e-15 && (f.t.length() - 1.0).abs() < 1e-15);
            let w = Vec3::new(0.1, 0.7, -0.4);
            assert!((f.to_world(f.to_local(w)) - w).length() < 1e-15);
        }
    }

    #[test]
    fn a_frames_derivative_is_its_difference() {
        for v in [Vec3::new(0.3, -0.5, 0.2), Vec3::new(-0.4, 0.1, -0.9), Vec3::new(0.01, 0.02, -1.0)] {
            let n = v.normalize();
            let dn = Vec3::new(0.2, 0.6, -0.3).cross(n);
            let h = 1e-5;
            let axes = |s: f64| {
                let f = Frame::from_unit((n + dn * s).normalize());
                [f.t, f.b, f.n]
            };
            let got = Frame::from_unit_derivative(n, dn);
            for (k, (above, below)) in axes(h).into_iter().zip(axes(-h)).enumerate() {
                // h²/6 times a third derivative of order ten, and rounding over h.
                assert!((got[k] - (above - below) / (2.0 * h)).length() < 20.0 * h * h, "axis {k} at {v}");
            }
        }
    }
}
