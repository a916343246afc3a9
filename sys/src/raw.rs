//! The declarations that bindgen made from the installed header and from `shim.h`.
//!
//! Public for this crate's own ABI tests only. Enums are integers: a newer library may return codes that the
//! header does not know. `PdeRayHit` is always the 96-byte layout; `shim.c` compares each offset with the header's.

#![allow(
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    dead_code,
    clippy::undocumented_unsafe_blocks,
    clippy::pedantic,
    reason = "generated code with Embree's names"
)]

include!(concat!(env!("OUT_DIR"), "/bindings.rs"));

// Embree loads single rays with aligned 16-byte instructions and, from 4.3 on, writes instPrimID at byte 80.
const _: () = {
    assert!(size_of::<PdeRayHit>() == 96);
    assert!(align_of::<PdeRayHit>() == 16);
    assert!(std::mem::offset_of!(PdeRayHit, org) == 0);
    assert!(std::mem::offset_of!(PdeRayHit, dir) == 16);
    assert!(std::mem::offset_of!(PdeRayHit, t_far) == 32);
    assert!(std::mem::offset_of!(PdeRayHit, ng) == 48);
    assert!(std::mem::offset_of!(PdeRayHit, prim_id) == 68);
    assert!(std::mem::offset_of!(PdeRayHit, geom_id) == 72);
    assert!(std::mem::offset_of!(PdeRayHit, inst_id) == 76);
    assert!(std::mem::offset_of!(PdeRayHit, inst_prim_id) == 80);
    // A mesh is copied into Embree's buffers as it is.
    assert!(size_of::<[f32; 3]>() == 12 && size_of::<[u32; 3]>() == 12);
};
