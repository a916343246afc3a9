//! Reads a study file: TOML, described in [`crate::doc::study_format`].

use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::exact::ClosedForm;
use super::method::{Method, Parameter, preset_names};
use super::metric::SsimDomain;
use super::plan::{
    BandwidthPlan, Baseline, Budget, Experiment, ExperimentMethod, Published, ReferencePart, ReferencePlan, Study,
    StudyScene,
};
use crate::import::keyed::convert::{Array, Choice, Integer, List, Number, POSITIVE, Text};
use crate::import::keyed::reader::{Reader, Section};
use crate::import::keyed::syntax_problems;
use crate::import::keyed::texts::Texts;
use crate::import::{Override, read_scene_text};
use crate::scene::error::{Problem, Problems};
use crate::scene::spelling::nearest;

/// The version of the format that this program reads.
const FORMAT: u64 = 1;

const LARGE: Integer = Integer::within(1, u64::MAX);
const UNIT: Number = Number::above_up_to(0.0, 1.0);

/// Reads the study file `path`.
///
/// # Errors
/// Everything that is wrong with it, each with its line and column.
pub fn read(path: &Path) -> Result<Study, Problems> {
    let text = read_scene_text(path)?;
    read_text(path, &text)
}

/// Like [`read`] with the file's content at hand.
///
/// # Errors
/// As [`read`].
pub fn read_text(path: &Path, text: &str) -> Result<Study, Problems> {
    let texts = Texts::new(path, text);
    let (document, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        return Err(syntax_problems(&errors, &texts));
    }
    let reader = Reader::new(&texts, Problems::default());
    let (span, table) = (document.span(), document.into_inner());
    let study = read_study(&Section::new(&reader, "the study", &table, span), path);
    reader.into_problems().into_result(study).map_err(Problems::sorted)
}

fn read_study(root: &Section<'_>, path: &Path) -> Study {
    let version = Integer { min: FORMAT, max: FORMAT, help: Some("this program reads version 1 of the format") };
    root.required("format", version, FORMAT);
    let title = root.required("title", Text, String::new());
    let about = root.or("about", Text, String::new());
    let scenes: Vec<StudyScene> = root.tables("scenes", |i| format!("scene {i}")).iter().map(read_scene).collect();
    let methods = read_methods(root);
    let names = Names { scenes: scenes.iter().map(|s| s.name.as_str()).collect(), methods: &methods };
    let experiments: Vec<Experiment> =
        root.tables("experiments", |i| format!("experiment {i}")).iter().map(|s| read_experiment(s, &names)).collect();
    for (key, missing) in [("scenes", scenes.is_empty()), ("experiments", experiments.is_empty())] {
        if missing && root.get(key).is_none() {
            root.missing(key, &format!("one or more [[{key}]]"));
        }
    }
    root.finish();
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    Study { title, about, folder, scenes, methods, experiments }
}

/// `key=value` texts, as the command line's `-D` takes them.
fn overrides(section: &Section<'_>) -> Vec<Override> {
    let Some(value) = section.get("set") else { return Vec::new() };
    let Some(texts) = section.reader.convert("set", value, &List(Text)) else { return Vec::new() };
    let report = |problem: Problem| section.reader.report(problem.at(&section.reader.source(value.span())));
    texts.iter().filter_map(|text| text.parse().map_err(report).ok()).collect()
}

fn read_scene(section: &Section<'_>) -> StudyScene {
    let ssim = Choice {
        names: &["linear", "srgb"],
        from_name: |name| match name {
            "linear" => Some(SsimDomain::Linear),
            "srgb" => Some(SsimDomain::Srgb),
            _ => None,
        },
    };
    let scene = StudyScene {
        name: section.required("name", Text, String::new()),
        file: section.required("file", Text, String::new()).into(),
        overrides: overrides(section),
        layer: section.or("layer", Text, String::new()),
        white: section.or("white", POSITIVE, 1.0),
        ssim: section.or("ssim", ssim, SsimDomain::Linear),
        reference: read_reference(section),
    };
    section.finish();
    scene
}

fn read_reference(section: &Section<'_>) -> ReferencePlan {
    let exact = section.optional("exact", Choice { names: ClosedForm::NAMES, from_name: ClosedForm::from_name });
    let parts: Vec<ReferencePart> = section
        .tables("reference", |i| format!("part {i} of the reference"))
        .iter()
        .map(|part| {
            let read = ReferencePart {
                layer: part.or("layer", Text, String::new()),
                overrides: overrides(part),
                passes: part.required("passes", Integer::within(2, 1_000_000), 2) as u32,
            };
            part.finish();
            read
        })
        .collect();
    match (exact, parts.is_empty()) {
        (Some(form), true) => ReferencePlan::Exact(form),
        (None, false) => ReferencePlan::Rendered(parts),
        (None, true) if section.get("exact").is_some() => ReferencePlan::Rendered(parts),
        (_, none) => {
            let what = if none { "needs a reference" } else { "has two references" };
            let problem = Problem::new(format!("{} {what}", section.label()));
            let help = "give `exact`, the closed form that the scene is, or [[scenes.reference]] parts";
            section.reader.report(problem.help(help).at(&section.source()));
            ReferencePlan::Rendered(parts)
        }
    }
}

/// The methods that the file defines, and behind them those that need no definition.
fn read_methods(root: &Section<'_>) -> Vec<Method> {
    let mut methods = Vec::new();
    for section in root.tables("methods", |i| format!("method {i}")) {
        let name = section.required("name", Text, String::new());
        let like = section.required("like", Choice { names: &preset_names(), from_name: preset }, "knn");
        methods.extend(Method::new(&name, like, &overrides(&section)));
        section.finish();
    }
    let known = preset_names().into_iter().filter_map(|name| Method::new(name, name, &[]));
    for method in known {
        if methods.iter().all(|m: &Method| m.name != method.name) {
            methods.push(method);
        }
    }
    methods
}

fn preset(name: &str) -> Option<&'static str> {
    preset_names().into_iter().find(|known| *known == name)
}

/// What experiments may name.
struct Names<'a> {
    scenes: Vec<&'a str>,
    methods: &'a [Method],
}

impl Names<'_> {
    /// The place of a name in a list, or `None` after reporting that it is not there.
    fn place(
        section: &Section<'_>,
        kind: &str,
        name: &str,
        known: &[&str],
        at: &Spanned<DeValue<'_>>,
    ) -> Option<usize> {
        let found = known.iter().position(|k| *k == name);
        if found.is_none() {
            let help = match nearest(name, known) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => format!("known: {}", known.join(", ")),
            };
            let problem = Problem::new(format!("{} names the {kind} \"{name}\", which is not there", section.label()));
            section.reader.report(problem.help(help).at(&section.reader.source(at.span())));
        }
        found
    }

    fn method_names(&self) -> Vec<&str> {
        self.methods.iter().map(|m| m.name.as_str()).collect()
    }

    fn method(&self, section: &Section<'_>, key: &'static str) -> Option<usize> {
        let value = section.get(key)?;
        let name = section.reader.convert(key, value, &Text)?;
        Names::place(section, "method", &name, &self.method_names(), value)
    }
}

fn read_experiment(section: &Section<'_>, names: &Names<'_>) -> Experiment {
    let experiment = Experiment {
        name: section.required("name", Text, String::new()),
        about: section.or("about", Text, String::new()),
        scenes: read_places(section, "scenes", "scene", &names.scenes)
            .unwrap_or_else(|| (0..names.scenes.len()).collect()),
        methods: read_experiment_methods(section, names),
        budgets: read_budgets(section),
        seeds: section.or("seeds", List(Integer::within(0, u64::MAX)), vec![1]),
        baseline: section.table("baseline").and_then(|table| {
            let method = names.method(&table, "method");
            let photons = table.optional("photons", LARGE);
            table.finish();
            method.map(|method| Baseline { method, photons })
        }),
        published: section
            .tables("published", |i| format!("published result {i}"))
            .into_iter()
            .filter_map(|table| {
                let method = names.method(&table, "method");
                let [rmse, ssim] = ["rmse", "ssim"].map(|key| table.optional(key, UNIT));
                let photons = table.optional("photons", LARGE);
                table.finish();
                method.map(|method| Published { method, photons, rmse, ssim })
            })
            .collect(),
        crop: read_rectangle(section, "crop"),
        region: read_rectangle(section, "region"),
    };
    section.finish();
    experiment
}

/// The places of a list of names; `None` without the key.
fn read_places(section: &Section<'_>, key: &'static str, kind: &str, known: &[&str]) -> Option<Vec<usize>> {
    let value = section.get(key)?;
    let list = section.reader.convert(key, value, &List(Text)).unwrap_or_default();
    Some(list.iter().filter_map(|name| Names::place(section, kind, name, known, value)).collect())
}

fn read_experiment_methods(section: &Section<'_>, names: &Names<'_>) -> Vec<ExperimentMethod> {
    let known = names.method_names();
    let Some(places) = read_places(section, "methods", "method", &known) else {
        section.missing("methods", "the names of methods");
        return Vec::new();
    };
    let mut plans: Vec<(usize, BandwidthPlan)> = Vec::new();
    if let Some(table) = section.table("bandwidth") {
        for (key, value) in table.entries() {
            let Some(place) = Names::place(section, "method", key.get_ref(), &known, value) else { continue };
            plans.extend(read_bandwidth(&table, key.get_ref(), value).map(|plan| (place, plan)));
        }
    }
    places
        .into_iter()
        .map(|method| {
            let given = plans.iter().find(|(place, _)| *place == method).map(|(_, plan)| plan.clone());
            let bandwidth = match names.methods[method].parameter {
                None => BandwidthPlan::AsSet,
                Some(parameter) => given.unwrap_or_else(|| widest(parameter)),
            };
            ExperimentMethod { method, bandwidth }
        })
        .collect()
}

/// The range that is searched where the study gives none.
fn widest(parameter: Parameter) -> BandwidthPlan {
    let (low, high) = match parameter {
        Parameter::Neighbours => (5.0, 50_000.0),
        Parameter::Scale => (0.5, 32.0),
        Parameter::Radius => (1e-5, 10.0),
    };
    BandwidthPlan::Best { low, high }
}

/// `"as set"`, `[1, 2, 4]`, `{ from = 1, to = 8 }` or `{ value = 3, at = 1000, exponent = 0.3333 }`.
fn read_bandwidth(table: &Section<'_>, name: &str, value: &Spanned<DeValue<'_>>) -> Option<BandwidthPlan> {
    match value.get_ref() {
        DeValue::Array(_) => table.reader.convert(name, value, &List(POSITIVE)).map(BandwidthPlan::Each),
        DeValue::Table(_) => {
            let section = Section::of_value(table.reader, format!("the bandwidth of {name}"), value)?;
            let plan = if section.get("from").is_some() {
                let low = section.required("from", POSITIVE, 1.0);
                BandwidthPlan::Best { low, high: section.required("to", POSITIVE, low).max(low) }
            } else {
                BandwidthPlan::Schedule {
                    value: section.required("value", POSITIVE, 1.0),
                    at: section.required("at", POSITIVE, 1.0),
                    exponent: section.required("exponent", Number::from_up_to(-2.0, 2.0), 0.0),
                }
            };
            section.finish();
            Some(plan)
        }
        DeValue::String(s) if s == "as set" => Some(BandwidthPlan::AsSet),
        _ => {
            let problem = Problem::new(format!("the bandwidth of {name} is none"));
            let help = "write \"as set\", [1, 2, 4], { from = 1, to = 8 } or { value = 3, at = 1000, exponent = 0.3 }";
            table.reader.report(problem.help(help).at(&table.reader.source(value.span())));
            None
        }
    }
}

fn read_budgets(section: &Section<'_>) -> Vec<Budget> {
    let [photons, stored] = ["photons", "stored"].map(|key| section.optional(key, List(LARGE)));
    let seconds = section.optional("seconds", List(POSITIVE));
    if stored.is_some() && (photons.is_some() || seconds.is_some()) {
        let problem = Problem::new(format!("{} has two kinds of work", section.label()));
        section.reader.report(problem.help("`stored` stands alone: remove it, or the others").at(&section.source()));
    }
    match (seconds, stored, photons) {
        (Some(seconds), _, photons) => {
            let counts = photons.map_or(vec![None], |counts| counts.into_iter().map(Some).collect());
            let timed = |&seconds: &f64| counts.iter().map(move |&photons| Budget::Seconds { seconds, photons });
            seconds.iter().flat_map(timed).collect()
        }
        (None, Some(counts), _) => counts.into_iter().map(Budget::Stored).collect(),
        (None, None, Some(counts)) => counts.into_iter().map(Budget::Photons).collect(),
        (None, None, None) => {
            section.missing("photons", "the numbers of photons, or `stored`, or `seconds`");
            Vec::new()
        }
    }
}

fn read_rectangle(section: &Section<'_>, key: &'static str) -> Option<[u32; 4]> {
    let value = section.get(key)?;
    let corners = section.reader.convert(key, value, &Array::<_, 4>(Integer::within(0, 65_536)))?;
    let [x0, y0, x1, y1] = corners.map(|c| c as u32);
    if x0 < x1 && y0 < y1 {
        return Some([x0, y0, x1, y1]);
    }
    let problem = Problem::new(format!("`{key}` has no pixels")).help("give [x0, y0, x1, y1] with x0 < x1, y0 < y1");
    section.reader.report(problem.at(&section.reader.source(value.span())));
    None
}
