//! Methods as data: a name, the settings it stands for, and the one parameter that a study may turn.

use crate::import::Override;

/// The parameter that trades noise against blur.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// k of the k nearest photons.
    Neighbours,
    /// s, the scale of the footprints.
    Scale,
    /// Metres: the disc of the first pass.
    Radius,
}

impl Parameter {
    /// As tables name it.
    pub fn name(self) -> &'static str {
        match self {
            Parameter::Neighbours => "k",
            Parameter::Scale => "s",
            Parameter::Radius => "radius",
        }
    }

    /// The setting that holds `value`.
    pub fn setting(self, value: f64) -> Override {
        match self {
            Parameter::Neighbours => Override::new("render.k", format!("{}", value.round())),
            // `{:?}` keeps the point of a whole number and every digit.
            Parameter::Scale => Override::new("render.bandwidth", format!("{value:?}")),
            Parameter::Radius => Override::new("render.radius", format!("{value:?}")),
        }
    }
}

/// A method of the literature.
struct Preset {
    name: &'static str,
    parameter: Option<Parameter>,
    settings: &'static [(&'static str, &'static str)],
}

/// What the published methods fix. Epanechnikov's kernel is the one of `[Schjoth07]` for both of its methods, and the
/// best for random photons; even emission is at its best under the smoother default.
const PRESETS: [Preset; 11] = [
    Preset {
        name: "knn",
        parameter: Some(Parameter::Neighbours),
        settings: &[("estimator", "knn"), ("emission", "random"), ("kernel", "epanechnikov")],
    },
    Preset {
        name: "pd-parallelogram",
        parameter: Some(Parameter::Scale),
        settings: &[("footprint", "parallelogram"), ("emission", "random"), ("kernel", "epanechnikov")],
    },
    Preset {
        name: "pd-random",
        parameter: Some(Parameter::Scale),
        settings: &[("emission", "random"), ("kernel", "epanechnikov")],
    },
    Preset { name: "pd-jittered", parameter: Some(Parameter::Scale), settings: &[("emission", "jittered")] },
    Preset { name: "pd-lattice", parameter: Some(Parameter::Scale), settings: &[("emission", "lattice")] },
    Preset {
        name: "sppm",
        parameter: Some(Parameter::Radius),
        // The eye's points are drawn anew in each pass, one a pixel.
        settings: &[
            ("estimator", "sppm"),
            ("emission", "random"),
            ("kernel", "uniform"),
            ("passes", "16"),
            ("spp", "1"),
        ],
    },
    Preset {
        name: "knn-global",
        parameter: Some(Parameter::Neighbours),
        settings: &[("estimator", "knn"), ("emission", "random"), ("kernel", "epanechnikov"), ("indirect", "global")],
    },
    Preset {
        name: "pd-global",
        parameter: Some(Parameter::Scale),
        settings: &[("emission", "lattice"), ("indirect", "global")],
    },
    Preset {
        name: "final-gather",
        parameter: Some(Parameter::Scale),
        settings: &[("emission", "lattice"), ("indirect", "final_gather")],
    },
    Preset { name: "path", parameter: None, settings: &[("method", "path")] },
    Preset { name: "light", parameter: None, settings: &[("method", "light"), ("emission", "random")] },
];

/// Names that need no further definition.
pub fn preset_names() -> [&'static str; PRESETS.len()] {
    PRESETS.map(|preset| preset.name)
}

/// A method of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    pub name: String,
    pub parameter: Option<Parameter>,
    pub overrides: Vec<Override>,
}

impl Method {
    /// The method `like` of the literature, called `name`, with more settings laid over it.
    pub fn new(name: &str, like: &str, more: &[Override]) -> Option<Method> {
        let preset = PRESETS.iter().find(|preset| preset.name == like)?;
        let setting = |&(key, value): &(&str, &str)| Override::new(format!("render.{key}"), value);
        let overrides = preset.settings.iter().map(setting).chain(more.iter().cloned()).collect();
        Some(Method { name: name.to_owned(), parameter: preset.parameter, overrides })
    }

    /// The value that a setting of the method has, if it sets it.
    pub fn setting(&self, key: &str) -> Option<&str> {
        self.overrides.iter().rev().find(|o| o.key() == key).map(Override::value)
    }

    /// Whether light or eye paths do without a photon map.
    pub fn traces_eye_paths_only(&self) -> bool {
        self.setting("render.method") == Some("path")
    }
}
