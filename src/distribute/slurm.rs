//! Slurm: an array of renders, and a merge that starts when all of them went well.
//!
//! Both scripts stand in the job's folder and can be queued by hand from there. Their headers hold no path, since
//! `sbatch` reads quotes and spaces of a header in its own way: logs go where `sbatch` was started.

use std::ffi::OsStr;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use super::error::SubmitError;
use super::job::{Job, Task, text};
use super::shell::{command_line, quote};
use crate::output::atomic;

/// Name of the renders' script in the job's folder.
pub const RENDER_SCRIPT: &str = "render.sbatch";
/// Name of the merge's script in the job's folder.
pub const MERGE_SCRIPT: &str = "merge.sbatch";

/// The command that queues, and what this site wants to hear.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slurm {
    pub sbatch: PathBuf,
    /// More options of `sbatch` for both scripts, such as `--partition=long`; they win over the scripts' own.
    pub options: Vec<String>,
}

/// Slurm's numbers of the two jobs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Queued {
    pub render: String,
    pub merge: String,
}

impl Default for Slurm {
    fn default() -> Slurm {
        Slurm { sbatch: PathBuf::from("sbatch"), options: Vec::new() }
    }
}

impl Slurm {
    /// Writes the scripts and queues them.
    ///
    /// # Errors
    /// The job is not possible, a file cannot be written, or `sbatch` is missing or refuses.
    pub fn submit(&self, job: &Job) -> Result<Queued, SubmitError> {
        write(job)?;
        let render = self.queue(job, RENDER_SCRIPT, &[])?;
        let mut after = vec![format!("--dependency=afterok:{}", render.id), "--kill-on-invalid-dep=yes".to_owned()];
        after.extend(render.cluster.map(|cluster| format!("--clusters={cluster}")));
        match self.queue(job, MERGE_SCRIPT, &after) {
            Ok(merge) => Ok(Queued { render: render.id, merge: merge.id }),
            Err(source) => Err(SubmitError::MergeNotQueued { render: render.id, source: Box::new(source) }),
        }
    }

    fn queue(&self, job: &Job, script: &'static str, more: &[String]) -> Result<Answer, SubmitError> {
        let mut command = Command::new(&self.sbatch);
        command.current_dir(&job.folder).stdin(Stdio::null());
        command.arg("--parsable").args(&self.options).args(more).arg(script);
        let output = command.output().map_err(|source| match source.kind() {
            ErrorKind::NotFound => {
                SubmitError::EngineMissing { program: self.sbatch.clone(), package: "Slurm (on Debian slurm-client)" }
            }
            _ => SubmitError::CannotStart { program: self.sbatch.clone(), source },
        })?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            let reason = if said.is_empty() { output.status.to_string() } else { said };
            return Err(SubmitError::SbatchFailed { script, reason });
        }
        Answer::read(&String::from_utf8_lossy(&output.stdout))
    }
}

/// What `sbatch --parsable` prints: the job's number and, where there are several, the cluster's name.
struct Answer {
    id: String,
    cluster: Option<String>,
}

impl Answer {
    fn read(text: &str) -> Result<Answer, SubmitError> {
        let text = text.trim();
        let (id, cluster) = match text.split_once(';') {
            Some((id, cluster)) => (id, Some(cluster.to_owned())),
            None => (text, None),
        };
        if id.is_empty() || !id.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(SubmitError::SbatchAnswer { answer: text.to_owned() });
        }
        Ok(Answer { id: id.to_owned(), cluster })
    }
}

/// Writes both scripts into the job's folder.
///
/// # Errors
/// The job is not possible, the folder's name is not for Slurm, or a file cannot be written.
pub fn write(job: &Job) -> Result<(), SubmitError> {
    // The name of a log is completed with the folder first, and then its `%a` replaced, and all that looks like it.
    if text(&job.folder).contains(['%', '\\']) {
        return Err(SubmitError::NotForSlurm { folder: job.folder.clone() });
    }
    job.prepare()?;
    atomic::write(&job.folder.join(RENDER_SCRIPT), render_script(job).as_bytes())?;
    atomic::write(&job.folder.join(MERGE_SCRIPT), merge_script(job).as_bytes())?;
    Ok(())
}

/// The table of tasks is in the script, of which Slurm takes a copy: nothing that changes later reaches a queued job.
fn render_script(job: &Job) -> String {
    let tasks = job.tasks();
    let mut lines = header(job, "render", "render_%a.log");
    lines.push(format!("#SBATCH --array=0-{}", tasks.len() - 1));
    // Not for failures: Slurm starts a task again whose node failed or was given to someone else.
    lines.push("#SBATCH --requeue".to_owned());
    // To the process itself, which is the shell's successor: it can tidy up before the time limit ends it.
    lines.push("#SBATCH --signal=B:TERM@60".to_owned());
    if let Some(threads) = job.threads {
        lines.push(format!("#SBATCH --cpus-per-task={threads}"));
    }
    lines.push("set -eu".to_owned());
    lines.push(format!("folder={}", quote(&text(&job.folder))));
    lines.push("tasks=(".to_owned());
    lines.extend(tasks.iter().map(|task| format!("    '{}'", row(task))));
    lines.push(")".to_owned());
    // No field of a row holds a space.
    lines.push("read -r part range <<<\"${tasks[$SLURM_ARRAY_TASK_ID]}\"".to_owned());
    // Unless it is told, the renderer would take every core of a machine that it shares.
    lines.push("threads=${SLURM_CPUS_ON_NODE:-1}".to_owned());
    lines.push(format!("exec {} \\", program_with(job, job.render_arguments())));
    // The range is more than one word.
    lines.push("    $range --nthreads \"$threads\" -o \"$folder/$part\"".to_owned());
    lines.join("\n") + "\n"
}

/// A row of the table: the part's name and the options of its range.
fn row(task: &Task) -> String {
    let name = task.part.file_name().and_then(OsStr::to_str).unwrap_or_default();
    let tile = task.tile.map_or_else(String::new, |(tile, tiles)| format!(" --tile {tile}/{tiles}"));
    format!("{name} --pass-range {}..{}{tile}", task.passes.start, task.passes.end)
}

fn merge_script(job: &Job) -> String {
    let mut lines = header(job, "merge", "merge.log");
    lines.push("#SBATCH --requeue".to_owned());
    lines.push(format!("exec {}", program_with(job, job.merge_arguments())));
    lines.join("\n") + "\n"
}

fn header(job: &Job, verb: &str, log: &str) -> Vec<String> {
    let title = format!("# Written by `pdembree submit`; queue it again from this folder, with sbatch {verb}.sbatch.");
    let name = format!("#SBATCH --job-name=pdembree-{verb}-{}", job.name());
    // Logs of a task that was started again follow one another.
    let log = [format!("#SBATCH --output={log}"), "#SBATCH --open-mode=append".to_owned()];
    ["#!/bin/bash".to_owned(), title, name].into_iter().chain(log).collect()
}

fn program_with(job: &Job, arguments: Vec<String>) -> String {
    command_line(&[vec![text(&job.program)], arguments].concat())
}

#[cfg(test)]
mod tests {
    use super::super::job::tests::awkward;
    use super::*;

    #[test]
    fn the_header_tells_slurm_what_it_needs() {
        let script = render_script(&awkward());
        let told: Vec<_> = script.lines().filter_map(|line| line.strip_prefix("#SBATCH --")).collect();
        let expected = [
            "job-name=pdembree-render-it_s__Gr__e___HOME__x___a",
            "output=render_%a.log",
            "open-mode=append",
            "array=0-7",
            "requeue",
            "signal=B:TERM@60",
            "cpus-per-task=2",
        ];
        assert_eq!(told, expected);
        // Slurm stops reading options at the first command.
        let first_command = script.lines().position(|line| !line.starts_with('#'));
        assert_eq!(first_command, script.lines().position(|line| line == "set -eu"));
        assert!(!render_script(&Job { threads: None, ..awkward() }).contains("--cpus-per-task"));
    }

    /// Bash runs the scripts with `printf` as the renderer; the arguments must be those of the job.
    #[test]
    fn the_scripts_start_the_program_with_the_jobs_arguments() {
        let job = Job { program: "/usr/bin/printf".into(), ..awkward() };
        let run = |script: &str, index: usize| {
            let script = script.replacen("printf ", "printf '%s\\n' ", 1);
            let mut bash = Command::new("bash");
            bash.args(["-c", &script]).env("SLURM_ARRAY_TASK_ID", index.to_string()).env("SLURM_CPUS_ON_NODE", "3");
            let output = bash.output().expect("bash");
            String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect::<Vec<_>>()
        };
        for (index, task) in job.tasks().iter().enumerate() {
            let mut expected = job.task_arguments(task);
            let before_output = expected.len() - 2;
            expected.splice(before_output..before_output, ["--nthreads".to_owned(), "3".to_owned()]);
            assert_eq!(run(&render_script(&job), index), expected);
        }
        assert_eq!(run(&merge_script(&job), 0), job.merge_arguments());
    }

    #[test]
    fn folders_that_slurm_reads_otherwise_are_refused() {
        for folder in ["/tmp/a %j", "/tmp/a\\b"] {
            let result = write(&Job { folder: folder.into(), ..awkward() });
            assert!(matches!(result, Err(SubmitError::NotForSlurm { .. })));
        }
    }

    #[test]
    fn answers_of_sbatch_are_numbers() {
        let plain = Answer::read("17\n").expect("a number");
        assert_eq!((plain.id.as_str(), plain.cluster), ("17", None));
        let far = Answer::read("17;north\n").expect("a number");
        assert_eq!((far.id.as_str(), far.cluster.as_deref()), ("17", Some("north")));
        assert!(Answer::read("Submitted batch job 17").is_err() && Answer::read("").is_err());
    }
}
