//! Rays per second of each backend on a bumpy closed mesh: `cargo bench --bench rays`.
//!
//! Camera-like rays are coherent and start outside; bounced rays start on the surface in random directions. One thread.

#[path = "../support/mod.rs"]
mod support;

use divan::Bencher;
use divan::counter::ItemsCount;
use pdembree::backend::{Backend, build};
use pdembree::math::{Dir3, Point3, Ray, Transform, Vec3};
use pdembree::scene::TriangleMesh;
use pdembree::scene::settings::BackendKind;
use support::scene::scene;
use support::worlds::{Numbers, icosphere, mesh, placed};

/// Tests every primitive, so it gets the small mesh only.
const ALL: &[BackendKind] = &[
    #[cfg(feature = "embree")]
    BackendKind::Embree,
    BackendKind::Obvhs,
    BackendKind::Brute,
];
const TREES: &[BackendKind] = &[
    #[cfg(feature = "embree")]
    BackendKind::Embree,
    BackendKind::Obvhs,
];

fn main() {
    divan::main();
}

/// A sphere with bumps, 20 · 4^level triangles.
fn bumpy(level: u32) -> TriangleMesh {
    let sphere = icosphere(level);
    let bump = |p: [f32; 3]| p.map(|x| x * (1.0 + 0.1 * (9.0 * p[0]).sin() * (7.0 * p[1]).sin() * (8.0 * p[2]).cos()));
    mesh(sphere.positions.into_iter().map(bump).collect(), sphere.triangles)
}

fn backend(kind: BackendKind, level: u32) -> Box<dyn Backend> {
    let scene = scene(vec![placed(0, Transform::IDENTITY)], vec![bumpy(level)]);
    build(kind, &scene).expect("a sound scene and a compiled backend")
}

fn camera_rays(side: u32) -> Vec<Ray> {
    let eye = Point3::new(0.0, 0.0, 4.0);
    let at = |i: u32| 2.0 * (f64::from(i) + 0.5) / f64::from(side) - 1.0;
    let towards = |x, y| Dir3::new(Vec3::new(0.3 * x, 0.3 * y, -1.0)).expect("it points forward");
    (0..side * side).map(|i| Ray::new(eye, towards(at(i % side), at(i / side)))).collect()
}

fn bounced_rays(count: usize, level: u32) -> Vec<Ray> {
    let (surface, mut numbers) = (bumpy(level), Numbers::new(1));
    let mut ray = || {
        let [a, b, c] = surface.corners(numbers.index(surface.triangles.len()) as u32).map(Point3::to_vec);
        let origin = Point3::from_vec((a + b + c) / 3.0);
        Ray { t_min: 1e-6, ..Ray::new(origin, numbers.direction()) }
    };
    (0..count).map(|_| ray()).collect()
}

fn run(bencher: Bencher, backend: &dyn Backend, rays: &[Ray]) {
    let hits = || rays.iter().filter(|ray| backend.intersect(ray).is_some()).count();
    bencher.counter(ItemsCount::new(rays.len())).bench_local(hits);
}

#[divan::bench(args = TREES, sample_count = 20)]
fn camera_330_000_triangles(bencher: Bencher, kind: &BackendKind) {
    run(bencher, &*backend(*kind, 7), &camera_rays(200));
}

#[divan::bench(args = TREES, sample_count = 20)]
fn bounced_330_000_triangles(bencher: Bencher, kind: &BackendKind) {
    run(bencher, &*backend(*kind, 7), &bounced_rays(40_000, 7));
}

#[divan::bench(args = TREES, sample_count = 20)]
fn shadow_330_000_triangles(bencher: Bencher, kind: &BackendKind) {
    let (backend, rays) = (backend(*kind, 7), bounced_rays(40_000, 7));
    let any = || rays.iter().filter(|ray| backend.occluded(ray)).count();
    bencher.counter(ItemsCount::new(rays.len())).bench_local(any);
}

#[divan::bench(args = ALL, sample_count = 10)]
fn bounced_1_280_triangles(bencher: Bencher, kind: &BackendKind) {
    run(bencher, &*backend(*kind, 3), &bounced_rays(2000, 3));
}
