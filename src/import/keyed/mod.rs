//! TOML files read key by key, every value typed, every problem with its line and column: scenes and studies alike.

pub(crate) mod convert;
pub(crate) mod reader;
pub(crate) mod texts;

use crate::scene::error::{Problem, Problems};
use texts::Texts;

/// Syntax errors reported from one file: after the first few the parser mostly trips over itself.
const MAX_SYNTAX_ERRORS: usize = 5;

/// Why a text is no TOML at all.
pub(crate) fn syntax_problems(errors: &[toml::de::Error], texts: &Texts<'_>) -> Problems {
    let problem = |error: &toml::de::Error| {
        let source = error.span().map_or_else(|| texts.file().clone(), |span| texts.source(span));
        Problem::new(format!("not TOML: {}", error.message())).at(&source)
    };
    Problems(errors.iter().take(MAX_SYNTAX_ERRORS).map(problem).collect())
}
