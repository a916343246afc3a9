//! Refraction · [Igehy99 (16)–(19)], with the full derivative of the normal and of the index ratio.

use super::lanes::Vectors;
use super::reflect::{reflect_about, renormalised};
use super::state::{Differential, ShapeOperator};
use crate::math::{Dir3, Normal3};

/// The outcome of meeting an interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refraction<const N: usize> {
    Transmitted(Dir3, Differential<N>),
    /// Total internal reflection: the mirror's rule applied.
    TotalReflection(Dir3, Differential<N>),
}

/// Refracts `w` (towards the surface) with η = n_incident / n_transmitted. The normal may face either way; `shape`
/// belongs to the orientation given.
#[inline(always)]
pub fn refract<const N: usize>(
    d: &Differential<N>,
    w: Dir3,
    n: Normal3,
    shape: &ShapeOperator,
    eta: f64,
) -> Refraction<N> {
    refract_about(d, w, n, shape.apply_each(&d.dx), eta)
}

/// The same where the normal changes by `dn` with each parameter.
#[inline(always)]
pub(super) fn refract_about<const N: usize>(
    d: &Differential<N>,
    w: Dir3,
    n: Normal3,
    dn: Vectors<N>,
    eta: f64,
) -> Refraction<N> {
    // The rule is written for a normal against the ray.
    let (n, dn) = if w.dot(n) > 0.0 { (-n, dn * -1.0) } else { (n, dn) };
    let c = -w.dot(n);
    let k = 1.0 - eta * eta * (1.0 - c * c);
    if k <= 0.0 {
        let (reflected, columns) = reflect_about(d, w, n, dn);
        return Refraction::TotalReflection(reflected, columns);
    }
    let root = k.sqrt();
    let m = eta * c - root;
    let transmitted = Dir3::from_unit(renormalised(w * eta + n * m));
    let dcos = d.dw.dot(n.to_vec()) + dn.dot(w.to_vec());
    // dm/dk with constant η: η dc − η² c dc / √k, and dc = −d cos.
    let dm = dcos * (eta * eta * c / root - eta);
    let dw = d.dw * eta + dn * m + Vectors::multiples(n.to_vec(), dm);
    Refraction::Transmitted(transmitted, Differential { dx: d.dx, dw })
}
