//! Reads tables key by key: types, ranges, choices; remembers what was asked for, so that the rest is unknown.
//!
//! A value that is wrong is reported and replaced by a placeholder, so one reading finds every problem of a file.

use std::cell::RefCell;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::convert::{Convert, Mismatch};
use super::texts::Texts;
use crate::scene::error::{Problem, Problems, Source};
use crate::scene::spelling::nearest;

/// Where problems of one scene file are collected.
pub(crate) struct Reader<'t> {
    pub texts: &'t Texts<'t>,
    problems: RefCell<Problems>,
}

impl<'t> Reader<'t> {
    pub fn new(texts: &'t Texts<'t>, problems: Problems) -> Reader<'t> {
        Reader { texts, problems: RefCell::new(problems) }
    }
    pub fn report(&self, problem: Problem) {
        self.problems.borrow_mut().push(problem);
    }
    pub fn report_all(&self, problems: Problems) {
        self.problems.borrow_mut().append(problems);
    }
    pub fn into_problems(self) -> Problems {
        self.problems.into_inner()
    }
    pub fn source(&self, span: Range<usize>) -> Source {
        self.texts.source(span)
    }
    /// `value` as `kind`, or `None` after reporting why not.
    pub fn convert<K: Convert>(&self, name: &str, value: &Spanned<DeValue<'_>>, kind: &K) -> Option<K::Output> {
        match kind.convert(value) {
            Ok(converted) => Some(converted),
            Err(Mismatch { found, span }) => {
                let message = format!("`{name}` must be {}, got {found}", kind.expects());
                self.report(Problem::new(message).maybe_help(kind.help()).at(&self.source(span)));
                None
            }
        }
    }
}

/// One table of the file while it is read.
pub(crate) struct Section<'t> {
    pub reader: &'t Reader<'t>,
    table: &'t DeTable<'t>,
    span: Range<usize>,
    /// As messages name it.
    label: String,
    asked: RefCell<Vec<&'static str>>,
}

impl<'t> Section<'t> {
    pub fn new(
        reader: &'t Reader<'t>,
        label: impl Into<String>,
        table: &'t DeTable<'t>,
        span: Range<usize>,
    ) -> Section<'t> {
        Section { reader, table, span, label: label.into(), asked: RefCell::new(Vec::new()) }
    }
    /// `value` as a section, or `None` after reporting that it is no table.
    pub fn of_value(
        reader: &'t Reader<'t>,
        label: impl Into<String>,
        value: &'t Spanned<DeValue<'t>>,
    ) -> Option<Section<'t>> {
        let label = label.into();
        match value.get_ref() {
            DeValue::Table(table) => Some(Section::new(reader, label, table, value.span())),
            other => {
                let message = format!("{label} must be a table, got {}", super::convert::found(other));
                reader.report(Problem::new(message).at(&reader.source(value.span())));
                None
            }
        }
    }
    pub fn source(&self) -> Source {
        self.reader.source(self.span.clone())
    }
    pub fn label(&self) -> &str {
        &self.label
    }

    /// The value of `key`, which from now on is a known key.
    pub fn get(&self, key: &'static str) -> Option<&'t Spanned<DeValue<'t>>> {
        self.asked.borrow_mut().push(key);
        self.table.get(key)
    }
    /// All keys of a table whose keys are names, in the order of the file.
    pub fn entries(&self) -> Vec<(&'t Spanned<toml::de::DeString<'t>>, &'t Spanned<DeValue<'t>>)> {
        let mut entries: Vec<_> = self.table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        entries
    }
    /// The value of `key` if it is there and right.
    pub fn optional<K: Convert>(&self, key: &'static str, kind: K) -> Option<K::Output> {
        self.get(key).and_then(|value| self.reader.convert(key, value, &kind))
    }
    pub fn or<K: Convert>(&self, key: &'static str, kind: K, default: K::Output) -> K::Output {
        self.optional(key, kind).unwrap_or(default)
    }
    /// The value of `key`; a missing one is reported. The placeholder stands for a value that was reported.
    pub fn required<K: Convert>(&self, key: &'static str, kind: K, placeholder: K::Output) -> K::Output {
        match self.get(key) {
            Some(value) => self.reader.convert(key, value, &kind).unwrap_or(placeholder),
            None => {
                self.missing(key, &kind.expects());
                placeholder
            }
        }
    }
    pub fn missing(&self, key: &str, expected: &str) {
        let problem = Problem::new(format!("{} needs the key `{key}`", self.label));
        self.reader.report(problem.help(format!("give {expected}")).at(&self.source()));
    }
    /// Elements of an array of tables; `singular` labels them.
    pub fn tables(&self, key: &'static str, label: impl Fn(usize) -> String) -> Vec<Section<'t>> {
        let Some(value) = self.get(key) else { return Vec::new() };
        match value.get_ref() {
            DeValue::Array(items) => {
                let section = |(i, item)| Section::of_value(self.reader, label(i), item);
                items.iter().enumerate().filter_map(section).collect()
            }
            other => {
                let message = format!("`{key}` must be an array of tables, got {}", super::convert::found(other));
                let problem = Problem::new(message).help(format!("write [[{key}]] before each"));
                self.reader.report(problem.at(&self.reader.source(value.span())));
                Vec::new()
            }
        }
    }
    pub fn table(&self, key: &'static str) -> Option<Section<'t>> {
        let label = format!("`{key}`");
        self.get(key).and_then(|value| Section::of_value(self.reader, label, value))
    }
    /// Reports every key that nobody asked for.
    pub fn finish(&self) {
        let asked = self.asked.borrow();
        for (key, _) in self.entries() {
            let name = key.get_ref().as_ref();
            if asked.contains(&name) {
                continue;
            }
            let help = match nearest(name, &asked) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("known keys: {}", asked.join(", ")),
            };
            let message = format!("unknown key `{name}` in {}", self.label);
            self.reader.report(Problem::new(message).help(help).at(&self.reader.source(key.span())));
        }
    }
}
