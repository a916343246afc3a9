//! Complex indices of refraction of four metals, one number a colour channel.
//!
//! Each number is the plain mean over a third of the visible band, red 600–700 nm, green 500–600 nm, blue 400–500 nm, of
//! the published table joined by straight lines: gold, silver and copper by Johnson and Christy, aluminium by Rakić.
//! Reflectances at normal incidence stay within 0.08 of those that follow from full spectra and the Rec.709
//! primaries (the largest difference is gold's blue: 0.41 instead of 0.34, since gold lies outside that gamut).

// Tables: [JohnsonChristy72], [Rakic95].

/// A metal that a scene may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metal {
    Gold,
    Silver,
    Copper,
    Aluminium,
}

/// η + i k relative to vacuum; red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComplexIndex {
    pub eta: [f64; 3],
    pub k: [f64; 3],
}

impl Metal {
    pub const ALL: [Metal; 4] = [Metal::Gold, Metal::Silver, Metal::Copper, Metal::Aluminium];
    pub const NAMES: &'static [&'static str] = &["gold", "silver", "copper", "aluminium"];

    pub fn from_name(name: &str) -> Option<Metal> {
        Metal::NAMES.iter().position(|n| *n == name).map(|i| Metal::ALL[i])
    }

    pub const fn index(self) -> ComplexIndex {
        match self {
            Metal::Gold => ComplexIndex { eta: [0.168, 0.481, 1.338], k: [3.592, 2.464, 1.903] },
            Metal::Silver => ComplexIndex { eta: [0.052, 0.054, 0.046], k: [4.409, 3.583, 2.645] },
            Metal::Copper => ComplexIndex { eta: [0.265, 0.950, 1.252], k: [3.603, 2.651, 2.380] },
            Metal::Aluminium => ComplexIndex { eta: [1.569, 1.022, 0.639], k: [7.695, 6.624, 5.450] },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (wavelength in µm, n, k) of the visible band and its neighbours, as published.
    type Table = &'static [(f64, f64, f64)];

    const GOLD: Table = &[
        (0.3974, 1.47, 1.952),
        (0.4133, 1.46, 1.958),
        (0.4305, 1.45, 1.948),
        (0.4509, 1.38, 1.914),
        (0.4714, 1.31, 1.849),
        (0.4959, 1.04, 1.833),
        (0.5209, 0.62, 2.081),
        (0.5486, 0.43, 2.455),
        (0.5821, 0.29, 2.863),
        (0.6168, 0.21, 3.272),
        (0.6595, 0.14, 3.697),
        (0.7045, 0.13, 4.103),
    ];
    const SILVER: Table = &[
        (0.3974, 0.05, 2.070),
        (0.4133, 0.05, 2.275),
        (0.4305, 0.04, 2.462),
        (0.4509, 0.04, 2.657),
        (0.4714, 0.05, 2.869),
        (0.4959, 0.05, 3.093),
        (0.5209, 0.05, 3.324),
        (0.5486, 0.06, 3.586),
        (0.5821, 0.05, 3.858),
        (0.6168, 0.06, 4.152),
        (0.6595, 0.05, 4.483),
        (0.7045, 0.04, 4.838),
    ];
    const COPPER: Table = &[
        (0.3974, 1.32, 2.116),
        (0.4133, 1.28, 2.207),
        (0.4305, 1.25, 2.305),
        (0.4509, 1.24, 2.397),
        (0.4714, 1.25, 2.483),
        (0.4959, 1.22, 2.564),
        (0.5209, 1.18, 2.608),
        (0.5486, 1.02, 2.577),
        (0.5821, 0.70, 2.704),
        (0.6168, 0.30, 3.205),
        (0.6595, 0.22, 3.747),
        (0.7045, 0.21, 4.205),
    ];
    const ALUMINIUM: Table = &[
        (0.36466, 0.39877, 4.3957),
        (0.41328, 0.52135, 5.0008),
        (0.44280, 0.60790, 5.3676),
        (0.47687, 0.72780, 5.7781),
        (0.51660, 0.87340, 6.2418),
        (0.56357, 1.0728, 6.7839),
        (0.61993, 1.3660, 7.4052),
        (0.65225, 1.5724, 7.7354),
        (0.68881, 1.8301, 8.0601),
        (0.72932, 2.1606, 8.3565),
    ];

    fn table(metal: Metal) -> Table {
        match metal {
            Metal::Gold => GOLD,
            Metal::Silver => SILVER,
            Metal::Copper => COPPER,
            Metal::Aluminium => ALUMINIUM,
        }
    }

    /// Exact mean of the piecewise linear function through `points` over [a, b].
    fn mean(points: &[(f64, f64)], a: f64, b: f64) -> f64 {
        let area = |w: &[(f64, f64)]| {
            let ((x0, y0), (x1, y1)) = (w[0], w[1]);
            let (lo, hi) = (x0.max(a), x1.min(b));
            let at = |x: f64| y0 + (y1 - y0) * (x - x0) / (x1 - x0);
            if lo < hi { 0.5 * (at(lo) + at(hi)) * (hi - lo) } else { 0.0 }
        };
        points.windows(2).map(area).sum::<f64>() / (b - a)
    }

    /// Fresnel reflectance at normal incidence.
    fn f0(eta: f64, k: f64) -> f64 {
        ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k)
    }

    const BANDS: [(f64, f64); 3] = [(0.6, 0.7), (0.5, 0.6), (0.4, 0.5)];

    #[test]
    fn the_numbers_are_the_means_of_the_published_tables() {
        for metal in Metal::ALL {
            let (ns, ks): (Vec<_>, Vec<_>) = table(metal).iter().map(|&(w, n, k)| ((w, n), (w, k))).unzip();
            for (channel, (a, b)) in BANDS.into_iter().enumerate() {
                let index = metal.index();
                // The constants are written with three decimals.
                assert!((mean(&ns, a, b) - index.eta[channel]).abs() <= 0.0005 + 1e-9, "{metal:?} eta {channel}");
                assert!((mean(&ks, a, b) - index.k[channel]).abs() <= 0.0005 + 1e-9, "{metal:?} k {channel}");
            }
        }
    }

    #[test]
    fn reflectances_are_near_those_of_full_spectra_and_differ_as_stated() {
        // F0 in linear Rec.709 from full spectra, as renderers' tables for artists give them, and ours minus theirs.
        let expected = [
            (Metal::Gold, [1.00, 0.77, 0.34], [-0.047, -0.003, 0.071]),
            (Metal::Silver, [0.97, 0.96, 0.92], [0.020, 0.025, 0.057]),
            (Metal::Copper, [0.95, 0.64, 0.54], [-0.023, 0.009, -0.006]),
            (Metal::Aluminium, [0.91, 0.92, 0.92], [-0.005, -0.005, 0.001]),
        ];
        for (metal, spectral, difference) in expected {
            let index = metal.index();
            for c in 0..3 {
                let ours = f0(index.eta[c], index.k[c]);
                assert!((ours - spectral[c] - difference[c]).abs() < 0.001, "{metal:?} {c}: {ours} {}", spectral[c]);
                assert!(difference[c].abs() < 0.08);
            }
        }
    }

    #[test]
    fn every_name_finds_its_metal() {
        assert_eq!(Metal::from_name("aluminium"), Some(Metal::Aluminium));
        assert_eq!(Metal::from_name("unobtainium"), None);
        assert_eq!(Metal::ALL.len(), Metal::NAMES.len());
    }
}
