//! Rays aimed exactly at the edges and vertices of a closed mesh, from inside: a ray that gets out has leaked.
//!
//! A photon that leaks out of closed glass is lost energy, so all scenes are robust ones. Embree's robust triangle
//! test [Pluecker edge functions, evaluated alike for both triangles of an edge] is watertight across an edge, so the
//! statement for edges is exact: none leaks. Around a vertex no such argument holds for f32: the statement there is
//! statistical, robust leaks less than fast. Fast scenes exist in this test alone, made through the raw interface.

use embree4_sys::{CommittedScene, Device, SceneBuilder, raw};
use support::{Random, Vec3, add, corners, icosphere, ray, scale, sub};

mod support;

const SEED: u64 = 0x5eed_0009;
const ORIGINS: usize = 40;

/// The same mesh in a scene with Embree's default flags.
struct Fast<'a> {
    scene: raw::RTCScene,
    _device: &'a Device,
}

impl<'a> Fast<'a> {
    fn new(device: &'a Device, vertices: &[[f32; 3]], faces: &[[u32; 3]]) -> Self {
        // SAFETY: the calls of `SceneBuilder::add_mesh` and `commit` in their order, on live handles; the buffers
        // have room for what is copied.
        unsafe {
            let scene = raw::rtcNewScene(device.raw());
            let mesh = raw::rtcNewGeometry(device.raw(), raw::RTC_GEOMETRY_TYPE_TRIANGLE);
            raw::rtcSetGeometryMask(mesh, u32::MAX);
            let buffer =
                |kind, format, count: usize| raw::rtcSetNewGeometryBuffer(mesh, kind, 0, format, 12, count as _);
            let points = buffer(raw::RTC_BUFFER_TYPE_VERTEX, raw::RTC_FORMAT_FLOAT3, vertices.len());
            points.cast::<[f32; 3]>().copy_from_nonoverlapping(vertices.as_ptr(), vertices.len());
            let indices = buffer(raw::RTC_BUFFER_TYPE_INDEX, raw::RTC_FORMAT_UINT3, faces.len());
            indices.cast::<[u32; 3]>().copy_from_nonoverlapping(faces.as_ptr(), faces.len());
            raw::rtcCommitGeometry(mesh);
            raw::rtcAttachGeometryByID(scene, mesh, 0);
            raw::rtcReleaseGeometry(mesh);
            raw::rtcCommitScene(scene);
            Self { scene, _device: device }
        }
    }

    fn hits(&self, origin: Vec3, direction: Vec3) -> bool {
        let mut rayhit = raw::PdeRayHit {
            org: origin.map(|x| x as f32),
            t_near: 0.0,
            dir: direction.map(|x| x as f32),
            time: 0.0,
            t_far: f32::INFINITY,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            ng: [0.0; 3],
            u: 0.0,
            v: 0.0,
            prim_id: raw::PDE_INVALID_ID,
            geom_id: raw::PDE_INVALID_ID,
            inst_id: raw::PDE_INVALID_ID,
            inst_prim_id: raw::PDE_INVALID_ID,
        };
        // SAFETY: the scene is committed and has no user geometry, so nobody reads the record.
        unsafe { raw::pde_intersect1(self.scene, &raw mut rayhit, std::ptr::null_mut()) };
        rayhit.geom_id != raw::PDE_INVALID_ID
    }
}

impl Drop for Fast<'_> {
    fn drop(&mut self) {
        // SAFETY: our own reference.
        unsafe { raw::rtcReleaseScene(self.scene) };
    }
}

struct Leaks {
    rays: u32,
    robust: u32,
    fast: u32,
}

/// Traces from random points inside to every target, in both kinds of scenes.
fn leaks(vertices: &[[f32; 3]], faces: &[[u32; 3]], targets: &[Vec3]) -> Leaks {
    let device = support::device();
    let mut builder = SceneBuilder::new(&device).unwrap();
    builder.add_mesh(0, vertices, faces).unwrap();
    let robust: CommittedScene = builder.commit().unwrap();
    let fast = Fast::new(&device, vertices, faces);
    let mut random = Random(SEED);
    let mut leaks = Leaks { rays: 0, robust: 0, fast: 0 };
    for _ in 0..ORIGINS {
        let origin = scale(random.in_cube(), 0.4);
        for &target in targets {
            let direction = sub(target, origin);
            let found = robust.intersect(&ray(origin, direction)).unwrap().is_some();
            assert_eq!(robust.occluded(&ray(origin, direction)), Ok(found), "seed {SEED:#x}: {origin:?} {target:?}");
            leaks.rays += 1;
            leaks.robust += u32::from(!found);
            leaks.fast += u32::from(!fast.hits(origin, direction));
        }
    }
    println!("{} rays: {} leak from a robust scene, {} from a fast one", leaks.rays, leaks.robust, leaks.fast);
    leaks
}

/// z of the hypothesis that the robust scene leaks as often as the fast one (two proportions, pooled).
fn fewer(leaks: &Leaks) -> f64 {
    let [n, robust, fast] = [leaks.rays, leaks.robust, leaks.fast].map(f64::from);
    let pooled = (robust + fast) / (2.0 * n);
    (fast - robust) / n / (pooled * (1.0 - pooled) * 2.0 / n).sqrt()
}

#[test]
fn no_ray_leaks_through_an_edge() {
    let (vertices, faces) = icosphere(4);
    let mut random = Random(SEED);
    for (what, place) in [("midpoints", None), ("anywhere", Some(()))] {
        let targets: Vec<Vec3> = faces
            .iter()
            .flat_map(|face| {
                let [a, b, c] = corners(&vertices, *face);
                [(a, b), (b, c), (c, a)]
            })
            .map(|(a, b)| {
                let s = if place.is_some() { 0.05 + 0.9 * random.unit() } else { 0.5 };
                add(scale(a, 1.0 - s), scale(b, s))
            })
            .collect();
        let leaks = leaks(&vertices, &faces, &targets);
        // The same rays do get out of a fast scene: they are aimed well enough for this test to fail.
        assert!(fewer(&leaks) > 4.75, "seed {SEED:#x}: {} of {} leak from a fast scene", leaks.fast, leaks.rays);
        assert_eq!(leaks.robust, 0, "seed {SEED:#x}: {} of {} rays at edges ({what}) leak", leaks.robust, leaks.rays);
    }
}

#[test]
fn fewer_rays_leak_at_vertices_than_in_a_fast_scene() {
    let (vertices, faces) = icosphere(4);
    let targets: Vec<Vec3> = vertices.iter().map(|vertex| vertex.map(f64::from)).collect();
    let leaks = leaks(&vertices, &faces, &targets);
    // One-sided, p < 1e-6.
    assert!(fewer(&leaks) > 4.75, "seed {SEED:#x}: {} against {} of {}", leaks.robust, leaks.fast, leaks.rays);
}
