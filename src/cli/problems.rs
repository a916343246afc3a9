//! What is wrong with a scene, shown: with the line and a caret on a terminal, one line a problem elsewhere.

use std::io::{self, Write};

use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report, Severity};
use pdembree::scene::error::{Problem, Problems};

use super::console::{stderr_has_colour, stderr_is_terminal};
use super::failure::{Failure, code};

/// Prints all problems; the exit code says whether files are missing or wrong.
pub fn failure(problems: &Problems) -> Failure {
    print(&problems.0, Severity::Error);
    let code = if problems.only_missing_inputs() { code::NO_INPUT } else { code::BAD_DATA };
    Failure { code, message: String::new() }
}

pub fn print(problems: &[Problem], severity: Severity) {
    let text: String = if stderr_is_terminal() {
        problems.iter().map(|problem| drawn(problem, severity)).collect()
    } else {
        let kind = if severity == Severity::Warning { "warning" } else { "error" };
        problems.iter().map(|problem| plain(problem, kind)).collect()
    };
    // Nobody is left to be told when stderr is closed.
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// `file:line:column: error: message (help)`, the form that editors understand.
fn plain(problem: &Problem, kind: &str) -> String {
    let place = problem.source.as_ref().map_or_else(|| "pdembree".to_owned(), ToString::to_string);
    let help = problem.help.as_ref().map_or_else(String::new, |help| format!(" ({help})"));
    format!("{place}: {kind}: {}{help}\n", problem.message)
}

fn drawn(problem: &Problem, severity: Severity) -> String {
    let span = problem.source.as_ref().and_then(|source| Some((source, source.span.clone()?)));
    // The file is read again for its text; if it is gone meanwhile, or its place is a whole file, the place is named.
    let text = span.and_then(|(source, span)| Some((source, span, std::fs::read_to_string(&source.file).ok()?)));
    let place = match (&text, &problem.source) {
        (None, Some(source)) => format!("{source}: "),
        _ => String::new(),
    };
    let mut diagnostic = MietteDiagnostic::new(format!("{place}{}", problem.message)).with_severity(severity);
    if let Some(help) = &problem.help {
        diagnostic = diagnostic.with_help(help);
    }
    let report = match text {
        None => Report::new(diagnostic),
        Some((source, span, text)) => {
            let label = LabeledSpan::new_primary_with_span(None, span);
            Report::new(diagnostic.with_label(label))
                .with_source_code(NamedSource::new(source.file.to_string_lossy(), text))
        }
    };
    let theme = if stderr_has_colour() { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let mut shown = String::new();
    match GraphicalReportHandler::new_themed(theme).render_report(&mut shown, report.as_ref()) {
        Ok(()) => shown,
        Err(_) => plain(problem, "error"),
    }
}
