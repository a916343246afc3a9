//! A bounce off a surface that is not a delta event: what is left of the columns, and what is new · world frame.
//!
//! Whither a photon goes on is drawn afresh, so the directions that it came by say nothing any more. Two things are
//! left (PHOTON_DIFFERENTIALS 6): the patch that it lit, from anywhere on which the bounce could have started as well,
//! and the cell of directions around the one that was drawn.

use std::f64::consts::{FRAC_2_SQRT_PI, TAU};

use super::state::{Column, Differential};
use crate::math::{Dir3, Frame, Normal3, Vec3};

/// The columns after a bounce into `w`: those in `columns`, which [`super::transfer()`] has put on the surface with normal
/// `ng`, become two that span the same patch, with no change of direction; two more turn the direction over a cell of
/// `cell` steradians, a hemisphere at most, and do not move the point.
///
/// As everywhere a column is 2/√π times the side of a square cell: the ellipse that is inscribed in a pair has the cell's
/// area. Patches are equal where Σ P Pᵀ is, which is all that a footprint depends on. No columns remain none.
pub fn bounced<const N: usize>(columns: &Differential<N>, ng: Normal3, w: Dir3, cell: f64) -> Differential<N> {
    let [a, b] = patch(columns, &Frame::from_unit(ng));
    let side = FRAC_2_SQRT_PI * cell.min(TAU).sqrt();
    let around = Frame::from_unit(w);
    let all = [
        Column::position(a),
        Column::position(b),
        Column::direction(around.t * side),
        Column::direction(around.b * side),
    ];
    Differential::new(all).first()
}

/// The columns after a facet of a rough surface with normal `ng` has sent light on to `w`: those in `columns`, which went
/// over the facet as over a mirror or an interface, with a cell of `cell` steradians added to all directions, since the
/// facet was drawn. As the lobe gets narrow nothing is added any more.
///
/// Four columns have the same Σ c cᵀ as those six, c = (∂x/∂k, ∂ω/∂k): all that transfers and footprints depend on.
pub fn blurred<const N: usize>(columns: &Differential<N>, ng: Normal3, w: Dir3, cell: f64) -> Differential<N> {
    let (on, around) = (Frame::from_unit(ng), Frame::from_unit(w));
    let mut sum = [[0.0; 4]; 4];
    for Column { dx, dw } in columns.columns() {
        let (x, d) = (on.project(dx), around.project(dw));
        let c = [x.x, x.y, d.x, d.y];
        for i in 0..4 {
            for j in 0..4 {
                sum[i][j] += c[i] * c[j];
            }
        }
    }
    let side = FRAC_2_SQRT_PI * cell.min(TAU).sqrt();
    sum[2][2] += side * side;
    sum[3][3] += side * side;
    let column = |[x, y, d, e]: [f64; 4]| Column { dx: on.t * x + on.b * y, dw: around.t * d + around.b * e };
    Differential::new(factor(sum).map(column)).first()
}

/// Vectors cₖ with Σ cₖ cₖᵀ = `sum`: Cholesky's columns, zero where nothing is left.
fn factor(mut sum: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    std::array::from_fn(|k| {
        let pivot = sum[k][k];
        if pivot <= 0.0 {
            return [0.0; 4];
        }
        let c: [f64; 4] = std::array::from_fn(|i| if i < k { 0.0 } else { sum[k][i] / pivot.sqrt() });
        for i in k..4 {
            for j in k..4 {
                sum[i][j] -= c[i] * c[j];
            }
            // What rounding left of a direction that is used up.
            if sum[i][i] < ROUNDING * c[i] * c[i] {
                sum[i][i] = 0.0;
            }
        }
        c
    })
}

/// Of a difference of squares.
const ROUNDING: f64 = 1e-14;

/// Two tangent vectors with the same Σ P Pᵀ as all columns' positions: its Cholesky factor.
fn patch<const N: usize>(columns: &Differential<N>, frame: &Frame) -> [Vec3; 2] {
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    for dx in columns.dx.to_array() {
        let p = frame.project(dx);
        xx += p.x * p.x;
        xy += p.x * p.y;
        yy += p.y * p.y;
    }
    let x = f64::sqrt(xx);
    if x == 0.0 {
        return [Vec3::ZERO, frame.b * yy.sqrt()];
    }
    let y = (yy - xy / xx * xy).max(0.0).sqrt();
    [frame.t * x + frame.b * (xy / x), frame.b * y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    fn spread(columns: &[Vec3]) -> [[f64; 3]; 3] {
        std::array::from_fn(|i| std::array::from_fn(|j| columns.iter().map(|c| c[i] * c[j]).sum()))
    }

    #[test]
    fn the_patch_stays_and_directions_are_new() {
        let ng = Normal3::new(Vec3::new(0.3, -0.2, 1.0)).expect("not zero");
        let frame = Frame::from_unit(ng);
        let (t, b) = (frame.t, frame.b);
        let before = Differential::new(
            [t * 0.3 + b * 0.1, b * 0.2 - t * 0.4, t * 0.05, b * 0.7].map(|dx| Column { dx, dw: Vec3::X }),
        );
        let w = Dir3::new(Vec3::new(-0.5, 0.4, 0.8)).expect("not zero");
        let after = bounced(&before, ng, w, 0.02);
        let (old, new) = (spread(&before.dx.to_array()), spread(&after.dx.to_array()));
        for i in 0..3 {
            for j in 0..3 {
                assert!((old[i][j] - new[i][j]).abs() < 1e-15, "{old:?} {new:?}");
            }
        }
        let dw = after.dw.to_array();
        assert_eq!((dw[0], dw[1]), (Vec3::ZERO, Vec3::ZERO));
        assert!(dw.iter().all(|dw| dw.dot(w.to_vec()).abs() < 1e-15));
        // The ellipse in the pair.
        assert!((FRAC_PI_4 * dw[2].cross(dw[3]).length() - 0.02).abs() < 1e-15);
    }

    #[test]
    fn a_line_a_point_and_nothing_are_patches_too() {
        let (ng, w) = (Normal3::Z, Dir3::Z);
        let frame = Frame::from_unit(ng);
        for along in [Vec3::ZERO, frame.t, frame.b, frame.t + frame.b] {
            let line = Differential::<4>::new([along, along * 2.0, -along, Vec3::ZERO].map(Column::position));
            let after = bounced(&line, ng, w, 1.0);
            assert!(after.is_finite());
            let area = after.dx.get(0).cross(after.dx.get(1)).length();
            assert!(area < 1e-7, "{along}: {area}");
            assert!((after.dx.length_squared().0.iter().sum::<f64>() - 6.0 * along.length_squared()).abs() < 1e-14);
        }
        assert_eq!(bounced(&Differential::<0>::ZERO, ng, w, 1.0), Differential::ZERO);
        let all = bounced(&Differential::<4>::ZERO, ng, w, 100.0);
        assert!((FRAC_PI_4 * all.dw.get(2).cross(all.dw.get(3)).length() - TAU).abs() < 1e-12);
    }

    fn moments(d: &Differential<4>) -> [[f64; 6]; 6] {
        let all = d.columns().map(|c| [c.dx.x, c.dx.y, c.dx.z, c.dw.x, c.dw.y, c.dw.z]);
        std::array::from_fn(|i| std::array::from_fn(|j| all.iter().map(|c| c[i] * c[j]).sum()))
    }

    /// All moments of places and directions stay, and those of the cell come on top, whatever the columns' rank; nothing is
    /// added by an empty cell.
    #[test]
    fn a_blur_keeps_every_moment_and_adds_its_own() {
        let (ng, w) = (
            Normal3::new(Vec3::new(0.3, -0.2, 1.0)).expect("not zero"),
            Dir3::new(Vec3::new(-0.5, 0.4, 0.8)).expect("not zero"),
        );
        let (on, around) = (Frame::from_unit(ng), Frame::from_unit(w));
        let column =
            |x: f64, y: f64, d: f64, e: f64| Column { dx: on.t * x + on.b * y, dw: around.t * d + around.b * e };
        let full = [
            column(0.1, 0.02, -0.3, 0.1),
            column(0.0, 0.2, 0.1, 0.4),
            column(0.3, -0.1, 0.0, 0.2),
            column(0.01, 0.0, 0.5, 0.5),
        ];
        let flat = [full[0], full[0], Column::ZERO, Column::ZERO];
        for (columns, cell) in [(full, 0.02), (full, 0.0), (flat, 0.02), (flat, 0.0), ([Column::ZERO; 4], 0.3)] {
            let before = Differential::<4>::new(columns);
            let [old, new] = [before, blurred(&before, ng, w, cell)].map(|d| moments(&d));
            let side = FRAC_2_SQRT_PI * f64::sqrt(cell);
            let added = moments(&Differential::new(
                [around.t, around.b, Vec3::ZERO, Vec3::ZERO].map(|e| Column::direction(e * side)),
            ));
            for i in 0..6 {
                for j in 0..6 {
                    let expected = old[i][j] + added[i][j];
                    assert!((new[i][j] - expected).abs() < 1e-8, "{i} {j}: {} not {expected}", new[i][j]);
                }
            }
        }
        assert_eq!(blurred(&Differential::<0>::ZERO, ng, w, 1.0), Differential::ZERO);
    }
}
