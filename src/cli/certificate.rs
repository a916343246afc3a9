//! Collects what the birth certificate says.

use std::collections::BTreeMap;

use pdembree::output::BirthCertificate;
use pdembree::output::sidecar::{
    BackendIdentity, Phase, Program, RefusedSamples, SCHEMA, SceneIdentity, settings_by_name,
};
use pdembree::render::RenderState;
use pdembree::world::World;
use serde::Serialize;

use super::memory;

/// What only the command knows.
pub struct Circumstances {
    pub scene: std::path::PathBuf,
    pub threads: usize,
    pub seconds: f64,
    pub phases: Vec<Phase>,
    pub warnings: Vec<String>,
}

pub fn certificate(world: &World, rendered: &RenderState, circumstances: Circumstances) -> BirthCertificate {
    let RenderState { film, report } = rendered;
    let settings = &world.scene.settings;
    let mut counters = counts(&report.photons);
    counters.insert("invalid_rays".to_owned(), report.invalid_rays);
    BirthCertificate {
        schema: SCHEMA,
        program: Program::this(),
        command: std::env::args_os().map(|argument| argument.to_string_lossy().into_owned()).collect(),
        scene: SceneIdentity { path: circumstances.scene, hash: world.scene.hash.clone() },
        resolution: world.scene.camera.resolution,
        settings: settings_by_name(settings),
        backend: BackendIdentity { name: settings.backend.name().to_owned(), version: world.backend.describe() },
        passes: report.passes,
        photons_emitted: report.photons.photons_emitted,
        photons_stored: report.photons.photons_stored,
        counters,
        lights: report.photons_by_light.iter().map(counts).collect(),
        refused_samples: RefusedSamples::from(film.refused()),
        warnings: circumstances.warnings,
        threads: circumstances.threads,
        seconds: circumstances.seconds,
        phases: circumstances.phases,
        peak_memory_bytes: memory::peak(),
    }
}

/// The fields of a table of counts, by name.
fn counts(table: &impl Serialize) -> BTreeMap<String, u64> {
    let value = serde_json::to_value(table).unwrap_or_default();
    let fields = value.as_object().into_iter().flatten();
    fields.filter_map(|(name, count)| Some((name.clone(), count.as_u64()?))).collect()
}
