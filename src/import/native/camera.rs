//! `[camera]` and `[render]`.

use toml::Spanned;
use toml::de::DeValue;

use crate::import::keyed::convert::{
    ANY, Array, Choice, Convert, Direction, Integer, Mismatch, Number, POINT, POSITIVE, found,
};
use crate::import::keyed::reader::Section;
use crate::scene::GroupLayer;
use crate::scene::camera::PixelFilter;
use crate::scene::description::{CameraDescription, CameraKeyDescription, CameraModelDescription};
use crate::scene::settings::{
    BackendKind, Bandwidth, BounceFootprint, Caustics, EmissionPattern, Estimator, FootprintRule, Guiding, Indirect,
    KernelShape, Layer, MAX_PHOTONS_PER_PASS, MediaEstimator, Method, Radius, RenderSettings, TimeKernel,
    TimeResolution,
};

/// Pixels along one side at most.
const MAX_RESOLUTION: u64 = 65_536;

#[derive(Clone, Copy)]
enum ModelName {
    Perspective,
    Orthographic,
    ThinLens,
}

impl ModelName {
    fn of(model: CameraModelDescription) -> ModelName {
        match model {
            CameraModelDescription::Perspective { .. } => ModelName::Perspective,
            CameraModelDescription::Orthographic { .. } => ModelName::Orthographic,
            CameraModelDescription::ThinLens { .. } => ModelName::ThinLens,
        }
    }
}

const MODELS: Choice<'_, ModelName> = Choice {
    names: &["perspective", "orthographic", "thin_lens"],
    from_name: |name| match name {
        "perspective" => Some(ModelName::Perspective),
        "orthographic" => Some(ModelName::Orthographic),
        "thin_lens" => Some(ModelName::ThinLens),
        _ => None,
    },
};

const FILTERS: Choice<'_, PixelFilter> = Choice {
    names: &["box", "gaussian"],
    from_name: |name| match name {
        "box" => Some(PixelFilter::Box),
        "gaussian" => Some(PixelFilter::Gaussian),
        _ => None,
    },
};

/// The camera of a table; what that leaves out is as in `base`, if there is one.
pub(super) fn read(section: Section<'_>, base: Option<&CameraDescription>) -> CameraDescription {
    let model_name = match section.get("type") {
        Some(value) => section.reader.convert("type", value, &MODELS),
        None if base.is_some() => base.map(|b| ModelName::of(b.model)),
        None => {
            section.missing("type", &MODELS.expects());
            None
        }
    };
    let base_model = base.map(|b| b.model);
    let model = read_model(&section, model_name.unwrap_or(ModelName::Perspective), model_name.is_some(), base_model);
    let resolution = Array(Integer::within(1, MAX_RESOLUTION));
    let base_resolution = base.map(|b| b.resolution.map(u64::from));
    let camera = CameraDescription {
        source: section.source(),
        model,
        position: as_in_base(&section, "position", POINT, base.map(|b| b.position), [0.0, 0.0, 1.0]),
        target: as_in_base(&section, "target", POINT, base.map(|b| b.target), [0.0; 3]),
        up: section.or("up", Direction, base.map_or([0.0, 1.0, 0.0], |b| b.up)),
        resolution: as_in_base(&section, "resolution", resolution, base_resolution, [1, 1]).map(|n| n as u32),
        filter: section.or("filter", FILTERS, base.map_or(PixelFilter::Box, |b| b.filter)),
        shutter: section.optional("shutter", Array(ANY)).or(base.and_then(|b| b.shutter)),
        motion: Vec::new(),
    };
    let motion = section.tables("motion", |i| format!("key {i} of the camera's `motion`"));
    let camera = CameraDescription { motion: motion.iter().map(|key| read_key(key, &camera)).collect(), ..camera };
    if model_name.is_some() {
        section.finish();
    }
    camera
}

/// The value of `key`, which may be missing only where there is a base.
fn as_in_base<K: Convert>(
    section: &Section<'_>,
    key: &'static str,
    kind: K,
    base: Option<K::Output>,
    placeholder: K::Output,
) -> K::Output {
    match base {
        Some(base) => section.or(key, kind, base),
        None => section.required(key, kind, placeholder),
    }
}

/// A place at a time; what it does not say is as in `camera`.
fn read_key(section: &Section<'_>, camera: &CameraDescription) -> CameraKeyDescription {
    let key = CameraKeyDescription {
        source: section.source(),
        time: section.required("time", ANY, 0.0),
        position: section.or("position", POINT, camera.position),
        target: section.or("target", POINT, camera.target),
        up: section.or("up", Direction, camera.up),
    };
    section.finish();
    key
}

/// The keys of the model; with `known` false its name was wrong and no key is missed.
fn read_model(
    section: &Section<'_>,
    name: ModelName,
    known: bool,
    base: Option<CameraModelDescription>,
) -> CameraModelDescription {
    const PLACEHOLDER: CameraModelDescription = CameraModelDescription::Orthographic { width: 1.0 };
    let angle = Number::between(0.0, 180.0);
    let base_angle = match base {
        Some(
            CameraModelDescription::Perspective { fov_degrees } | CameraModelDescription::ThinLens { fov_degrees, .. },
        ) => Some(fov_degrees),
        _ => None,
    };
    let base_width = match base {
        Some(CameraModelDescription::Orthographic { width }) => Some(width),
        _ => None,
    };
    let base_lens = match base {
        Some(CameraModelDescription::ThinLens { lens_radius, focus_distance, .. }) => {
            [lens_radius, focus_distance].map(Some)
        }
        _ => [None; 2],
    };
    let fov_degrees = || as_in_base(section, "fov_degrees", angle, base_angle, 90.0);
    match name {
        _ if !known => PLACEHOLDER,
        ModelName::Perspective => CameraModelDescription::Perspective { fov_degrees: fov_degrees() },
        ModelName::Orthographic => {
            CameraModelDescription::Orthographic { width: as_in_base(section, "width", POSITIVE, base_width, 1.0) }
        }
        ModelName::ThinLens => CameraModelDescription::ThinLens {
            fov_degrees: fov_degrees(),
            lens_radius: as_in_base(section, "lens_radius", POSITIVE, base_lens[0], 1.0),
            focus_distance: as_in_base(section, "focus_distance", POSITIVE, base_lens[1], 1.0),
        },
    }
}

/// "auto", which is `None`, or a number.
#[derive(Clone, Copy)]
struct AutoOr(Number);

impl Convert for AutoOr {
    type Output = Option<f64>;
    fn expects(&self) -> String {
        format!("\"auto\" or {}", self.0.expects())
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<Option<f64>, Mismatch> {
        match value.get_ref() {
            DeValue::String(s) if s == "auto" => Ok(None),
            _ => self.0.convert(value).map(Some),
        }
    }
}

/// "auto", which is `None`, or a count.
#[derive(Clone, Copy)]
struct AutoOrCount(Integer);

impl Convert for AutoOrCount {
    type Output = Option<u64>;
    fn expects(&self) -> String {
        format!("\"auto\" or {}", self.0.expects())
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<Option<u64>, Mismatch> {
        match value.get_ref() {
            DeValue::String(s) if s == "auto" => Ok(None),
            _ => self.0.convert(value).map(Some),
        }
    }
}

/// A list of layers, each once.
#[derive(Clone, Copy)]
struct Layers;

impl Convert for Layers {
    type Output = (Vec<Layer>, Vec<GroupLayer>);
    fn expects(&self) -> String {
        format!(
            "an array of layers, each {}, or direct_, caustic_ or indirect_ and a group of lights or *",
            LAYERS.expects()
        )
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<Self::Output, Mismatch> {
        let DeValue::Array(items) = value.get_ref() else {
            return Err(Mismatch { found: found(value.get_ref()), span: value.span() });
        };
        let (mut layers, mut grouped) = (Vec::new(), Vec::new());
        for item in items.iter() {
            let is_new = match item.get_ref().as_str().and_then(GroupLayer::from_name) {
                Some(layer) => push_new(&mut grouped, layer),
                None => push_new(&mut layers, LAYERS.convert(item)?),
            };
            if !is_new {
                let name = item.get_ref().as_str().unwrap_or_default();
                return Err(Mismatch { found: format!("\"{name}\" twice"), span: item.span() });
            }
        }
        Ok((layers, grouped))
    }
}

/// False if it was there.
fn push_new<T: PartialEq>(list: &mut Vec<T>, item: T) -> bool {
    let is_new = !list.contains(&item);
    if is_new {
        list.push(item);
    }
    is_new
}

const LAYERS: Choice<'_, Layer> = Choice { names: Layer::NAMES, from_name: Layer::from_name };

const KERNELS: Choice<'_, KernelShape> = Choice {
    names: &["uniform", "cone", "epanechnikov", "biweight", "silverman", "triweight", "gaussian"],
    from_name: |name| if name == "silverman" { Some(KernelShape::Biweight) } else { KernelShape::from_name(name) },
};

/// The settings of a table; what that leaves out is as in `default`.
pub(super) fn read_settings(section: Section<'_>, default: RenderSettings) -> RenderSettings {
    const LARGE: u64 = 1_000_000;
    let count = |min| Integer::within(min, LARGE);
    let depth = |min| Integer::within(min, 65_535);
    let photons = Integer {
        min: 1,
        max: MAX_PHOTONS_PER_PASS,
        help: Some("photons of one pass; use render.passes to emit more, a million is a good start"),
    };
    let (layers, group_layers) = section.or("layers", Layers, (default.layers, default.group_layers));
    let settings = RenderSettings {
        method: section.or("method", Choice { names: Method::NAMES, from_name: Method::from_name }, default.method),
        backend: section.or(
            "backend",
            Choice { names: BackendKind::NAMES, from_name: BackendKind::from_name },
            default.backend,
        ),
        seed: section.or("seed", Integer::within(0, u64::MAX), default.seed),
        passes: section.or("passes", count(1), default.passes.into()) as u32,
        spp: section.or("spp", count(1), default.spp.into()) as u32,
        photons: section.or("photons", photons, default.photons),
        beams: section.or("beams", Integer::within(1, MAX_PHOTONS_PER_PASS), default.beams),
        media_estimator: section.or(
            "media_estimator",
            Choice { names: MediaEstimator::NAMES, from_name: MediaEstimator::from_name },
            default.media_estimator,
        ),
        beam_points: section.or("beam_points", Integer::within(1, 65_536), default.beam_points.into()) as u32,
        emission: section.or(
            "emission",
            Choice { names: EmissionPattern::NAMES, from_name: EmissionPattern::from_name },
            default.emission,
        ),
        guiding: section.or(
            "guiding",
            Choice { names: Guiding::NAMES, from_name: Guiding::from_name },
            default.guiding,
        ),
        estimator: section.or(
            "estimator",
            Choice { names: Estimator::NAMES, from_name: Estimator::from_name },
            default.estimator,
        ),
        footprint: section.or(
            "footprint",
            Choice { names: FootprintRule::NAMES, from_name: FootprintRule::from_name },
            default.footprint,
        ),
        caustics: section.or(
            "caustics",
            Choice { names: Caustics::NAMES, from_name: Caustics::from_name },
            default.caustics,
        ),
        indirect: section.or(
            "indirect",
            Choice { names: Indirect::NAMES, from_name: Indirect::from_name },
            default.indirect,
        ),
        bounce_footprint: section.or(
            "bounce_footprint",
            Choice { names: BounceFootprint::NAMES, from_name: BounceFootprint::from_name },
            default.bounce_footprint,
        ),
        kernel: section.or("kernel", KERNELS, default.kernel),
        bandwidth: section.or("bandwidth", AutoOr(POSITIVE), None).map_or(Bandwidth::Auto, Bandwidth::Scale),
        // The k-th neighbour only sets the radius, so at least one more is needed.
        k: section.or("k", count(2), default.k.into()) as u32,
        radius: section.or("radius", AutoOr(POSITIVE), None).map_or(Radius::Auto, Radius::Metres),
        time_cells: section
            .or("time_cells", AutoOrCount(count(1)), None)
            .map_or(TimeResolution::Auto, |n| TimeResolution::Cells(n as u32)),
        time_kernel: section.or(
            "time_kernel",
            Choice { names: TimeKernel::NAMES, from_name: TimeKernel::from_name },
            default.time_kernel,
        ),
        max_depth: section.or("max_depth", depth(1), default.max_depth.into()) as u32,
        max_bounces: section.or("max_bounces", depth(0), default.max_bounces.into()) as u32,
        layers,
        group_layers,
    };
    section.finish();
    settings
}
