//! What is wrong with a scene: problems with their place in a file, reported all at once.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A place in an input file. Lines and columns count from 1; 0 stands for "the file as a whole".
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Source {
    /// The file, or the text of a `-D` option when a value came from the command line.
    pub file: Arc<Path>,
    pub line: u32,
    /// Counted in characters.
    pub column: u32,
    /// Bytes in the file, for a caret under the text.
    pub span: Option<Range<usize>>,
}

impl Source {
    /// The file as a whole.
    pub fn file(file: impl Into<PathBuf>) -> Source {
        Source { file: file.into().into(), line: 0, column: 0, span: None }
    }
    /// A whole line of this source's file.
    pub fn at_line(&self, line: u32) -> Source {
        Source { file: self.file.clone(), line, column: 0, span: None }
    }
    pub fn at(&self, line: u32, column: u32) -> Source {
        Source { file: self.file.clone(), line, column, span: None }
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        match (self.line, self.column) {
            (0, _) => Ok(()),
            (line, 0) => write!(f, ":{line}"),
            (line, column) => write!(f, ":{line}:{column}"),
        }
    }
}

/// What an exit code distinguishes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProblemKind {
    /// The content of an input is wrong.
    #[default]
    BadContent,
    /// An input file is not there or cannot be read.
    MissingInput,
    /// The content is sound, but nothing here renders it.
    Unsupported,
}

/// One thing that is wrong, or one warning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
    pub source: Option<Source>,
    pub kind: ProblemKind,
}

impl Problem {
    pub fn new(message: impl Into<String>) -> Problem {
        Problem { message: message.into(), help: None, source: None, kind: ProblemKind::BadContent }
    }
    /// A file that cannot be opened or read.
    pub fn unreadable(path: &Path, error: &std::io::Error) -> Problem {
        let mut problem = Problem::new(format!("cannot read {}: {error}", path.display()));
        problem.kind = ProblemKind::MissingInput;
        problem
    }
    pub fn help(mut self, help: impl Into<String>) -> Problem {
        self.help = Some(help.into());
        self
    }
    pub fn at(mut self, source: &Source) -> Problem {
        self.source = Some(source.clone());
        self
    }
    pub fn maybe_help(mut self, help: Option<String>) -> Problem {
        self.help = help.or(self.help);
        self
    }
    /// At `source` if it has no place yet.
    pub fn at_unless_placed(mut self, source: &Source) -> Problem {
        self.source.get_or_insert_with(|| source.clone());
        self
    }
}

/// `file:line:column: message (help)`.
impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(source) = &self.source {
            write!(f, "{source}: ")?;
        }
        f.write_str(&self.message)?;
        match &self.help {
            Some(help) => write!(f, " ({help})"),
            None => Ok(()),
        }
    }
}

/// Everything that is wrong with a scene; never empty when returned as an error.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Problems(pub Vec<Problem>);

impl Problems {
    pub fn push(&mut self, problem: Problem) {
        self.0.push(problem);
    }
    pub fn append(&mut self, other: Problems) {
        self.0.extend(other.0);
    }
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
    pub fn len(&self) -> usize {
        self.0.len()
    }
    pub fn iter(&self) -> std::slice::Iter<'_, Problem> {
        self.0.iter()
    }
    /// In the order of their places: files in the order they first appear, then lines and columns.
    pub fn sorted(self) -> Problems {
        let file = |problem: &Problem| problem.source.as_ref().map(|s| s.file.clone());
        let mut files: Vec<Option<Arc<Path>>> = Vec::new();
        for problem in self.iter() {
            let file = file(problem);
            if !files.contains(&file) {
                files.push(file);
            }
        }
        let mut problems = self.0;
        problems.sort_by_key(|problem| {
            let rank = files.iter().position(|f| *f == file(problem));
            (rank, problem.source.as_ref().map_or((0, 0), |s| (s.line, s.column)))
        });
        Problems(problems)
    }
    /// Whether all of them are files that could not be read.
    pub fn only_missing_inputs(&self) -> bool {
        !self.is_empty() && self.iter().all(|p| p.kind == ProblemKind::MissingInput)
    }
    /// `Ok(value)` if nothing was reported.
    pub fn into_result<T>(self, value: T) -> Result<T, Problems> {
        if self.is_empty() { Ok(value) } else { Err(self) }
    }
}

impl From<Problem> for Problems {
    fn from(problem: Problem) -> Problems {
        Problems(vec![problem])
    }
}

/// One line a problem.
impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{problem}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_names_its_place_and_what_to_do() {
        let file = Source::file("a.toml");
        let problem = Problem::new("radius must be > 0").help("give metres").at(&file.at(3, 7));
        assert_eq!(problem.to_string(), "a.toml:3:7: radius must be > 0 (give metres)");
        assert_eq!(Problem::new("no light").at(&file).to_string(), "a.toml: no light");
        assert_eq!(Problem::new("bad face").at(&file.at_line(9)).to_string(), "a.toml:9: bad face");
    }
}
