//! What single directives do to the scene that is being read.

use std::rc::Rc;

use glam::{DMat4, DVec3};

use super::directive::{Directive, Trouble};
use super::lights;
use super::materials::{Chosen, Written};
use super::media::Interface;
use super::parameters::{Parameters, shortened, unsupported};
use super::placing;
use super::reading::Reading;
use super::state::Target;
use super::textures::Type;
use crate::scene::error::{Problem, Problems};

impl Reading<'_> {
    pub fn transform(&mut self, d: &mut Directive<'_, '_>) -> Result<(), Trouble> {
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
    pub fn option(&mut self, d: &mut Directive<'_, '_>) -> Result<(), Trouble> {
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
                if self.state.interface.as_ref().is_some_and(|interface| !interface.outside.is_empty()) {
                    let help = "leave its MediumInterface out, or say `atmosphere` in a TOML scene that includes this";
                    self.report(ps.cannot("a medium around the camera cannot be rendered", help));
                }
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
    pub fn content(&mut self, d: &mut Directive<'_, '_>) -> Result<(), Trouble> {
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

    /// What fills shapes.
    pub fn medium(&mut self, d: &mut Directive<'_, '_>) -> Result<(), Trouble> {
        if d.name == "MakeNamedMedium" {
            let (name, ps) = d.named(&self.state, Some(Target::Medium))?;
            return Ok(self.media.define(name, ps, self.state.matrix)?);
        }
        let inside = d.text()?;
        let outside = d.optional_text()?.unwrap_or_else(|| inside.clone());
        let is_vacuum = inside.is_empty() && outside.is_empty();
        let source = d.source();
        self.state.interface = (!is_vacuum).then(|| Rc::new(Interface { inside, outside, source }));
        Ok(())
    }

    /// What is understood and cannot be rendered.
    pub fn refused(&mut self, d: &mut Directive<'_, '_>) -> Result<(), Trouble> {
        match d.name {
            "ActiveTransform" => drop(d.word()?),
            _ => drop(d.numbers::<2>()?),
        }
        let message = format!("{}: transforms that change with time cannot be rendered", d.name);
        Err(unsupported(d.problem(message, "leave them out, or use `motion` in a TOML scene")).into())
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
