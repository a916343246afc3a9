//! How a photon's share of a source with area is split between where it starts and whither it goes.
//!
//! The slides give each photon 1/n of both ([Frisvad-slides]). Footprints then cover a point s² times as for a point
//! light, but each photon starts elsewhere on the source, so that nothing tiles: the penumbra is as noisy as with random
//! photons. Wider cells overlap in position and direction. Both parts blur; for a given overlap the blur is least where
//! they are equally wide on what they light, B √p = D √d for a p part of the source and a d part of the directions, where
//! B is the width of the whole source's image and D that of all its directions. Pilot photons measure B/D.

use super::trace::PhotonTracer;
use crate::differential::Differential;
use crate::light::{Aim, Emission, Lights};
use crate::sampling::{Purpose, Stream, qmc};
use crate::scene::LightId;

/// Pilot photons of a light; their mean logarithm of B/D is known to a few per cent.
const PILOTS: u64 = 512;

/// Up to so many footprints over a point, cells fill positions × directions.
pub const FULL_OVERLAP: f64 = 32.0;
/// With more, what noise is left falls with the overlap and the blur grows. Their sum is least for sides of the cells about
/// a quarter of what would fill, of many photons and of few, on lamps wide and narrow (`src/doc/performance.md`).
const FILL: f64 = 0.25;

/// The cell of one photon, as fractions of the two unit squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    pub positions: f64,
    pub directions: f64,
}

impl Share {
    /// 1/n of both: the slides' rule.
    pub fn same(n: u64) -> Share {
        Share { positions: 1.0 / n as f64, directions: 1.0 / n as f64 }
    }

    /// 1/n of the one pair that a source without area, or without directions, has.
    pub fn leading(n: u64, collimated: bool) -> Share {
        let cell = 1.0 / n as f64;
        if collimated { Share { positions: cell, directions: 1.0 } } else { Share { positions: 1.0, directions: cell } }
    }

    /// Equal parts for a source whose image is `ratio` = B/D times as wide as all its directions'.
    ///
    /// Cells that fill positions × directions, p d = 1/n, have parts of the area f = B D/√n. Their overlap, about
    /// 2 n f/(B² + D²), grows like √n: at [`FULL_OVERLAP`] they shrink to `FILL` of that. A pair too small to be cut is
    /// one cell, and the other pair gets all n.
    pub fn equal_parts(n: u64, ratio: f64) -> Share {
        let n = n as f64;
        // In units of D².
        let filling = ratio / n.sqrt();
        let part = filling.min((FILL * filling).max(0.5 * FULL_OVERLAP * (1.0 + ratio * ratio) / n));
        Share { positions: (part / (ratio * ratio)).clamp(1.0 / n, 1.0), directions: part.clamp(1.0 / n, 1.0) }
    }

    /// How many of `n` such cells lie over a place that all of the source lights: n (p B² + d D²)/(B² + D²), where equal parts
    /// say what B/D is; of a source that is not cut in one of them the other is as wide as all.
    pub fn overlap(self, n: u64) -> f64 {
        let Share { positions: p, directions: d } = self;
        let both = if p < 1.0 && d < 1.0 { 2.0 * p * d / (p + d) } else { p * d };
        (n as f64 * both).max(1.0)
    }

    /// The cell of a photon whose pass is parted into `count` of fewer photons, which overlap in what they light: wider
    /// than its share of all, and not as wide as one of its part, in as far as it is cut at all.
    pub fn parted(self, count: u64) -> Share {
        let area = (count as f64).sqrt();
        let Share { positions, directions } = self;
        let wider = if positions < 1.0 && directions < 1.0 { area.sqrt() } else { area };
        Share { positions: (positions * wider).min(1.0), directions: (directions * wider).min(1.0) }
    }

    /// Sides of the cell in (u, v; θ, φ), where the square of positions stands for a rectangle `aspects[0]` × 1 and that
    /// of directions for `aspects[1]` × 1: cells are squares there, but for those that fill a side.
    pub fn sides(&self, aspects: [f64; 2]) -> [f64; 4] {
        let [[u, v], [theta, phi]] =
            [(self.positions, aspects[0]), (self.directions, aspects[1])].map(|(area, aspect)| {
                let width = (area / aspect).sqrt().clamp(area, 1.0);
                [width, area / width]
            });
        [u, v, theta, phi]
    }

    /// The split that makes both parts of the footprints equally wide. `tracer` is a fresh one; what it stores is
    /// thrown away by the caller.
    pub fn balanced(lights: &Lights, light: LightId, aim: &Aim, n: u64, tracer: &mut PhotonTracer<4>) -> Share {
        let mut log_ratio = 0.0;
        let mut pairs = 0u32;
        for i in 0..PILOTS {
            // The sample points are fixed ones, so that the split is a property of the scene.
            let (a, b) = (qmc::r2(i), qmc::golden_lattice(i, PILOTS));
            let mut stream = Stream::new(0, Purpose::Photon, u32::MAX, u64::from(light.0) << 44 | i);
            let time = tracer.draw_time(&mut stream);
            let Some(emission) = lights.emit(light, [a[0], a[1], b[0], b[1]], aim, time) else { continue };
            let mut widths = |kept: std::ops::Range<usize>| {
                tracer.stored.caustic.clear();
                let pilot = Emission { jacobian: only(&emission.jacobian, kept), ..emission };
                // Both parts take the same way.
                let mut stream = stream.clone();
                tracer.trace(&pilot, time, &mut stream);
                tracer.stored.caustic.iter().map(|photon| photon.form().trace()).collect::<Vec<f64>>()
            };
            for (positions, directions) in widths(0..2).into_iter().zip(widths(2..4)) {
                if positions > 0.0 && directions > 0.0 {
                    log_ratio += (positions / directions).ln();
                    pairs += 1;
                }
            }
        }
        if pairs == 0 {
            return Share::same(n);
        }
        let ratio = (0.5 * log_ratio / f64::from(pairs)).exp();
        Share::equal_parts(n, ratio)
    }
}

/// The Jacobian with the other columns zero.
fn only(jacobian: &Differential<4>, kept: std::ops::Range<usize>) -> Differential<4> {
    jacobian.scaled_each(std::array::from_fn(|k| if kept.contains(&k) { 1.0 } else { 0.0 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_fill_the_space_while_their_overlap_is_small() {
        for (n, ratio) in [(100u64, 0.15), (20_000, 0.01)] {
            let share = Share::equal_parts(n, ratio);
            assert!((share.positions * share.directions * n as f64 - 1.0).abs() < 1e-9, "{share:?}");
        }
    }

    #[test]
    fn both_parts_are_equally_wide_and_fill_a_part_of_the_space() {
        for (n, ratio) in [(20_000u64, 0.3f64), (1_000_000, 0.05), (1_000_000, 1.2)] {
            let share = Share::equal_parts(n, ratio);
            assert!((share.positions * ratio * ratio / share.directions - 1.0).abs() < 1e-9, "{share:?}");
            let fill = (share.positions * share.directions * n as f64).sqrt();
            assert!((fill - FILL).abs() < 1e-9 || (fill > FILL && fill < 1.0), "{fill}");
        }
    }

    /// Of cells in equal parts what [`FULL_OVERLAP`] says; of a source that is not cut in one pair, one.
    #[test]
    fn a_share_knows_its_overlap() {
        assert!((Share::equal_parts(20_000, 0.3).overlap(20_000) - FULL_OVERLAP).abs() < 1e-9);
        assert_eq!(Share::leading(1000, false).overlap(1000), 1.0);
        assert_eq!(Share::leading(1000, true).overlap(1000), 1.0);
    }

    /// The overlap 2 n d/(B² + D²), in units of D: all of it at first, then [`FULL_OVERLAP`], then as √n.
    #[test]
    fn the_overlap_grows_without_steps() {
        let ratio = 0.3;
        let overlap = |n: u64| 2.0 * n as f64 * Share::equal_parts(n, ratio).directions / (1.0 + ratio * ratio);
        let filling = |n: u64| 2.0 * (n as f64).sqrt() * ratio / (1.0 + ratio * ratio);
        let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
        assert!(close(overlap(1000), filling(1000)) && filling(1000) < FULL_OVERLAP);
        assert!(close(overlap(20_000), FULL_OVERLAP));
        assert!(close(overlap(4_000_000), FILL * filling(4_000_000)) && FILL * filling(4_000_000) > FULL_OVERLAP);
    }

    /// Between one of all and one of its part; a pair that is not cut stays whole.
    #[test]
    fn cells_of_parts_have_the_mean_of_both_areas() {
        let area = |share: Share| share.positions * share.directions;
        for share in [Share::leading(1600, false), Share::leading(1600, true), Share::equal_parts(20_000, 0.3)] {
            let parted = share.parted(4);
            assert!((area(parted) / area(share) - 2.0).abs() < 1e-12, "{parted:?}");
            assert!(share.positions < 1.0 || parted.positions == 1.0, "{parted:?}");
            assert_eq!(share.parted(1), share);
        }
    }

    #[test]
    fn a_tiny_source_is_one_cell() {
        let share = Share::equal_parts(10_000, 1e-6);
        assert_eq!((share.positions, share.directions), (1.0, 1e-4));
    }
}
