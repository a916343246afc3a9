//! Collects what the birth certificate says.

use std::collections::BTreeMap;

use pdembree::film::Image;
use pdembree::medium::LostCount;
use pdembree::output::sidecar::{Phase, RefusedSamples, SCHEMA};
use pdembree::output::{BirthCertificate, PartInfo};
use pdembree::photon::PhotonCounts;
use pdembree::render::RenderState;
use pdembree::scene::texture::TextureReport;
use serde::Serialize;

use super::memory;

/// What only the command knows.
pub struct Circumstances {
    pub threads: usize,
    pub seconds: f64,
    pub phases: Vec<Phase>,
    pub warnings: Vec<String>,
    pub textures: Option<TextureReport>,
}

pub fn certificate(
    info: &PartInfo,
    state: &RenderState,
    picture: &Image,
    circumstances: Circumstances,
) -> BirthCertificate {
    let RenderState { film, report } = state;
    let mut counters = counts(&report.photons);
    counters.insert("invalid_rays".to_owned(), report.invalid_rays);
    counters.insert("inexact_hits".to_owned(), report.inexact_hits);
    if report.lost_count != LostCount::default() {
        counters.extend(counts(&report.lost_count));
    }
    let mut settings = info.identity.settings.clone();
    settings.insert("passes".to_owned(), film.passes().into());
    BirthCertificate {
        schema: SCHEMA,
        program: info.identity.program.clone(),
        command: std::env::args_os().map(|argument| argument.to_string_lossy().into_owned()).collect(),
        scene: info.scene.clone(),
        resolution: info.identity.resolution,
        settings,
        backend: info.identity.backend.clone(),
        first_pass: film.first_pass(),
        passes: film.passes(),
        noise: film.noise().map(|noise| noise.relative),
        photons_emitted: report.photons.photons_emitted,
        photons_stored: report.photons.photons_stored,
        counters,
        lights: report.photons_by_light.iter().map(counts).collect(),
        bounced_photons: counts(&report.bounced_photons),
        beam_photons: if report.beam_photons == PhotonCounts::default() {
            BTreeMap::new()
        } else {
            counts(&report.beam_photons)
        },
        refused_samples: RefusedSamples::from(film.refused()),
        denoised: picture.channel("noisy.R").is_some(),
        pixels: picture.digest(),
        warnings: circumstances.warnings,
        threads: circumstances.threads,
        seconds: circumstances.seconds,
        render_seconds: report.seconds,
        phases: circumstances.phases,
        peak_memory_bytes: memory::peak(),
        textures: circumstances.textures,
        parts: None,
    }
}

/// The fields of a table of counts, by name.
fn counts(table: &impl Serialize) -> BTreeMap<String, u64> {
    let value = serde_json::to_value(table).unwrap_or_default();
    let fields = value.as_object().into_iter().flatten();
    fields.filter_map(|(name, count)| Some((name.clone(), count.as_u64()?))).collect()
}
