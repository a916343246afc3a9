//! Photons per second that become a map, its trees included: `cargo bench --bench map`. One thread.

#[path = "../support/mod.rs"]
mod support;

use divan::Bencher;
use divan::counter::ItemsCount;
use pdembree::photon::{PhotonCounts, PhotonHarvest};
use pdembree::scene::LightId;
use support::pass::{SCENES, Small, alone};

fn main() {
    divan::main();
}

#[divan::bench(args = SCENES, sample_count = 20)]
fn photons_20_000(bencher: Bencher, scene: &str) {
    build(bencher, &Small::of(scene));
}

#[divan::bench(args = SCENES, sample_count = 10)]
fn photons_200_000(bencher: Bencher, scene: &str) {
    build(bencher, &Small::with(scene, &[("render.photons", "200000")]));
}

fn build(bencher: Bencher, small: &Small) {
    let photons = small.maps().caustic.photons;
    let harvest = || {
        let mut harvest = PhotonHarvest::new(1);
        harvest.add(LightId(0), photons.clone(), &PhotonCounts::default());
        harvest
    };
    let bencher = bencher.counter(ItemsCount::new(photons.len())).with_inputs(harvest);
    bencher.bench_local_values(|harvest| alone(|| harvest.into_map()));
}
