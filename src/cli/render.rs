//! `pdembree render SCENE -o out.exr`

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use pdembree::film::PixelBounds;
use pdembree::output::lock::Lock;
use pdembree::output::target::probe;
use pdembree::output::tev::Viewer;
use pdembree::output::{BirthCertificate, PartInfo, atomic};
use pdembree::render::budget::{Budget, MAX_PASSES};
use pdembree::render::progress::Progress;
use pdembree::render::store::{self, Assignment};
use pdembree::render::{Ended, RenderState, go_on, tiling};
use pdembree::scene::settings::Method;
use pdembree::world::World;

use super::certificate::{Circumstances, certificate};
use super::console::{Verbosity, note};
#[cfg(feature = "mpi")]
use super::crew::over_ranks;
use super::crew::{Alone, Crew};
use super::failure::{Failure, code};
use super::fit;
use super::keeper::{Checkpoint, Keeper, Snapshot};
use super::number::{bytes, fraction, length_of_time, range, tile};
use super::outputs::{OutputArgs, Outputs, rescued, snapshot_beside};
use super::progress::{Mode, duration};
use super::scene::SceneArgs;
use super::signals::Signals;
use super::work::{WorkArgs, render_failure, world};

/// Render a scene into a picture
///
/// Beside the picture out.exr stands its birth certificate, out.exr.json: what made it, from what, with which settings
/// and seed, and what happened on the way. Files are written whole or not at all.
///
/// SIGINT (Ctrl-C) and SIGTERM finish the units under way, save the checkpoint and a snapshot and exit with 130 or 143;
/// a second one ends at once. SIGUSR1 writes out.snapshot.exr, the picture so far.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    output: OutputArgs,
    #[command(flatten)]
    until: UntilArgs,
    #[command(flatten)]
    part: PartArgs,
    #[command(flatten)]
    keep: KeepArgs,
    #[command(flatten)]
    work: WorkArgs,
}

/// The first of these ends the render; with one of the two given, --passes counts only if it is given too.
#[derive(clap::Args)]
#[command(next_help_heading = "How long (default: the passes that the scene file says)")]
struct UntilArgs {
    /// Begin no pass that would probably end later than this: 90s, 10m, 1.5h. Passes that are longer are made smaller, but
    /// not those of a tile or of a render that is saved
    #[arg(long, env = "PDEMBREE_TIME_LIMIT", value_name = "TIME", value_parser = length_of_time)]
    time_limit: Option<Duration>,
    /// Stop when the noise, the mean over the pixels of standard error over luminance, is below this: 0.02
    #[arg(long, env = "PDEMBREE_TARGET_ERROR", visible_alias = "target-noise", value_name = "X", value_parser = fraction)]
    target_error: Option<f64>,
    /// Exit with 3 if the wanted error was not reached
    #[arg(long, requires = "target_error")]
    strict: bool,
}

#[derive(clap::Args)]
#[command(next_help_heading = "Parts of a render, for farms; `pdembree merge` puts them together")]
struct PartArgs {
    /// Render the passes A, A + 1, ... B - 1 only, and keep their sums in out.pdpart; does nothing if they are there
    #[arg(long, value_name = "A..B", value_parser = range, conflicts_with_all = ["time_limit", "target_error"])]
    pass_range: Option<(u32, u32)>,
    /// Render tile J of M only, J from 0, and keep its sums in out.pdpart; does nothing if they are there
    #[arg(long, value_name = "J/M", value_parser = tile)]
    tile: Option<(u32, u32)>,
    /// Share the passes out over the ranks of an mpirun; the first rank tells, and writes the picture. Under an mpirun
    /// this is so without being said, unless an option is given that concerns one process
    #[cfg(feature = "mpi")]
    #[arg(long, conflicts_with_all = ["pass_range", "tile", "time_limit", "target_error", "checkpoint", "display_server"])]
    mpi: bool,
}

#[derive(clap::Args)]
#[command(next_help_heading = "Looking after it")]
struct KeepArgs {
    /// Save the render here while it works, and at its end
    #[arg(long, env = "PDEMBREE_CHECKPOINT", value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// How often
    #[arg(long, env = "PDEMBREE_EVERY", value_name = "TIME", default_value = "60s", value_parser = length_of_time)]
    every: Duration,
    /// Go on where the checkpoint ends; from the start if there is none yet
    #[arg(long, requires = "checkpoint")]
    resume: bool,
    /// Memory for a pass's photons: more of them are split into several passes. Suffixes K, M, G for powers of 1024
    #[arg(long, env = "PDEMBREE_PHOTON_MEMORY", value_name = "BYTES", value_parser = bytes)]
    photon_memory: Option<u64>,
    /// Show the picture in a viewer that speaks tev's protocol; one that is slow or absent does no harm
    #[arg(long, env = "PDEMBREE_DISPLAY_SERVER", value_name = "HOST[:PORT]")]
    display_server: Option<String>,
}

/// Whether Open MPI or an MPICH started this process.
#[cfg(feature = "mpi")]
fn is_under_mpirun() -> bool {
    ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"].iter().any(|name| std::env::var_os(name).is_some())
}

impl Args {
    /// Whether nothing is asked for that only one process can do.
    #[cfg(feature = "mpi")]
    fn may_be_shared_out(&self) -> bool {
        let Args { until, part, keep, .. } = self;
        let parts = part.pass_range.is_some() || part.tile.is_some();
        let bounds = until.time_limit.is_some() || until.target_error.is_some();
        !parts && !bounds && keep.checkpoint.is_none() && keep.display_server.is_none()
    }

    /// How progress is told.
    pub fn progress(&self) -> Mode {
        self.work.progress()
    }
}

pub fn run(args: &Args, verbosity: Verbosity) -> Result<ExitCode, Failure> {
    #[cfg(feature = "mpi")]
    if args.part.mpi || is_under_mpirun() && args.may_be_shared_out() {
        return over_ranks(verbosity, |ranks, verbosity| render(args, verbosity, ranks));
    }
    render(args, verbosity, &Alone)
}

fn render(args: &Args, verbosity: Verbosity, crew: &dyn Crew) -> Result<ExitCode, Failure> {
    let start = Instant::now();
    // A wrong name is told before a large scene is read; folders are made only for a good scene.
    Outputs::check_names(&args.output)?;
    let viewer = open_viewer(args)?;
    let threads = args.work.start_threads()?;
    let mut loaded = args.scene.load(verbosity)?;
    args.output.add_layers(&mut loaded.scene.settings.layers);
    let is_a_part = args.part.pass_range.is_some() || args.part.tile.is_some();
    let outputs = Outputs::check(&args.output, is_a_part)?;
    let reporter = args.work.reporter(verbosity);
    let signals = Signals::watch()?;

    reporter.phase("scene", 1);
    let mut world = world(loaded.scene)?;
    reporter.finish();
    fit::memory(&mut world, args.keep.photon_memory, verbosity);
    let mut plan = Plan::new(args, &world, crew)?;
    let mut info = store::identify(&world, &args.scene.scene, plan.wanted_passes);
    if let Some(part) = outputs.part().filter(|part| store::is_done(part, &info, &plan.assignment) && outputs.exist()) {
        reporter.end();
        note(verbosity, "done", &format!("{} was there already", part.display()));
        return Ok(ExitCode::SUCCESS);
    }

    let (_lock, mut state) = begin(args, &world, &info, &plan, verbosity)?;
    let checkpoint = |path| Checkpoint { path, every: args.keep.every, info: info.clone() };
    let keeper = Keeper::new(
        &reporter,
        &signals,
        args.keep.checkpoint.clone().map(checkpoint),
        viewer,
        Snapshot { path: snapshot_beside(&args.output.output), resolution: info.identity.resolution },
        verbosity,
    );
    let before = state.film.passes();
    keeper.reporter.expect(&plan.budget, before);
    if let Some(limit) = args.until.time_limit.filter(|_| !is_a_part && args.keep.checkpoint.is_none()) {
        state = fit::time(&mut world, limit.saturating_sub(start.elapsed()), &keeper, verbosity)?;
        plan = Plan::new(args, &world, crew)?;
        info = store::identify(&world, &args.scene.scene, plan.wanted_passes);
    }
    let ended = go_on_by_plan(&world, &mut state, &keeper, &plan, before, start)?;
    keeper.save(&state).map_err(|error| rescued(error, &info, &state))?;
    if ended == Ended::Stopped {
        return stopped(&keeper, &state, verbosity);
    }

    let Some(state) = crew.gather(&info, state)? else { return Ok(ExitCode::SUCCESS) };
    let (picture, told) = args.output.finished(state.film.resolve());
    let mut found = findings(&world, &state, &plan.budget);
    found.extend(told);
    let warnings = loaded.warnings.iter().map(ToString::to_string).chain(found.iter().cloned()).collect();
    let seconds = start.elapsed().as_secs_f64();
    let textures = world.textures.report();
    let circumstances = Circumstances { threads, seconds, phases: reporter.phases(), warnings, textures };
    let certificate = certificate(&info, &state, &picture, circumstances);
    outputs.write(&info, &state, &picture, &certificate, &reporter).map_err(|error| rescued(error, &info, &state))?;
    let trouble = keeper.close_viewer(picture);
    reporter.end();

    found.iter().chain(&trouble).for_each(|warning| note(verbosity, "warning", warning));
    note(verbosity, "done", &farewell(&args.output.output, &certificate));
    if verbosity.verbose {
        details(&certificate, verbosity);
    }
    let missed = args.until.strict && !plan.budget.is_good_enough(&state);
    Ok(if missed { ExitCode::from(code::INCOMPLETE) } else { ExitCode::SUCCESS })
}

/// Passes are added to those that there were `before` this program began, and to those that it has added since `start`.
fn go_on_by_plan(
    world: &World,
    state: &mut RenderState,
    keeper: &Keeper,
    plan: &Plan,
    before: u32,
    start: Instant,
) -> Result<Ended, Failure> {
    keeper.reporter.expect(&plan.budget, before);
    let wanted = |state: &RenderState| {
        keeper.reporter.pass(state.film.passes(), plan.budget.enough(state));
        plan.budget.wants_more(state, start.elapsed(), state.film.passes() - before)
    };
    go_on(world, state, keeper, wanted).map_err(|error| render_failure(&error))
}

/// What is to be rendered, and until when.
struct Plan {
    assignment: Assignment,
    budget: Budget,
    /// Of the whole render.
    wanted_passes: u32,
}

impl Plan {
    fn new(args: &Args, world: &World, crew: &dyn Crew) -> Result<Plan, Failure> {
        let resolution = world.scene.camera.resolution;
        let pixels = match args.part.tile {
            None => PixelBounds::whole(resolution),
            Some((j, m)) => tiling::tile(resolution, j, m).ok_or_else(|| {
                let [width, height] = resolution;
                let message = format!("--tile {j}/{m}: tiles are 0/{m} to {}/{m}, and {width} x {height} pixels can be cut into {} at most", m - 1, tiling::most(resolution));
                Failure::new(code::USAGE, message)
            })?,
        };
        let passes = world.scene.settings.passes;
        let (first, end) = args.part.pass_range.unwrap_or((0, passes));
        let open = (args.until.time_limit.is_some() || args.until.target_error.is_some()) && !args.scene.gives_passes();
        let end = if open { MAX_PASSES } else { end };
        let wanted_passes = if open { 0 } else { passes.max(end) };
        let passes = crew.share(first..end);
        let budget = Budget { end: passes.end, time: args.until.time_limit, error: args.until.target_error };
        Ok(Plan { assignment: Assignment { pixels, passes }, budget, wanted_passes })
    }
}

fn open_viewer(args: &Args) -> Result<Option<Viewer>, Failure> {
    let name = args.output.output.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let open = |address: &String| Viewer::open(address, &name);
    args.keep
        .display_server
        .as_ref()
        .map(open)
        .transpose()
        .map_err(|error| Failure::new(code::USAGE, format!("--display-server: {error}")))
}

/// Locks the checkpoint and reads it, or begins from nothing.
fn begin(
    args: &Args,
    world: &World,
    info: &PartInfo,
    plan: &Plan,
    verbosity: Verbosity,
) -> Result<(Option<Lock>, RenderState), Failure> {
    let fresh = || RenderState::new(world, plan.assignment.pixels, plan.assignment.passes.start);
    let Some(path) = &args.keep.checkpoint else { return Ok((None, fresh())) };
    probe(path, args.output.make_path)?;
    let lock = Lock::of(path)?;
    atomic::sweep(path);
    let state = match (path.exists(), args.keep.resume) {
        (false, _) => fresh(),
        (true, true) => {
            let state = store::resume(path, info, &plan.assignment)?;
            let under_way = if state.film.is_between_passes() { "" } else { " and a part of the next" };
            note(verbosity, "resume", &format!("{}: {} passes{under_way}", path.display(), state.film.passes()));
            state
        }
        (true, false) => {
            let message =
                format!("{}: there is a checkpoint; add --resume to go on with it, or delete it", path.display());
            return Err(Failure::new(code::CANNOT_CREATE, message));
        }
    };
    Ok((Some(lock), state))
}

/// Ends a render that a signal stopped: what there is was saved, and is shown.
fn stopped(keeper: &Keeper, state: &RenderState, verbosity: Verbosity) -> Result<ExitCode, Failure> {
    keeper.reporter.end();
    let passes = state.film.passes();
    let mut told = format!("after {passes} passes");
    match &keeper.checkpoint {
        Some(checkpoint) => told += &format!("; --resume goes on with {}", checkpoint.path.display()),
        None => told += "; with --checkpoint it could be resumed",
    }
    if passes > 0 {
        keeper.write_snapshot(state)?;
        told += &format!("; {} shows it", keeper.snapshot.path.display());
    }
    note(verbosity, "stopped", &told);
    Ok(ExitCode::from(keeper.signals.exit_code().unwrap_or(code::FAILED)))
}

/// What happened that the user should know: every fallback is told.
fn findings(world: &World, state: &RenderState, budget: &Budget) -> Vec<String> {
    let refused = state.film.refused();
    let photons = &state.report.photons;
    let mut found = Vec::new();
    if refused.total() > 0 {
        let first = refused
            .first
            .first()
            .map_or_else(String::new, |r| format!("; the first in pixel ({}, {}) of pass {}", r.x, r.y, r.pass));
        found.push(format!(
            "{} eye samples were left out: {} not a number, {} too large, {} negative{first}",
            refused.total(),
            refused.not_a_number,
            refused.too_large,
            refused.negative
        ));
    }
    if state.report.invalid_rays > 0 {
        found.push(format!("{} rays were not finite and hit nothing", state.report.invalid_rays));
    }
    let bounced = &state.report.bounced_photons;
    let broken = [photons, bounced].iter().map(|counts| counts.broken_columns + counts.broken_flux).sum::<u64>();
    if broken > 0 {
        found.push(format!("{broken} photons were dropped because their differentials or flux were not finite"));
    }
    let scatters = world.regions.as_ref().is_some_and(|regions| regions.scatter());
    let wants_photons = world.scene.settings.method == Method::PhotonMap && world.aim.is_some() && !scatters;
    if wants_photons && photons.photons_stored == 0 {
        found.push("no photon was stored: no light reaches a matt surface over a specular one".to_owned());
    }
    if let Some(wanted) = budget.error.filter(|_| !budget.is_good_enough(state)) {
        let noise = state.film.noise().map_or_else(|| "unknown".to_owned(), |noise| format!("{:.4}", noise.relative));
        found
            .push(format!("the error of {wanted} was not reached; it is {noise} after {} passes", state.film.passes()));
    }
    found
}

fn farewell(output: &Path, certificate: &BirthCertificate) -> String {
    let photons = match certificate.photons_emitted {
        0 => String::new(),
        emitted => format!(", {} of {emitted} photons stored", certificate.photons_stored),
    };
    let noise = certificate.noise.map_or_else(String::new, |noise| format!(", noise {noise:.4}"));
    let memory = certificate.peak_memory_bytes.map_or_else(String::new, |b| format!(", {} MiB", b >> 20));
    format!("{} in {}{photons}{noise}{memory}", output.display(), duration(certificate.seconds))
}

fn details(certificate: &BirthCertificate, verbosity: Verbosity) {
    let tell = |kind: &str, text: String| note(verbosity, kind, &text);
    tell("backend", certificate.backend.version.clone());
    tell("threads", certificate.threads.to_string());
    certificate.phases.iter().for_each(|phase| tell("time", format!("{} {}", phase.name, duration(phase.seconds))));
    certificate.counters.iter().for_each(|(name, count)| tell("count", format!("{name} {count}")));
}
