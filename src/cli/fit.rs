//! Passes that fit into the memory and the time there is.

use std::time::Duration;

use pdembree::render;
use pdembree::render::progress::{Progress, Silent};
use pdembree::render::rehearsal::Rehearsal;
use pdembree::render::watch::Watch;
use pdembree::scene::settings::Method;
use pdembree::world::World;

use super::console::{Verbosity, note};
use super::failure::{Failure, code};
use super::progress::{duration, size};
use super::signals::Signals;

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

/// Makes passes smaller of which not one would end within `left`; a small one tells how long they take.
pub fn time(world: &mut World, left: Duration, signals: &Signals, verbosity: Verbosity) -> Result<(), Failure> {
    let rehearsal =
        Rehearsal::of_pass(world, &Unseen(signals)).map_err(|error| Failure::new(code::BAD_DATA, error.to_string()))?;
    let Some(rehearsal) = rehearsal else { return Ok(()) };
    let Some(settings) = rehearsal.fit(&world.scene.settings, left) else { return Ok(()) };
    let photons = match settings.method {
        Method::Path => String::new(),
        Method::PhotonMap | Method::LightTrace => format!("photons = {} and ", settings.photons),
    };
    let (pass, spp) = (duration(rehearsal.pass().as_secs_f64()), settings.spp);
    let about = format!("a pass would take about {pass}; passes with {photons}spp = {spp} instead");
    note(verbosity, "time", &about);
    world.scene.settings = settings;
    Ok(())
}

/// Tells nothing, and stops when a signal asked.
struct Unseen<'a>(&'a Signals);

impl Progress for Unseen<'_> {
    fn phase(&self, name: &str, total: u64) {
        Silent.phase(name, total);
    }
    fn advance(&self, n: u64) {
        Silent.advance(n);
    }
    fn finish(&self) {
        Silent.finish();
    }
    fn skip(&self, n: u64) {
        Silent.skip(n);
    }
}

impl Watch for Unseen<'_> {
    fn stop(&self) -> bool {
        self.0.stop_asked()
    }
}
