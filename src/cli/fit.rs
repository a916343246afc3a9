//! Passes that fit into the memory and the time there is.

use std::time::Duration;

use pdembree::render::watch::Watch;
use pdembree::render::{self, RenderState, first_pass};
use pdembree::scene::settings::Method;
use pdembree::world::World;

use super::console::{Verbosity, note};
use super::failure::Failure;
use super::progress::{duration, size};
use super::work::render_failure;

/// Splits passes whose photons would not fit into the memory for them.
pub fn memory(world: &mut World, limit: Option<u64>, verbosity: Verbosity) {
    if limit.is_none() && !verbosity.verbose || world.scene.settings.method != Method::PhotonMap {
        return;
    }
    let estimate = render::memory::estimate(world);
    let about = match estimate.beams {
        0 => format!(
            "about {} of {} photons are stored in a pass, {} at {} bytes each",
            estimate.stored,
            world.scene.settings.photons,
            size(estimate.bytes()),
            render::memory::BYTES_PER_PHOTON
        ),
        beams => format!(
            "about {} photons at {} bytes and {beams} beams at {} bytes are stored in a pass, {}",
            estimate.stored,
            render::memory::BYTES_PER_PHOTON,
            estimate.bytes_per_beam,
            size(estimate.bytes()),
        ),
    };
    let split = limit.and_then(|limit| render::memory::split(&world.scene.settings, &estimate, limit));
    let what = match &split {
        None => String::new(),
        Some(settings) => format!("; split into {} passes of {} photons", settings.passes, settings.photons),
    };
    note(verbosity, "photons", &(about + &what));
    if let Some(settings) = split {
        world.scene.settings = settings;
    }
}

/// The first pass, and smaller passes from there on where a whole one would not end within `left`.
pub fn time(
    world: &mut World,
    left: Duration,
    watch: &dyn Watch,
    verbosity: Verbosity,
) -> Result<RenderState, Failure> {
    let mut whole = None;
    let first = first_pass::render(world, left, watch, |pass| _ = whole.get_or_insert(pass));
    let state = first.map_err(|error| render_failure(&error))?;
    if let Some(whole) = whole {
        let settings = &world.scene.settings;
        let photons = match settings.method {
            Method::Path => String::new(),
            Method::PhotonMap | Method::LightTrace => format!("photons = {} and ", settings.photons),
        };
        let (pass, spp) = (duration(whole.as_secs_f64()), settings.spp);
        let about = format!("a pass would take about {pass}; passes with {photons}spp = {spp} instead");
        note(verbosity, "time", &about);
    }
    Ok(state)
}
