//! Eye paths per second, the film's sums included: `cargo bench --bench path`. One thread.

#[path = "../support/mod.rs"]
mod support;

use divan::Bencher;
use divan::counter::ItemsCount;
use pdembree::render::partition::EyeFinds;
use support::pass::{SCENES, Small, alone};

fn main() {
    divan::main();
}

/// The path tracer.
#[divan::bench(args = SCENES, sample_count = 10)]
fn everything(bencher: Bencher, scene: &str) {
    expose(bencher, scene, EyeFinds::Everything);
}

/// The photon map's part of the light is left to it.
#[divan::bench(args = SCENES, sample_count = 10)]
fn all_but_caustics(bencher: Bencher, scene: &str) {
    expose(bencher, scene, EyeFinds::AllButFocused);
}

fn expose(bencher: Bencher, scene: &str, finds: EyeFinds) {
    let small = Small::of(scene);
    bencher.counter(ItemsCount::new(small.samples())).bench_local(|| alone(|| small.expose(finds, None)));
}
