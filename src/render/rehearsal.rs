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

/// Sizes of passes between a whole and its half, in eighths; as many between the half and the quarter, and so on.
const EIGHTHS: [u32; 4] = [8, 7, 6, 5];

/// A part of a pass that was rendered for the clock alone.
#[derive(Clone, Copy, Debug)]
pub struct Rehearsal {
    /// How large a part.
    size: f64,
    taken: Duration,
}

impl Rehearsal {
    /// Renders the smallest part of a pass of the whole picture. `None`: it has one eye sample, hence no parts, or it was
    /// stopped.
    pub fn of_pass(world: &mut World, watch: &dyn Watch) -> Result<Option<Rehearsal>, BadCamera> {
        let settings = world.scene.settings.clone();
        let Some(size) = smaller_sizes(&settings).last() else { return Ok(None) };
        world.scene.settings = part(&settings, size);
        let start = Instant::now();
        let mut state = RenderState::new(world, PixelBounds::whole(world.scene.camera.resolution), 0);
        let ended = go_on(world, &mut state, watch, |state| state.film.passes() == 0);
        world.scene.settings = settings;
        let is_done = ended? == Ended::Done;
        Ok(is_done.then(|| Rehearsal { size, taken: start.elapsed() }))
    }

    /// What a whole pass takes, about.
    pub fn pass(&self) -> Duration {
        self.taken.div_f64(self.size)
    }

    /// Settings whose passes are the largest parts that end within `left` of when the rehearsal began, or else the smallest
    /// ones; their number is such that the whole has as many photons and samples. `None`: a pass ends in time as it is.
    pub fn fit(&self, settings: &RenderSettings, left: Duration) -> Option<RenderSettings> {
        let left = left.saturating_sub(self.taken);
        if self.pass() <= left {
            return None;
        }
        let in_time = smaller_sizes(settings).find(|&size| self.pass().mul_f64(size) <= left);
        let size = in_time.or_else(|| smaller_sizes(settings).last())?;
        let passes = (f64::from(settings.passes) / size).ceil() as u32;
        Some(RenderSettings { passes, ..part(settings, size) })
    }
}

/// Shares of a pass that are passes of their own, descending.
fn smaller_sizes(settings: &RenderSettings) -> impl Iterator<Item = f64> {
    let smallest = 1.0 / f64::from(settings.spp.clamp(1, MOST_PARTS));
    let sizes = (0..).flat_map(|halvings: u32| EIGHTHS.map(|eighths| f64::from(eighths) / f64::from(8u32 << halvings)));
    sizes.skip(1).take_while(move |&size| size >= smallest)
}

fn part(settings: &RenderSettings, size: f64) -> RenderSettings {
    RenderSettings {
        photons: (settings.photons as f64 * size).ceil() as u64,
        spp: (f64::from(settings.spp) * size).round() as u32,
        ..settings.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_are_as_large_as_the_time_allows() {
        let settings = RenderSettings { photons: 1_000_000, spp: 16, passes: 1, ..RenderSettings::default() };
        let rehearsal = Rehearsal { size: 1.0 / 16.0, taken: Duration::from_secs(1) };
        assert_eq!(rehearsal.pass(), Duration::from_secs(16));
        let fit = |seconds| {
            let fitted = rehearsal.fit(&settings, Duration::from_secs_f64(seconds))?;
            Some((fitted.photons, fitted.spp, fitted.passes))
        };
        assert_eq!(fit(17.0), None);
        assert_eq!(fit(16.5), Some((875_000, 14, 2)));
        assert_eq!(fit(12.0), Some((625_000, 10, 2)));
        assert_eq!(fit(4.0), Some((187_500, 3, 6)));
        assert_eq!(fit(0.0), Some((62_500, 1, 16)));
    }

    #[test]
    fn no_pass_has_less_than_a_sample() {
        let of = |spp| smaller_sizes(&RenderSettings { spp, ..RenderSettings::default() }).collect::<Vec<f64>>();
        assert_eq!(of(1), [0.0; 0]);
        assert_eq!(of(3), [0.875, 0.75, 0.625, 0.5, 0.4375, 0.375]);
        assert_eq!((of(16).len(), of(16).last()), (16, Some(&0.0625)));
        assert_eq!(of(16), of(1000));
        let smallest =
            |spp| part(&RenderSettings { spp, ..RenderSettings::default() }, *of(spp).last().expect("a part"));
        assert!((2..100).all(|spp| smallest(spp).spp >= 1));
    }
}
