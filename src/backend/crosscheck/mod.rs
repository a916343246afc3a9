//! Two backends asked the same questions, every disagreement explained or not.
//!
//! World frame, metres. The rules, in the order in which they are tried on a ray whose answers differ:
//!
//! | class | when | explained |
//! | --- | --- | --- |
//! | `tie` | both hit, ids differ, the two t lie within the sum of their bounds: a shared edge, or coplanar surfaces | yes |
//! | `edge` | one backend has a hit that the other lacks, and the ray passes that triangle's outline within the rounding of an f32 backend | yes |
//! | `interval_end` | the same, and the hit's t lies within its bound of t_min or t_max | yes |
//! | `t_beyond`, `uv_beyond` | the same primitive, but t or (u, v) differ by more than their bounds | no |
//! | `unexplained` | anything else, also a reported hit that the f64 judge does not find | no |
//!
//! The bounds are those of [`judge`]; hits on exact shapes come from one f64 function in every backend and get none.

pub mod judge;
pub mod report;

use judge::Verdict;
pub use report::{Class, Counts, Example, RayBits, Report, Worst};
use serde::{Deserialize, Serialize};

use super::{Backend, Geometry, RawHit, is_valid};
use crate::math::Ray;

/// What a ray is for, which decides what is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RayKind {
    /// First hit, from the camera.
    Camera,
    /// Whether anything is hit.
    Shadow,
    /// First hit, from a light or a scattering event.
    Photon,
}

/// One question.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    pub ray: Ray,
    pub kind: RayKind,
}

/// Two backends over one geometry.
#[derive(Clone, Copy)]
pub struct Crosscheck<'a> {
    pub geometry: &'a Geometry,
    pub a: &'a dyn Backend,
    pub b: &'a dyn Backend,
}

/// What became of one comparison: a class, or agreement, and how far apart the same primitive's hits were.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Comparison {
    pub class: Option<Class>,
    pub worst: Worst,
}

impl Crosscheck<'_> {
    /// Asks both backends all of `queries`. `first_index` is the number of the first query in the whole run, for the
    /// examples. A pure function: units may run in any order and are merged in theirs.
    pub fn compare(&self, first_index: u64, queries: &[Query]) -> Report {
        let mut report = Report::default();
        for (index, query) in (first_index..).zip(queries) {
            let counts = report.counts_mut(query.kind);
            counts.rays += 1;
            if !is_valid(&query.ray) {
                counts.refused += 1;
            }
            match query.kind {
                RayKind::Shadow => self.compare_any(index, &query.ray, &mut report),
                RayKind::Camera | RayKind::Photon => self.compare_first(index, query, &mut report),
            }
        }
        report
    }

    fn compare_first(&self, index: u64, query: &Query, report: &mut Report) {
        let (a, b) = (self.a.intersect(&query.ray), self.b.intersect(&query.ray));
        let counts = report.counts_mut(query.kind);
        counts.hits += u64::from(a.is_some() || b.is_some());
        let comparison = self.judge_first(&query.ray, a, b);
        report.worst.merge(&comparison.worst);
        if let Some(class) = comparison.class {
            report.add(Example::new(index, query, class, a, b));
        }
    }

    fn compare_any(&self, index: u64, ray: &Ray, report: &mut Report) {
        let (any_a, any_b) = (self.a.occluded(ray), self.b.occluded(ray));
        report.shadow.hits += u64::from(any_a || any_b);
        if any_a == any_b {
            return;
        }
        // The occluders are looked for as first hits. A backend that contradicts itself is not excused by the other.
        let (a, b) = (self.a.intersect(ray), self.b.intersect(ray));
        let seen = [a, b].into_iter().flatten().min_by(|x, y| x.t.total_cmp(&y.t));
        let class = seen.map_or(Class::Unexplained, |hit| absence(ray, &hit, &self.verdict(ray, &hit)));
        report.add(Example::new(index, &Query { ray: *ray, kind: RayKind::Shadow }, class, a, b));
    }

    fn verdict(&self, ray: &Ray, hit: &RawHit) -> Verdict {
        judge::verdict(self.geometry, ray, hit)
    }

    /// Compares two answers to one ray.
    pub fn judge_first(&self, ray: &Ray, a: Option<RawHit>, b: Option<RawHit>) -> Comparison {
        let class_only = |class| Comparison { class: Some(class), worst: Worst::default() };
        let (a, b) = match (a, b) {
            (None, None) => return Comparison::default(),
            (Some(hit), None) | (None, Some(hit)) => return class_only(absence(ray, &hit, &self.verdict(ray, &hit))),
            (Some(a), Some(b)) => (a, b),
        };
        let (of_a, of_b) = (self.verdict(ray, &a), self.verdict(ray, &b));
        if (a.object, a.primitive) == (b.object, b.primitive) {
            return same_primitive(&a, &b, &of_a);
        }
        let (near, far) = if a.t <= b.t { ((&a, &of_a), (&b, &of_b)) } else { ((&b, &of_b), (&a, &of_a)) };
        if !far.1.confirms(far.0) {
            return class_only(Class::Unexplained);
        }
        if near.1.confirms(near.0) && (a.t - b.t).abs() <= of_a.t_bound + of_b.t_bound {
            return class_only(Class::Tie);
        }
        class_only(absence(ray, near.0, near.1))
    }
}

/// Why a backend may lack `hit`.
fn absence(ray: &Ray, hit: &RawHit, verdict: &Verdict) -> Class {
    if !verdict.confirms(hit) {
        return Class::Unexplained;
    }
    if verdict.is_marginal() {
        return Class::Edge;
    }
    let at_end = |end: f64| (hit.t - end).abs() <= verdict.t_bound;
    if at_end(ray.t_min) || at_end(ray.t_max) { Class::IntervalEnd } else { Class::Unexplained }
}

fn same_primitive(a: &RawHit, b: &RawHit, verdict: &Verdict) -> Comparison {
    let t = (a.t - b.t).abs();
    let uv = (a.uv[0] - b.uv[0]).abs().max((a.uv[1] - b.uv[1]).abs());
    let scale = a.t.abs().max(b.t.abs());
    // Two f32 answers may err to opposite sides.
    let (t_bound, uv_bound) = (2.0 * verdict.t_bound, 2.0 * verdict.uv_bound);
    let worst = Worst {
        // Nearer to the origin than its own rounding a hit has no relative precision.
        relative_t: if scale > t_bound { t / scale } else { 0.0 },
        t_of_bound: of_bound(t, t_bound),
        uv,
        uv_of_bound: of_bound(uv, uv_bound),
    };
    // Written so that a NaN is beyond.
    let class = match (t <= t_bound, uv <= uv_bound) {
        (false, _) => Some(Class::TBeyond),
        (true, false) => Some(Class::UvBeyond),
        (true, true) => None,
    };
    Comparison { class, worst }
}

fn of_bound(difference: f64, bound: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { difference / bound }
}
