//! Hypothesis tests: samples, p-values, fixed seeds.

#[path = "../support/mod.rs"]
mod support;

mod agreement;
mod convergence;
mod far_lights;
mod guiding;
mod interreflection;
mod light_emission;
mod light_samples;
mod lights;
mod many_lights;
mod media;
mod motion_blur;
mod bsdf;
