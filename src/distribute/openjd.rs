//! Open Job Description: the job as a template that render farms read, and the command that runs it on this machine.
//!
//! No shell is involved: tasks are the program and its arguments. Files are parameters of the job, so that a farm can
//! map them to where its machines see them; the settings stand in the template.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::error::SubmitError;
use super::job::{Job, text};
use crate::output::atomic;

/// Name of the template in the job's folder.
pub const TEMPLATE: &str = "job.json";

/// Time that a cancelled task has to tidy up.
const NOTIFY_SECONDS: u32 = 60;

/// Writes the template into the job's folder; returns where it is.
///
/// # Errors
/// The job is not possible, a setting would be read as a parameter, or the file cannot be written.
pub fn write(job: &Job) -> Result<PathBuf, SubmitError> {
    job.check()?;
    if let Some(setting) = job.settings.iter().chain(&job.merge_settings).find(|setting| setting.contains("{{")) {
        return Err(SubmitError::Braces { text: setting.clone() });
    }
    job.prepare()?;
    let path = job.folder.join(TEMPLATE);
    atomic::write(&path, format!("{:#}\n", template(job)).as_bytes())?;
    Ok(path)
}

/// The command that runs the whole template here, one task after another. Its program is the PyPI package openjd-cli.
pub fn command(job: &Job) -> Vec<String> {
    let parameters = json!({
        "Program": text(&job.program), "Scene": text(&job.scene),
        "Folder": text(&job.folder), "Output": text(&job.output),
    });
    let template = text(&job.folder.join(TEMPLATE));
    let options = ["--step", "Merge", "--run-dependencies", "--job-param"].map(str::to_owned);
    [vec!["openjd".to_owned(), "run".to_owned(), template], options.to_vec(), vec![parameters.to_string()]].concat()
}

fn template(job: &Job) -> Value {
    let path = |name, kind, flow| json!({ "name": name, "type": "PATH", "objectType": kind, "dataFlow": flow });
    json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": format!("pdembree {}", job.name()),
        // Defaults of paths would have to be relative, hence none.
        "parameterDefinitions": [
            { "name": "Program", "type": "STRING", "default": text(&job.program) },
            path("Scene", "FILE", "IN"),
            path("Folder", "DIRECTORY", "INOUT"),
            path("Output", "FILE", "OUT"),
        ],
        "steps": [render_step(job), merge_step(job)],
    })
}

fn render_step(job: &Job) -> Value {
    let part = job.part_name("{{Task.Param.Start}}", "{{Task.Param.End}}", "{{Task.Param.Tile}}");
    let mut arguments = vec!["render".to_owned(), "{{Param.Scene}}".to_owned()];
    arguments.extend(job.settings.iter().cloned());
    arguments.extend(["--pass-range", "{{Task.Param.Start}}..{{Task.Param.End}}"].map(str::to_owned));
    if job.is_tiled() {
        arguments.extend(["--tile".to_owned(), format!("{{{{Task.Param.Tile}}}}/{}", job.tiles)]);
    }
    if let Some(threads) = job.threads {
        arguments.extend(["--nthreads".to_owned(), threads.to_string()]);
    }
    arguments.extend(["--progress", "openjd", "-o"].map(str::to_owned));
    arguments.push(format!("{{{{Param.Folder}}}}/{part}"));
    json!({
        "name": "Render",
        "parameterSpace": {
            "taskParameterDefinitions": parameters(job),
            // Each start with its own end, and every tile of that range.
            "combination": if job.is_tiled() { "(Start, End) * Tile" } else { "(Start, End)" },
        },
        "script": script(arguments),
    })
}

fn parameters(job: &Job) -> Value {
    // Range expressions, unlike lists, have no limit on their length; ends of ranges are written as one.
    let list = |bounds: Vec<u32>| bounds.iter().map(u32::to_string).collect::<Vec<_>>().join(",");
    let number = |name, range: String| json!({ "name": name, "type": "INT", "range": range });
    let mut parameters = vec![
        number("Start", list(job.ranges().map(|range| range.start).collect())),
        number("End", list(job.ranges().map(|range| range.end).collect())),
    ];
    if job.is_tiled() {
        parameters.push(number("Tile", format!("0-{}", job.tiles - 1)));
    }
    Value::Array(parameters)
}

fn merge_step(job: &Job) -> Value {
    let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut arguments = vec!["merge".to_owned()];
    arguments.extend(job.tasks().iter().map(|task| format!("{{{{Param.Folder}}}}/{}", name(&task.part))));
    arguments.extend(job.merge_settings.iter().cloned());
    arguments.extend(["-o", "{{Param.Output}}"].map(str::to_owned));
    json!({ "name": "Merge", "dependencies": [{ "dependsOn": "Render" }], "script": script(arguments) })
}

fn script(arguments: Vec<String>) -> Value {
    let cancelation = json!({ "mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": NOTIFY_SECONDS });
    let run = json!({ "command": "{{Param.Program}}", "args": arguments, "cancelation": cancelation });
    json!({ "actions": { "onRun": run } })
}

#[cfg(test)]
mod tests {
    use super::super::job::tests::awkward;
    use super::*;

    #[test]
    fn ranges_and_tiles_are_the_parameter_space() {
        let space = &template(&awkward())["steps"][0]["parameterSpace"];
        assert_eq!(space["combination"], "(Start, End) * Tile");
        let ranges: Vec<_> = (0..3).map(|i| &space["taskParameterDefinitions"][i]["range"]).collect();
        assert_eq!(ranges, ["0,2,5,7", "2,5,7,10", "0-1"]);
        let whole = &template(&Job { tiles: 1, ..awkward() })["steps"][0];
        assert_eq!(whole["parameterSpace"]["combination"], "(Start, End)");
        assert!(!whole.to_string().contains("Tile"));
    }

    /// With the parameters put in, the arguments are those of the other engines.
    #[test]
    fn arguments_are_those_of_the_job() {
        let job = awkward();
        let template = template(&job);
        let filled = |step: usize, values: &[(&str, String)]| {
            let arguments = template["steps"][step]["script"]["actions"]["onRun"]["args"].as_array().expect("a list");
            let fill = |argument: &Value| {
                let start = argument.as_str().expect("a string").to_owned();
                values.iter().fold(start, |all, (name, value)| all.replace(&format!("{{{{{name}}}}}"), value))
            };
            arguments.iter().map(fill).collect::<Vec<_>>()
        };
        let common = [
            ("Param.Scene", text(&job.scene)),
            ("Param.Folder", text(&job.folder)),
            ("Param.Output", text(&job.output)),
        ];
        for task in job.tasks() {
            let (start, end) = (task.passes.start.to_string(), task.passes.end.to_string());
            let tile = task.tile.map_or(0, |(tile, _)| tile).to_string();
            let own = [("Task.Param.Start", start), ("Task.Param.End", end), ("Task.Param.Tile", tile)];
            let mut expected = job.task_arguments(&task);
            let before_output = expected.len() - 2;
            let more = ["--nthreads", "2", "--progress", "openjd"].map(str::to_owned);
            expected.splice(before_output..before_output, more);
            assert_eq!(filled(0, &[common.to_vec(), own.to_vec()].concat()), expected);
        }
        assert_eq!(filled(1, &common), job.merge_arguments());
    }

    #[test]
    fn settings_that_look_like_parameters_are_refused() {
        let job = Job { settings: vec!["a={{b}}".to_owned()], ..awkward() };
        let message = write(&job).expect_err("refused").to_string();
        assert_eq!(message, "setting \"a={{b}}\": `{{` begins a parameter of an Open Job Description; change it");
    }

    #[test]
    fn the_command_holds_the_files() {
        let command = command(&awkward());
        assert_eq!(command[..5], ["openjd", "run", "/out/p %j/job.json", "--step", "Merge"]);
        let parameters: Value = serde_json::from_str(&command[7]).expect("JSON");
        assert_eq!(parameters["Output"], "/out/o !.exr");
    }
}
