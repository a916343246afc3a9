//! The lights of a scene, ready to emit.

use super::motion::LightMotion;
use super::select::Picks;
use super::{
    Aim, AreaLight, DirectionalLight, Emission, EnvironmentLight, Light, LightSample, PanoramaLight, PointLight,
    SceneSphere, SpotLight,
};
use crate::math::{Dir3, Normal3, Point3};
use crate::radiometry::{Intensity, Irradiance, Pdf, Radiance, SolidAngle};
use crate::scene::light::BeamExtent;
use crate::scene::{LightId, LightSource, ObjectGeometry, ObjectId, Scene};

/// A light of the scene that cannot emit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LightError {
    #[error("the emitting mesh of object \"{object}\" has no area; give it triangles that are not degenerate")]
    MeshWithoutArea { object: String },
    #[error(
        "object \"{object}\" is a {kind}, which cannot be a light; make it a mesh, a sphere, a disk, a rectangle, a cylinder \
         or a torus"
    )]
    ShapeCannotEmit { object: String, kind: &'static str },
    #[error("the cross-section of directional light {} has no area; its half axes must not be parallel", .light.0)]
    BeamWithoutArea { light: LightId },
    #[error("the image of environment light {} is black", .light.0)]
    BlackPanorama { light: LightId },
}

/// All lights of a scene, in the scene's order.
#[derive(Debug)]
pub struct Lights {
    lights: Vec<Box<dyn Light>>,
    /// Of those that move; empty if none does.
    motions: Vec<Option<LightMotion>>,
    /// What shadow rays choose from.
    pub(super) picks: Option<Picks>,
    environments: Vec<LightId>,
    scene: SceneSphere,
}

impl Lights {
    /// Builds every light; all that cannot emit are reported at once.
    pub fn new(scene: &Scene) -> Result<Lights, Vec<LightError>> {
        let sphere = bounding_sphere(scene);
        let (mut lights, mut errors) = (Vec::with_capacity(scene.lights.len()), Vec::new());
        for (i, source) in scene.lights.iter().enumerate() {
            match build(scene, LightId(i as u32), source, sphere) {
                Ok(light) => lights.push(light),
                Err(error) => errors.push(error),
            }
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        let powers: Vec<f64> = lights.iter().map(|light| light.power().0.luminance()).collect();
        let environments = (0..scene.lights.len())
            .filter(|&i| matches!(scene.lights[i], LightSource::Environment { .. } | LightSource::Panorama(_)))
            .map(|i| LightId(i as u32))
            .collect();
        let motions = motions(scene, sphere);
        let stands = |light: LightId| motions.get(light.index()).is_none_or(Option::is_none);
        let picks = Picks::new(&powers, |light| lights[light.index()].bounds().filter(|_| stands(light)));
        Ok(Lights { lights, motions, picks, environments, scene: sphere })
    }

    pub fn len(&self) -> usize {
        self.lights.len()
    }
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }
    /// The light of an id of the same scene; one that moves is where it is in the middle of the shutter's interval.
    pub fn get(&self, id: LightId) -> &dyn Light {
        self.lights[id.index()].as_ref()
    }
    fn motion(&self, id: LightId) -> Option<&LightMotion> {
        self.motions.get(id.index())?.as_ref()
    }
    /// [`Light::emit`] of a light at a time.
    pub fn emit(&self, id: LightId, u: [f64; 4], aim: &Aim, time: f64) -> Option<Emission> {
        match self.motion(id) {
            None => self.get(id).emit(u, aim),
            Some(motion) => motion.emit(self.get(id), u, aim, time),
        }
    }
    /// [`Light::sample_li`] of a light at a time.
    pub fn sample_li(&self, id: LightId, p: Point3, u: [f64; 2], time: f64) -> Option<LightSample> {
        match self.motion(id) {
            None => self.get(id).sample_li(p, u),
            Some(motion) => motion.sample_li(self.get(id), p, u, time),
        }
    }
    /// [`Light::pdf_li`] of a light at a time, which is met at `on_light`, a point and its outward geometric normal.
    pub fn pdf_li(&self, id: LightId, p: Point3, wi: Dir3, on_light: (Point3, Normal3), time: f64) -> Pdf<SolidAngle> {
        match self.motion(id) {
            None => self.get(id).pdf_li(p, wi, on_light.0, on_light.1),
            Some(motion) => motion.pdf_li(self.get(id), p, wi, on_light, time),
        }
    }
    pub fn iter(&self) -> impl Iterator<Item = (LightId, &dyn Light)> {
        self.lights.iter().enumerate().map(|(i, light)| (LightId(i as u32), light.as_ref()))
    }
    /// The sphere around the scene's objects that unbounded light is aimed at.
    pub fn scene_sphere(&self) -> SceneSphere {
        self.scene
    }

    /// What a ray that leaves the scene meets: all of them.
    pub fn environments(&self) -> impl Iterator<Item = (LightId, &dyn Light)> {
        self.environments.iter().map(|&id| (id, self.get(id)))
    }
}

/// How the scene's lights move, by their number; nothing if none does.
fn motions(scene: &Scene, sphere: SceneSphere) -> Vec<Option<LightMotion>> {
    let of = |(i, source): (usize, &LightSource)| {
        let motion = match source {
            LightSource::Area { object, .. } => scene.objects[object.index()].motion.clone(),
            _ => scene.light_motions.get(i).cloned().flatten(),
        };
        let unbounded = matches!(source, LightSource::Directional { extent: BeamExtent::Unbounded, .. });
        motion.map(|motion| LightMotion::new(motion, scene.shutter.middle(), unbounded.then_some(sphere)))
    };
    let motions: Vec<Option<LightMotion>> = scene.lights.iter().enumerate().map(of).collect();
    if motions.iter().all(Option::is_none) { Vec::new() } else { motions }
}

/// The sphere around the scene's objects; of radius zero if there are none.
fn bounding_sphere(scene: &Scene) -> SceneSphere {
    if scene.bounds.is_empty() {
        return SceneSphere { centre: crate::math::Point3::ORIGIN, radius: 0.0 };
    }
    let (centre, radius) = scene.bounds.bounding_sphere();
    SceneSphere { centre, radius }
}

fn build(scene: &Scene, id: LightId, source: &LightSource, sphere: SceneSphere) -> Result<Box<dyn Light>, LightError> {
    Ok(match source {
        LightSource::Point { position, intensity } => {
            Box::new(PointLight { position: *position, intensity: Intensity(*intensity) })
        }
        LightSource::Spot { position, direction, intensity, cos_inner, cos_outer } => {
            Box::new(SpotLight::new(*position, *direction, Intensity(*intensity), *cos_inner, *cos_outer))
        }
        LightSource::Directional { direction, irradiance, extent } => {
            let beam = DirectionalLight::new(*direction, Irradiance(*irradiance), extent, sphere);
            Box::new(beam.ok_or(LightError::BeamWithoutArea { light: id })?)
        }
        LightSource::Area { object, radiance, two_sided } => {
            Box::new(build_area(scene, *object, Radiance(*radiance), *two_sided)?)
        }
        LightSource::Environment { radiance } => {
            Box::new(EnvironmentLight { radiance: Radiance(*radiance), scene: sphere })
        }
        LightSource::Panorama(panorama) => {
            let light = PanoramaLight::new(panorama.as_ref().clone(), sphere);
            Box::new(light.ok_or(LightError::BlackPanorama { light: id })?)
        }
    })
}

fn build_area(scene: &Scene, object: ObjectId, radiance: Radiance, two_sided: bool) -> Result<AreaLight, LightError> {
    let object = &scene.objects[object.index()];
    match &object.geometry {
        ObjectGeometry::Mesh { mesh, to_world } => {
            AreaLight::from_mesh(&scene.meshes[mesh.index()], to_world, radiance, two_sided)
                .ok_or_else(|| LightError::MeshWithoutArea { object: object.name.clone() })
        }
        ObjectGeometry::Shape { shape, to_world } => AreaLight::from_shape(shape, to_world, radiance, two_sided)
            .ok_or_else(|| LightError::ShapeCannotEmit { object: object.name.clone(), kind: shape.kind() }),
    }
}
