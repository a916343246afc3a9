//! Whole renders, compared as pictures.

#[path = "../support/mod.rs"]
mod support;

mod animation;
mod blur_reference;
mod exact;
mod exr;
mod imported;
mod page;
mod killed;
mod layers;
mod peers;
mod closed_form_scenes;
mod refraction;
mod study_tables;
