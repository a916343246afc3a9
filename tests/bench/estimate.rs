//! Points per second that get their light from photons, tile by tile: `cargo bench --bench estimate`. One thread.

#[path = "../support/mod.rs"]
mod support;

use divan::Bencher;
use divan::counter::ItemsCount;
use support::pass::{SCENES, Seen, Small, alone};

fn main() {
    divan::main();
}

/// The photons' own footprints.
#[divan::bench(args = SCENES, sample_count = 10)]
fn footprints(bencher: Bencher, scene: &str) {
    gather(bencher, &Small::of(scene));
}

/// The points that the eye sees alone, without those behind a diffuse bounce.
#[divan::bench(args = SCENES, sample_count = 10)]
fn footprints_seen_at_once(bencher: Bencher, scene: &str) {
    gather(bencher, &Small::with(scene, &[("render.max_bounces", "0")]));
}

/// The k nearest photons.
#[divan::bench(args = SCENES, sample_count = 10)]
fn nearest(bencher: Bencher, scene: &str) {
    gather(bencher, &Small::with(scene, &[("render.estimator", "knn")]));
}

fn gather(bencher: Bencher, small: &Small) {
    let (maps, seen) = (small.maps(), small.seen());
    let light = small.light(&maps);
    let points: usize = seen.iter().map(|tile| tile.queries.len()).sum();
    let tile = |tile: &Seen| {
        let mut samples = tile.samples.clone();
        light.add(&tile.queries, &tile.owners, &mut samples);
        samples.len()
    };
    let all = || seen.iter().map(tile).sum::<usize>();
    bencher.counter(ItemsCount::new(points)).bench_local(|| alone(all));
}
