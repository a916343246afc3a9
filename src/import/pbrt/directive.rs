//! The words of one directive: names, numbers and parameters, as far as they are wanted.

use std::rc::Rc;

use super::lexer::{Kind, Lexer, Place, Token};
use super::parameters::{Parameter, Parameters, number, shortened};
use super::state::{State, Target};
use crate::scene::error::{Problem, Problems, Source};

/// A directive as its words are read.
pub struct Directive<'l, 't> {
    pub lexer: &'l mut Lexer<'t>,
    pub name: &'t str,
    pub place: Place,
}

impl Directive<'_, '_> {
    pub fn source(&self) -> Source {
        self.place.source(self.lexer.file())
    }

    pub fn problem(&self, message: impl Into<String>, help: impl Into<String>) -> Problem {
        Problem::new(message).help(help).at(&self.source())
    }

    /// The next word, which is in quotation marks.
    pub fn text(&mut self) -> Result<String, Garbled> {
        match self.lexer.next()? {
            Some(Token { kind: Kind::Text(text), .. }) => Ok(text.into_owned()),
            other => {
                let source = other.map_or(self.source(), |token| token.place.source(self.lexer.file()));
                let problem = Problem::new(format!("{} needs a name in quotation marks here", self.name));
                Err(Garbled(problem.help("write it as \"name\"").at(&source)))
            }
        }
    }

    pub fn optional_text(&mut self) -> Result<Option<String>, Garbled> {
        let is_text = matches!(self.lexer.peek()?, Some(Token { kind: Kind::Text(_), .. }));
        if is_text { self.text().map(Some) } else { Ok(None) }
    }

    /// A word without quotation marks.
    pub fn word(&mut self) -> Result<(), Garbled> {
        match self.lexer.next()? {
            Some(Token { kind: Kind::Word(_), .. }) => Ok(()),
            _ => Err(Garbled(self.problem(format!("{} needs a word", self.name), "as All"))),
        }
    }

    /// `N` numbers, in brackets or without.
    pub fn numbers<const N: usize>(&mut self) -> Result<[f64; N], Garbled> {
        let bracketed = matches!(self.lexer.peek()?, Some(Token { kind: Kind::Open, .. }));
        if bracketed {
            self.lexer.next()?;
        }
        let mut numbers = [0.0; N];
        for slot in &mut numbers {
            match self.lexer.next()? {
                Some(Token { kind: Kind::Word(word), place }) => {
                    *slot = number(word, &place.source(self.lexer.file()))?;
                }
                other => return Err(self.not_numbers(N, other)),
            }
        }
        if bracketed {
            match self.lexer.next()? {
                Some(Token { kind: Kind::Close, .. }) => {}
                other => return Err(self.not_numbers(N, other)),
            }
        }
        Ok(numbers)
    }

    fn not_numbers(&self, count: usize, found: Option<Token<'_>>) -> Garbled {
        let source = found.map_or(self.source(), |token| token.place.source(self.lexer.file()));
        let problem = Problem::new(format!("{} needs {count} numbers", self.name));
        Garbled(problem.help("one is missing or too many").at(&source))
    }

    pub fn parameters(&mut self) -> Result<Vec<Rc<Parameter>>, Garbled> {
        let mut list = Vec::new();
        while matches!(self.lexer.peek()?, Some(Token { kind: Kind::Text(_), .. })) {
            let Some(head) = self.lexer.next()? else { break };
            let Kind::Text(declaration) = &head.kind else { break };
            list.push(Rc::new(Parameter::read(self.lexer, &head, declaration)?));
        }
        Ok(list)
    }

    /// A name and parameters, as most directives have.
    pub fn named(&mut self, state: &State, target: Option<Target>) -> Result<(String, Parameters), Garbled> {
        let name = self.text()?;
        let label = format!("{} \"{}\"", self.name, shortened(&name));
        let list = self.parameters()?;
        let defaults = target.map_or(Vec::new(), |target| state.defaults(target));
        Ok((name, Parameters::new(list, defaults, self.source(), label)))
    }
}

/// The words of a directive mean nothing, nor do those behind them.
pub struct Garbled(pub Problem);

impl From<Problem> for Garbled {
    fn from(problem: Problem) -> Garbled {
        Garbled(problem)
    }
}

/// What is wrong with a directive.
pub enum Trouble {
    /// The next one can be read.
    Content(Problems),
    /// The words from here on mean nothing.
    Syntax(Problem),
    /// It was reported.
    Stopped,
}

impl From<Garbled> for Trouble {
    fn from(Garbled(problem): Garbled) -> Trouble {
        Trouble::Syntax(problem)
    }
}

impl From<Problem> for Trouble {
    fn from(problem: Problem) -> Trouble {
        Trouble::Content(problem.into())
    }
}

impl From<Problems> for Trouble {
    fn from(problems: Problems) -> Trouble {
        Trouble::Content(problems)
    }
}
