//! When a render will end, from what its phases took so far. Told all times from outside, in seconds since the start.

use std::collections::BTreeMap;

/// The part of a phase that has to be done before its pace is believed.
const BELIEVED: f64 = 0.05;

/// Watches the phases of a render of several passes.
#[derive(Clone, Debug, Default)]
pub struct Eta {
    /// Passes this run will add, as far as is known; a pass may be a fraction of what was begun elsewhere.
    passes: f64,
    /// No pass is begun after this.
    limit: Option<f64>,
    ended_passes: f64,
    pass_began: f64,
    /// Seconds of all passes ended here.
    in_passes: f64,
    phase: Option<Phase>,
    /// By name: seconds and how often, of the phases that ended.
    known: BTreeMap<String, (f64, u32)>,
    /// Phases of a pass, in order, as seen so far.
    of_pass: Vec<String>,
    ended_in_pass: usize,
}

#[derive(Clone, Debug)]
struct Phase {
    name: String,
    began: f64,
    done: f64,
}

impl Eta {
    /// `passes` are to come, until `limit` if there is one.
    pub fn expect(&mut self, passes: f64, limit: Option<f64>) {
        (self.passes, self.limit) = (passes, limit);
        // What came before is no part of a pass.
        self.of_pass.clear();
    }

    /// It turned out that so many passes will do.
    pub fn set_passes(&mut self, passes: f64) {
        self.passes = passes;
    }

    /// So many passes have ended in this run.
    pub fn passes_ended(&mut self, ended: f64, now: f64) {
        if ended > self.ended_passes {
            self.in_passes += now - self.pass_began;
        }
        (self.ended_passes, self.pass_began, self.ended_in_pass) = (ended, now, 0);
    }

    pub fn phase(&mut self, name: &str, now: f64) {
        self.phase = Some(Phase { name: name.to_owned(), began: now, done: 0.0 });
    }

    /// The phase under way is done to this part, from 0 to 1.
    pub fn advance(&mut self, done: f64) {
        if let Some(phase) = &mut self.phase {
            phase.done = done;
        }
    }

    pub fn finish(&mut self, now: f64) {
        let Some(phase) = self.phase.take() else { return };
        let known = self.known.entry(phase.name.clone()).or_default();
        *known = (known.0 + now - phase.began, known.1 + 1);
        self.ended_in_pass += 1;
        if self.of_pass.len() < self.ended_in_pass {
            self.of_pass.push(phase.name);
        }
    }

    /// Seconds from `now` to the end; none as long as something that is to come was never seen.
    pub fn left(&self, now: f64) -> Option<f64> {
        let pass = self.left_of_pass(now)?;
        let each =
            if self.ended_passes > 0.0 { self.in_passes / self.ended_passes } else { now + pass - self.pass_began };
        let more = (self.passes - self.ended_passes - 1.0).max(0.0) * each;
        let left = pass + more;
        // The pass under way at the limit is finished, unless it would not have been begun.
        Some(self.limit.map_or(left, |limit| left.min((limit - now).max(pass))))
    }

    fn left_of_pass(&self, now: f64) -> Option<f64> {
        if self.ended_passes >= self.passes {
            return Some(0.0);
        }
        let mean = |name: &String| self.known.get(name).map(|&(seconds, n)| seconds / f64::from(n));
        let under_way = match &self.phase {
            None => 0.0,
            Some(phase) if phase.done > BELIEVED => (now - phase.began) * (1.0 - phase.done) / phase.done,
            Some(phase) => (mean(&phase.name)? - (now - phase.began)).max(0.0),
        };
        let to_come = self.of_pass.iter().skip(self.ended_in_pass + usize::from(self.phase.is_some()));
        // In the first pass the last phase is not known to be the last; it is the longest, and the others are quick.
        to_come.map(mean).try_fold(under_way, |sum, seconds| Some(sum + seconds?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four passes of 1 s photons and 3 s picture: right from a twentieth of the first picture on.
    #[test]
    fn equal_passes_are_foretold() {
        let mut eta = Eta::default();
        eta.expect(4.0, None);
        for pass in 0..4 {
            let start = 4.0 * f64::from(pass);
            eta.phase("photons", start);
            eta.advance(0.5);
            if pass > 0 {
                assert!((eta.left(start + 0.5).expect("seen before") - (15.5 - start)).abs() < 1e-9);
            }
            eta.finish(start + 1.0);
            eta.phase("picture", start + 1.0);
            eta.advance(0.1);
            let left = eta.left(start + 1.3).expect("the pace is known");
            assert!((left - (14.7 - start)).abs() < 1e-9, "pass {pass}: {left}");
            eta.finish(start + 4.0);
            eta.passes_ended(f64::from(pass) + 1.0, start + 4.0);
        }
        assert_eq!(eta.left(16.0), Some(0.0));
    }

    #[test]
    fn a_time_limit_ends_it_and_nothing_is_said_too_early() {
        let mut eta = Eta::default();
        eta.expect(1e6, Some(60.0));
        eta.phase("photons", 0.0);
        assert_eq!(eta.left(0.1), None);
        eta.finish(1.0);
        eta.phase("picture", 1.0);
        eta.finish(5.0);
        eta.passes_ended(1.0, 5.0);
        assert_eq!(eta.left(5.0), Some(55.0));
    }
}
