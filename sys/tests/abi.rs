//! The memory layout at the border to Embree: nothing beyond our ray is written, and the 80-byte layout would be overrun.
//!
//! [EMBREE.md] Embree 4.3 appended `instPrimID` to `RTCHit`. A binding with the older 80-byte `RTCRayHit` is
//! overwritten on every hit by a newer library; the canaries show which of the two layouts the linked library writes.

use embree4_sys::{CommittedScene, Device, HEADER_VERSION, SceneBuilder, Version, raw, version};

mod support;

const CANARY: u8 = 0xa5;

/// Our ray with guards around it. Aligned for the packets' sake too, so that the ray starts at byte 64.
#[repr(C, align(64))]
struct Guarded {
    before: [u8; 64],
    rayhit: raw::PdeRayHit,
    after: [u8; 160],
}

fn scene(device: &Device) -> CommittedScene {
    let mut builder = SceneBuilder::new(device).unwrap();
    let vertices = [[-4.0, -4.0, 5.0], [4.0, -4.0, 5.0], [0.0, 8.0, 5.0]];
    builder.add_mesh(7, &vertices, &[[0, 1, 2]]).unwrap();
    let mesh = builder.commit().unwrap();
    let mut builder = SceneBuilder::new(device).unwrap();
    builder.add_mesh(7, &vertices, &[[0, 1, 2]]).unwrap();
    // In front of the triangle, so that a ray meets an instance first.
    let nearer = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -2.0]];
    builder.add_instance(3, &mesh, &nearer).unwrap();
    builder.commit().unwrap()
}

fn trace(scene: &CommittedScene, occluded: bool) -> Guarded {
    let mut guarded = Guarded {
        before: [CANARY; 64],
        rayhit: raw::PdeRayHit {
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
            inst_prim_id: u32::from_ne_bytes([CANARY; 4]),
        },
        after: [CANARY; 160],
    };
    // SAFETY: every byte of `Guarded` is made known, the ray's tail padding too.
    unsafe {
        let tail = (&raw mut guarded.rayhit).cast::<u8>().add(84);
        tail.write_bytes(CANARY, 12);
    }
    let mut record = raw::PdeRecord {
        org: [0.0; 3],
        dir: [0.0, 0.0, 1.0],
        t_near: 0.0,
        time: 0.0,
        t_far: f64::INFINITY,
        u: 0.0,
        v: 0.0,
        geom_id: raw::PDE_INVALID_ID,
        prim_id: raw::PDE_INVALID_ID,
        part: 0,
        t_far_f32: 0.0,
    };
    let call = if occluded { raw::pde_occluded1 } else { raw::pde_intersect1 };
    // SAFETY: the scene is committed and alive; ray and record are ours and outlive the call.
    unsafe { call(scene.raw(), &raw mut guarded.rayhit, &raw mut record) };
    guarded
}

fn intact(bytes: &[u8]) -> bool {
    bytes.iter().all(|byte| *byte == CANARY)
}

/// The ray's bytes from `from` on.
fn tail(guarded: &Guarded, from: usize) -> Vec<u8> {
    let base = (&raw const guarded.rayhit).cast::<u8>();
    // SAFETY: within the ray; its padding was written byte by byte, and Embree writes whole fields.
    (from..96).map(|offset| unsafe { base.add(offset).read() }).collect()
}

#[test]
fn nothing_beyond_our_ray_is_written() {
    let device = support::device();
    let scene = scene(&device);
    let hit = trace(&scene, false);
    assert_eq!((hit.rayhit.geom_id, hit.rayhit.inst_id), (7, 3));
    assert!((hit.rayhit.t_far - 3.0).abs() < 1e-5, "{}", hit.rayhit.t_far);
    assert!(intact(&hit.before) && intact(&hit.after), "Embree {} writes outside of 96 bytes", device.version());
    assert!(intact(&tail(&hit, 84)), "Embree {} writes behind instPrimID", device.version());

    let shadow = trace(&scene, true);
    assert_eq!(shadow.rayhit.t_far, f32::NEG_INFINITY);
    assert!(intact(&shadow.before) && intact(&shadow.after));
    assert!(intact(&tail(&shadow, 80)), "an occlusion query touches the ray part only");
    assert_eq!(shadow.rayhit.geom_id, raw::PDE_INVALID_ID, "an occlusion query touches the ray part only");
}

/// Why the layout is 96 bytes: bytes 80 to 83 belong to instPrimID, which an 80-byte structure does not have.
#[test]
fn the_80_byte_layout_would_be_overrun_from_4_3_on() {
    let device = support::device();
    let hit = trace(&scene(&device), false);
    let overrun = !intact(&tail(&hit, 80)[..4]);
    let newer = device.version() >= Version { major: 4, minor: 3, patch: 0 };
    assert_eq!(overrun, newer, "Embree {}", device.version());
}

#[test]
fn the_header_fits_our_layout() {
    // SAFETY: reads a constant.
    let size = unsafe { raw::pde_header_ray_hit_size() } as usize;
    let number = raw::RTC_VERSION;
    assert_eq!(size, if number >= 40_300 { 96 } else { 80 }, "Embree {HEADER_VERSION}");
    assert!(size <= size_of::<raw::PdeRayHit>());
}

#[test]
fn library_and_header_are_of_one_major_version() {
    let linked = version().unwrap();
    assert_eq!(linked.major, raw::RTC_VERSION_MAJOR);
    assert_eq!(linked, support::device().version());
    assert!(HEADER_VERSION.starts_with(&format!("{}.", linked.major)), "{HEADER_VERSION}");
    assert!(linked >= Version { major: 3, minor: 13, patch: 0 }, "{linked}");
}
