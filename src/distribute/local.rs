//! Processes of this machine: for trying a job out, and where no engine is.
//!
//! Tasks are in the caller's process group, so that Ctrl-C reaches them too.

use std::collections::VecDeque;
use std::fs::File;
use std::num::NonZeroUsize;
use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{available_parallelism, sleep};
use std::time::{Duration, Instant};

use super::error::SubmitError;
use super::job::{Job, Task};
use crate::output::WriteError;

/// Between two looks at the processes.
const PAUSE: Duration = Duration::from_millis(20);
/// Time that tasks have to tidy up when they are no longer wanted.
const GRACE: Duration = Duration::from_secs(10);

/// Runs all tasks, `at_once` at a time, then the merge. `told` hears how many processes are done, of how many.
///
/// Ends early, and ends what is running, when a task fails or `stop` becomes true.
///
/// # Errors
/// The job is not possible, the program cannot be started, a task failed (the first that did), or `stop` was set.
pub fn run(
    job: &Job,
    at_once: NonZeroUsize,
    stop: &AtomicBool,
    told: &mut dyn FnMut(usize, usize),
) -> Result<(), SubmitError> {
    job.prepare()?;
    let threads = threads(job, at_once);
    let renders: VecDeque<_> =
        job.tasks().iter().enumerate().map(|(i, task)| Work::render(job, i, task, threads)).collect();
    let total = renders.len() + 1;
    told(0, total);
    run_all(job, renders, at_once, stop, &mut |done| told(done, total))?;
    run_all(job, [Work::merge(job)].into(), NonZeroUsize::MIN, stop, &mut |_| told(total, total))
}

/// Tasks at once share the cores; a single one may have all.
fn threads(job: &Job, at_once: NonZeroUsize) -> Option<usize> {
    let share = || available_parallelism().map_or(1, |cores| (cores.get() / at_once).max(1));
    job.threads.map(|threads| threads as usize).or_else(|| (at_once.get() > 1).then(share))
}

/// A process that is to be.
struct Work {
    what: String,
    arguments: Vec<String>,
    log: PathBuf,
}

impl Work {
    fn render(job: &Job, index: usize, task: &Task, threads: Option<usize>) -> Work {
        let mut arguments = job.task_arguments(task);
        arguments.extend(threads.into_iter().flat_map(|threads| ["--nthreads".to_owned(), threads.to_string()]));
        let tile = task.tile.map_or_else(String::new, |(tile, tiles)| format!(" of tile {tile}/{tiles}"));
        let what = format!("rendering passes {}..{}{tile}", task.passes.start, task.passes.end);
        Work { what, arguments, log: job.folder.join(format!("render_{index}.log")) }
    }

    fn merge(job: &Job) -> Work {
        let log = job.folder.join("merge.log");
        Work { what: "merging the parts".to_owned(), arguments: job.merge_arguments(), log }
    }

    fn start(self, job: &Job) -> Result<Running, SubmitError> {
        let failed = |source| WriteError::CannotCreate { path: self.log.clone(), source };
        let log = File::create(&self.log).map_err(failed)?;
        let same_log = log.try_clone().map_err(failed)?;
        let child = Command::new(&job.program)
            .args(&self.arguments)
            .stdin(Stdio::null())
            .stdout(log)
            .stderr(same_log)
            .spawn()
            .map_err(|source| SubmitError::CannotStart { program: job.program.clone(), source })?;
        Ok(Running { child, what: self.what, log: self.log })
    }
}

/// A process that ends with this value at the latest.
struct Running {
    child: Child,
    what: String,
    log: PathBuf,
}

impl Drop for Running {
    fn drop(&mut self) {
        // Both fail only for a process that is over.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Running {
    /// The status, if it is over. One that cannot be asked is taken for one that goes on.
    fn status(&mut self) -> Option<ExitStatus> {
        self.child.try_wait().ok().flatten()
    }

    fn failure(&self, status: ExitStatus) -> SubmitError {
        let code = status.code().unwrap_or_else(|| 128 + status.signal().unwrap_or(0));
        let code = u8::try_from(code).unwrap_or(u8::MAX);
        SubmitError::TaskFailed { what: self.what.clone(), code, status: status.to_string(), log: self.log.clone() }
    }
}

fn run_all(
    job: &Job,
    mut waiting: VecDeque<Work>,
    at_once: NonZeroUsize,
    stop: &AtomicBool,
    told: &mut dyn FnMut(usize),
) -> Result<(), SubmitError> {
    let mut running: Vec<Running> = Vec::new();
    let mut done = 0;
    loop {
        let result = take_finished(&mut running);
        // Asked after the look: a task that Ctrl-C ended did not fail by itself.
        let result = if stop.load(Ordering::Relaxed) { Err(SubmitError::Interrupted) } else { result };
        let finished = result.inspect_err(|_| end(&mut running))?;
        if finished > 0 {
            done += finished;
            told(done);
        }
        while running.len() < at_once.get()
            && let Some(work) = waiting.pop_front()
        {
            let started = work.start(job).inspect_err(|_| end(&mut running))?;
            running.push(started);
        }
        if running.is_empty() {
            return Ok(());
        }
        sleep(PAUSE);
    }
}

/// Takes out what went well and counts it; the first failure if there is one.
fn take_finished(running: &mut Vec<Running>) -> Result<usize, SubmitError> {
    let before = running.len();
    let mut failure = None;
    running.retain_mut(|task| match task.status() {
        None => true,
        Some(status) if status.success() => false,
        Some(status) => {
            failure.get_or_insert_with(|| task.failure(status));
            false
        }
    });
    failure.map_or(Ok(before - running.len()), Err)
}

/// Asks the processes to end, and waits; those that do not in time are killed.
fn end(running: &mut Vec<Running>) {
    if !running.is_empty() {
        // The shell's own `kill`: sending another signal than KILL takes unsafe code here.
        let ids = running.iter().map(|task| task.child.id().to_string());
        let _ = Command::new("sh").args(["-c", "kill -TERM \"$@\"", "sh"]).args(ids).stderr(Stdio::null()).status();
    }
    let begin = Instant::now();
    while !running.is_empty() && begin.elapsed() < GRACE {
        running.retain_mut(|task| task.status().is_none());
        sleep(PAUSE);
    }
    running.clear();
}
