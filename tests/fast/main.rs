//! Tests that take seconds: formulas, data structures, the house's rules.

#[path = "../support/mod.rs"]
mod support;

mod backends;
mod cli;
mod closed_form;
mod differential_chains;
mod differential_vectors;
mod discrete;
mod distribute;
mod exact;
mod farm;
mod film;
mod gltf;
mod instructions;
mod interaction;
mod light_assembly;
mod lights;
mod bad_input;
mod mesh_files;
mod media;
mod metric;
mod motion;
mod motion_blur;
mod moving_lights;
mod oracles_ball;
mod oracles_mirror;
mod oracles_refraction;
mod output;
mod scene_file;
mod bsdf_delta;
mod bsdf_energy;
mod chi2_support;
mod panorama;
mod parts;
mod pbrt;
mod shape_derivatives;
mod shape_intersect;
mod shape_sampling;
mod statistics_support;
mod study;
mod structure;
mod tev;
mod texture;
mod time_column;
mod warps;
