//! Rank-1 lattices of the unit square, as round as they can be once the square is stretched to the shape it is mapped
//! to · points (i/n, i·g/n mod 1) · lattices and their duals in
//! `[SloanJoe94]`, shortest vectors by Gauss's reduction.
//!
//! Photon footprints tile a surface if the emission points are evenly spread *there*: a beam of 7 m by 1 m wants seven
//! columns for every row. The generator g is the one of some hundred candidates whose stretched lattice has the
//! longest shortest vector.

/// Candidates tried around each golden section of the residues.
const CANDIDATES: u64 = 256;

/// n points, evenly spread in the rectangle `aspect` × 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rank1Lattice {
    n: u64,
    generator: u64,
}

impl Rank1Lattice {
    /// `aspect`: width over height of the rectangle that the square stands for; `n` > 0.
    pub fn new(n: u64, aspect: f64) -> Rank1Lattice {
        let mut best = (0.0, 1);
        for k in 0..CANDIDATES.min(n) {
            // The multiples of the golden ratio visit the residues evenly, whatever n is.
            let generator = ((k as f64 * 0.618_033_988_749_894_9).fract() * n as f64) as u64;
            let length = shortest_vector(n, generator, aspect);
            if length > best.0 {
                best = (length, generator);
            }
        }
        Rank1Lattice { n, generator: best.1 }
    }

    pub fn len(&self) -> u64 {
        self.n
    }
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// Point `i`, 0 ≤ i < n.
    pub fn point(&self, i: u64) -> [f64; 2] {
        let product = u128::from(i) * u128::from(self.generator) % u128::from(self.n);
        [i as f64 / self.n as f64, product as f64 / self.n as f64]
    }
}

/// Squared length of the shortest vector of the lattice on the torus, in units of the area of a cell, after stretching
/// x by `aspect`: at most 2/√3, that of the hexagonal lattice.
fn shortest_vector(n: u64, generator: u64, aspect: f64) -> f64 {
    let (nf, stretch) = (n as f64, aspect.sqrt());
    // The stretch keeps areas, so that a cell has the area 1/n; both axes are then scaled by √n.
    let scale = [stretch * nf.sqrt(), nf.sqrt() / stretch];
    let mut a = [scale[0] / nf, scale[1] * generator as f64 / nf];
    let mut b = [0.0, scale[1]];
    let dot = |p: [f64; 2], q: [f64; 2]| p[0] * q[0] + p[1] * q[1];
    if dot(a, a) > dot(b, b) {
        std::mem::swap(&mut a, &mut b);
    }
    // Each round replaces the longer vector by a strictly shorter one, so rounding cannot make it go round in circles.
    loop {
        let m = (dot(a, b) / dot(a, a)).round();
        b = [b[0] - m * a[0], b[1] - m * a[1]];
        if dot(b, b).partial_cmp(&dot(a, a)) != Some(std::cmp::Ordering::Less) {
            return dot(a, a);
        }
        std::mem::swap(&mut a, &mut b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square whose shortest vector is s² cells has its points at least that far apart; checked by brute force on
    /// the torus, for square and stretched lattices.
    #[test]
    fn points_are_as_far_apart_as_the_reduction_says() {
        for (n, aspect) in [(100, 1.0), (101, 7.0), (500, 0.2), (64, 30.0)] {
            let lattice = Rank1Lattice::new(n, aspect);
            let claimed = shortest_vector(n, lattice.generator, aspect);
            let nearest = (1..n)
                .map(|i| {
                    let [x, y] = lattice.point(i).map(|t| t - t.round());
                    (x * x * aspect + y * y / aspect) * n as f64
                })
                .fold(aspect.min(1.0 / aspect) * n as f64, f64::min);
            assert!((claimed - nearest).abs() < 1e-9 * nearest.max(1.0), "n={n}: {claimed} against {nearest}");
        }
    }

    /// The golden ratio guarantees 0.4 or so; the search should come near the hexagonal lattice's 1.1547.
    #[test]
    fn lattices_are_nearly_hexagonal_for_all_n_and_aspects() {
        for n in [500, 1000, 4096, 20_000, 20_011, 1_000_000] {
            for aspect in [0.1, 0.5, 1.0, 1.3, 7.0] {
                let lattice = Rank1Lattice::new(n, aspect);
                let length = shortest_vector(n, lattice.generator, aspect);
                assert!(length > 0.9, "n={n} aspect={aspect}: {length}");
            }
        }
    }

    #[test]
    fn small_lattices_have_all_their_points() {
        for n in 1..20 {
            let lattice = Rank1Lattice::new(n, 1.0);
            assert!((0..n).all(|i| lattice.point(i).iter().all(|t| (0.0..1.0).contains(t))));
        }
    }
}
