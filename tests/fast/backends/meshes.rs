//! Embree against obvhs on common test meshes, where the shared data are present.

use std::path::Path;
use std::sync::Arc;

use pdembree::backend::crosscheck::{Crosscheck, Query, RayKind};
use pdembree::backend::{Backend, BruteBackend, Geometry, ObvhsBackend};
use pdembree::math::{Dir3, Point3, Ray, Transform};
use pdembree::scene::{ObjectGeometry, TriangleMesh};

use super::backends;
use crate::support::data::shared;
use crate::support::scene::scene;
use crate::support::worlds::{Numbers, mesh, placed, placements};

fn read(path: &Path) -> TriangleMesh {
    let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
    let (models, _) = tobj::load_obj(path, &options).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for model in models {
        let first = positions.len() as u32;
        positions.extend(model.mesh.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        triangles.extend(model.mesh.indices.chunks_exact(3).map(|t| [t[0] + first, t[1] + first, t[2] + first]));
    }
    mesh(positions, triangles)
}

/// Chords of the bounding sphere, rays at corners, at points of edges, and from points of the surface.
fn queries(mesh: &TriangleMesh, to_world: &Transform, count: usize) -> Vec<Query> {
    let (centre, radius) = mesh.bounds().bounding_sphere();
    let mut numbers = Numbers::new(41);
    let query = |i: usize| {
        let [a, b, c] = mesh.corners(numbers.index(mesh.triangles.len()) as u32);
        let outside = centre + numbers.direction() * (1.5 * radius);
        let (from, to) = match i % 4 {
            0 => (outside, centre + numbers.in_cube(radius)),
            1 => (outside, a),
            2 => (outside, a + (b - a) * numbers.between(0.0, 1.0)),
            _ => (Point3::from_vec((a.to_vec() + b.to_vec() + c.to_vec()) / 3.0), centre + numbers.in_cube(radius)),
        };
        let (from, to) = (to_world.point(from), to_world.point(to));
        let kind = [RayKind::Camera, RayKind::Shadow, RayKind::Photon][i % 3];
        // Rays that leave the surface skip it, as a tracer's do.
        let ray = Ray { t_min: if i % 4 == 3 { 1e-3 * radius } else { 0.0 }, ..Ray::new(from, Dir3::new(to - from)?) };
        Some(Query { ray: if kind == RayKind::Shadow { Ray { t_max: from.distance(to), ..ray } } else { ray }, kind })
    };
    (0..count).filter_map(query).collect()
}

#[test]
fn common_meshes_are_the_same_to_all_backends() {
    let Some(folder) = shared("meshes") else { return };
    for name in ["stanford-bunny", "suzanne", "teapot", "spot", "rocker-arm", "fandisk"] {
        let mesh = read(&folder.join(format!("{name}.obj")));
        // Baked and instanced, away from the origin and mirrored.
        let place = placements(42, 1)[0];
        let worlds: [(&str, Vec<ObjectGeometry>, Transform); 2] = [
            ("as it is", vec![placed(0, Transform::IDENTITY)], Transform::IDENTITY),
            ("instanced", vec![placed(0, place), placed(0, Transform::IDENTITY)], place),
        ];
        for (how, objects, to_world) in worlds {
            let scene = scene(objects, vec![mesh.clone()]);
            let geometry = Arc::new(Geometry::new(&scene).expect("a sound scene"));
            let queries = queries(&mesh, &to_world, 20_000);
            let judge = ObvhsBackend::new(geometry.clone());
            let brute = BruteBackend::new(geometry.clone());
            for query in queries.iter().take(40) {
                assert_eq!(judge.intersect(&query.ray), brute.intersect(&query.ray), "{name} {how}: {query:?}");
            }
            for backend in backends(&scene).iter().filter(|b| !b.describe().starts_with("brute")) {
                let report = Crosscheck { geometry: &geometry, a: &judge, b: &**backend }.compare(0, &queries);
                let total = report.total();
                assert!(total.hits > 10_000, "{name} {how}: {} hits", total.hits);
                assert_eq!(total.not_explained(), 0, "{name} {how}, {}: {report:#?}", backend.describe());
            }
        }
    }
}
