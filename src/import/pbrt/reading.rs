//! A scene as its directives add to it.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;

use glam::DMat4;

use super::budget::Budget;
use super::film::Film;
use super::lights;
use super::materials::{Chosen, Context, Materials, Surface, Written};
use super::media::{Interface, Media};
use super::parameters::{Parameters, shortened, unsupported};
use super::placing;
use super::shapes::Shapes;
use super::state::{Kept, State};
use super::textures::Textures;
use crate::import::ignored::Ignored;
use crate::import::imported::Imported;
use crate::scene::Caustics;
use crate::scene::TextureMemory;
use crate::scene::description::{
    Emission, LightDescription, ObjectDescription, Reference, ShapeDescription, TransformStep,
};
use crate::scene::error::{Problem, ProblemKind, Problems, Source};
use crate::scene::spelling::nearest;

/// A shape in the world, before it is known what its material is made of.
#[derive(Clone, Debug)]
struct Placed {
    label: String,
    source: Source,
    shape: ShapeDescription,
    to_world: DMat4,
    /// Whether it faces the other way; a mesh or disk was turned already.
    reversed: bool,
    material: Chosen,
    interface: Option<Rc<Interface>>,
    emission: Option<Emission>,
}

/// Everything that was read so far.
pub(super) struct Reading<'a> {
    pub folder: &'a Path,
    source: &'a Source,
    lenient: bool,
    pub problems: Vec<Problem>,
    warnings: Vec<Problem>,
    /// What was warned of.
    told: HashSet<String>,
    pub ignored: Ignored,
    pub budget: Budget,
    /// Of all files.
    pub read_bytes: usize,
    pub in_world: bool,
    pub state: State,
    pub kept: Kept,
    pub systems: HashMap<String, DMat4>,
    pub film: Film,
    pub textures: Textures<'a>,
    pub materials: Materials,
    pub media: Media,
    shapes: Shapes<'a>,
    placed: Vec<Placed>,
    pub lights: Vec<LightDescription>,
    /// Objects that instances show; the last is the one that is being defined.
    objects: HashMap<String, Vec<Placed>>,
    defining: Option<String>,
}

impl<'a> Reading<'a> {
    /// Names of files are those of files in `folder`, that of the scene file at `source`.
    pub fn new(folder: &'a Path, source: &'a Source, lenient: bool, memory: &'a TextureMemory) -> Reading<'a> {
        let parameters = Parameters::new(Vec::new(), Vec::new(), source.clone(), "the material".to_owned());
        let usual = Chosen::Direct(Rc::new(Written { kind: "diffuse".to_owned(), parameters }));
        Reading {
            folder,
            source,
            lenient,
            problems: Vec::new(),
            warnings: Vec::new(),
            told: HashSet::new(),
            ignored: Ignored::default(),
            budget: Budget::new(),
            read_bytes: 0,
            in_world: false,
            state: State::new(usual),
            kept: Kept::default(),
            systems: HashMap::from([("world".to_owned(), DMat4::IDENTITY)]),
            film: Film::new(source),
            textures: Textures::new(folder, memory),
            materials: Materials::new(),
            media: Media::default(),
            shapes: Shapes::new(folder),
            placed: Vec::new(),
            lights: Vec::new(),
            objects: HashMap::new(),
            defining: None,
        }
    }

    /// What cannot be rendered is an error, or with `lenient` a warning, once; what is wrong is an error.
    pub fn report(&mut self, problem: Problem) {
        if !self.lenient || problem.kind != ProblemKind::Unsupported {
            self.problems.push(problem);
        } else if self.told.insert(problem.message.clone()) {
            self.warnings.push(problem);
        }
    }

    /// `Shape "kind" …`.
    pub fn shape(&mut self, kind: &str, ps: &Parameters) -> Result<(), Problems> {
        let reversed = self.state.reversed;
        let shape = self.shapes.describe(kind, ps, reversed, &mut self.budget)?;
        if let Some(alpha) = ps.find("alpha")
            && alpha.number(&["float"]).ok() != Some(1.0)
        {
            self.report(ps.cannot("shapes with holes (`alpha`) cannot be rendered", "leave it out, or cut the mesh"));
        }
        let to_world = self.film.to_ours() * self.state.matrix;
        let lamp = self.state.lamp.clone();
        let emission = match &lamp {
            Some(_) if self.defining.is_some() => {
                self.ignored.note("area lights of objects that instances show");
                None
            }
            Some(lamp) => lights::emission(lamp, || self.shapes.area(&shape, &to_world, lamp), self.folder)?,
            None => None,
        };
        self.problems.extend(lamp.iter().flat_map(|lamp| lamp.unknown()));
        let turned = matches!(shape.description, ShapeDescription::Mesh { .. } | ShapeDescription::Disk { .. });
        if reversed && !turned && emission.as_ref().is_some_and(|e| !e.two_sided) {
            let message = format!("a {kind} that sends light inwards cannot be rendered");
            self.report(ps.cannot(message, "leave out ReverseOrientation, or make it a mesh"));
        }
        if reversed && self.state.interface.is_some() {
            let message = format!("a {kind} that is turned inside out cannot be the boundary of a medium");
            self.report(ps.cannot(message, "leave out ReverseOrientation"));
        }
        let placed = Placed {
            label: kind.to_owned(),
            source: ps.source.clone(),
            shape: shape.description,
            to_world,
            reversed: reversed && !turned,
            material: self.state.material.clone(),
            interface: self.state.interface.clone(),
            emission,
        };
        self.budget.spend(1, size_of::<Placed>() + size_of::<ObjectDescription>(), &ps.source)?;
        let defined = self.defining.as_ref().and_then(|name| self.objects.get_mut(name));
        defined.unwrap_or(&mut self.placed).push(placed);
        Ok(())
    }

    /// `ObjectBegin`.
    pub fn begin_object(&mut self, name: String, at: Source) -> Result<(), Problem> {
        if let Some(outer) = &self.defining {
            let message = format!("ObjectBegin stands within the object \"{}\"", shortened(outer));
            return Err(Problem::new(message).help("end that first").at(&at));
        }
        if self.objects.contains_key(&name) {
            let message = format!("there is another object \"{}\"", shortened(&name));
            return Err(Problem::new(message).help("names of objects must differ").at(&at));
        }
        self.objects.insert(name.clone(), Vec::new());
        self.defining = Some(name);
        Ok(())
    }

    /// `ObjectEnd`.
    pub fn end_object(&mut self) {
        self.defining = None;
    }

    /// `ObjectInstance`: the object's shapes, placed as they were when it was defined and then by the current matrix.
    pub fn instance(&mut self, name: &str, at: &Source) -> Result<(), Problem> {
        if self.defining.is_some() {
            let problem = Problem::new("ObjectInstance stands within an object");
            return Err(problem.help("end the object first").at(at));
        }
        let Some(shapes) = self.objects.get(name) else {
            let mut names: Vec<&str> = self.objects.keys().map(String::as_str).collect();
            names.sort_unstable();
            let help = match nearest(name, &names) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => "define it before by ObjectBegin".to_owned(),
            };
            return Err(Problem::new(format!("there is no object \"{}\"", shortened(name))).help(help).at(at));
        };
        self.budget.spend(shapes.len(), size_of::<Placed>() + size_of::<ObjectDescription>(), at)?;
        let ours = self.film.to_ours();
        // Ours of pbrt's instance of pbrt's world.
        let moved = ours * self.state.matrix * ours.inverse();
        let place = |shape: &Placed| Placed { to_world: moved * shape.to_world, source: at.clone(), ..shape.clone() };
        self.placed.extend(shapes.iter().map(place));
        Ok(())
    }

    /// The whole of it.
    pub fn finish(mut self) -> Result<Imported, Problems> {
        self.problems.extend(self.kept.unended(0));
        let placed = std::mem::take(&mut self.placed);
        let mut objects = Vec::with_capacity(placed.len());
        let mut numbers: HashMap<String, usize> = HashMap::new();
        for item in placed {
            let number = numbers.entry(item.label.clone()).or_default();
            *number += 1;
            let name = format!("{} {number}", item.label);
            objects.extend(self.object(item, name));
        }
        let (media, problems) = self.media.describe(&self.film.to_ours(), self.folder, &mut self.budget);
        problems.into_iter().for_each(|problem| self.report(problem));
        let help = "say `atmosphere` in a TOML scene that includes this";
        let around = |(name, source): (&str, &Source)| {
            let message = format!("the medium \"{}\" around shapes cannot be rendered: it fills none", shortened(name));
            unsupported(Problem::new(message).help(help).at(source))
        };
        let missing: Vec<Problem> = self.media.missing().into_iter().map(around).collect();
        missing.into_iter().for_each(|problem| self.report(problem));
        let camera = self.film.describe();
        let camera = camera.map_err(|problem| self.problems.push(problem)).ok();
        let (Some(camera), true) = (camera, self.problems.is_empty()) else {
            return Err(Problems(self.problems));
        };
        let is_lit = !self.lights.is_empty() || objects.iter().any(|o: &ObjectDescription| o.emission.is_some());
        self.warnings.extend(self.ignored.warning(self.source));
        Ok(Imported {
            source: self.source.clone(),
            has_camera: self.film.has_camera,
            camera,
            settings: self.film.settings,
            materials: self.materials.described,
            textures: self.textures.described,
            media,
            meshes: self.shapes.meshes,
            objects,
            lights: self.lights,
            is_lit,
            warnings: self.warnings,
        })
    }

    /// `None` where nothing is seen, or after a problem was reported.
    fn object(&mut self, item: Placed, name: String) -> Option<ObjectDescription> {
        let (mut problems, mut refused) = (Vec::new(), Vec::new());
        let mut context = Context {
            textures: &mut self.textures,
            folder: self.folder,
            ignored: &mut self.ignored,
            lenient: self.lenient,
            problems: &mut problems,
            refused: &mut refused,
        };
        let surface = self.materials.surface(&item.material, &mut context);
        self.problems.extend(problems);
        refused.into_iter().for_each(|problem| self.report(problem));
        let mut surface = surface?;
        let inside = self.media.inside(item.interface.as_ref());
        if let Some(inside) = inside.map_err(|problem| self.problems.push(problem)).ok()? {
            surface = self.materials.filled(&surface, &inside, &item.source);
        }
        let Surface::Material(mut material) = surface else { return None };
        if item.reversed {
            material = self.materials.inside_out(&material);
        }
        if self.materials.has_image(&material) {
            match item.shape {
                ShapeDescription::Mesh { mesh: Some(index) } => {
                    let done = self.shapes.texture(index, &mut self.budget);
                    done.map_err(|problem| self.problems.push(problem)).ok()?;
                }
                ShapeDescription::Disk { .. } => self.ignored.note("how pbrt lays images on disks (they lie flat)"),
                _ => {}
            }
        }
        let map = placing::transform_map(&item.to_world);
        Some(ObjectDescription {
            name,
            material: Reference { name: material, source: item.source.clone() },
            transform: vec![TransformStep { source: item.source.clone(), map }],
            source: item.source,
            shape: item.shape,
            motion: Vec::new(),
            emission: item.emission,
            caustics: Caustics::default(),
        })
    }
}
