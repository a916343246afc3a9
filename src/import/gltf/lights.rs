//! `KHR_lights_punctual`: lights that send along −z of their node, in photometric units.
//!
//! A watt is taken for 683 lm, the efficacy at 555 nm that defines the candela, for every colour: so does Blender, and
//! what it writes comes back as it was.

use glam::{DMat4, DVec3};
use gltf::khr_lights_punctual::{Kind, Light};

use super::nodes::direction;
use crate::import::ignored::Ignored;
use crate::scene::PhotonChoice;
use crate::scene::description::{ExtentDescription, LightDescription, LightModel};
use crate::scene::error::Source;

/// lm/W.
const EFFICACY: f64 = 683.0;

/// A light of the file in the world; `None` for one that is switched off.
pub(super) fn describe(
    light: &Light<'_>,
    to_world: &DMat4,
    source: &Source,
    ignored: &mut Ignored,
) -> Option<LightDescription> {
    // cd to W/sr, lx to W/m².
    let power = light.color().map(|c| f64::from(c) * f64::from(light.intensity()) / EFFICACY);
    if power == [0.0; 3] {
        ignored.note("lights of intensity 0");
        return None;
    }
    ignored.note_if(light.range().is_some(), "the range of lights");
    let position = to_world.w_axis.truncate();
    let along = direction(to_world, DVec3::NEG_Z);
    let model = match light.kind() {
        Kind::Point => LightModel::Point { position: position.to_array(), intensity: power },
        Kind::Directional => LightModel::Directional {
            direction: along.to_array(),
            irradiance: power,
            extent: ExtentDescription::Unbounded,
        },
        Kind::Spot { inner_cone_angle, outer_cone_angle } => {
            let [inner, outer] = [inner_cone_angle, outer_cone_angle].map(|angle| f64::from(angle).to_degrees());
            LightModel::Spot {
                position: position.to_array(),
                target: (position + along).to_array(),
                intensity: power,
                angle_degrees: outer,
                penumbra_degrees: (outer - inner).max(0.0),
            }
        }
    };
    Some(LightDescription {
        source: source.clone(),
        model,
        group: None,
        photons: PhotonChoice::Auto,
        motion: Vec::new(),
    })
}
