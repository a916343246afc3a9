//! Samples per second that a film takes in, adds up and gives back: `cargo bench --bench film`. One thread.

#[path = "../support/mod.rs"]
mod support;

use divan::Bencher;
use divan::counter::ItemsCount;
use pdembree::film::Tile;
use support::pass::Small;

fn main() {
    divan::main();
}

/// 64 × 48 pixels of four samples.
fn small() -> Small {
    Small::of("cornell")
}

/// Samples go into tiles.
#[divan::bench]
fn add_samples(bencher: Bencher) {
    let small = small();
    let (film, seen) = (small.film(), small.seen());
    let all = || seen.iter().map(|seen| small.tile(&film, seen)).collect::<Vec<Tile>>();
    bencher.counter(ItemsCount::new(small.samples())).bench_local(all);
}

/// Tiles go into a film.
#[divan::bench]
fn add_tiles(bencher: Bencher) {
    let (small, film) = (small(), small().film());
    let tiles: Vec<Tile> = small.seen().iter().map(|seen| small.tile(&film, seen)).collect();
    let bencher = bencher.counter(ItemsCount::new(small.samples())).with_inputs(|| film.clone());
    bencher.bench_local_refs(|film| tiles.iter().enumerate().for_each(|(unit, tile)| film.add_tile(unit, tile)));
}

/// A film gets the passes of another.
#[divan::bench]
fn merge(bencher: Bencher) {
    let small = small();
    let film = small.developed(&small.seen());
    let bencher = bencher.counter(ItemsCount::new(small.samples())).with_inputs(|| film.clone());
    bencher.bench_local_refs(|sum| sum.add_passes(&film));
}

/// A film becomes a picture.
#[divan::bench]
fn resolve(bencher: Bencher) {
    let small = small();
    let film = small.developed(&small.seen());
    bencher.counter(ItemsCount::new(small.samples())).bench_local(|| film.resolve());
}
