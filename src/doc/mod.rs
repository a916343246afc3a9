//! Long documentation, one page a module; it holds no code.

#[doc = include_str!("notation.md")]
pub mod notation {}

#[doc = include_str!("scene_format.md")]
pub mod scene_format {}

#[doc = include_str!("layers.md")]
pub mod layers {}

#[doc = include_str!("gltf.md")]
pub mod gltf {}

#[doc = include_str!("pbrt.md")]
pub mod pbrt {}

#[doc = include_str!("motion.md")]
pub mod motion {}

#[doc = include_str!("media.md")]
pub mod media {}

#[doc = include_str!("passes.md")]
pub mod passes {}

#[doc = include_str!("interreflection.md")]
pub mod interreflection {}

#[doc = include_str!("performance.md")]
pub mod performance {}

#[doc = include_str!("study_format.md")]
pub mod study_format {}

#[doc = include_str!("units.md")]
pub mod units {}

#[doc = include_str!("testing.md")]
pub mod testing {}

#[doc = include_str!("references.md")]
pub mod references {}
