//! Structural similarity `[Wang04]` with its authors' window: Gaussian of σ = 1.5 pixels over 11 × 11, K₁ = 0.01,
//! K₂ = 0.03, L = 1, population covariances, mean over the positions where the whole window lies inside the picture.

/// Half the window; 2·5 + 1 pixels hold ±3.3 σ.
const RADIUS: usize = 5;
/// Pixels a side that a picture needs.
pub const WINDOW: usize = 2 * RADIUS + 1;
const SIGMA: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

fn window() -> [f64; WINDOW] {
    let weight = |i: usize| (-0.5 * ((i as f64 - RADIUS as f64) / SIGMA).powi(2)).exp();
    let weights: [f64; WINDOW] = std::array::from_fn(weight);
    let total: f64 = weights.iter().sum();
    weights.map(|w| w / total)
}

/// Weighted means over the windows that lie inside: (width − 10) × (height − 10) values.
fn filter(values: &[f64], width: usize, weights: &[f64; WINDOW]) -> Vec<f64> {
    let inner = width - 2 * RADIUS;
    let dot = |part: &[f64]| part.iter().zip(weights).map(|(v, w)| v * w).sum::<f64>();
    let rows: Vec<f64> = values.chunks_exact(width).flat_map(|row| row.windows(WINDOW).map(dot)).collect();
    let height = rows.len() / inner - 2 * RADIUS;
    let column = |i: usize| -> f64 { weights.iter().enumerate().map(|(k, w)| w * rows[i + k * inner]).sum() };
    (0..height * inner).map(column).collect()
}

/// Mean SSIM of two channels of `width` pixels a row, values in [0, 1], over the windows whose centre `mask` holds (all
/// without a mask); `None` if there are none, as where a side is shorter than [`WINDOW`].
pub fn ssim(a: &[f64], b: &[f64], width: usize, mask: Option<&[bool]>) -> Option<f64> {
    if width < WINDOW || a.len() / width < WINDOW {
        return None;
    }
    let weights = window();
    let product = |p: &[f64], q: &[f64]| p.iter().zip(q).map(|(x, y)| x * y).collect::<Vec<f64>>();
    let mean = |values: &[f64]| filter(values, width, &weights);
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (square_a, square_b, cross) = (mean(&product(a, a)), mean(&product(b, b)), mean(&product(a, b)));
    let at = |i: usize| {
        let (ma, mb) = (mean_a[i], mean_b[i]);
        let (var_a, var_b, cov) = (square_a[i] - ma * ma, square_b[i] - mb * mb, cross[i] - ma * mb);
        // [Wang04 (13)]
        (2.0 * ma * mb + C1) * (2.0 * cov + C2) / ((ma * ma + mb * mb + C1) * (var_a + var_b + C2))
    };
    let inner = width - 2 * RADIUS;
    let centre = |i: usize| (i / inner + RADIUS) * width + i % inner + RADIUS;
    let held: Vec<usize> = (0..mean_a.len()).filter(|&i| mask.is_none_or(|mask| mask[centre(i)])).collect();
    (!held.is_empty()).then(|| held.iter().map(|&i| at(i)).sum::<f64>() / held.len() as f64)
}
