//! Many queries in a row, laid out beforehand: what the library alone costs.

use std::time::{Duration, Instant};

use crate::query::Ray;
use crate::raw;
use crate::scene::CommittedScene;

/// Which query is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// The first hit.
    Intersect,
    /// Whether there is one.
    Occluded,
}

impl CommittedScene {
    /// How long the library takes to answer for all `rays` one after the other, without what is done before and after a
    /// query; rays that cannot be traced are left out.
    pub fn time(&self, query: Query, rays: &[Ray]) -> Duration {
        let mut laid_out: Vec<(raw::PdeRayHit, raw::PdeRecord)> =
            rays.iter().filter(|ray| ray.can_hit()).map(|ray| ray.laid_out(query, self.interval())).collect();
        let start = Instant::now();
        for (rayhit, record) in &mut laid_out {
            match query {
                // SAFETY: as in `CommittedScene::intersect`: the scene is committed and alive, the ray was validated, and
                // the record outlives the call.
                Query::Intersect => unsafe { raw::pde_intersect1(self.raw(), rayhit, record) },
                // SAFETY: as above; an occlusion query touches only the ray part.
                Query::Occluded => unsafe { raw::pde_occluded1(self.raw(), rayhit, record) },
            }
        }
        start.elapsed()
    }
}
