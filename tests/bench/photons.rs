//! Photons emitted and traced per second: `cargo bench --bench photons`. One thread.

#[path = "../support/mod.rs"]
mod support;

use divan::Bencher;
use divan::counter::ItemsCount;
use pdembree::render::emission;
use support::pass::{SCENES, Small, alone};

fn main() {
    divan::main();
}

/// Before the first pass: where photons are of use, and how many each light sends.
#[divan::bench(args = SCENES, sample_count = 10)]
fn pilots(bencher: Bencher, scene: &str) {
    let small = Small::of(scene);
    bencher.bench_local(|| alone(|| emission::plan(&small.world)));
}

#[divan::bench(args = SCENES, sample_count = 10)]
fn guided(bencher: Bencher, scene: &str) {
    trace(bencher, &Small::of(scene));
}

#[divan::bench(args = SCENES, sample_count = 10)]
fn unguided(bencher: Bencher, scene: &str) {
    trace(bencher, &Small::with(scene, &[("render.guiding", "off")]));
}

fn trace(bencher: Bencher, small: &Small) {
    let plans = emission::plan(&small.world);
    let of_both = small.maps().map(|map| map.counts.photons_emitted);
    let emitted = of_both.caustic + of_both.bounced;
    bencher.counter(ItemsCount::new(emitted)).bench_local(|| alone(|| small.harvest(&plans)));
}
