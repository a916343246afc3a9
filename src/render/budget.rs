//! When a render has enough passes.

use std::time::Duration;

use super::RenderState;

/// Passes that the error is not believed before: of fewer, their variance says little.
pub const PASSES_FOR_ERROR: u32 = 8;

/// Passes that a render has at most, whatever it waits for: it always ends.
pub const MAX_PASSES: u32 = 1 << 20;

/// What ends a render: the first of these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// One after the number of the last pass.
    pub end: u32,
    /// Wall-clock time of this program's work on it. A pass that would probably end later is not begun.
    pub time: Option<Duration>,
    /// [`crate::film::Noise::relative`] of the picture.
    pub error: Option<f64>,
}

impl Budget {
    /// So many passes.
    pub fn passes(end: u32) -> Budget {
        Budget { end, time: None, error: None }
    }

    /// Whether another pass is wanted, after `elapsed` and `ended` passes in this program. The first one always is.
    pub fn wants_more(&self, state: &RenderState, elapsed: Duration, ended: u32) -> bool {
        if state.film.pass() >= self.end {
            return false;
        }
        if state.film.passes() == 0 {
            return true;
        }
        let in_time = self.time.is_none_or(|limit| {
            // Half a pass late is as good as half a pass early.
            let pass = elapsed / ended.max(1);
            elapsed + if ended == 0 { Duration::ZERO } else { pass / 2 } < limit
        });
        in_time && !self.is_good_enough(state)
    }

    /// Whether the wanted error is reached.
    pub fn is_good_enough(&self, state: &RenderState) -> bool {
        self.error.is_some_and(|wanted| {
            let noise = state.film.noise().filter(|noise| noise.passes >= PASSES_FOR_ERROR);
            noise.is_some_and(|noise| noise.relative <= wanted)
        })
    }

    /// Passes that will probably reach the wanted error, which falls like their number^(−1/2) as long as noise is most of
    /// it.
    pub fn enough(&self, state: &RenderState) -> Option<u32> {
        let (wanted, noise) = (self.error?, state.film.noise()?);
        let passes = f64::from(noise.passes) * (noise.relative / wanted).powi(2);
        Some((passes.ceil() as u32).clamp(PASSES_FOR_ERROR, MAX_PASSES))
    }
}
