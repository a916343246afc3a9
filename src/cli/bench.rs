//! `pdembree bench SCENE`

use std::process::ExitCode;

use pdembree::render::bench::{BenchError, Measured, Phase, Standard, measure};

use super::console::{Verbosity, print, print_json};
use super::failure::{Failure, code};
use super::scene::SceneArgs;
use super::work::{WorkArgs, world_failure};

/// Measure how fast the phases of a pass are, and the ray library alone on the same rays
///
/// Runs one pass of the photon map on one thread and on all of them, records its rays, and asks the ray library for them
/// once more with nothing around it, then the other ray library. Last it measures what the columns cost, and what the
/// standard photon map takes with the same photons. Times are of one run on whatever else the machine does; ratios within a run are
/// what can be compared.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    work: WorkArgs,
}

pub fn run(args: &Args, verbosity: Verbosity) -> Result<ExitCode, Failure> {
    args.work.start_threads()?;
    let scene = args.scene.load(verbosity)?.scene;
    let measured = measure(scene).map_err(|error| failure(&error))?;
    if args.json {
        print_json(&measured)?
    } else {
        print(&table(&measured))?
    }
    Ok(ExitCode::SUCCESS)
}

fn failure(error: &BenchError) -> Failure {
    match error {
        BenchError::World(error) => world_failure(error),
        BenchError::Camera(_) => Failure::new(code::BAD_DATA, error.to_string()),
        BenchError::Thread(_) => Failure::new(code::FAILED, error.to_string()),
    }
}

fn table(measured: &Measured) -> String {
    let Measured { backend, threads, phases, photons_emitted, photons_stored, .. } = measured;
    let mut lines = vec![
        format!("{backend}, {threads} threads; `other` is {}", measured.other.as_deref().unwrap_or("not there")),
        format!(
            "{:<10} {:>9} {:>9} {:>8} {:>9} {:>9} {:>9} {:>9}",
            "phase", "1 thread", "all", "speed-up", "Mrays/s", "bare", "x bare", "other"
        ),
    ];
    lines.extend(phases.iter().map(line));
    let sum = |of: &dyn Fn(&Phase) -> f64| phases.iter().map(of).sum::<f64>();
    let (seconds, bare) = (sum(&|phase| phase.seconds[0]), sum(&|phase| phase.bare_seconds));
    lines.push(line(&Phase {
        name: "all",
        seconds: [seconds, sum(&|phase| phase.seconds[1])],
        rays: [0, 1].map(|kind| phases.iter().map(|phase| phase.rays[kind]).sum()),
        bare_seconds: bare,
        other_seconds: phases.iter().filter_map(|phase| phase.other_seconds).reduce(|a, b| a + b),
    }));
    let of = |name: &str| phases.iter().find(|phase| phase.name == name).map_or(f64::NAN, |phase| phase.seconds[0]);
    lines.push(format!(
        "{photons_emitted} photons emitted, {photons_stored} stored, {:.2} Mphotons/s, {:.0} bytes each; {:.1} M kernel \
         evaluations, {:.1} M/s",
        *photons_emitted as f64 / of("photons") / 1e6,
        measured.bytes_per_photon,
        measured.kernel_evaluations as f64 / 1e6,
        measured.kernel_evaluations as f64 / of("estimate") / 1e6,
    ));
    lines.push(against_standard(measured, of("map") + of("estimate")));
    lines.join("\n")
}

/// `footprints` is the time of the map and the estimate with differentials.
fn against_standard(measured: &Measured, footprints: f64) -> String {
    let Standard { photons: [with_columns, without], map, estimate, neighbours } = measured.standard;
    format!(
        "the same photons without columns: {without:.3} s, with them {:+.0} %; the {neighbours} nearest of them at each \
         point instead of footprints: {:.3} s, footprints {:+.0} %",
        100.0 * (with_columns / without - 1.0),
        map + estimate,
        100.0 * (footprints / (map + estimate) - 1.0),
    )
}

/// Rates are those of one thread.
fn line(phase: &Phase) -> String {
    let rays = phase.rays.iter().sum::<u64>() as f64 / 1e6;
    let rate = |seconds: f64| if rays > 0.0 { format!("{:.2}", rays / seconds) } else { "-".to_owned() };
    format!(
        "{:<10} {:>7.3} s {:>7.3} s {:>8.2} {:>9} {:>9} {:>9} {:>9}",
        phase.name,
        phase.seconds[0],
        phase.seconds[1],
        phase.speed_up(),
        rate(phase.seconds[0]),
        rate(phase.bare_seconds),
        phase.over_bare().map_or("-".to_owned(), |ratio| format!("{ratio:.2}")),
        phase.other_seconds.map_or("-".to_owned(), rate),
    )
}
