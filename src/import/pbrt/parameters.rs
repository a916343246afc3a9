//! The parameters of a directive, `"type name" [values]`, asked for by type and name; what nobody asks for is a mistake.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use super::lexer::{Kind, Lexer, Token};
use crate::scene::error::{Problem, ProblemKind, Source};
use crate::scene::spelling::nearest;

/// What a parameter holds.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
    Flags(Vec<bool>),
}

/// One parameter as it is written.
#[derive(Debug)]
pub(super) struct Parameter {
    /// As in the file, older names replaced by today's.
    pub kind: &'static str,
    pub name: String,
    pub values: Values,
    pub source: Source,
    asked: Cell<bool>,
}

/// Types of parameters, with the older names of some.
const TYPES: [(&str, &str); 16] = [
    ("bool", "bool"),
    ("integer", "integer"),
    ("float", "float"),
    ("point2", "point2"),
    ("vector2", "vector2"),
    ("point3", "point3"),
    ("point", "point3"),
    ("vector3", "vector3"),
    ("vector", "vector3"),
    ("normal3", "normal"),
    ("normal", "normal"),
    ("spectrum", "spectrum"),
    ("rgb", "rgb"),
    ("blackbody", "blackbody"),
    ("texture", "texture"),
    ("string", "string"),
];

impl Parameter {
    /// Reads the values that follow `"type name"`, whose token is `head`.
    pub fn read(lexer: &mut Lexer<'_>, head: &Token<'_>, declaration: &str) -> Result<Parameter, Problem> {
        let source = head.place.source(lexer.file());
        let mut words = declaration.split_whitespace();
        let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
            let problem = Problem::new(format!("`{declaration}` declares no parameter"));
            return Err(problem.help("write \"type name\", as \"float radius\"").at(&source));
        };
        let known: Vec<&str> = TYPES.iter().map(|(name, _)| *name).collect();
        let Some((_, kind)) = TYPES.iter().find(|(name, _)| *name == kind) else {
            let help = match nearest(kind, &known) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("types are {}", known.join(", ")),
            };
            return Err(Problem::new(format!("`{kind}` is no type of a parameter")).help(help).at(&source));
        };
        let values = read_values(lexer, kind, &source)?;
        Ok(Parameter { kind, name: name.to_owned(), values, source, asked: Cell::new(false) })
    }

    /// A problem of this parameter.
    pub fn problem(&self, message: impl Into<String>, help: impl Into<String>) -> Problem {
        Problem::new(message).help(help).at(&self.source)
    }

    fn expected(&self, what: &str) -> Problem {
        self.problem(format!("`{}` must be {what}", self.name), format!("it is of type {}", self.kind))
    }

    fn numbers(&self, kinds: &[&str]) -> Result<&[f64], Problem> {
        match &self.values {
            Values::Numbers(numbers) if kinds.contains(&self.kind) => Ok(numbers),
            _ => Err(self.expected(&format!("of type {}", kinds.join(" or ")))),
        }
    }

    /// The only number.
    pub fn number(&self, kinds: &[&str]) -> Result<f64, Problem> {
        match self.numbers(kinds)? {
            [number] => Ok(*number),
            other => Err(self.problem(format!("`{}` has {} values", self.name, other.len()), "give one")),
        }
    }

    /// The only text.
    pub fn text(&self, kind: &str) -> Result<&str, Problem> {
        match &self.values {
            Values::Texts(texts) if self.kind == kind => match &texts[..] {
                [text] => Ok(text),
                other => Err(self.problem(format!("`{}` has {} values", self.name, other.len()), "give one")),
            },
            _ => Err(self.expected(&format!("of type {kind}"))),
        }
    }

    /// Numbers in groups of N.
    pub fn tuples<const N: usize>(&self, kinds: &[&str]) -> Result<&[[f64; N]], Problem> {
        let (groups, rest) = self.numbers(kinds)?.as_chunks::<N>();
        if !rest.is_empty() {
            let count = groups.len() * N + rest.len();
            let message = format!("`{}` has {count} numbers, no multiple of {N}", self.name);
            return Err(self.problem(message, "one is missing or too many"));
        }
        Ok(groups)
    }
}

/// One value, or any number of them in brackets.
fn read_values(lexer: &mut Lexer<'_>, kind: &str, source: &Source) -> Result<Values, Problem> {
    let missing = || Problem::new("the parameter has no value").help("write it behind the name").at(source);
    let mut values = match kind {
        "bool" => Values::Flags(Vec::new()),
        "string" | "texture" => Values::Texts(Vec::new()),
        _ => Values::Numbers(Vec::new()),
    };
    let bracketed = matches!(lexer.peek()?, Some(Token { kind: Kind::Open, .. }));
    if bracketed {
        lexer.next()?;
    }
    loop {
        let token = lexer.next()?.ok_or_else(missing)?;
        if token.kind == Kind::Close && bracketed {
            return Ok(values);
        }
        let place = token.place.source(lexer.file());
        values = with_value(values, kind, token, &place)?;
        if !bracketed {
            return Ok(values);
        }
    }
}

/// `values` and one more.
fn with_value(mut values: Values, kind: &str, token: Token<'_>, place: &Source) -> Result<Values, Problem> {
    // A spectrum is named, or numbers.
    if let (Values::Numbers(numbers), "spectrum", Kind::Text(_)) = (&values, kind, &token.kind)
        && numbers.is_empty()
    {
        values = Values::Texts(Vec::new());
    }
    match (&mut values, token.kind) {
        (Values::Numbers(numbers), Kind::Word(word)) => numbers.push(number(word, place)?),
        (Values::Texts(texts), Kind::Text(text)) => texts.push(text.into_owned()),
        (Values::Flags(flags), Kind::Word("true")) => flags.push(true),
        (Values::Flags(flags), Kind::Word("false")) => flags.push(false),
        (_, found) => {
            let found = match found {
                Kind::Word(word) => format!("`{}`", shortened(word)),
                Kind::Text(text) => format!("\"{}\"", shortened(&text)),
                Kind::Open => "`[`".to_owned(),
                Kind::Close => "`]`".to_owned(),
            };
            let help = match kind {
                "bool" => "write true or false, without quotation marks",
                "string" | "texture" => "write it in quotation marks",
                _ => "write a number",
            };
            return Err(Problem::new(format!("{found} is no value of type {kind}")).help(help).at(place));
        }
    }
    Ok(values)
}

/// A finite number.
pub(super) fn number(word: &str, place: &Source) -> Result<f64, Problem> {
    let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
    number.ok_or_else(|| {
        let problem = Problem::new(format!("`{}` is no finite number", shortened(word)));
        problem.help("is a closing bracket or a quotation mark missing?").at(place)
    })
}

/// What is understood and cannot be rendered.
pub(super) fn unsupported(problem: Problem) -> Problem {
    Problem { kind: ProblemKind::Unsupported, ..problem }
}

/// For messages.
pub(super) fn shortened(text: &str) -> String {
    text.chars().take(60).map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// All of a directive.
#[derive(Debug)]
pub(super) struct Parameters {
    list: Vec<Rc<Parameter>>,
    /// What `Attribute` has set for such directives; weaker.
    defaults: Vec<Rc<Parameter>>,
    /// The directive.
    pub source: Source,
    /// As messages name it.
    pub label: String,
    /// Names that there are.
    known: RefCell<Vec<String>>,
}

impl Parameters {
    pub fn new(list: Vec<Rc<Parameter>>, defaults: Vec<Rc<Parameter>>, source: Source, label: String) -> Parameters {
        Parameters { list, defaults, source, label, known: RefCell::default() }
    }

    pub fn problem(&self, message: impl Into<String>, help: impl Into<String>) -> Problem {
        Problem::new(message).help(help).at(&self.source)
    }

    /// What is understood and cannot be rendered.
    pub fn cannot(&self, message: impl Into<String>, help: impl Into<String>) -> Problem {
        unsupported(self.problem(message, help))
    }

    pub fn find(&self, name: &str) -> Option<&Parameter> {
        let mut known = self.known.borrow_mut();
        if !known.iter().any(|n| n == name) {
            known.push(name.to_owned());
        }
        let by_name = |p: &&Rc<Parameter>| p.name == name;
        // Of two of the same name the later wins, as of `Attribute`'s.
        let found = self.list.iter().rev().find(by_name).or_else(|| self.defaults.iter().rev().find(by_name));
        found.map(|parameter| {
            parameter.asked.set(true);
            &**parameter
        })
    }

    pub fn has(&self, name: &str) -> bool {
        self.find(name).is_some()
    }

    pub fn number(&self, name: &str, default: f64) -> Result<f64, Problem> {
        self.find(name).map_or(Ok(default), |p| p.number(&["float"]))
    }

    pub fn optional_number(&self, name: &str) -> Result<Option<f64>, Problem> {
        self.find(name).map(|p| p.number(&["float"])).transpose()
    }

    /// A number that must be > 0.
    pub fn positive(&self, name: &str, default: f64) -> Result<f64, Problem> {
        let number = self.number(name, default)?;
        match self.find(name) {
            Some(p) if number <= 0.0 => Err(p.problem(format!("`{name}` is {number}"), "it must be above 0")),
            _ => Ok(number),
        }
    }

    /// A whole number in `range`.
    pub fn integer(&self, name: &str, range: std::ops::RangeInclusive<i64>, default: i64) -> Result<i64, Problem> {
        let Some(parameter) = self.find(name) else { return Ok(default) };
        let number = parameter.number(&["integer"])?;
        if number.fract() != 0.0 || !(*range.start() as f64..=*range.end() as f64).contains(&number) {
            let help = format!("it must be a whole number from {} to {}", range.start(), range.end());
            return Err(parameter.problem(format!("`{name}` is {number}"), help));
        }
        Ok(number as i64)
    }

    pub fn flag(&self, name: &str, default: bool) -> Result<bool, Problem> {
        let Some(parameter) = self.find(name) else { return Ok(default) };
        match &parameter.values {
            Values::Flags(flags) if flags.len() == 1 => Ok(flags[0]),
            _ => Err(parameter.expected("one bool")),
        }
    }

    pub fn text(&self, name: &str) -> Result<Option<&str>, Problem> {
        self.find(name).map(|p| p.text("string")).transpose()
    }

    pub fn point(&self, name: &str, default: [f64; 3]) -> Result<[f64; 3], Problem> {
        let Some(parameter) = self.find(name) else { return Ok(default) };
        match parameter.tuples::<3>(&["point3"])? {
            [point] => Ok(*point),
            _ => Err(parameter.expected("one point")),
        }
    }

    pub fn tuples<const N: usize>(&self, name: &str, kinds: &[&str]) -> Result<Option<&[[f64; N]]>, Problem> {
        self.find(name).map(|p| p.tuples::<N>(kinds)).transpose()
    }

    /// Marks what is known and changes nothing here.
    pub fn ignore(&self, names: &[&str]) {
        for name in names {
            self.find(name);
        }
    }

    /// For a directive that is not understood as a whole.
    pub fn ignore_all(&self) {
        self.list.iter().for_each(|p| p.asked.set(true));
    }

    /// Those that nobody has asked for, each as a problem.
    pub fn unknown(&self) -> Vec<Problem> {
        let known = self.known.borrow();
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        let problem = |p: &Rc<Parameter>| {
            let help = match nearest(&p.name, &known) {
                Some(near) => format!("did you mean `{near}`?"),
                None if known.is_empty() => "it has none".to_owned(),
                None => format!("it has {}", known.join(", ")),
            };
            p.problem(format!("`{}` is no parameter of {}", shortened(&p.name), self.label), help)
        };
        self.list.iter().filter(|p| !p.asked.get()).map(problem).collect()
    }
}
