//! Which light: how many photons each emits, which one a surface point looks at.

use super::bounds::{LightBounds, Receiver};
use super::tree::LightTree;
use super::{Aim, Lights};
use crate::radiometry::Pmf;
use crate::sampling::discrete::DiscreteTable;
use crate::scene::LightId;

/// So many lights that stand somewhere are chosen from a table; of more, each point looks at those near it.
const MOST_IN_TABLE: usize = 4;

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

    /// A light for shadow rays from a point: of few by their `pick_weights`, of many by what may arrive from each. `None` if
    /// all are dark.
    pub fn pick(&self, at: &Receiver, u: f64) -> Option<LightChoice> {
        Some(self.picks.as_ref()?.pick(at, u))
    }

    /// A light by its `pick_weights`, wherever its light is wanted; `None` if all are dark.
    pub fn pick_anywhere(&self, u: f64) -> Option<LightChoice> {
        Some(self.picks.as_ref()?.pick_from_table(u))
    }

    /// The probability with which [`Lights::pick`] chooses `light`.
    pub fn pick_pmf(&self, at: &Receiver, light: LightId) -> Pmf {
        self.picks.as_ref().map_or(Pmf(0.0), |picks| picks.pmf(at, light))
    }
}

/// What shadow rays choose from.
#[derive(Clone, Debug)]
pub(super) struct Picks {
    table: DiscreteTable,
    /// Where there are many.
    many: Option<Many>,
}

/// Lights in a tree, and evenly beside it each one without a place: infinitely far away, or moving.
#[derive(Clone, Debug)]
struct Many {
    tree: LightTree,
    others: Vec<LightId>,
}

impl Picks {
    /// Of lights with so much power, W, and their bounds, where they have any; `None` if all are dark.
    pub fn new(powers: &[f64], bounds: impl Fn(LightId) -> Option<LightBounds>) -> Option<Picks> {
        let table = DiscreteTable::new(&pick_weights(powers))?;
        let (mut placed, mut others) = (Vec::new(), Vec::new());
        for (light, _) in (0..).map(LightId).zip(powers).filter(|&(_, &power)| power > 0.0) {
            match bounds(light) {
                Some(bounds) => placed.push((light, bounds)),
                None => others.push(light),
            }
        }
        let is_many = placed.len() > MOST_IN_TABLE;
        let many = LightTree::new(placed).filter(|_| is_many).map(|tree| Many { tree, others });
        Some(Picks { table, many })
    }

    fn pick_from_table(&self, u: f64) -> LightChoice {
        let s = self.table.sample(u);
        LightChoice { light: LightId(s.index as u32), pmf: s.pmf, reused: s.reused }
    }

    fn pick(&self, at: &Receiver, u: f64) -> LightChoice {
        let Some(Many { tree, others }) = &self.many else { return self.pick_from_table(u) };
        let shares = (others.len() + 1) as f64;
        let share = (u * shares) as usize;
        let reused = u * shares - share as f64;
        match others.get(share) {
            Some(&light) => LightChoice { light, pmf: Pmf(1.0 / shares), reused },
            None => {
                let choice = tree.pick(at, reused);
                LightChoice { pmf: Pmf(choice.pmf.0 / shares), ..choice }
            }
        }
    }

    fn pmf(&self, at: &Receiver, light: LightId) -> Pmf {
        let Some(Many { tree, others }) = &self.many else { return self.table.pmf(light.index()) };
        let own = if others.contains(&light) { 1.0 } else { tree.pmf(at, light).0 };
        Pmf(own / (others.len() + 1) as f64)
    }
}

/// How often shadow rays should look at each light: half by power, half evenly among all that shine. By power alone a
/// spot that lights what the camera sees is hardly looked at beside a sky that lights the whole scene.
fn pick_weights(powers: &[f64]) -> Vec<f64> {
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
