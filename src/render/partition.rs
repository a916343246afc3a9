//! Which technique finds which light: every path from a light to the eye is counted once, by one of them
//! (PHOTON_DIFFERENTIALS 9.4).
//!
//! What the eye receives from a vertex that scatters, its first or one behind `b` of its own bounces, has arrived there
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
//! S is a delta lobe or one of microfacets, D any other. Past a rough surface that it sees before any D the eye looks on,
//! as past a mirror: only what comes to it over delta lobes is the photons' there. An eye path does not go on where its
//! light is the photons'. Light that no surface has scattered, L S* E, is the eye's. `straight` is found in two ways, shadow rays and bounces that run into a light, weighted by the
//! power heuristic; nothing else is found twice.

use crate::scene::RenderSettings;
use crate::scene::settings::Indirect;

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
