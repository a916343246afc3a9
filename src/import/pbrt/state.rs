//! The graphics state: what directives set for the shapes and lights behind them, kept and restored by pairs of directives.

use std::rc::Rc;

use glam::DMat4;

use super::materials::Chosen;
use super::media::Interface;
use super::parameters::{Parameter, Parameters};
use crate::scene::error::{Problem, Source};

/// What `Attribute` sets parameters of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    Shape,
    Light,
    Material,
    Medium,
    Texture,
}

impl Target {
    pub const NAMES: [&'static str; 5] = ["shape", "light", "material", "medium", "texture"];

    pub fn from_name(name: &str) -> Option<Target> {
        const ALL: [Target; 5] = [Target::Shape, Target::Light, Target::Material, Target::Medium, Target::Texture];
        Target::NAMES.iter().position(|n| *n == name).map(|i| ALL[i])
    }
}

/// Cheap to copy, since every `AttributeBegin` does.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// World from object.
    pub matrix: DMat4,
    pub reversed: bool,
    pub material: Chosen,
    /// `AreaLightSource`.
    pub lamp: Option<Rc<Parameters>>,
    /// `MediumInterface`, where it names a medium.
    pub interface: Option<Rc<Interface>>,
    /// One list for each target.
    defaults: Rc<[Vec<Rc<Parameter>>; 5]>,
}

impl State {
    pub fn new(material: Chosen) -> State {
        State {
            matrix: DMat4::IDENTITY,
            reversed: false,
            material,
            lamp: None,
            interface: None,
            defaults: Rc::default(),
        }
    }
    pub fn defaults(&self, target: Target) -> Vec<Rc<Parameter>> {
        self.defaults[target as usize].clone()
    }
    pub fn add_defaults(&mut self, target: Target, more: Vec<Rc<Parameter>>) {
        Rc::make_mut(&mut self.defaults)[target as usize].extend(more);
    }
}

/// What a state was kept for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scope {
    Attribute,
    Transform,
    Object,
}

impl Scope {
    fn begin(self) -> &'static str {
        match self {
            Scope::Attribute => "AttributeBegin",
            Scope::Transform => "TransformBegin",
            Scope::Object => "ObjectBegin",
        }
    }
    fn end(self) -> &'static str {
        match self {
            Scope::Attribute => "AttributeEnd",
            Scope::Transform => "TransformEnd",
            Scope::Object => "ObjectEnd",
        }
    }
}

/// States that will be restored.
#[derive(Debug, Default)]
pub(super) struct Kept(Vec<(Scope, State, Source)>);

impl Kept {
    pub fn keep(&mut self, scope: Scope, state: &State, at: Source) {
        self.0.push((scope, state.clone(), at));
    }

    /// Ends `scope`, which the directive at `at` says.
    pub fn restore(&mut self, scope: Scope, state: &mut State, at: &Source) -> Result<(), Problem> {
        match self.0.pop() {
            Some((began, kept, _)) if began == scope => {
                if scope == Scope::Transform {
                    state.matrix = kept.matrix;
                } else {
                    *state = kept;
                }
                Ok(())
            }
            Some((began, kept, place)) => {
                let message = format!("{} ends what {} at {place} began", scope.end(), began.begin());
                self.0.push((began, kept, place));
                Err(Problem::new(message).help(format!("write {} first", began.end())).at(at))
            }
            None => {
                let problem = Problem::new(format!("{} ends what nothing began", scope.end()));
                Err(problem.help(format!("write {} before it, or remove it", scope.begin())).at(at))
            }
        }
    }

    /// Where `Import` begins, so that what it reads ends what it began.
    pub fn depth(&self) -> usize {
        self.0.len()
    }

    /// What was begun behind `depth` and never ended.
    pub fn unended(&self, depth: usize) -> Option<Problem> {
        let (scope, _, place) = self.0.get(depth)?;
        Some(Problem::new(format!("{} has no {}", scope.begin(), scope.end())).help("add it").at(place))
    }

    pub fn truncate(&mut self, depth: usize) {
        self.0.truncate(depth);
    }
}
