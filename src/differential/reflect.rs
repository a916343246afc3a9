//! Mirror reflection · [Igehy99 (14), (15)].

use super::lanes::Vectors;
use super::state::{Differential, ShapeOperator};
use crate::math::{Dir3, Normal3, Vec3};

/// Reflects the ray direction `w` (towards the surface) and its columns about the normal `n`, whose shape operator
/// belongs to the same orientation. Either orientation gives the same answer.
#[inline(always)]
pub fn reflect<const N: usize>(
    d: &Differential<N>,
    w: Dir3,
    n: Normal3,
    shape: &ShapeOperator,
) -> (Dir3, Differential<N>) {
    reflect_about(d, w, n, shape.apply_each(&d.dx))
}

/// The same where the normal changes by `dn` with each parameter.
#[inline(always)]
pub(super) fn reflect_about<const N: usize>(
    d: &Differential<N>,
    w: Dir3,
    n: Normal3,
    dn: Vectors<N>,
) -> (Dir3, Differential<N>) {
    let cos = w.dot(n);
    let reflected = Dir3::from_unit(renormalised(w.to_vec() - n * (2.0 * cos)));
    let dcos = d.dw.dot(n.to_vec()) + dn.dot(w.to_vec());
    let dw = d.dw - (dn * cos + Vectors::multiples(n.to_vec(), dcos)) * 2.0;
    (reflected, Differential { dx: d.dx, dw })
}

/// Removes the last rounding error of a vector that is unit by construction.
pub(super) fn renormalised(v: Vec3) -> Vec3 {
    v * (1.5 - 0.5 * v.length_squared())
}
