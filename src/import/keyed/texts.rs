//! Where a byte of the scene came from: the file, or one of the `-D` options laid behind it.
//!
//! An override is parsed from a text that starts with as many blanks as the file and the earlier overrides have bytes,
//! so its spans continue theirs and one number says which text a value came from.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use crate::scene::error::Source;

/// The texts of a scene, laid one behind the other.
pub(crate) struct Texts<'t> {
    file: Source,
    text: &'t str,
    line_starts: Vec<usize>,
    /// First byte and source of each override.
    overrides: Vec<(usize, Source)>,
    end: usize,
}

impl<'t> Texts<'t> {
    pub fn new(path: &Path, text: &'t str) -> Texts<'t> {
        let after_newlines = text.bytes().enumerate().filter(|&(_, b)| b == b'\n').map(|(i, _)| i + 1);
        let line_starts = std::iter::once(0).chain(after_newlines).collect();
        Texts { file: Source::file(path), text, line_starts, overrides: Vec::new(), end: text.len() + 1 }
    }

    /// Lays an override of `length` bytes behind the rest; returns its first byte.
    pub fn add_override(&mut self, shown: &str, length: usize) -> usize {
        let start = self.end;
        let source = Source { file: Arc::from(Path::new(shown)), line: 0, column: 0, span: None };
        self.overrides.push((start, source));
        self.end += length + 1;
        start
    }

    pub fn file(&self) -> &Source {
        &self.file
    }

    pub fn source(&self, span: Range<usize>) -> Source {
        if let Some((_, source)) = self.overrides.iter().rev().find(|(start, _)| span.start >= *start) {
            return source.clone();
        }
        let start = span.start.min(self.text.len());
        let line = self.line_starts.partition_point(|&s| s <= start).max(1);
        let line_start = self.line_starts.get(line - 1).copied().unwrap_or(0);
        let column = self.text.get(line_start..start).map_or(1, |before| before.chars().count() + 1);
        let end = span.end.clamp(start, self.text.len());
        Source { span: Some(start..end), ..self.file.at(line as u32, column as u32) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_count_characters_from_one() {
        let mut texts = Texts::new(Path::new("s.toml"), "a = 1\nβ = 22\n");
        assert_eq!(texts.source(0..1).to_string(), "s.toml:1:1");
        assert_eq!(texts.source(11..13).to_string(), "s.toml:2:5");
        assert_eq!(texts.source(99..100).line, 3);
        let start = texts.add_override("-D x=1", 3);
        assert_eq!(texts.source(start..start + 1).to_string(), "-D x=1");
    }
}
