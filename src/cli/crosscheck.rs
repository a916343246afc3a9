//! `pdembree crosscheck SCENE`

use std::process::ExitCode;

use clap::builder::PossibleValuesParser;
use pdembree::backend::crosscheck::{Counts, Report};
use pdembree::render::crosscheck::{CrosscheckError, Crosschecked, crosscheck};
use pdembree::scene::settings::BackendKind;

use super::console::{Verbosity, print, print_json};
use super::failure::{Failure, code};
use super::number::{count, finite};
use super::scene::SceneArgs;
use super::work::{WorkArgs, world_failure};

/// Trace the same camera, shadow and photon rays through two backends and compare the answers
///
/// Every disagreement is classed: ties of t at shared edges, rays within rounding of an edge and hits at the ends of the
/// interval are explained; other ids, t or (u, v) beyond the bounds of f32 arithmetic are not. Exits with 1 if the share
/// of rays whose disagreement is not explained exceeds the bound.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Rays of all kinds together; suffixes K, M, G
    #[arg(long, value_name = "N", default_value = "1M", value_parser = count)]
    rays: u64,
    /// Backend that the scene's own is compared with
    #[arg(long, value_name = "BACKEND", value_parser = PossibleValuesParser::new(BackendKind::NAMES))]
    against: Option<String>,
    /// Largest share of unexplained disagreements that passes
    #[arg(long, value_name = "SHARE", default_value = "1e-6", value_parser = finite)]
    bound: f64,
    /// Print JSON, with examples that can be replayed
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    work: WorkArgs,
}

#[derive(serde::Serialize)]
struct Answer {
    backends: [String; 2],
    rays: u64,
    disagreements: u64,
    not_explained: u64,
    unexplained_rate: f64,
    bound: f64,
    report: Report,
}

pub fn run(args: &Args, verbosity: Verbosity) -> Result<ExitCode, Failure> {
    args.work.start_threads()?;
    let scene = args.scene.load(verbosity)?.scene;
    let own = scene.settings.backend;
    // Without a wish: the other one of the two fast backends.
    let fast = if own == BackendKind::Obvhs { BackendKind::Embree } else { BackendKind::Obvhs };
    let other = args.against.as_deref().and_then(BackendKind::from_name).unwrap_or(fast);
    let reporter = args.work.reporter(verbosity);
    let found = crosscheck(scene, [own, other], args.rays, &reporter).map_err(|error| failure(&error))?;
    reporter.end();
    let answer = answer(found, args.bound);
    if args.json {
        print_json(&answer)?
    } else {
        print(&table(&answer))?
    }
    let same = answer.unexplained_rate <= args.bound;
    Ok(if same { ExitCode::SUCCESS } else { ExitCode::from(code::FAILED) })
}

fn failure(error: &CrosscheckError) -> Failure {
    match error {
        CrosscheckError::World(error) => world_failure(error),
        CrosscheckError::Camera(_) => Failure::new(code::BAD_DATA, error.to_string()),
    }
}

fn answer(found: Crosschecked, bound: f64) -> Answer {
    let Crosschecked { report, backends } = found;
    let total = report.total();
    Answer {
        backends,
        rays: total.rays,
        disagreements: total.disagreements(),
        not_explained: total.not_explained(),
        unexplained_rate: report.unexplained_rate(),
        bound,
        report,
    }
}

fn table(answer: &Answer) -> String {
    let Answer { backends: [a, b], report, .. } = answer;
    let heading = ["rays", "hits", "refused", "tie", "edge", "end", "t", "uv", "unexplained"];
    let columns =
        |name: &str, cells: [String; 9]| format!("{name:<8}{}\n", cells.map(|cell| format!("{cell:>12}")).concat());
    let row = |name: &str, c: &Counts| {
        let counts = [c.rays, c.hits, c.refused, c.tie, c.edge, c.interval_end, c.t_beyond, c.uv_beyond, c.unexplained];
        columns(name, counts.map(|n| n.to_string()))
    };
    let worst = &report.worst;
    format!(
        "{a} and {b}\n{}{}{}{}\
         same primitive: t differs by at most {:.1e} of itself ({:.2} of its bound), uv by {:.1e} ({:.2} of its bound)\n\
         {} of {} rays disagree, {} of them not explained: {:.1e} of the rays, allowed {:.1e}\n",
        columns("", heading.map(str::to_owned)),
        row("camera", &report.camera),
        row("shadow", &report.shadow),
        row("photon", &report.photon),
        worst.relative_t,
        worst.t_of_bound,
        worst.uv,
        worst.uv_of_bound,
        answer.disagreements,
        answer.rays,
        answer.not_explained,
        answer.unexplained_rate,
        answer.bound,
    )
}
