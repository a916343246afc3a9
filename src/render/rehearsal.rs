//! How long a pass takes, told by a small one, and passes that fit into the time there is.

use std::time::{Duration, Instant};

use super::watch::Watch;
use super::{BadCamera, Ended, RenderState, go_on};
use crate::film::PixelBounds;
use crate::scene::RenderSettings;
use crate::world::World;

/// A pass is made smaller by this factor at most: its photons and its eye samples alike, so that whatever takes its time, a
/// part of it takes about that part of the time.
const MOST_PARTS: u32 = 16;

/// A part of a pass that was rendered for the clock alone.
#[derive(Clone, Copy, Debug)]
pub struct Rehearsal {
    /// How many of them make a pass.
    parts: u32,
    taken: Duration,
}

impl Rehearsal {
    /// Renders the smallest part of a pass of the whole picture. `None`: it has one eye sample, hence no parts, or it was
    /// stopped.
    pub fn of_pass(world: &mut World, watch: &dyn Watch) -> Result<Option<Rehearsal>, BadCamera> {
        let settings = world.scene.settings.clone();
        let Some(parts) = all_parts(&settings).last() else { return Ok(None) };
        world.scene.settings = part(&settings, parts);
        let start = Instant::now();
        let mut state = RenderState::new(world, PixelBounds::whole(world.scene.camera.resolution), 0);
        let ended = go_on(world, &mut state, watch, |state| state.film.passes() == 0);
        world.scene.settings = settings;
        let is_done = ended? == Ended::Done;
        Ok(is_done.then(|| Rehearsal { parts, taken: start.elapsed() }))
    }

    /// What a whole pass takes, about.
    pub fn pass(&self) -> Duration {
        self.taken * self.parts
    }

    /// Settings whose passes are the largest parts that end within `left`, or else the smallest ones; their number is such
    /// that the whole has as many photons and samples. `None`: a pass ends in time as it is.
    pub fn fit(&self, settings: &RenderSettings, left: Duration) -> Option<RenderSettings> {
        if self.pass() <= left {
            return None;
        }
        let in_time = all_parts(settings).find(|&parts| self.pass() / parts <= left);
        let parts = in_time.or_else(|| all_parts(settings).last())?;
        Some(RenderSettings { passes: settings.passes.saturating_mul(parts), ..part(settings, parts) })
    }
}

/// Into how many parts a pass can be cut, ascending.
fn all_parts(settings: &RenderSettings) -> impl Iterator<Item = u32> {
    let most = settings.spp.min(MOST_PARTS);
    (1..).map(|k| 1 << k).take_while(move |&parts| parts <= most)
}

fn part(settings: &RenderSettings, parts: u32) -> RenderSettings {
    RenderSettings {
        photons: settings.photons.div_ceil(u64::from(parts)),
        spp: settings.spp.div_ceil(parts),
        ..settings.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_are_as_large_as_the_time_allows() {
        let settings = RenderSettings { photons: 1_000_000, spp: 16, passes: 1, ..RenderSettings::default() };
        let rehearsal = Rehearsal { parts: 16, taken: Duration::from_secs(1) };
        assert_eq!(rehearsal.pass(), Duration::from_secs(16));
        let fit = |seconds| {
            let fitted = rehearsal.fit(&settings, Duration::from_secs_f64(seconds))?;
            Some((fitted.photons, fitted.spp, fitted.passes))
        };
        assert_eq!(fit(16.0), None);
        assert_eq!(fit(15.0), Some((500_000, 8, 2)));
        assert_eq!(fit(3.0), Some((125_000, 2, 8)));
        assert_eq!(fit(0.0), Some((62_500, 1, 16)));
    }

    #[test]
    fn no_pass_has_less_than_a_sample() {
        let of = |spp| all_parts(&RenderSettings { spp, ..RenderSettings::default() }).collect::<Vec<u32>>();
        assert_eq!(of(1), [0; 0]);
        assert_eq!(of(5), [2, 4]);
        assert_eq!(of(1000), [2, 4, 8, 16]);
    }
}
