//! Light sources: that they send something somewhere.

use std::sync::Arc;

use super::Report;
use super::motion::moving_light;
use crate::math::{Dir3, Motion, Point3, Transform, Vec3};
use crate::radiometry::Spectrum;
use crate::scene::artistic::{LightPhotons, PhotonChoice};
use crate::scene::camera::Shutter;
use crate::scene::description::{ExtentDescription, LightDescription, LightModel, SceneDescription};
use crate::scene::error::Problem;
use crate::scene::light::{BeamExtent, LightSource};

/// Cosine between axes up to which they count as perpendicular.
const PERPENDICULAR: f64 = 1e-6;

/// The lights of a description; area lights come behind them, without motions of their own.
#[derive(Default)]
pub(super) struct AssembledLights {
    /// Where they are in the middle of the shutter's interval.
    pub sources: Vec<LightSource>,
    /// How they move meanwhile.
    pub motions: Vec<Option<Arc<Motion>>>,
    /// Which of the description's each is, or is a part of.
    pub described: Vec<usize>,
    /// How many photons each is to send.
    pub photons: Vec<PhotonChoice>,
}

pub(super) fn assemble(described: &[LightDescription], shutter: Shutter, report: &mut Report) -> AssembledLights {
    let mut lights = AssembledLights::default();
    for (i, light) in described.iter().enumerate() {
        let Some(source) = assemble_light(light, report) else { continue };
        let Some((place, motion)) = moving_light(&format!("light {i}"), &light.motion, shutter, report) else {
            continue;
        };
        let parts = in_parts(moved(source, &place, light, report));
        let photons = match light.photons {
            PhotonChoice::Count(n) => PhotonChoice::Count(n.div_ceil(parts.len().max(1) as u64)),
            choice => choice,
        };
        for source in parts {
            lights.sources.push(source);
            lights.motions.push(motion.clone());
            lights.photons.push(photons);
            lights.described.push(i);
        }
    }
    lights
}

/// Numbers of photons that a pass can send; and what a picture is to leave out is told.
pub(super) fn check_photons(photons: &LightPhotons, description: &SceneDescription, report: &mut Report) {
    let (asked, all) = (photons.asked(), description.settings.photons);
    if asked > all {
        let problem = Problem::new(format!("the lights ask for {asked} photons, a pass has {all}"));
        report
            .problem(problem.help("raise `photons` of [render], or lower those of the lights").at(&description.source));
    }
    let lamps = description.lights.iter().map(|light| (light.photons, &light.source));
    let objects = description.objects.iter().filter_map(|object| object.emission.as_ref());
    let emitting = objects.map(|emission| (emission.photons, &emission.source));
    for (_, source) in lamps.chain(emitting).filter(|(choice, _)| *choice == PhotonChoice::Off) {
        let warning =
            Problem::new("the light sends no photons: what would be focused of it is left out of the picture");
        report.warning(warning.help("this is no physics; take `photons = \"off\"` away to have it").at(source));
    }
    for object in &description.objects {
        for (is_in, what) in [(object.caustics.cast, "casts"), (object.caustics.receive, "receives")] {
            if !is_in {
                let warning =
                    Problem::new(format!("`{}` {what} no caustics: they are left out of the picture", object.name));
                report
                    .warning(warning.help("this is no physics; take `caustics` away to have them").at(&object.source));
            }
        }
    }
}

/// A sun in a sky is a light for itself.
fn in_parts(source: LightSource) -> Vec<LightSource> {
    match source {
        LightSource::Panorama(panorama) => {
            let parts = Arc::unwrap_or_clone(panorama).into_lights();
            parts.into_iter().map(|part| LightSource::Panorama(Arc::new(part))).collect()
        }
        other => vec![other],
    }
}

/// The light where a rigid map puts it.
fn moved(source: LightSource, place: &Transform, described: &LightDescription, report: &mut Report) -> LightSource {
    let turned = |w: Dir3| Dir3::new(place.vector(w.to_vec())).unwrap_or(w);
    match source {
        source if place.is_identity() => source,
        LightSource::Point { position, intensity } => LightSource::Point { position: place.point(position), intensity },
        LightSource::Spot { position, direction, intensity, cos_inner, cos_outer } => {
            let (position, direction) = (place.point(position), turned(direction));
            LightSource::Spot { position, direction, intensity, cos_inner, cos_outer }
        }
        LightSource::Directional { direction, irradiance, extent } => {
            let extent = match extent {
                BeamExtent::Unbounded => BeamExtent::Unbounded,
                BeamExtent::Rectangle { centre, a, b } => {
                    BeamExtent::Rectangle { centre: place.point(centre), a: place.vector(a), b: place.vector(b) }
                }
                BeamExtent::Disk { centre, radius } => BeamExtent::Disk { centre: place.point(centre), radius },
            };
            LightSource::Directional { direction: turned(direction), irradiance, extent }
        }
        LightSource::Environment { .. } | LightSource::Panorama(_) => {
            let problem = Problem::new("light: the environment lies infinitely far away, it has no motion");
            report.problem(problem.help("take `motion` away").at(&described.source));
            source
        }
        // Made of objects later on.
        LightSource::Area { .. } => source,
    }
}

/// At least one light must emit something.
pub(super) fn check_some_light(lights: &[LightSource], description: &SceneDescription, report: &mut Report) {
    let described = !description.lights.is_empty() || description.objects.iter().any(|o| o.emission.is_some());
    if lights.is_empty() && !described {
        let problem = Problem::new("the scene has no light").at(&description.source);
        report.problem(problem.help("add a [[lights]] table, or give an object `emission`"));
    }
}

fn assemble_light(light: &LightDescription, report: &mut Report) -> Option<LightSource> {
    let mut checks = Checks { light, report };
    match light.model {
        LightModel::Point { position, intensity } => {
            let intensity = checks.power("intensity", intensity);
            Some(LightSource::Point { position: checks.point("position", position), intensity })
        }
        LightModel::Spot { position, target, intensity, angle_degrees, penumbra_degrees } => {
            let intensity = checks.power("intensity", intensity);
            let position = checks.point("position", position);
            let axis = checks.point("target", target) - position;
            if !(angle_degrees > 0.0 && angle_degrees <= 180.0) {
                checks.refuse(format!("`angle_degrees` is {angle_degrees}"), "it must be above 0 and at most 180");
            }
            if !(0.0..=angle_degrees).contains(&penumbra_degrees) {
                let help = "it must be from 0 to `angle_degrees`";
                checks.refuse(format!("`penumbra_degrees` is {penumbra_degrees}"), help);
            }
            let direction = checks.direction("`position` and `target` are the same point", axis)?;
            let cos_inner = (angle_degrees - penumbra_degrees).to_radians().cos();
            let cos_outer = angle_degrees.to_radians().cos();
            Some(LightSource::Spot { position, direction, intensity, cos_inner, cos_outer })
        }
        LightModel::Directional { direction, irradiance, extent } => {
            let irradiance = checks.power("irradiance", irradiance);
            let direction = checks.direction("`direction` has no length", Vec3::from(direction))?;
            let extent = checks.extent(extent, direction)?;
            Some(LightSource::Directional { direction, irradiance, extent })
        }
        LightModel::Environment { radiance } => {
            Some(LightSource::Environment { radiance: checks.power("radiance", radiance) })
        }
        LightModel::Panorama(ref panorama) => {
            checks.power("radiance.factor", panorama.factor.to_array());
            if panorama.integral().0.is_black() {
                checks.refuse(
                    "the image is black: it emits nothing".to_owned(),
                    "take another image, or remove the light",
                );
                return None;
            }
            Some(LightSource::Panorama(Arc::new(panorama.clone())))
        }
    }
}

struct Checks<'a> {
    light: &'a LightDescription,
    report: &'a mut Report,
}

impl Checks<'_> {
    fn refuse(&mut self, message: String, help: &str) {
        self.report.problem(Problem::new(format!("light: {message}")).help(help).at(&self.light.source));
    }

    fn power(&mut self, name: &str, value: [f64; 3]) -> Spectrum {
        let power = Spectrum::from(value);
        if !(power.is_finite() && power.min_component() >= 0.0) {
            self.refuse(format!("`{name}` is {value:?}"), "it must be finite and ≥ 0");
        } else if power.is_black() {
            self.refuse(format!("`{name}` is 0: it emits nothing"), "give it power, or remove the light");
        }
        power
    }

    fn point(&mut self, name: &str, value: [f64; 3]) -> Point3 {
        let point = Point3::from(value);
        if !point.is_finite() {
            self.refuse(format!("`{name}` is {value:?}"), "give finite numbers");
        }
        point
    }

    fn direction(&mut self, message: &str, value: Vec3) -> Option<Dir3> {
        let direction = Dir3::new(value);
        if direction.is_none() {
            self.refuse(message.to_owned(), "it must point somewhere");
        }
        direction
    }

    fn extent(&mut self, extent: ExtentDescription, direction: Dir3) -> Option<BeamExtent> {
        match extent {
            ExtentDescription::Unbounded => Some(BeamExtent::Unbounded),
            ExtentDescription::Disk { centre, radius } => {
                if !(radius > 0.0 && radius.is_finite()) {
                    self.refuse(format!("`extent.radius` is {radius}"), "it must be a finite number > 0");
                }
                Some(BeamExtent::Disk { centre: self.point("extent.centre", centre), radius })
            }
            ExtentDescription::Rectangle { centre, a, b } => {
                let centre = self.point("extent.centre", centre);
                let (a, b) = (Vec3::from(a), Vec3::from(b));
                let unit_a = self.direction("`extent.a` has no length", a)?;
                let unit_b = self.direction("`extent.b` has no length", b)?;
                for (what, cosine) in [
                    ("`extent.a` and `extent.b` are not perpendicular", unit_a.dot(unit_b)),
                    ("`extent.a` is not perpendicular to `direction`", unit_a.dot(direction)),
                    ("`extent.b` is not perpendicular to `direction`", unit_b.dot(direction)),
                ] {
                    if cosine.abs() > PERPENDICULAR {
                        let message = format!("{what} (the cosine of their angle is {cosine:.3e})");
                        self.refuse(message, "the extent is the beam's cross-section: half axes across the direction");
                    }
                }
                Some(BeamExtent::Rectangle { centre, a, b })
            }
        }
    }
}
