//! The words of a pbrt file, each with its place: names, numbers, quoted texts, brackets; `#` starts a comment.

use std::borrow::Cow;
use std::str::CharIndices;

use crate::scene::error::{Problem, Source};

/// Where a token starts and ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub line: u32,
    /// In characters, from 1.
    pub column: u32,
    /// Bytes.
    pub start: usize,
    pub end: usize,
}

impl Place {
    /// In the file of `file`.
    pub fn source(self, file: &Source) -> Source {
        Source { span: Some(self.start..self.end), ..file.at(self.line, self.column) }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind<'t> {
    /// A directive, a number, `true` or `false`.
    Word(&'t str),
    /// In quotation marks, which are left out, its escapes replaced.
    Text(Cow<'t, str>),
    Open,
    Close,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token<'t> {
    pub kind: Kind<'t>,
    pub place: Place,
}

/// Reads tokens from a text, one ahead.
pub(super) struct Lexer<'t> {
    text: &'t str,
    file: &'t Source,
    chars: CharIndices<'t>,
    /// Of the next character.
    line: u32,
    column: u32,
    ahead: Option<Token<'t>>,
}

impl<'t> Lexer<'t> {
    pub fn new(text: &'t str, file: &'t Source) -> Lexer<'t> {
        Lexer { text, file, chars: text.char_indices(), line: 1, column: 1, ahead: None }
    }

    pub fn file(&self) -> &'t Source {
        self.file
    }

    /// The next token, which stays the next one.
    pub fn peek(&mut self) -> Result<Option<&Token<'t>>, Problem> {
        if self.ahead.is_none() {
            self.ahead = self.read()?;
        }
        Ok(self.ahead.as_ref())
    }

    /// The next token; `None` at the end of the text.
    pub fn next(&mut self) -> Result<Option<Token<'t>>, Problem> {
        match self.ahead.take() {
            Some(token) => Ok(Some(token)),
            None => self.read(),
        }
    }

    fn position(&self) -> usize {
        self.chars.offset()
    }

    fn next_char(&self) -> Option<char> {
        self.chars.as_str().chars().next()
    }

    fn advance(&mut self) -> Option<char> {
        let (_, c) = self.chars.next()?;
        if c == '\n' {
            (self.line, self.column) = (self.line.saturating_add(1), 1);
        } else {
            self.column = self.column.saturating_add(1);
        }
        Some(c)
    }

    fn read(&mut self) -> Result<Option<Token<'t>>, Problem> {
        self.skip_blanks();
        let mut place = Place { line: self.line, column: self.column, start: self.position(), end: 0 };
        let Some(c) = self.next_char() else { return Ok(None) };
        let kind = match c {
            '[' | ']' => {
                self.advance();
                if c == '[' { Kind::Open } else { Kind::Close }
            }
            '"' => Kind::Text(self.quoted(place)?),
            _ => {
                while self.next_char().is_some_and(|c| !c.is_whitespace() && !matches!(c, '[' | ']' | '"' | '#')) {
                    self.advance();
                }
                Kind::Word(&self.text[place.start..self.position()])
            }
        };
        place.end = self.position();
        Ok(Some(Token { kind, place }))
    }

    fn skip_blanks(&mut self) {
        while let Some(c) = self.next_char() {
            if c == '#' {
                while self.next_char().is_some_and(|c| c != '\n') {
                    self.advance();
                }
            } else if c.is_whitespace() {
                self.advance();
            } else {
                return;
            }
        }
    }

    /// The text up to the closing quotation mark, on one line.
    fn quoted(&mut self, place: Place) -> Result<Cow<'t, str>, Problem> {
        self.advance();
        let first = self.position();
        let mut unescaped: Option<String> = None;
        loop {
            let before = self.position();
            match self.advance() {
                Some('"') => {
                    return Ok(unescaped.map_or(Cow::Borrowed(&self.text[first..before]), Cow::Owned));
                }
                Some('\\') => {
                    let c = match self.advance() {
                        Some('n') => '\n',
                        Some('t') => '\t',
                        Some('r') => '\r',
                        Some('b') => '\u{8}',
                        Some('f') => '\u{c}',
                        Some(c @ ('\\' | '"' | '\'')) => c,
                        other => {
                            let what = other.map_or("nothing".to_owned(), |c| format!("`{}`", c.escape_default()));
                            let problem = Problem::new(format!("a backslash before {what} means nothing"));
                            return Err(problem.help("write \\\\ for a backslash").at(&place.source(self.file)));
                        }
                    };
                    unescaped.get_or_insert_with(|| self.text[first..before].to_owned()).push(c);
                }
                Some('\n') | None => {
                    let end = Place { end: before, ..place };
                    let problem = Problem::new("this text has no closing quotation mark on its line");
                    return Err(problem.help("add a \"").at(&end.source(self.file)));
                }
                Some(c) => {
                    if let Some(text) = &mut unescaped {
                        text.push(c);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> Result<Vec<(String, u32, u32)>, String> {
        let file = Source::file("s.pbrt");
        let mut lexer = Lexer::new(text, &file);
        let mut found = Vec::new();
        while let Some(Token { kind, place }) = lexer.next().map_err(|problem| problem.to_string())? {
            let shown = match kind {
                Kind::Word(word) => word.to_owned(),
                Kind::Text(text) => format!("<{text}>"),
                Kind::Open => "[".to_owned(),
                Kind::Close => "]".to_owned(),
            };
            found.push((shown, place.line, place.column));
        }
        Ok(found)
    }

    #[test]
    fn words_texts_and_brackets_have_lines_and_columns_in_characters() {
        let token = |s: &str, line, column| (s.to_owned(), line, column);
        assert_eq!(
            all("Shape\"é a\"[1 -2.5e3]# end\n\t\"b\\\"c\" x").expect("tokens"),
            [
                token("Shape", 1, 1),
                token("<é a>", 1, 6),
                token("[", 1, 11),
                token("1", 1, 12),
                token("-2.5e3", 1, 14),
                token("]", 1, 20),
                token("<b\"c>", 2, 2),
                token("x", 2, 9),
            ]
        );
    }

    #[test]
    fn texts_end_on_their_line_and_backslashes_mean_something() {
        assert!(all("a \"b\nc\"").expect_err("open").starts_with("s.pbrt:1:3: this text has no closing"));
        assert!(all("\"b").expect_err("open").contains("no closing"));
        assert!(all("\"a\\q\"").expect_err("escape").starts_with("s.pbrt:1:1: a backslash before `q`"));
    }
}
