//! Helpers that the test binaries share; each includes this folder by `#[path]`.
#![allow(dead_code, reason = "each test binary uses its own part")]

pub mod browser;
pub mod closed_form;
pub mod bsdf;
pub mod chi2;
pub mod data;
pub mod optics;
pub mod panorama;
pub mod pass;
pub mod renders;
pub mod gltf;
pub mod instructions;
pub mod scene;
pub mod evenness;
pub mod lights;
pub mod shapes;
pub mod quartet;
pub mod source;
pub mod special;
pub mod statistics;
pub mod study;
pub mod worlds;
