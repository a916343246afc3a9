//! Rank-1 lattices of the four-dimensional unit cube, chosen for the cells that photons take in it · points
//! i (1, g, g², g³)/n mod 1 (Korobov's form, `[SloanJoe94]`).
//!
//! What is left of a lattice of photons after their kernels have smoothed it are its waves: frequencies h with
//! h · z ≡ 0 (mod n), the dual lattice. A kernel over cells of sides c suppresses the wave h the better the longer h is
//! measured in those sides, |(h₁c₁, …, h₄c₄)|. The generator is the one of some hundred candidates whose shortest wave is
//! longest: a beam of 7 m by 1 m gets seven columns for every row, and positions on a lamp do not beat against the
//! directions that leave it.

/// Candidates tried around the circle of residues.
const CANDIDATES: u64 = 256;

/// n points in four dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rank1Lattice {
    n: u64,
    generator: [u64; 4],
}

impl Rank1Lattice {
    /// The lattice of `n` > 0 points for cells with these sides, each in (0, 1]. A side of 1 asks for nothing.
    pub fn new(n: u64, cell: [f64; 4]) -> Rank1Lattice {
        Rank1Lattice::best(n, |lattice| lattice.shortest_wave(cell))
    }

    /// A lattice of `n` > 0 points of which every `parts`-th ones, `parts` dividing `n`, are a lattice that is as good: for
    /// cells of all points, and for those of a part's.
    pub fn in_parts(n: u64, parts: u64, cell: [f64; 4], parts_cell: [f64; 4]) -> Rank1Lattice {
        Rank1Lattice::best(n, |lattice| lattice.shortest_wave(cell).min(lattice.part(parts).shortest_wave(parts_cell)))
    }

    /// Every `parts`-th of the points: i `parts` z/n = i z/(n/`parts`).
    fn part(&self, parts: u64) -> Rank1Lattice {
        let n = self.n / parts;
        Rank1Lattice { n, generator: self.generator.map(|g| g % n) }
    }

    /// The candidate of which `quality` is greatest.
    fn best(n: u64, quality: impl Fn(&Rank1Lattice) -> f64) -> Rank1Lattice {
        let mut best = (0.0, Rank1Lattice::korobov(n, 1));
        for k in 0..CANDIDATES.min(n) {
            // The multiples of the golden ratio visit the residues evenly, whatever n is.
            let g = ((k as f64 * 0.618_033_988_749_894_9).fract() * n as f64) as u64;
            let lattice = Rank1Lattice::korobov(n, g);
            let length = quality(&lattice);
            if length > best.0 {
                best = (length, lattice);
            }
        }
        best.1
    }

    fn korobov(n: u64, g: u64) -> Rank1Lattice {
        let g1 = g % n;
        let g2 = product_modulo(g1, g, n);
        Rank1Lattice { n, generator: [1, g1, g2, product_modulo(g2, g, n)] }
    }

    pub fn len(&self) -> u64 {
        self.n
    }
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// Point `i`, 0 ≤ i < n.
    pub fn point(&self, i: u64) -> [f64; 4] {
        self.generator.map(|g| product_modulo(i, g, self.n) as f64 / self.n as f64)
    }

    /// Squared length of the shortest non-zero wave, in cells.
    fn shortest_wave(&self, cell: [f64; 4]) -> f64 {
        let [_, g1, g2, g3] = self.generator.map(|g| -(g as f64));
        // Rows that generate all h with h · z ≡ 0 (mod n).
        let dual = [[self.n as f64, 0.0, 0.0, 0.0], [g1, 1.0, 0.0, 0.0], [g2, 0.0, 1.0, 0.0], [g3, 0.0, 0.0, 1.0]];
        let mut basis = dual.map(|row| std::array::from_fn(|k| row[k] * cell[k]));
        reduce(&mut basis);
        basis.iter().map(|&b| dot(b, b)).fold(f64::INFINITY, f64::min)
    }
}

/// a b mod n of numbers below 2n. Half as wide, a division takes a fifth of the time.
fn product_modulo(a: u64, b: u64, n: u64) -> u64 {
    if n < 1 << 31 { a * b % n } else { (u128::from(a) * u128::from(b) % u128::from(n)) as u64 }
}

type Vec4 = [f64; 4];

fn dot(a: Vec4, b: Vec4) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn minus(a: Vec4, b: Vec4, m: f64) -> Vec4 {
    std::array::from_fn(|k| a[k] - m * b[k])
}

/// Makes a basis of a lattice short: pairs by Gauss's reduction, then by all sums of its vectors with coefficients -1, 0
/// and 1. In four dimensions a basis that no such sum shortens holds a shortest vector (`[NguyenStehle09]`, Minkowski's
/// conditions).
fn reduce(basis: &mut [Vec4; 4]) {
    while shorten_by_pairs(basis) || shorten_by_sums(basis) {}
}

/// What counts as shorter: rounding must not make a reduction go round in circles.
const SHORTER: f64 = 1.0 - 1e-9;

fn shorten_by_pairs(basis: &mut [Vec4; 4]) -> bool {
    let mut shortened = false;
    for i in 0..4 {
        for j in (0..4).filter(|&j| j != i) {
            let m = (dot(basis[i], basis[j]) / dot(basis[j], basis[j])).round();
            let candidate = minus(basis[i], basis[j], m);
            if m.is_finite() && dot(candidate, candidate) < SHORTER * dot(basis[i], basis[i]) {
                basis[i] = candidate;
                shortened = true;
            }
        }
    }
    shortened
}

fn shorten_by_sums(basis: &mut [Vec4; 4]) -> bool {
    for code in 0..81u32 {
        let coefficients: Vec4 = std::array::from_fn(|k| f64::from(code / 3u32.pow(k as u32) % 3) - 1.0);
        let sum = (0..4).fold([0.0; 4], |sum, k| minus(sum, basis[k], -coefficients[k]));
        // Any vector of the sum may be replaced by it; the longest gains most.
        let longest = (0..4)
            .filter(|&k| coefficients[k] != 0.0)
            .max_by(|&a, &b| dot(basis[a], basis[a]).total_cmp(&dot(basis[b], basis[b])));
        if let Some(longest) = longest
            && dot(sum, sum) < SHORTER * dot(basis[longest], basis[longest])
        {
            basis[longest] = sum;
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells of 1/n in the first pair, stretched, and nothing asked of the second.
    fn planar(n: u64, aspect: f64) -> Vec4 {
        let side = (1.0 / n as f64).sqrt();
        [side / aspect.sqrt(), side * aspect.sqrt(), 1.0, 1.0]
    }

    /// The shortest wave by trying all of them in a box.
    fn by_trial(lattice: &Rank1Lattice, cell: Vec4, reach: i64) -> f64 {
        let side = || -reach..=reach;
        let mut shortest = f64::INFINITY;
        for (h0, h1) in side().flat_map(|a| side().map(move |b| (a, b))) {
            for (h2, h3) in side().flat_map(|a| side().map(move |b| (a, b))) {
                let h = [h0, h1, h2, h3];
                let phase: i64 = h.iter().zip(lattice.generator).map(|(h, g)| h * g as i64).sum();
                if h != [0; 4] && phase.rem_euclid(lattice.n as i64) == 0 {
                    let scaled: Vec4 = std::array::from_fn(|k| h[k] as f64 * cell[k]);
                    shortest = shortest.min(dot(scaled, scaled));
                }
            }
        }
        shortest
    }

    #[test]
    fn the_reduction_finds_the_shortest_wave() {
        for (n, g) in [(97, 5), (100, 37), (128, 45), (210, 11), (251, 33)] {
            for cell in [[0.3; 4], [0.2, 0.4, 0.1, 0.3], [0.1, 0.1, 1.0, 1.0]] {
                let lattice = Rank1Lattice::korobov(n, g);
                let (found, tried) = (lattice.shortest_wave(cell), by_trial(&lattice, cell, 16));
                assert!((found - tried).abs() < 1e-9, "n={n} g={g} {cell:?}: {found} against {tried}");
            }
        }
    }

    /// Where only the first pair matters, the best is the hexagonal lattice's 2/√3.
    #[test]
    fn planar_lattices_are_nearly_hexagonal_for_all_n_and_aspects() {
        for n in [500, 1000, 4096, 20_000, 20_011, 1_000_000] {
            for aspect in [0.1, 0.5, 1.0, 1.3, 7.0] {
                let length = Rank1Lattice::new(n, planar(n, aspect)).shortest_wave(planar(n, aspect));
                assert!(length > 0.9 && length < 1.16, "n={n} aspect={aspect}: {length}");
            }
        }
    }

    /// Every `parts`-th point is a point of the smaller lattice, moved by the first of them; both are nearly as good as
    /// lattices that are chosen for themselves.
    #[test]
    fn parts_of_a_lattice_are_lattices() {
        for (n, parts) in [(20_007u64, 9u64), (4_000, 4), (999, 3)] {
            let [cell, part_cell] = [n, n / parts].map(|n| planar(n, 1.3));
            let lattice = Rank1Lattice::in_parts(n, parts, cell, part_cell);
            let part = lattice.part(parts);
            for (c, k) in [(0, 5), (1, 0), (parts - 1, n / parts - 1)] {
                let [point, first, step] = [lattice.point(c + parts * k), lattice.point(c), part.point(k)];
                for ((x, from), by) in point.iter().zip(first).zip(step) {
                    let turns = x - from - by;
                    assert!((turns - turns.round()).abs() < 1e-9, "{n}, {c} + {parts} · {k}");
                }
            }
            let alone =
                [(n, cell), (n / parts, part_cell)].map(|(n, cell)| Rank1Lattice::new(n, cell).shortest_wave(cell));
            let found = [lattice.shortest_wave(cell), part.shortest_wave(part_cell)];
            assert!(found.iter().zip(alone).all(|(found, alone)| *found > 0.5 * alone), "{found:?} of {alone:?}");
        }
    }

    /// Hermite's constant bounds the shortest vector of a lattice of volume 1 in four dimensions by √2, squared.
    #[test]
    fn lattices_in_four_dimensions_come_near_hermites_bound() {
        for n in [1000u64, 20_011, 1_000_000] {
            for ratio in [1.0, 0.5, 0.3] {
                let n4 = (n as f64).powf(-0.25);
                let cell = [n4 * ratio, n4 * ratio, n4 / ratio, n4 / ratio];
                let length = Rank1Lattice::new(n, cell).shortest_wave(cell);
                assert!(length > 0.9 && length < 1.4143, "n={n} ratio={ratio}: {length}");
            }
        }
    }

    #[test]
    fn small_lattices_have_all_their_points() {
        for n in 1..20 {
            let lattice = Rank1Lattice::new(n, [0.5; 4]);
            assert!((0..n).all(|i| lattice.point(i).iter().all(|t| (0.0..1.0).contains(t))));
        }
    }
}
