//! What a file uses and this program does not render: each thing once, by the name that the format gives it.

use std::collections::BTreeSet;

use crate::scene::error::{Problem, Source};

#[derive(Debug, Default)]
pub(crate) struct Ignored(BTreeSet<String>);

impl Ignored {
    pub fn note(&mut self, name: impl Into<String>) {
        self.0.insert(name.into());
    }
    pub fn note_if(&mut self, used: bool, name: &str) {
        if used {
            self.note(name);
        }
    }
    /// All of it in one warning.
    pub fn warning(&self, source: &Source) -> Option<Problem> {
        let names: Vec<&str> = self.0.iter().map(String::as_str).collect();
        let warning = || Problem::new(format!("not rendered: {}", names.join("; "))).at(source);
        (!names.is_empty()).then(warning)
    }
}
