//! The best bandwidth: a bracketed search over the logarithm of a parameter.
//!
//! An error as a function of the bandwidth falls while noise is smoothed away and rises where blur takes over. The
//! search steps outwards by factors of two until the best point has a worse one on both sides. From then on it looks
//! where the parabola through the best point and its two neighbours is lowest `[Brent73 5]`, and cuts a gap beside the
//! best point at the golden section where the parabola has nothing new to say. It ends with both gaps narrow and the
//! parabola's lowest place next to a point that is known. Everything that was looked at is kept: it is the curve.

use crate::study::results::CurvePoint;

/// Where the parameter may lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    pub low: f64,
    pub high: f64,
    /// Only whole numbers make sense.
    pub whole: bool,
}

/// Factor between the points of the first steps.
const STEP: f64 = 2.0;
/// 2 − φ: the smaller part of the golden section.
const GOLDEN: f64 = 0.381_966_011_250_105_1;
/// A parabola's lowest place is wrong by about a third of the square of its half width over ln x: the errors' curves are
/// about twice as skew as they are bent. It is trusted up to the width where that is half of the tolerance.
const TRUSTED: f64 = 1.5;
/// More evaluations than any curve needs; a noisy one must end, too.
const MAX_POINTS: usize = 60;

/// What the best bandwidth is best for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goal {
    /// Smallest RMSE.
    Rmse,
    /// Largest SSIM.
    Ssim,
}

impl Goal {
    /// Less is better; `None` where the metric does not exist.
    fn cost(self, point: &CurvePoint) -> Option<f64> {
        match self {
            Goal::Rmse => Some(point.rmse),
            Goal::Ssim => point.ssim.map(|ssim| -ssim),
        }
    }
}

/// The curve so far, in order of the bandwidth.
#[derive(Clone, Debug)]
pub struct Search {
    range: Range,
    /// Ratio to the best bandwidth that is near enough.
    tolerance: f64,
    points: Vec<CurvePoint>,
}

impl Search {
    /// A search that has looked nowhere yet; `tolerance` > 1.
    pub fn new(range: Range, tolerance: f64) -> Search {
        Search { range, tolerance, points: Vec::new() }
    }

    pub fn points(&self) -> &[CurvePoint] {
        &self.points
    }

    /// The best point for `goal` so far.
    pub fn best(&self, goal: Goal) -> Option<usize> {
        let cost = |i: usize| goal.cost(&self.points[i]);
        (0..self.points.len()).filter(|&i| cost(i).is_some()).min_by(|&a, &b| {
            let [a, b] = [a, b].map(|i| cost(i).unwrap_or(f64::INFINITY));
            a.total_cmp(&b)
        })
    }

    /// Whether a worse point lies on both sides of the best one.
    pub fn is_bracketed(&self, goal: Goal) -> bool {
        self.best(goal).is_some_and(|i| i > 0 && i + 1 < self.points.len())
    }

    /// Goes on, from `start` or from what is known, until the best bandwidth for `goal` is found. `look` evaluates one
    /// bandwidth.
    pub fn run<E>(
        &mut self,
        goal: Goal,
        start: f64,
        mut look: impl FnMut(f64) -> Result<CurvePoint, E>,
    ) -> Result<(), E> {
        let mut next = if self.points.is_empty() { Some(self.admissible(start)) } else { self.next(goal) };
        while let Some(bandwidth) = next.filter(|_| self.points.len() < MAX_POINTS) {
            let point = look(bandwidth)?;
            let place = self.points.partition_point(|p| p.bandwidth < bandwidth);
            self.points.insert(place, CurvePoint { bandwidth, ..point });
            next = self.next(goal);
        }
        Ok(())
    }

    /// The bandwidth to look at next, `None` when done.
    fn next(&self, goal: Goal) -> Option<f64> {
        let best = self.best(goal)?;
        let x = self.points[best].bandwidth;
        let below = best.checked_sub(1).map(|i| self.points[i].bandwidth);
        let above = self.points.get(best + 1).map(|p| p.bandwidth);
        let outwards = match (below, above) {
            (None, _) if x > self.range.low => Some(x / STEP),
            (_, None) if x < self.range.high => Some(x * STEP),
            _ => None,
        };
        if let Some(next) = outwards {
            return Some(self.admissible(next));
        }
        let known = |next: f64| self.points.iter().any(|p| (p.bandwidth / next).ln().abs() < 0.5 * self.tolerance.ln());
        if let Some(vertex) = self.vertex(goal, best).map(|v| self.admissible(v)).filter(|&v| !known(v)) {
            return Some(vertex);
        }
        let gaps = [below, above].map(|neighbour| neighbour.map_or(0.0, |n| (n / x).ln()));
        let wider = if gaps[0].abs() > gaps[1].abs() { gaps[0] } else { gaps[1] };
        if wider.abs() <= (TRUSTED * self.tolerance.ln()).sqrt() {
            return None;
        }
        let next = self.admissible(x * (GOLDEN * wider).exp());
        // Between neighbouring whole numbers there is nothing.
        self.points.iter().all(|p| p.bandwidth != next).then_some(next)
    }

    /// Where the parabola through the best point and its neighbours, over ln x, is lowest; `None` at an end of the range
    /// and where the three are level.
    fn vertex(&self, goal: Goal, best: usize) -> Option<f64> {
        let at = |i: usize| {
            let p = self.points.get(i)?;
            Some((p.bandwidth.ln(), goal.cost(p)?))
        };
        let [(xa, ya), (x, y), (xb, yb)] = [at(best.checked_sub(1)?)?, at(best)?, at(best + 1)?];
        let (left, right) = ((x - xa) * (yb - y), (xb - x) * (ya - y));
        let bend = left + right;
        (bend > 0.0).then(|| (x + 0.5 * ((xb - x) * right - (x - xa) * left) / bend).exp())
    }

    fn admissible(&self, x: f64) -> f64 {
        let x = x.clamp(self.range.low, self.range.high);
        if self.range.whole { x.round() } else { x }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    const RANGE: Range = Range { low: 0.01, high: 1e4, whole: false };

    fn point(rmse: f64, ssim: f64) -> CurvePoint {
        CurvePoint { bandwidth: 0.0, rmse, ssim: Some(ssim) }
    }

    /// √(noise²/x² + blur² x⁴): what theory says of an estimate, least at x⁶ = noise²/(2 blur²).
    fn curve(best: f64, x: f64) -> f64 {
        let t = x / best;
        (2.0 / (t * t) + t.powi(4)).sqrt()
    }

    fn found(range: Range, tolerance: f64, start: f64, best: f64) -> (f64, usize) {
        let mut search = Search::new(range, tolerance);
        let look = |x| Ok::<_, Infallible>(point(curve(best, x), 0.5));
        let Ok(()) = search.run(Goal::Rmse, start, look);
        let i = search.best(Goal::Rmse).expect("a best point");
        (search.points()[i].bandwidth, search.points().len())
    }

    /// The known minimum is found within the tolerance, from starts on both sides of it, however narrow the tolerance.
    #[test]
    fn the_known_minimum_is_found_within_the_tolerance() {
        for best in [0.3, 4.0, 70.0, 333.3] {
            for start in [0.05, 1.0, 50.0, 2000.0] {
                for tolerance in [1.1, 1.05, 1.01, 1.001] {
                    let (x, looked) = found(RANGE, tolerance, start, best);
                    assert!((x / best).ln().abs() <= tolerance.ln(), "best {best}, start {start}: {x}");
                    let outwards = (best / start).log2().abs() + 3.0;
                    assert!((looked as f64) <= outwards + 14.0, "{looked} points for {tolerance}");
                }
            }
        }
    }

    /// At the tolerance of a study the error at the point that is found is within 0.5 % of the least one, and few points
    /// were looked at.
    #[test]
    fn near_the_minimum_the_error_is_flat() {
        for best in [0.3, 4.0, 70.0, 333.3, 91.7] {
            let (x, looked) = found(RANGE, 1.05, 20.0, best);
            assert!(curve(best, x) / curve(best, best) < 1.005, "best {best}: {x}");
            assert!(looked <= 15, "{looked} points");
        }
    }

    /// A corner is no parabola: the golden section still closes in on it.
    #[test]
    fn a_corner_is_found_within_the_trusted_gap() {
        for best in [0.3, 4.0, 70.0, 333.3, 91.7] {
            for skew in [0.2, 1.0, 5.0] {
                let mut search = Search::new(RANGE, 1.05);
                let corner = |x: f64| {
                    let t = (x / best).ln();
                    if t < 0.0 { -t } else { skew * t }
                };
                let Ok(()) = search.run(Goal::Rmse, 20.0, |x| Ok::<_, Infallible>(point(corner(x), 0.5)));
                let x = search.points()[search.best(Goal::Rmse).expect("a best point")].bandwidth;
                assert!((x / best).ln().abs() <= (TRUSTED * 1.05f64.ln()).sqrt(), "best {best}, skew {skew}: {x}");
            }
        }
    }

    #[test]
    fn whole_numbers_are_searched_to_the_last_one() {
        let range = Range { low: 2.0, high: 500.0, whole: true };
        for best in [3.0, 17.0, 240.0] {
            let (x, _) = found(range, 1.0001, 70.0, best);
            assert_eq!(x, best);
        }
    }

    #[test]
    fn a_minimum_at_the_end_of_the_range_is_told() {
        let mut search = Search::new(Range { low: 1.0, high: 8.0, whole: false }, 1.1);
        let Ok(()) = search.run(Goal::Rmse, 4.0, |x| Ok::<_, Infallible>(point(1.0 / x, 0.0)));
        let best = search.best(Goal::Rmse).expect("a best point");
        assert_eq!(search.points()[best].bandwidth, 8.0);
        assert!(!search.is_bracketed(Goal::Rmse));
    }

    /// Both goals share what was looked at, each ends at its own best.
    #[test]
    fn two_goals_share_one_curve() {
        let mut search = Search::new(RANGE, 1.2);
        let look = |x| Ok::<_, Infallible>(point(curve(5.0, x), -curve(11.0, x)));
        let Ok(()) = search.run(Goal::Rmse, 6.0, look);
        let Ok(()) = search.run(Goal::Ssim, 6.0, look);
        let at = |goal| search.points()[search.best(goal).expect("a best point")].bandwidth;
        assert!((at(Goal::Rmse) / 5.0).ln().abs() < 1.2f64.ln() && (at(Goal::Ssim) / 11.0).ln().abs() < 1.2f64.ln());
        assert!(search.points().is_sorted_by(|a, b| a.bandwidth < b.bandwidth));
    }

    /// A curve that is level, and one that is pure noise, come to an end.
    #[test]
    fn odd_curves_end() {
        let mut search = Search::new(RANGE, 1.0001);
        let Ok(()) = search.run(Goal::Rmse, 1.0, |_| Ok::<_, Infallible>(point(1.0, 0.0)));
        let Ok(()) = search.run(Goal::Ssim, 1.0, |x: f64| Ok::<_, Infallible>(point(1.0, (1e6 * x).sin())));
        assert!(search.points().len() <= MAX_POINTS);
    }

    #[test]
    fn an_error_of_the_evaluation_ends_the_search() {
        let mut search = Search::new(RANGE, 1.1);
        let result = search.run(Goal::Rmse, 1.0, |x| if x < 0.7 { Err("stop") } else { Ok(point(1.0, 0.0)) });
        assert_eq!(result, Err("stop"));
    }
}
