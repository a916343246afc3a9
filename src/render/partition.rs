//! Which technique finds which light: every path from a light to the eye is counted once, by one of them
//! (PHOTON_DIFFERENTIALS 9.4).
//!
//! What the eye receives from a vertex that scatters, on a surface or in a medium, its first or one behind `b` of its own
//! bounces, has arrived there
//!
//! | as | path | `path` method | `indirect = path` | `global` | `final_gather` |
//! | --- | --- | --- | --- | --- | --- |
//! | straight | L D | eye | eye | eye | eye |
//! | focused | L S⁺ D | eye | photons | photons | photons |
//! | sent back | L … D S⁺ D | eye | photons | photons | photons |
//! | scattered | L … D D, b = 0 | eye | eye | photons | eye |
//! | | the same, b = 1 | eye | eye | | photons |
//! | | the same, b > 1 | eye | eye | | |
//!
//! S is a delta lobe or one of microfacets, D any other, and a place in a medium, where photons are beams
//! ([`super::beam_light`]). Past a rough surface that it sees before any D the eye looks on, as past a mirror: only what comes to it over delta lobes is the photons' there. An eye path does not go on where its
//! light is the photons'. Light that no surface has scattered, L S* E, is the eye's.
//!
//! Two kinds are found in two ways. `straight` by shadow rays and by bounces that run into a light, weighted by the power
//! heuristic. And `focused`, of lamps that are wide: by photons, and by bounces of the eye that run into the lamp over
//! S⁺, which are weighted by [`EyesPart`], the photons by the rest ([`super::mis`]).

use crate::film::Arrival;
use crate::photon::{EmissionPlan, Kinds, Population};
use crate::scene::settings::Indirect;
use crate::scene::{LightId, RenderSettings};
use crate::world::World;

/// Which light eye paths bring back; photons bring the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EyeFinds {
    /// All of it: the path tracer.
    Everything,
    /// All but what reaches a scattering vertex over S⁺.
    AllButFocused,
    /// Nothing of that, and from the `from`th bounce on nothing that comes straight from a surface that scatters either.
    NothingScattered { from: u32 },
    /// E S* L only: what light tracing cannot connect to the camera.
    Emitters,
}

impl EyeFinds {
    /// What photons leave to the eye.
    pub fn beside_photons(settings: &RenderSettings) -> EyeFinds {
        match settings.indirect {
            Indirect::Path => EyeFinds::AllButFocused,
            Indirect::Global => EyeFinds::NothingScattered { from: 0 },
            Indirect::FinalGather => EyeFinds::NothingScattered { from: 1 },
        }
    }

    /// Whether light over S⁺ is the photons'.
    pub fn leaves_focused(self) -> bool {
        matches!(self, EyeFinds::AllButFocused | EyeFinds::NothingScattered { .. })
    }

    /// Whether light that arrives scattered at a vertex behind so many bounces of the eye is the photons'.
    pub fn leaves_scattered(self, bounces: u32) -> bool {
        matches!(self, EyeFinds::NothingScattered { from } if bounces >= from)
    }
}

/// Whether photons straight from surfaces that scatter have to be stored.
pub fn photons_bring_scattered(settings: &RenderSettings) -> bool {
    settings.indirect != Indirect::Path
}

/// The weight of eye paths on each light's focused light; that of photons is the rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EyesPart(Vec<f64>);

impl EyesPart {
    /// Of so many lights, some of which send photons.
    pub fn new(lights: usize, plans: &[EmissionPlan]) -> EyesPart {
        if plans.iter().all(|plan| plan.eyes_part == 0.0) {
            return EyesPart::default();
        }
        let mut parts = vec![0.0; lights];
        plans.iter().for_each(|plan| parts[plan.light.index()] = plan.eyes_part);
        EyesPart(parts)
    }

    /// Whether all of it is the photons'.
    pub fn is_none(&self) -> bool {
        self.0.is_empty()
    }

    pub fn of(&self, light: LightId) -> f64 {
        self.0[light.index()]
    }
}

/// What is asked of eye paths.
#[derive(Clone, Debug)]
pub struct EyeTask {
    pub finds: EyeFinds,
    /// Of the focused light that is left to photons.
    pub part: EyesPart,
}

impl EyeTask {
    /// Nobody else finds the same light.
    pub fn alone(finds: EyeFinds) -> EyeTask {
        EyeTask { finds, part: EyesPart::default() }
    }

    /// What photons of these plans leave to the eye.
    pub fn beside(world: &World, plans: &Kinds<Population>) -> EyeTask {
        let part = EyesPart::new(world.lights.len(), &plans.caustic.plans);
        EyeTask { finds: EyeFinds::beside_photons(&world.scene.settings), part }
    }
}

/// What an eye path has come over, as far as it says what light that it finds is to the eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Walked {
    /// What a light is that the edge under way runs into.
    pub arrival: Arrival,
    /// Whether the last event that was no delta one was at a glossy surface.
    pub from_glossy: bool,
}

impl Walked {
    /// At the eye.
    pub const START: Walked = Walked { arrival: Arrival::Emission, from_glossy: false };

    /// What light is that comes straight from a lamp to the vertex at the end of the edge. The eye looks on past glossy
    /// surfaces before the first D.
    pub fn straight_at(self, glossy: bool) -> Arrival {
        match self.arrival {
            Arrival::Emission => Arrival::Straight,
            Arrival::Straight if self.from_glossy => Arrival::Straight,
            Arrival::Straight | Arrival::Focused if glossy => Arrival::Focused,
            Arrival::Straight => Arrival::Scattered,
            Arrival::Focused => Arrival::SentBack,
            settled => settled,
        }
    }

    /// Behind an event of that vertex that was no delta one.
    pub fn scattered(self, glossy: bool) -> Walked {
        Walked { arrival: self.straight_at(glossy), from_glossy: glossy }
    }

    /// Behind a delta event.
    pub fn over_delta(self) -> Walked {
        match self.arrival {
            Arrival::Straight => Walked { arrival: Arrival::Focused, ..self },
            _ => self,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Paths as the eye walks them, with what a light is that it runs into at the end: D, G for a glossy surface, S for a
    /// mirror.
    #[test]
    fn paths_are_told_apart_by_how_light_arrives() {
        for (path, expected) in [
            ("", Arrival::Emission),
            ("SS", Arrival::Emission),
            ("D", Arrival::Straight),
            ("SD", Arrival::Straight),
            ("G", Arrival::Straight),
            ("GG", Arrival::Straight),
            ("GD", Arrival::Straight),
            ("DS", Arrival::Focused),
            ("DG", Arrival::Focused),
            ("DSGS", Arrival::Focused),
            ("GS", Arrival::Focused),
            ("GSG", Arrival::Focused),
            ("GDGG", Arrival::Focused),
            ("DSD", Arrival::SentBack),
            ("DGD", Arrival::SentBack),
            ("GSD", Arrival::SentBack),
            ("DSDSDG", Arrival::SentBack),
            ("DD", Arrival::Scattered),
            ("GDD", Arrival::Scattered),
            ("DDS", Arrival::Scattered),
            ("DDGD", Arrival::Scattered),
        ] {
            let end = path.chars().fold(Walked::START, |walked, event| match event {
                'S' => walked.over_delta(),
                _ => walked.scattered(event == 'G'),
            });
            assert_eq!(end.arrival, expected, "{path}");
        }
    }
}
