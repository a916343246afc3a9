//! What lights send in every pass: how many photons, of what kind, and whither.

use std::sync::Arc;

use super::bounce::Bounces;
use super::guide::Guide;
use super::path::FirstEvent;
use super::share::Share;
use crate::light::{Aim, Lights};
use crate::scene::LightId;

/// Whither a light's photons set out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    pub aim: Aim,
    /// Only where one of this group is met first do they go on, if a group is meant.
    pub group: Option<u32>,
}

impl Target {
    /// All that is within reach.
    pub fn all(aim: Aim) -> Target {
        Target { aim, group: None }
    }
}

/// What one light sends in every pass.
#[derive(Clone, Debug)]
pub struct EmissionPlan {
    pub light: LightId,
    pub target: Target,
    /// Points that fill its emission map.
    pub points: u64,
    /// The cell that each stands for.
    pub share: Share,
    /// Which of them are kept; all of them if there is none.
    pub guide: Option<Arc<Guide>>,
    /// Which part of the light's caustics eye paths bring; photons bring the rest.
    pub eyes_part: f64,
}

impl EmissionPlan {
    /// `n` photons for each light, evenly over its map; lights that are due none are left out. `share` gives the cell of
    /// each of a light's n photons.
    pub fn even(
        lights: &Lights,
        target: Target,
        due: &[u64],
        share: impl Fn(LightId, u64) -> Share,
    ) -> Vec<EmissionPlan> {
        let lights = lights.iter().zip(due).filter(|&(_, &n)| n > 0);
        lights
            .map(|((light, _), &points)| EmissionPlan {
                light,
                target,
                points,
                share: share(light, points),
                guide: None,
                eyes_part: 0.0,
            })
            .collect()
    }

    /// About how many photons are emitted.
    pub fn photons(&self) -> f64 {
        self.points as f64 * self.guide.as_ref().map_or(1.0, |guide| guide.kept())
    }
}

/// What all lights send of one kind of photons in every pass.
#[derive(Clone, Debug)]
pub struct Population {
    pub plans: Vec<EmissionPlan>,
    pub first_event: FirstEvent,
    /// How they go on from surfaces that scatter, if they do.
    pub bounces: Option<Bounces>,
    /// So many of them share the directions of a glossy lobe out between them: the cell of each is 1/(sharing p), sr.
    pub sharing: f64,
    /// Whether they bring the light that comes straight from surfaces that scatter, too.
    pub stores_scattered: bool,
    /// Whether they become beams in media, instead of photons on surfaces.
    pub makes_beams: bool,
}

impl Population {
    pub const NONE: Population = Population {
        plans: Vec::new(),
        first_event: FirstEvent::Delta,
        bounces: None,
        sharing: f64::INFINITY,
        stores_scattered: false,
        makes_beams: false,
    };
}
