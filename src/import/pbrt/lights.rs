//! Lights: a unit of pbrt, which its picture shows as 1, is a W/(m² sr) here; so are its intensities and irradiances.

use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

use glam::{DMat4, DVec3};

use super::parameters::{Parameters, shortened};
use super::spectra;
use crate::import::image;
use crate::math::Dir3;
use crate::radiometry::Spectrum;
use crate::scene::PhotonChoice;
use crate::scene::description::{Emission, ExtentDescription, LightDescription, LightModel};
use crate::scene::error::Problem;
use crate::scene::panorama::{Panorama, Part, Projection};
use crate::scene::texture::TextureMemory;
use crate::scene::texture::Wrap;

/// `LightSource "kind" …`, placed by `to_world`; `None` for one that is switched off.
pub(super) fn describe(
    kind: &str,
    ps: &Parameters,
    to_world: &DMat4,
    folder: &Path,
) -> Result<Option<LightDescription>, Problem> {
    let point = |name, default| -> Result<DVec3, Problem> {
        Ok(to_world.transform_point3(DVec3::from_array(ps.point(name, default)?)))
    };
    let model = match kind {
        "point" => {
            let intensity = power(ps, "I", folder, |_| Ok(4.0 * PI))?;
            LightModel::Point { position: point("from", [0.0; 3])?.to_array(), intensity }
        }
        "spot" => {
            let angle_degrees = ps.number("coneangle", 30.0)?;
            let penumbra_degrees = ps.number("conedeltaangle", 5.0)?;
            let solid_angle = |_: &Parameters| {
                let [end, start] = [angle_degrees, angle_degrees - penumbra_degrees].map(|a| a.to_radians().cos());
                Ok(2.0 * PI * ((1.0 - start) + 0.5 * (start - end)))
            };
            LightModel::Spot {
                intensity: power(ps, "I", folder, solid_angle)?,
                position: point("from", [0.0; 3])?.to_array(),
                target: point("to", [0.0, 0.0, 1.0])?.to_array(),
                angle_degrees,
                penumbra_degrees,
            }
        }
        "distant" => {
            let irradiance = illuminated(ps, folder, 1.0)?;
            let direction = (point("to", [0.0, 0.0, 1.0])? - point("from", [0.0; 3])?).to_array();
            LightModel::Directional { direction, irradiance, extent: ExtentDescription::Unbounded }
        }
        "infinite" => {
            if ps.has("portal") {
                return Err(ps.cannot("lights through a portal cannot be rendered", "take \"point3 portal\" away"));
            }
            match ps.text("filename")? {
                Some(file) => return panorama(ps, file, to_world, folder),
                None => LightModel::Environment { radiance: illuminated(ps, folder, PI)? },
            }
        }
        "goniometric" | "projection" => {
            let message = format!("the light \"{kind}\" cannot be rendered");
            return Err(ps.cannot(message, "use \"point\" or \"spot\""));
        }
        other => {
            let message = format!("there is no light \"{}\"", shortened(other));
            return Err(ps.problem(message, "lights are point, spot, distant and infinite"));
        }
    };
    let (LightModel::Point { intensity: sent, .. }
    | LightModel::Spot { intensity: sent, .. }
    | LightModel::Directional { irradiance: sent, .. }
    | LightModel::Environment { radiance: sent }) = model
    else {
        return Ok(None);
    };
    Ok((sent != [0.0; 3]).then(|| LightDescription {
        source: ps.source.clone(),
        model,
        group: None,
        photons: PhotonChoice::Auto,
        motion: Vec::new(),
    }))
}

/// An infinite light of an image: the octahedral map of the light's own space, which may be mirrored.
fn panorama(ps: &Parameters, file: &str, to_world: &DMat4, folder: &Path) -> Result<Option<LightDescription>, Problem> {
    if ps.has("illuminance") || ps.has("L") {
        let message = "of a light with an image neither \"illuminance\" nor \"L\" can be rendered";
        return Err(ps.cannot(message, "scale it by \"float scale\""));
    }
    let scale = ps.number("scale", 1.0)?;
    if scale < 0.0 {
        return Err(ps.problem(format!("the light's scale is {scale}"), "it must be at least 0"));
    }
    let path = folder.join(file);
    let image = image::read(&path, None, Wrap::Clamp, &TextureMemory::unlimited());
    let image = image.map_err(|problem| problem.at_unless_placed(&ps.source))?;
    let (width, height) = (image.texels.width(), image.texels.height());
    if width != height {
        let message = format!("the image of {width} × {height} texels is no square");
        return Err(
            ps.problem(message, "pbrt's maps are equal-area octahedral ones: its `imgtool makeequiarea` makes them")
        );
    }
    let axes = axes(to_world).ok_or_else(|| {
        ps.cannot("a light of an image that is skewed or scaled unevenly cannot be rendered", "only turn or mirror it")
    })?;
    let (projection, factor) = (Projection::Octahedral, Spectrum::splat(scale));
    let model = LightModel::Panorama(Panorama { image: Arc::new(image), projection, axes, factor, part: Part::All });
    Ok((scale > 0.0).then(|| LightDescription {
        source: ps.source.clone(),
        model,
        group: None,
        photons: PhotonChoice::Auto,
        motion: Vec::new(),
    }))
}

/// Where a light's x, y and z are; `None` if they do not stay perpendicular or equally long.
fn axes(to_world: &DMat4) -> Option<[Dir3; 3]> {
    const ROUNDING: f64 = 1e-6;
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_world.transform_vector3(axis));
    let size = x.length();
    let is_even = [y, z].iter().all(|axis| (axis.length() - size).abs() <= ROUNDING * size);
    let is_square = [(x, y), (y, z), (z, x)].iter().all(|(a, b)| a.dot(*b).abs() <= ROUNDING * size * size);
    let [x, y, z] = [Dir3::new(x)?, Dir3::new(y)?, Dir3::new(z)?];
    (is_even && is_square).then_some([x, y, z])
}

/// `AreaLightSource "diffuse"` on a shape of `area` m²: that of one of pbrt's shapes, which a mesh's triangles are each.
pub(super) fn emission(
    ps: &Parameters,
    area: impl Fn() -> Result<f64, Problem>,
    folder: &Path,
) -> Result<Option<Emission>, Problem> {
    let two_sided = ps.flag("twosided", false)?;
    if ps.has("filename") {
        return Err(ps.cannot("area lights with an image cannot be rendered", "give a constant \"rgb L\""));
    }
    let sides = if two_sided { 2.0 } else { 1.0 };
    let radiance = power(ps, "L", folder, |_| Ok(sides * PI * area()?))?;
    Ok((radiance != [0.0; 3]).then(|| Emission {
        source: ps.source.clone(),
        radiance,
        two_sided,
        group: None,
        photons: PhotonChoice::Auto,
    }))
}

/// The colour `name` times `scale`, white where there is none.
fn scaled(ps: &Parameters, name: &str, folder: &Path) -> Result<[f64; 3], Problem> {
    let colour = ps.find(name).map_or(Ok([1.0; 3]), |p| spectra::light(p, folder))?;
    let scale = ps.number("scale", 1.0)?;
    if scale < 0.0 {
        return Err(ps.problem(format!("the light's scale is {scale}"), "it must be at least 0"));
    }
    Ok(colour.map(|c| c * scale))
}

/// As `power` says, if it does: all that goes out for a unit being `of_unit`.
fn power(
    ps: &Parameters,
    name: &str,
    folder: &Path,
    of_unit: impl Fn(&Parameters) -> Result<f64, Problem>,
) -> Result<[f64; 3], Problem> {
    let colour = scaled(ps, name, folder)?;
    match ps.optional_number("power")? {
        Some(power) if power > 0.0 => {
            let unit = of_unit(ps)?;
            Ok(colour.map(|c| c * power / unit))
        }
        _ => Ok(colour),
    }
}

/// As `illuminance` says, if it does: what a unit brings to a surface that faces it being `of_unit`.
fn illuminated(ps: &Parameters, folder: &Path, of_unit: f64) -> Result<[f64; 3], Problem> {
    let colour = scaled(ps, "L", folder)?;
    match ps.optional_number("illuminance")? {
        Some(illuminance) if illuminance > 0.0 => Ok(colour.map(|c| c * illuminance / of_unit)),
        _ => Ok(colour),
    }
}
