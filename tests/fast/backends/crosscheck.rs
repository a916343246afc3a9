//! The cross-check finds what is wrong, and explains only what rounding does.

use std::sync::Arc;

use pdembree::backend::crosscheck::{Class, Crosscheck, Query, RayKind, Report};
use pdembree::backend::{Backend, BruteBackend, Geometry, RawHit};
use pdembree::math::{Dir3, Point3, Ray, Transform, Vec3};
use pdembree::scene::ObjectId;

use super::{all_worlds, backends};
use crate::support::scene::scene;
use crate::support::worlds::{icosphere, mesh, placed, rays};

fn queries(seed: u64, count: usize) -> Vec<Query> {
    let kinds = [RayKind::Camera, RayKind::Shadow, RayKind::Photon];
    rays(seed, count, 2.0).into_iter().zip(kinds.into_iter().cycle()).map(|(ray, kind)| Query { ray, kind }).collect()
}

#[test]
fn every_backend_is_brute_up_to_explained_rounding() {
    for (name, scene) in all_worlds() {
        let geometry = Arc::new(Geometry::new(&scene).expect("a sound scene"));
        let judge = BruteBackend::new(geometry.clone());
        for backend in backends(&scene) {
            let queries = queries(31, 3000);
            let report = Crosscheck { geometry: &geometry, a: &judge, b: &*backend }.compare(0, &queries);
            let total = report.total();
            assert_eq!(total.not_explained(), 0, "{name}, {}: {report:#?}", backend.describe());
            assert!(total.hits > 200 || name == "nothing", "{name}: only {} hits", total.hits);
            // Shapes are tested in f64 by every backend, and the pure-Rust ones test triangles in f64 too.
            let exact = scene.meshes.is_empty() || !backend.describe().starts_with("Embree");
            assert!(!exact || total.disagreements() == 0, "{name}, {}: {report:#?}", backend.describe());
            assert!(!exact || report.worst == Default::default(), "{name}, {}: {report:#?}", backend.describe());
        }
    }
}

/// A backend whose answers are bent.
struct Liar<F> {
    honest: BruteBackend,
    bend: F,
}

impl<F: Fn(Option<RawHit>) -> Option<RawHit> + Send + Sync> Backend for Liar<F> {
    fn intersect(&self, ray: &Ray) -> Option<RawHit> {
        (self.bend)(self.honest.intersect(ray))
    }
    fn occluded(&self, ray: &Ray) -> bool {
        self.intersect(ray).is_some()
    }
    fn describe(&self) -> String {
        "liar".into()
    }
    fn invalid_rays(&self) -> u64 {
        0
    }
}

/// What the cross-check makes of an honest and a lying backend over two spheres.
fn accuse(bend: impl Fn(Option<RawHit>) -> Option<RawHit> + Send + Sync) -> Report {
    let apart = placed(0, Transform::translate(Vec3::X * 0.7));
    let scene = scene(vec![placed(0, Transform::IDENTITY), apart], vec![icosphere(1)]);
    let geometry = Arc::new(Geometry::new(&scene).expect("a sound scene"));
    let honest = || BruteBackend::new(geometry.clone());
    let liar = Liar { honest: honest(), bend };
    Crosscheck { geometry: &geometry, a: &honest(), b: &liar }.compare(0, &queries(32, 3000))
}

#[test]
fn lies_are_not_explained() {
    let share = |report: &Report| {
        let total = report.total();
        total.not_explained() as f64 / total.hits as f64
    };
    let misses = accuse(|_| None);
    assert!(share(&misses) > 0.99, "{misses:#?}");
    let far = accuse(|hit| hit.map(|h| RawHit { t: h.t * 1.001, ..h }));
    assert!(far.camera.t_beyond + far.photon.t_beyond > 400, "{far:#?}");
    let turned = accuse(|hit| hit.map(|h| RawHit { uv: [h.uv[1], h.uv[0]], ..h }));
    assert!(turned.camera.uv_beyond + turned.photon.uv_beyond > 400, "{turned:#?}");
    let other = accuse(|hit| hit.map(|h| RawHit { object: ObjectId(1 - h.object.0), ..h }));
    assert!(other.camera.unexplained + other.photon.unexplained > 400, "{other:#?}");
    let nowhere = accuse(|hit| hit.map(|h| RawHit { primitive: 1_000_000, ..h }));
    assert!(nowhere.camera.unexplained + nowhere.photon.unexplained > 400, "{nowhere:#?}");
    let invented = accuse(|hit| hit.or(Some(RawHit { t: 1.0, object: ObjectId(0), primitive: 0, uv: [0.2, 0.2] })));
    assert!(invented.total().unexplained > 400, "{invented:#?}");
}

#[test]
fn rounding_is_explained_by_its_class() {
    let square =
        mesh(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2], [0, 2, 3]]);
    let scene = scene(vec![placed(0, Transform::IDENTITY)], vec![square]);
    let geometry = Arc::new(Geometry::new(&scene).expect("a sound scene"));
    let brute = BruteBackend::new(geometry.clone());
    let check = Crosscheck { geometry: &geometry, a: &brute, b: &brute };
    let down = |x: f64, y: f64| Ray::new(Point3::new(x, y, 1.0), -Dir3::Z);
    let hit = |t, primitive, uv| Some(RawHit { t, object: ObjectId(0), primitive, uv });
    let class = |ray: &Ray, a, b| check.judge_first(ray, a, b).class;

    let (on_diagonal, inside, at_border) = (down(0.5, 0.5), down(0.7, 0.2), down(1.0 - 1e-9, 0.5));
    assert_eq!(class(&on_diagonal, hit(1.0, 0, [0.0, 0.5]), hit(1.0, 1, [0.5, 0.0])), Some(Class::Tie));
    // (0.7, 0.2) is 0.5 (0,0) + 0.3 … of triangle 0 alone: a hit on the other one is invented.
    assert_eq!(class(&inside, hit(1.0, 0, [0.5, 0.2]), hit(1.0, 1, [0.2, 0.0])), Some(Class::Unexplained));
    assert_eq!(class(&at_border, brute.intersect(&at_border), None), Some(Class::Edge));
    assert_eq!(class(&inside, brute.intersect(&inside), None), Some(Class::Unexplained));
    assert_eq!(class(&inside, hit(1.0, 0, [0.5, 0.2]), hit(1.0 + 1e-9, 0, [0.5, 0.2])), None);
    assert_eq!(class(&inside, hit(1.0, 0, [0.5, 0.2]), hit(1.0 + 1e-4, 0, [0.5, 0.2])), Some(Class::TBeyond));
    let ended = Ray { t_max: 1.0 + 1e-9, ..inside };
    assert_eq!(class(&ended, brute.intersect(&ended), None), Some(Class::IntervalEnd));
}

#[test]
fn units_merge_to_the_whole_and_examples_replay() {
    let apart = placed(0, Transform::translate(Vec3::X * 0.7));
    let scene = scene(vec![placed(0, Transform::IDENTITY), apart], vec![icosphere(1)]);
    let geometry = Arc::new(Geometry::new(&scene).expect("a sound scene"));
    let honest = BruteBackend::new(geometry.clone());
    let liar =
        Liar { honest: BruteBackend::new(geometry.clone()), bend: |hit: Option<RawHit>| hit.filter(|h| h.t > 1.0) };
    let check = Crosscheck { geometry: &geometry, a: &honest, b: &liar };
    let mut queries = queries(33, 1000);
    queries[10].ray.t_min = f64::NAN;
    let whole = check.compare(0, &queries);
    let mut merged = Report::default();
    for (unit, chunk) in queries.chunks(64).enumerate() {
        merged.merge(check.compare(64 * unit as u64, chunk));
    }
    assert_eq!(merged, whole);
    assert_eq!((whole.total().rays, whole.total().refused), (1000, 1));
    assert!(!whole.examples.is_empty());
    let text = serde_json::to_string(&whole).expect("plain numbers");
    let read: Report = serde_json::from_str(&text).expect("what was written");
    for (example, original) in read.examples.iter().zip(&whole.examples) {
        assert_eq!(example.ray, original.ray);
        assert_eq!(example.ray.to_ray(), Some(queries[example.index as usize].ray));
    }
}
