//! A backend that writes down what it is asked.

use std::sync::{Arc, Mutex, PoisonError};

use super::{Backend, Query, RawHit};
use crate::math::Ray;

/// Queries in the order they were asked: all are counted, the first ones kept.
#[derive(Debug, Default)]
pub struct Recorded {
    /// Of first hits and of occlusion.
    kinds: [(u64, Vec<Ray>); 2],
    keep: usize,
}

impl Recorded {
    /// Queries of a kind so far, and the first of them.
    pub fn of(&self, query: Query) -> (u64, &[Ray]) {
        let (count, rays) = &self.kinds[query as usize];
        (*count, rays)
    }

    /// How many of first hits and of occlusion.
    pub fn counts(&self) -> [u64; 2] {
        [Query::Intersect, Query::Occluded].map(|query| self.of(query).0)
    }

    /// What was recorded so far; recording starts anew.
    pub fn take(&mut self) -> Recorded {
        let empty = Recorded { keep: self.keep, ..Recorded::default() };
        std::mem::replace(self, empty)
    }

    fn add(&mut self, query: Query, ray: &Ray) {
        let (count, rays) = &mut self.kinds[query as usize];
        *count += 1;
        if rays.len() < self.keep {
            rays.push(*ray);
        }
    }
}

/// Asks another backend and records the rays.
pub struct RecordingBackend {
    inner: Box<dyn Backend>,
    recorded: Arc<Mutex<Recorded>>,
}

impl RecordingBackend {
    /// Keeps at most `keep` rays of each kind.
    pub fn new(inner: Box<dyn Backend>, keep: usize) -> (RecordingBackend, Arc<Mutex<Recorded>>) {
        let recorded = Arc::new(Mutex::new(Recorded { keep, ..Recorded::default() }));
        (RecordingBackend { inner, recorded: recorded.clone() }, recorded)
    }

    fn record(&self, query: Query, ray: &Ray) {
        self.recorded.lock().unwrap_or_else(PoisonError::into_inner).add(query, ray);
    }
}

impl Backend for RecordingBackend {
    fn intersect(&self, ray: &Ray) -> Option<RawHit> {
        self.record(Query::Intersect, ray);
        self.inner.intersect(ray)
    }
    fn occluded(&self, ray: &Ray) -> bool {
        self.record(Query::Occluded, ray);
        self.inner.occluded(ray)
    }
    fn describe(&self) -> String {
        self.inner.describe()
    }
    fn invalid_rays(&self) -> u64 {
        self.inner.invalid_rays()
    }
}
