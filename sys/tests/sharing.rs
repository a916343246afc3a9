//! One committed scene, many threads: the same answers, bit for bit. And errors that find the thread they belong to.

use std::sync::Arc;
use std::thread;

use embree4_sys::{CommittedScene, Device, DeviceError, ErrorCode, Hit, Ray, SceneBuilder, raw};
use support::{Random, Spheres, icosphere, ray, scale};

mod support;

const SEED: u64 = 0x5eed_000a;

/// A mesh, instances of it and spheres: every kind of callback and context is in use.
fn scene(device: &Device) -> CommittedScene {
    let (vertices, faces) = icosphere(3);
    let mut builder = SceneBuilder::new(device).unwrap();
    builder.add_mesh(0, &vertices, &faces).unwrap();
    let ball = builder.commit().unwrap();
    let mut builder = SceneBuilder::new(device).unwrap();
    builder.add_mesh(0, &vertices, &faces).unwrap();
    for id in 1..20_u32 {
        let turn = f64::from(id) * 2.4;
        let [x, z] = [turn.cos(), turn.sin()].map(|w| w * 0.6 * f64::from(id).sqrt());
        builder.add_instance(id, &ball, &[[0.3, 0.0, 0.0, x], [0.0, 0.3, 0.0, 1.0], [0.0, 0.0, 0.3, z]]).unwrap();
    }
    let mut random = Random(SEED);
    let spheres = (0..50).map(|_| (scale(random.in_cube(), 2.0), 0.1 + 0.2 * random.unit())).collect();
    builder.add_user(20, Spheres(spheres)).unwrap();
    builder.commit().unwrap()
}

fn rays() -> Vec<Ray> {
    let mut random = Random(SEED + 1);
    (0..20_000).map(|_| ray(scale(random.in_cube(), 3.0), random.direction())).collect()
}

fn answers(scene: &CommittedScene, rays: &[Ray]) -> Vec<(Option<Hit>, bool)> {
    rays.iter().map(|ray| (scene.intersect(ray).unwrap(), scene.occluded(ray).unwrap())).collect()
}

#[test]
fn many_threads_get_the_answers_of_one() {
    let scene = scene(&support::device());
    let rays = rays();
    let expected = answers(&scene, &rays);
    let kinds = |test: fn(&Hit) -> bool| expected.iter().filter(|(hit, _)| hit.as_ref().is_some_and(test)).count();
    let (instances, spheres) = (kinds(|hit| hit.instance.is_some()), kinds(|hit| hit.geometry == 20));
    assert!(instances > 500 && spheres > 500, "{instances} hits on instances, {spheres} on spheres");
    thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| assert!(answers(&scene, &rays) == expected, "seed {SEED:#x}: answers differ"));
        }
    });
}

/// A builder moves to another thread; scenes are built at the same time on one device, outlive it, and are dropped
/// elsewhere.
#[test]
fn scenes_are_built_traced_and_dropped_on_any_thread() {
    let rays = rays();
    let expected = answers(&scene(&support::device()), &rays);
    let device = support::device();
    let scenes: Vec<_> = (0..4)
        .map(|_| {
            let device = device.clone();
            thread::spawn(move || scene(&device))
        })
        .collect();
    let moved = SceneBuilder::new(&device).unwrap();
    drop(device);
    assert!(thread::spawn(move || moved.commit().is_ok()).join().unwrap());
    for scene in scenes {
        let scene = Arc::new(scene.join().unwrap());
        assert!(answers(&scene, &rays) == expected, "seed {SEED:#x}: answers differ");
        thread::spawn(move || drop(scene)).join().unwrap();
    }
}

/// Makes Embree report an error: a scene that was never committed is traced, which only the raw interface allows.
fn provoke(device: &Device) {
    let mut rayhit = raw::PdeRayHit {
        org: [0.0; 3],
        t_near: 0.0,
        dir: [0.0, 0.0, 1.0],
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
    // SAFETY: live handles, an attached but incomplete mesh; Embree checks it at the geometry's commit and reports.
    // The uncommitted scene has no user geometry, so nobody reads the record.
    unsafe {
        let scene = raw::rtcNewScene(device.raw());
        let mesh = raw::rtcNewGeometry(device.raw(), raw::RTC_GEOMETRY_TYPE_TRIANGLE);
        raw::rtcAttachGeometryByID(scene, mesh, 0);
        raw::pde_intersect1(scene, &raw mut rayhit, std::ptr::null_mut());
        raw::rtcReleaseGeometry(mesh);
        raw::rtcReleaseScene(scene);
    }
}

#[test]
fn the_error_callback_carries_code_and_text() {
    let device = support::device();
    assert_eq!(device.take_errors(), []);
    provoke(&device);
    let errors = device.take_errors();
    let [DeviceError { code, text }] = errors.as_slice() else { panic!("one error, not {errors:?}") };
    assert_eq!(*code, ErrorCode::INVALID_OPERATION, "{text}");
    assert!(text.contains("commit"), "{text}");
    assert_eq!(device.take_errors(), [], "taken is taken");
}

#[test]
fn an_error_fails_the_call_of_its_own_thread_only() {
    let device = support::device();
    provoke(&device);
    // Another thread builds on the same device and is not blamed.
    let other = device.clone();
    thread::spawn(move || assert!(SceneBuilder::new(&other).is_ok())).join().unwrap();
    // This thread's next call is.
    let error = SceneBuilder::new(&device).unwrap_err().to_string();
    assert!(error.contains("invalid operation (code 3)"), "{error}");
    assert!(SceneBuilder::new(&device).is_ok(), "an error is reported once");
}

#[test]
fn a_refused_device_is_an_error() {
    let error = Device::with_config("threads=1\0").unwrap_err();
    assert_eq!(error.code, ErrorCode::INVALID_ARGUMENT);
}

#[test]
fn codes_unknown_today_stay_numbers() {
    let error = DeviceError { code: ErrorCode(4711), text: "news".into() };
    assert_eq!(error.to_string(), "Embree reports code 4711: news");
    assert_ne!(error.code, ErrorCode::UNKNOWN);
}
