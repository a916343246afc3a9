//! What an artist may leave out of a picture: caustics that an object casts or receives, photons of a light. No physics is
//! meant; what is left out is dropped, not found in another way.

use super::ids::LightId;

/// Whether an object takes part in caustics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Caustics {
    /// Whether light that its mirrors, glass and glossy lobes focus is in the picture.
    pub cast: bool,
    /// Whether the caustics on it are.
    pub receive: bool,
}

impl Default for Caustics {
    fn default() -> Caustics {
        Caustics { cast: true, receive: true }
    }
}

/// How many of a pass's photons for caustics a light gets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PhotonChoice {
    /// Its share of those that no light asks for, by what it sends and where that is of use.
    #[default]
    Auto,
    /// None: what is focused of its light is left out.
    Off,
    Count(u64),
}

/// The choice of each light.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightPhotons(Vec<PhotonChoice>);

impl LightPhotons {
    pub fn new(choices: Vec<PhotonChoice>) -> LightPhotons {
        LightPhotons(choices)
    }

    pub fn of(&self, light: LightId) -> PhotonChoice {
        self.0.get(light.index()).copied().unwrap_or_default()
    }

    /// Photons of a pass that lights ask for by number.
    pub fn asked(&self) -> u64 {
        let count = |choice: &PhotonChoice| match choice {
            PhotonChoice::Count(n) => *n,
            PhotonChoice::Auto | PhotonChoice::Off => 0,
        };
        self.0.iter().map(count).fold(0, u64::saturating_add)
    }

    pub fn all_auto(&self) -> bool {
        self.0.iter().all(|choice| *choice == PhotonChoice::Auto)
    }
}
