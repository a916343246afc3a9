//! `key=value` from the command line, laid over the parsed scene file before anything is read from it.

use std::fmt;
use std::str::FromStr;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use crate::import::keyed::texts::Texts;
use crate::scene::error::{Problem, Problems};

/// One override: `render.photons=1000`, `materials.glass.ior=1.7`, `lights.0.intensity=[1, 2, 3]`.
///
/// The key is a dotted TOML key; elements of an array are counted from 0. The value is a TOML value, or any other text,
/// which is then taken as a string, so that `render.estimator=knn` needs no quotes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    key: String,
    value: String,
}

impl Override {
    pub fn new(key: impl Into<String>, value: impl Into<String>) -> Override {
        Override { key: key.into(), value: value.into() }
    }
    pub fn key(&self) -> &str {
        &self.key
    }
    pub fn value(&self) -> &str {
        &self.value
    }
}

/// As [`FromStr`] reads it.
impl fmt::Display for Override {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.key, self.value)
    }
}

impl FromStr for Override {
    type Err = Problem;
    fn from_str(text: &str) -> Result<Override, Problem> {
        match text.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() => Ok(Override::new(key.trim(), value.trim())),
            _ => {
                Err(Problem::new(format!("`{text}` is not an override"))
                    .help("write key=value, as render.photons=1000"))
            }
        }
    }
}

/// An override as two TOML documents, padded with blanks to its place behind the file's text.
pub(super) struct Statement {
    start: usize,
    shown: String,
    /// The value as TOML.
    plain: String,
    /// The value as a TOML string.
    quoted: String,
}

pub(super) fn statements(overrides: &[Override], texts: &mut Texts<'_>) -> Vec<Statement> {
    let statement = |item: &Override| {
        let plain = format!("{} = {}", item.key, item.value);
        let quoted = format!("{} = {}", item.key, toml::Value::String(item.value.clone()));
        let shown = format!("-D {}={}", item.key, item.value);
        let start = texts.add_override(&shown, quoted.len().max(plain.len()));
        let blanks = " ".repeat(start);
        Statement { start, shown, plain: blanks.clone() + &plain, quoted: blanks + &quoted }
    };
    overrides.iter().map(statement).collect()
}

/// Lays the statements over `table`, the later over the earlier.
pub(super) fn apply<'t>(
    table: &mut DeTable<'t>,
    statements: &'t [Statement],
    texts: &Texts<'_>,
    problems: &mut Problems,
) {
    for statement in statements {
        match parse(statement, texts) {
            Ok(parsed) => merge(table, parsed, texts, problems),
            Err(problem) => problems.push(problem),
        }
    }
}

fn parse<'t>(statement: &'t Statement, texts: &Texts<'_>) -> Result<DeTable<'t>, Problem> {
    // A line break would start a second statement.
    let multi_line = statement.plain.contains('\n');
    let plain = if multi_line { None } else { DeTable::parse(&statement.plain).ok() };
    match plain.map_or_else(|| DeTable::parse(&statement.quoted), Ok) {
        Ok(table) => Ok(table.into_inner()),
        Err(error) => Err(Problem::new(format!("override `{}` cannot be read: {}", statement.shown, error.message()))
            .help("write key=value with a dotted key, as render.photons=1000")
            .at(&texts.source(statement.start..statement.start + 1))),
    }
}

fn merge<'t>(target: &mut DeTable<'t>, from: DeTable<'t>, texts: &Texts<'_>, problems: &mut Problems) {
    for (key, value) in from {
        let span = value.span();
        let old = target.get_mut(key.get_ref().as_ref()).map(Spanned::get_mut);
        match (old, value.into_inner()) {
            (Some(DeValue::Table(old)), DeValue::Table(new)) => merge(old, new, texts, problems),
            (Some(DeValue::Array(old)), DeValue::Table(new)) => {
                merge_elements(old, new, &key.get_ref().clone(), texts, problems);
            }
            (_, new) => {
                // Removed first, so that the key's place is the command line too.
                target.remove(key.get_ref().as_ref());
                target.insert(key, Spanned::new(span, new));
            }
        }
    }
}

/// `lights.0.intensity = …`: the keys of `from` are positions in `array`.
fn merge_elements<'t>(
    array: &mut DeArray<'t>,
    from: DeTable<'t>,
    name: &str,
    texts: &Texts<'_>,
    problems: &mut Problems,
) {
    let count = array.len();
    for (key, value) in from {
        let span = value.span();
        let position = key.get_ref().parse::<usize>().ok();
        match (position.and_then(|i| array.get_mut(i)), value) {
            (Some(old), new) => match (old.get_mut(), new.into_inner()) {
                (DeValue::Table(old), DeValue::Table(new)) => merge(old, new, texts, problems),
                (_, new) => *old = Spanned::new(span, new),
            },
            (None, _) => problems.push(
                Problem::new(format!("`{name}` has no element `{}`", key.get_ref()))
                    .help(format!("it has {count}, counted from 0"))
                    .at(&texts.source(key.span())),
            ),
        }
    }
}
