//! Reads our own source text, for tests of the house's rules.

use std::path::{Path, PathBuf};

/// All files below `folder` whose name ends in `.ext`, sorted.
pub fn files(folder: &Path, ext: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(dir) = open.pop() {
        let entries = std::fs::read_dir(&dir).unwrap_or_else(|e| panic!("{}: {e}", dir.display()));
        for entry in entries {
            let path = entry.expect("a readable entry").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == ext) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// One line cut into code and comment. String contents are blanked, so that words in messages are not code.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    pub number: usize,
    pub code: String,
    pub comment: String,
}

/// Cuts Rust source into lines of code and comment. Knows line comments, strings, raw strings and characters; the
/// project uses no block comments.
pub fn lines(text: &str) -> Vec<Line> {
    let mut out = Vec::new();
    let mut string_end: Option<String> = None;
    for (i, line) in text.lines().enumerate() {
        let (mut code, mut comment) = (String::new(), String::new());
        let mut rest = line;
        while !rest.is_empty() {
            if let Some(end) = &string_end {
                match find_end(rest, end) {
                    Some(at) => {
                        rest = &rest[at + end.len()..];
                        string_end = None;
                        code.push('"');
                    }
                    None => break,
                }
            } else if rest.starts_with("//") {
                comment = rest.trim_start_matches(['/', '!']).to_string();
                break;
            } else if rest.starts_with("r\"")
                || rest.starts_with("r#") && rest.trim_start_matches(['r', '#']).starts_with('"')
            {
                let hashes = rest[1..].chars().take_while(|&c| c == '#').count();
                string_end = Some(format!("\"{}", "#".repeat(hashes)));
                code.push('"');
                rest = &rest[2 + hashes..];
            } else if rest.starts_with('"') {
                string_end = Some("\"".into());
                code.push('"');
                rest = &rest[1..];
            } else if let Some(length) = character_literal(rest) {
                code.push_str("' '");
                rest = &rest[length..];
            } else {
                let c = rest.chars().next().expect("not empty");
                code.push(c);
                rest = &rest[c.len_utf8()..];
            }
        }
        out.push(Line { number: i + 1, code, comment });
    }
    out
}

/// Where `end` closes a string; a backslash escapes the quote of ordinary strings.
fn find_end(text: &str, end: &str) -> Option<usize> {
    if end.len() > 1 {
        return text.find(end);
    }
    let mut escaped = false;
    for (at, c) in text.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return Some(at),
            _ => {}
        }
    }
    None
}

/// Length in bytes of a character literal at the start of `text`; lifetimes are none.
fn character_literal(text: &str) -> Option<usize> {
    let inner = text.strip_prefix('\'')?;
    let mut chars = inner.char_indices();
    let (_, first) = chars.next()?;
    if first == '\\' {
        let close = inner[2..].find('\'')?;
        return Some(close + 4);
    }
    let (at, next) = chars.next()?;
    (next == '\'').then_some(at + 2)
}
