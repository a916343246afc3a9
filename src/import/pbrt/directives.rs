//! Reads directives one by one and does what they say.
//!
//! What is wrong with a directive is reported and the next one read, so that one reading finds every problem; a text whose
//! words make no directives ends it.

use glam::DMat4;

use super::directive::{Directive, Trouble};
use super::lexer::{Kind, Lexer, Token};
use super::parameters::shortened;
use super::reading::Reading;
use super::state::{Scope, Target};
use crate::import::read_text;
use crate::scene::error::{Problem, Source};
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
            "MakeNamedMedium" | "MediumInterface" => self.medium(d),
            "ActiveTransform" | "TransformTimes" => self.refused(d),
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
}
