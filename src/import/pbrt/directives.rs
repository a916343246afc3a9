//! Reads directives one by one and does what they say.
//!
//! What is wrong with a directive is reported and the next one read, so that one reading finds every problem; a text whose
//! words make no directives ends it.

use std::rc::Rc;

use glam::{DMat4, DVec3};

use super::lexer::{Kind, Lexer, Place, Token};
use super::lights;
use super::materials::{Chosen, Written};
use super::parameters::{Parameter, Parameters, number, shortened, unsupported};
use super::placing;
use super::reading::Reading;
use super::state::{Scope, State, Target};
use super::textures::Type;
use crate::import::read_text;
use crate::scene::error::{Problem, Problems, Source};
use crate::scene::spelling::nearest;

/// Files within files.
const MAX_DEPTH: u32 = 32;
/// Bytes of one file.
const MAX_FILE: u64 = 1 << 30;
/// Bytes of all files, those that are read twice counted twice.
const MAX_TOTAL: usize = 2 << 30;
/// Problems after which nobody wants to read on.
const ENOUGH: usize = 100;

const DIRECTIVES: [&str; 38] = [
    "Accelerator",
    "ActiveTransform",
    "AreaLightSource",
    "Attribute",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ColorSpace",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Film",
    "Identity",
    "Import",
    "Include",
    "Integrator",
    "LightSource",
    "LookAt",
    "MakeNamedMaterial",
    "MakeNamedMedium",
    "Material",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "PixelFilter",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "Shape",
    "Texture",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "TransformTimes",
];
/// Those that only the part before `WorldBegin` has, and those that only the part behind it has.
const BEFORE: [&str; 9] =
    ["Accelerator", "Camera", "Film", "Integrator", "PixelFilter", "Sampler", "Option", "TransformTimes", "WorldBegin"];
const BEHIND: [&str; 8] = [
    "AreaLightSource",
    "Import",
    "LightSource",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "ReverseOrientation",
    "Shape",
];

/// A directive as its words are read.
struct Directive<'l, 't> {
    lexer: &'l mut Lexer<'t>,
    name: &'t str,
    place: Place,
}

impl Directive<'_, '_> {
    fn source(&self) -> Source {
        self.place.source(self.lexer.file())
    }

    fn problem(&self, message: impl Into<String>, help: impl Into<String>) -> Problem {
        Problem::new(message).help(help).at(&self.source())
    }

    /// The next word, which is in quotation marks.
    fn text(&mut self) -> Result<String, Garbled> {
        match self.lexer.next()? {
            Some(Token { kind: Kind::Text(text), .. }) => Ok(text.into_owned()),
            other => {
                let source = other.map_or(self.source(), |token| token.place.source(self.lexer.file()));
                let problem = Problem::new(format!("{} needs a name in quotation marks here", self.name));
                Err(Garbled(problem.help("write it as \"name\"").at(&source)))
            }
        }
    }

    fn optional_text(&mut self) -> Result<Option<String>, Garbled> {
        let is_text = matches!(self.lexer.peek()?, Some(Token { kind: Kind::Text(_), .. }));
        if is_text { self.text().map(Some) } else { Ok(None) }
    }

    /// A word without quotation marks.
    fn word(&mut self) -> Result<(), Garbled> {
        match self.lexer.next()? {
            Some(Token { kind: Kind::Word(_), .. }) => Ok(()),
            _ => Err(Garbled(self.problem(format!("{} needs a word", self.name), "as All"))),
        }
    }

    /// `N` numbers, in brackets or without.
    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], Garbled> {
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

    fn parameters(&mut self) -> Result<Vec<Rc<Parameter>>, Garbled> {
        let mut list = Vec::new();
        while matches!(self.lexer.peek()?, Some(Token { kind: Kind::Text(_), .. })) {
            let Some(head) = self.lexer.next()? else { break };
            let Kind::Text(declaration) = &head.kind else { break };
            list.push(Rc::new(Parameter::read(self.lexer, &head, declaration)?));
        }
        Ok(list)
    }

    /// A name and parameters, as most directives have.
    fn named(&mut self, state: &State, target: Option<Target>) -> Result<(String, Parameters), Garbled> {
        let name = self.text()?;
        let label = format!("{} \"{}\"", self.name, shortened(&name));
        let list = self.parameters()?;
        let defaults = target.map_or(Vec::new(), |target| state.defaults(target));
        Ok((name, Parameters::new(list, defaults, self.source(), label)))
    }
}

/// The words of a directive mean nothing, nor do those behind them.
struct Garbled(Problem);

impl From<Problem> for Garbled {
    fn from(problem: Problem) -> Garbled {
        Garbled(problem)
    }
}

/// Why reading ends early; the problems were reported.
struct Stop;

impl Reading<'_> {
    /// Does what `text`, the content of `file`, says. `false` if it ended early.
    pub fn read_text(&mut self, text: &str, file: &Source) -> bool {
        self.read_nested(text, file, 0).is_ok()
    }

    fn read_nested(&mut self, text: &str, file: &Source, depth: u32) -> Result<(), Stop> {
        self.budget.earn(text.len());
        let mut lexer = Lexer::new(text, file);
        loop {
            let token = lexer.next();
            let (name, place) = match token {
                Ok(None) => return Ok(()),
                Ok(Some(Token { kind: Kind::Word(name), place })) => (name, place),
                Ok(Some(Token { place, .. })) => {
                    let problem = Problem::new("a directive is missing here").help("as Shape, Material, LightSource");
                    self.problems.push(problem.at(&place.source(file)));
                    return Err(Stop);
                }
                Err(problem) => {
                    self.problems.push(problem);
                    return Err(Stop);
                }
            };
            let directive = Directive { lexer: &mut lexer, name, place };
            self.read_directive(directive, depth)?;
            if self.problems.len() >= ENOUGH {
                let problem = Problem::new("there are more problems, which are left out").help("mend these first");
                self.problems.push(problem.at(file));
                return Err(Stop);
            }
        }
    }

    /// `Err` where the text cannot be understood from here on.
    fn read_directive(&mut self, mut d: Directive<'_, '_>, depth: u32) -> Result<(), Stop> {
        let ordered = self.check_order(&d);
        let done = match ordered {
            Ok(()) => self.dispatch(&mut d, depth),
            Err(problem) => Err(Trouble::Syntax(problem)),
        };
        match done {
            Ok(()) => Ok(()),
            Err(Trouble::Content(problems)) => {
                problems.0.into_iter().for_each(|problem| self.report(problem));
                Ok(())
            }
            Err(Trouble::Syntax(problem)) => {
                self.problems.push(problem);
                Err(Stop)
            }
            Err(Trouble::Stopped) => Err(Stop),
        }
    }

    fn check_order(&self, d: &Directive<'_, '_>) -> Result<(), Problem> {
        if self.in_world && BEFORE.contains(&d.name) {
            return Err(d.problem(format!("{} stands behind WorldBegin", d.name), "move it before WorldBegin"));
        }
        if !self.in_world && BEHIND.contains(&d.name) {
            return Err(d.problem(format!("{} stands before WorldBegin", d.name), "move it behind WorldBegin"));
        }
        Ok(())
    }

    fn dispatch(&mut self, d: &mut Directive<'_, '_>, depth: u32) -> Result<(), Trouble> {
        match d.name {
            "Identity" | "Translate" | "Scale" | "Rotate" | "LookAt" | "Transform" | "ConcatTransform"
            | "CoordinateSystem" | "CoordSysTransform" => self.transform(d),
            "AttributeBegin" => self.begin(Scope::Attribute, d),
            "AttributeEnd" => self.end(Scope::Attribute, d),
            "TransformBegin" => self.begin(Scope::Transform, d),
            "TransformEnd" => self.end(Scope::Transform, d),
            "ObjectBegin" => {
                let name = d.text()?;
                self.begin_object(name, d.source())?;
                self.begin(Scope::Object, d)
            }
            "ObjectEnd" => {
                self.end(Scope::Object, d)?;
                self.end_object();
                Ok(())
            }
            "ObjectInstance" => {
                let name = d.text()?;
                Ok(self.instance(&name, &d.source())?)
            }
            "ReverseOrientation" => {
                self.state.reversed = !self.state.reversed;
                Ok(())
            }
            "WorldBegin" => {
                self.in_world = true;
                self.state.matrix = DMat4::IDENTITY;
                self.systems.insert("world".to_owned(), DMat4::IDENTITY);
                Ok(())
            }
            "Attribute" => {
                let name = d.text()?;
                let more = d.parameters()?;
                let Some(target) = Target::from_name(&name) else {
                    let help = format!("there are {}", Target::NAMES.join(", "));
                    return Err(d.problem(format!("nothing has attributes of \"{}\"", shortened(&name)), help).into());
                };
                self.state.add_defaults(target, more);
                Ok(())
            }
            "Camera" | "Film" | "PixelFilter" | "Sampler" | "Integrator" | "Accelerator" | "Option" | "ColorSpace" => {
                self.option(d)
            }
            "Shape" | "LightSource" | "AreaLightSource" | "Material" | "MakeNamedMaterial" | "NamedMaterial"
            | "Texture" => self.content(d),
            "MakeNamedMedium" | "MediumInterface" | "ActiveTransform" | "TransformTimes" => self.refused(d),
            "Include" | "Import" => self.include(d, depth),
            other => {
                let help = match nearest(other, &DIRECTIVES) {
                    Some(near) => format!("did you mean {near}?"),
                    None => "a scene of pbrt-v4 consists of directives, as Shape or Material".to_owned(),
                };
                Err(Trouble::Syntax(d.problem(format!("there is no directive `{}`", shortened(other)), help)))
            }
        }
    }

    fn begin(&mut self, scope: Scope, d: &Directive<'_, '_>) -> Result<(), Trouble> {
        self.kept.keep(scope, &self.state, d.source());
        Ok(())
    }

    fn end(&mut self, scope: Scope, d: &Directive<'_, '_>) -> Result<(), Trouble> {
        Ok(self.kept.restore(scope, &mut self.state, &d.source())?)
    }

    fn transform(&mut self, d: &mut Directive<'_, '_>) -> Result<(), Trouble> {
        let current = self.state.matrix;
        let vector = DVec3::from_array;
        self.state.matrix = match d.name {
            "Identity" => DMat4::IDENTITY,
            "Translate" => current * DMat4::from_translation(vector(d.numbers()?)),
            "Scale" => current * DMat4::from_scale(vector(d.numbers()?)),
            "Rotate" => {
                let [degrees, x, y, z] = d.numbers()?;
                let rotation = placing::rotation(degrees, DVec3::new(x, y, z));
                current * rotation.ok_or_else(|| d.problem("the axis of Rotate has no length", "give a direction"))?
            }
            "LookAt" => {
                let [a, b, c, e, f, g, h, i, j] = d.numbers()?;
                let view = placing::look_at([DVec3::new(a, b, c), DVec3::new(e, f, g), DVec3::new(h, i, j)]);
                let help = "eye and target must differ, and up must not be parallel to the view";
                current * view.ok_or_else(|| d.problem("LookAt looks nowhere", help))?
            }
            "Transform" | "ConcatTransform" => {
                let matrix = placing::matrix(&d.numbers()?);
                let help = "its numbers are columns, of which the fourth number is 0, 0, 0 and 1";
                let matrix = matrix.ok_or_else(|| d.problem(format!("{} is no affine map", d.name), help))?;
                if d.name == "Transform" { matrix } else { current * matrix }
            }
            "CoordinateSystem" => {
                let name = d.text()?;
                self.systems.insert(name, current);
                current
            }
            _ => {
                let name = d.text()?;
                let known = self.systems.get(&name).copied();
                known.ok_or_else(|| {
                    let message = format!("there is no coordinate system \"{}\"", shortened(&name));
                    d.problem(message, "name it before by CoordinateSystem")
                })?
            }
        };
        Ok(())
    }

    /// What stands before `WorldBegin`.
    fn option(&mut self, d: &mut Directive<'_, '_>) -> Result<(), Trouble> {
        match d.name {
            "Option" => {
                // Of pbrt's own program.
                d.parameters()?;
                return Ok(());
            }
            "ColorSpace" => {
                let name = d.text()?;
                if name != "srgb" {
                    let message = format!("colours of the space \"{}\" cannot be rendered", shortened(&name));
                    return Err(unsupported(d.problem(message, "convert them to srgb")).into());
                }
                return Ok(());
            }
            _ => {}
        }
        let (name, ps) = d.named(&self.state, None)?;
        let done = match d.name {
            "Camera" => {
                self.systems.insert("camera".to_owned(), self.state.matrix.inverse());
                self.film.camera(&name, &ps, self.state.matrix, &mut self.ignored)
            }
            "Film" => self.film.film(&name, &ps, &mut self.ignored),
            "PixelFilter" => self.film.filter(&name, &ps, &mut self.ignored),
            "Sampler" => self.film.sampler(&name, &ps),
            "Integrator" => self.film.integrator(&name, &ps),
            _ => {
                ps.ignore_all();
                Ok(())
            }
        };
        self.settle(done, &ps)
    }

    /// What the scene consists of.
    fn content(&mut self, d: &mut Directive<'_, '_>) -> Result<(), Trouble> {
        match d.name {
            "Shape" => {
                let (kind, ps) = d.named(&self.state, Some(Target::Shape))?;
                let done = self.shape(&kind, &ps);
                self.settle_all(done, &ps)
            }
            "LightSource" => {
                let (kind, ps) = d.named(&self.state, Some(Target::Light))?;
                let to_world = self.film.to_ours() * self.state.matrix;
                let done = lights::describe(&kind, &ps, &to_world, self.folder);
                let done = done.map(|light| {
                    self.ignored.note_if(light.is_none(), "lights that are black");
                    self.lights.extend(light);
                });
                self.settle(done, &ps)
            }
            "AreaLightSource" => {
                let (kind, ps) = d.named(&self.state, Some(Target::Light))?;
                if kind != "diffuse" {
                    let message = format!("there is no area light \"{}\"", shortened(&kind));
                    return Err(ps.problem(message, "there is \"diffuse\"").into());
                }
                self.state.lamp = Some(Rc::new(ps));
                Ok(())
            }
            "Material" => {
                let (kind, parameters) = d.named(&self.state, Some(Target::Material))?;
                self.state.material = Chosen::Direct(Rc::new(Written { kind, parameters }));
                Ok(())
            }
            "NamedMaterial" => {
                let (name, place) = d.named(&self.state, None)?;
                self.state.material = Chosen::Named(name, Rc::new(place));
                Ok(())
            }
            "MakeNamedMaterial" => {
                let (name, parameters) = d.named(&self.state, Some(Target::Material))?;
                let kind = match parameters.text("type")? {
                    Some(kind) => kind.to_owned(),
                    None => return Err(parameters.problem("the material has no \"string type\"", "name it").into()),
                };
                Ok(self.materials.define(name, Written { kind, parameters })?)
            }
            _ => self.texture(d),
        }
    }

    fn texture(&mut self, d: &mut Directive<'_, '_>) -> Result<(), Trouble> {
        let (name, kind) = (d.text()?, d.text()?);
        let (class, ps) = d.named(&self.state, Some(Target::Texture))?;
        let kind = match kind.as_str() {
            "float" => Type::Float,
            "spectrum" => Type::Spectrum,
            other => {
                let message = format!("textures are not of the type \"{}\"", shortened(other));
                return Err(ps.problem(message, "they are of \"float\" or \"spectrum\"").into());
            }
        };
        let done = self.textures.define(name, kind, &class, &ps, &mut self.budget);
        self.settle(done, &ps)
    }

    /// What is understood and cannot be rendered.
    fn refused(&mut self, d: &mut Directive<'_, '_>) -> Result<(), Trouble> {
        let (what, help) = match d.name {
            "MakeNamedMedium" | "MediumInterface" => ("media cannot be rendered", "leave them out"),
            _ => (
                "transforms that change with time cannot be rendered",
                "leave them out, or use `motion` in a TOML scene",
            ),
        };
        match d.name {
            "MakeNamedMedium" => drop(d.named(&self.state, Some(Target::Medium))?),
            "ActiveTransform" => drop(d.word()?),
            "TransformTimes" => drop(d.numbers::<2>()?),
            _ => {
                let inside = d.text()?;
                let outside = d.optional_text()?.unwrap_or_default();
                // Vacuum on both sides.
                if inside.is_empty() && outside.is_empty() {
                    return Ok(());
                }
            }
        }
        Err(unsupported(d.problem(format!("{}: {what}", d.name), help)).into())
    }

    /// `Include` reads another file as if it stood here; what `Import` reads changes no state.
    fn include(&mut self, d: &mut Directive<'_, '_>, depth: u32) -> Result<(), Trouble> {
        let name = d.text()?;
        let path = self.folder.join(&name);
        if depth >= MAX_DEPTH {
            let message = format!("files within files go deeper than {MAX_DEPTH}");
            return Err(Trouble::Syntax(d.problem(message, "does one include itself?")));
        }
        let text = read_text(&path, MAX_FILE).map_err(|problem| problem.at_unless_placed(&d.source()))?;
        self.read_bytes = self.read_bytes.saturating_add(text.len());
        if self.read_bytes > MAX_TOTAL {
            let message = format!("the files together are longer than {} MiB", MAX_TOTAL >> 20);
            return Err(Trouble::Syntax(d.problem(message, "does one include itself?")));
        }
        let (state, kept) = (self.state.clone(), self.kept.depth());
        let read = self.read_nested(&text, &Source::file(&path), depth + 1);
        read.map_err(|Stop| Trouble::Stopped)?;
        if d.name == "Import" {
            let unended = self.kept.unended(kept);
            self.kept.truncate(kept);
            self.state = state;
            unended.map_or(Ok(()), Err)?;
        }
        Ok(())
    }

    /// Reports what failed, or parameters that nobody knows.
    fn settle(&mut self, done: Result<(), Problem>, ps: &Parameters) -> Result<(), Trouble> {
        self.settle_all(done.map_err(Problems::from), ps)
    }

    fn settle_all(&mut self, done: Result<(), Problems>, ps: &Parameters) -> Result<(), Trouble> {
        done?;
        self.problems.extend(ps.unknown());
        Ok(())
    }
}

/// What is wrong with a directive.
enum Trouble {
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
