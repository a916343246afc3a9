//! Which light: how many photons each emits, which one a surface point looks at.

use super::{Aim, Lights};
use crate::radiometry::Pmf;
use crate::scene::LightId;

/// A light chosen for next-event estimation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightChoice {
    pub light: LightId,
    pub pmf: Pmf,
    /// The number that chose, fit for reuse: uniform in [0, 1).
    pub reused: f64,
}

impl Lights {
    /// Shares `n` photons among the lights in proportion to the luminance of what each sends towards the aim.
    ///
    /// Every light that sends anything gets one at least, so the sum exceeds `n` where there are more lights than
    /// photons; a light that sends nothing gets none.
    pub fn allot(&self, n: u64, aim: &Aim) -> Vec<u64> {
        let shares: Vec<f64> = self.iter().map(|(_, light)| light.emitted_flux(aim).0.luminance()).collect();
        allot(n, &shares)
    }

    /// A light with a probability in proportion to its `pick_weights`; `None` if all are dark.
    pub fn pick(&self, u: f64) -> Option<LightChoice> {
        let s = self.picks.as_ref()?.sample(u);
        Some(LightChoice { light: LightId(s.index as u32), pmf: s.pmf, reused: s.reused })
    }

    /// The probability with which [`Lights::pick`] chooses `light`.
    pub fn pick_pmf(&self, light: LightId) -> Pmf {
        self.picks.as_ref().map_or(Pmf(0.0), |table| table.pmf(light.index()))
    }
}

/// How often shadow rays should look at each light: half by power, half evenly among all that shine. By power alone a
/// spot that lights what the camera sees is hardly looked at beside a sky that lights the whole scene.
pub(super) fn pick_weights(powers: &[f64]) -> Vec<f64> {
    let total: f64 = powers.iter().sum();
    let shining = powers.iter().filter(|&&power| power > 0.0).count() as f64;
    let weight = |&power: &f64| if power > 0.0 { 0.5 * power / total + 0.5 / shining } else { 0.0 };
    powers.iter().map(weight).collect()
}

/// Splits `n` in proportion to `shares` by largest remainders, ties to the earlier one; at least 1 for every positive
/// share, 0 for the others.
pub fn allot(n: u64, shares: &[f64]) -> Vec<u64> {
    let mut counts = vec![0u64; shares.len()];
    let mut open: Vec<usize> = (0..shares.len()).filter(|&i| shares[i] > 0.0 && shares[i].is_finite()).collect();
    let mut left = n;
    // Who is due less than one gets one; that lowers what is due to the others, so look again.
    loop {
        let total: f64 = open.iter().map(|&i| shares[i]).sum();
        let due = |i: usize| left as f64 * shares[i] / total;
        let small: Vec<usize> = open.iter().copied().filter(|&i| due(i) < 1.0).collect();
        if small.is_empty() {
            break;
        }
        for &i in &small {
            counts[i] = 1;
        }
        left = left.saturating_sub(small.len() as u64);
        open.retain(|i| !small.contains(i));
    }
    let total: f64 = open.iter().map(|&i| shares[i]).sum();
    let mut remainders: Vec<(usize, f64)> = Vec::with_capacity(open.len());
    let mut given = 0;
    for &i in &open {
        let due = left as f64 * shares[i] / total;
        counts[i] = due.floor() as u64;
        given += counts[i];
        remainders.push((i, due.fract()));
    }
    // A stable sort: equal remainders keep the order of lights.
    remainders.sort_by(|a, b| b.1.total_cmp(&a.1));
    for (i, _) in remainders.iter().cycle().take(left.saturating_sub(given) as usize) {
        counts[*i] += 1;
    }
    counts
}
