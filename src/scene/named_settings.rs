//! Settings under the names that scene files and the command line give them.

use std::collections::BTreeMap;

use super::light_group::GroupLayer;
use super::settings::{Bandwidth, Radius, RenderSettings, TimeResolution};

/// Every setting under its name in scene files.
pub fn settings_by_name(settings: &RenderSettings) -> BTreeMap<String, serde_json::Value> {
    let bandwidth = match settings.bandwidth {
        Bandwidth::Auto => "auto".into(),
        Bandwidth::Scale(s) => s.into(),
    };
    let radius = match settings.radius {
        Radius::Auto => "auto".into(),
        Radius::Metres(radius) => radius.into(),
    };
    let layers = settings.layers.iter().map(|layer| layer.name().to_owned());
    let layers: Vec<String> = layers.chain(settings.group_layers.iter().map(GroupLayer::name)).collect();
    let time_cells = match settings.time_cells {
        TimeResolution::Auto => "auto".into(),
        TimeResolution::Cells(count) => count.into(),
    };
    let all: [(&str, serde_json::Value); 25] = [
        ("method", settings.method.name().into()),
        ("backend", settings.backend.name().into()),
        ("seed", settings.seed.into()),
        ("passes", settings.passes.into()),
        ("spp", settings.spp.into()),
        ("photons", settings.photons.into()),
        ("beams", settings.beams.into()),
        ("media_estimator", settings.media_estimator.name().into()),
        ("beam_points", settings.beam_points.into()),
        ("emission", settings.emission.name().into()),
        ("estimator", settings.estimator.name().into()),
        ("guiding", settings.guiding.name().into()),
        ("footprint", settings.footprint.name().into()),
        ("caustics", settings.caustics.name().into()),
        ("indirect", settings.indirect.name().into()),
        ("bounce_footprint", settings.bounce_footprint.name().into()),
        ("kernel", settings.kernel.name().into()),
        ("bandwidth", bandwidth),
        ("k", settings.k.into()),
        ("radius", radius),
        ("time_cells", time_cells),
        ("time_kernel", settings.time_kernel.name().into()),
        ("max_depth", settings.max_depth.into()),
        ("max_bounces", settings.max_bounces.into()),
        ("layers", layers.into()),
    ];
    all.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}
