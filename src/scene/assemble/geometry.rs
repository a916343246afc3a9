//! Objects' geometry: transforms that can be inverted, shapes that exist, meshes that are sound.

use std::sync::Arc;

use super::Report;
use super::materials::Materials;
use super::meshes::{Topology, make_sound};
use super::motion::moving;
use crate::math::{Bounds3, Dir3, Motion, Point3, Transform, Vec2, Vec3};
use crate::scene::camera::Shutter;
use crate::scene::description::{
    ObjectDescription, SceneDescription, ShapeDescription, TransformMap, TransformStep, WaveDescription,
};
use crate::scene::error::{Problem, Source};
use crate::scene::ids::MeshId;
use crate::scene::material::Material;
use crate::scene::mesh::TriangleMesh;
use crate::scene::object::ObjectGeometry;
use crate::shape::{Cylinder, Disk, HeightField, Rectangle, Shape, ShapeError, Sphere, Torus, Wave};

/// A map whose columns span less than this share of the box of their lengths is singular for our purposes.
const SINGULAR: f64 = 1e-12;

pub(super) struct Geometry {
    pub meshes: Vec<TriangleMesh>,
    /// One for each object of the description, `None` where it is broken.
    pub placed: Vec<Option<Placed>>,
    /// Around each mesh, its own space.
    pub mesh_bounds: Vec<Bounds3>,
}

/// An object's geometry and how it moves.
#[derive(Clone)]
pub(super) struct Placed {
    pub geometry: ObjectGeometry,
    pub motion: Option<Arc<Motion>>,
}

impl Geometry {
    /// Takes the meshes out of the description.
    pub fn assemble(
        description: &mut SceneDescription,
        shutter: Shutter,
        materials: &Materials,
        report: &mut Report,
    ) -> Geometry {
        let sound: Vec<bool> = description.meshes.iter_mut().map(|mesh| make_sound(mesh, shutter, report)).collect();
        warn_about_glass(description, &sound, materials, report);
        let meshes: Vec<TriangleMesh> = description.meshes.iter_mut().map(|m| std::mem::take(&mut m.mesh)).collect();
        let place = |object: &ObjectDescription| place(object, shutter, &sound, report);
        let placed = description.objects.iter().map(place).collect();
        let mesh_bounds = meshes.iter().map(TriangleMesh::swept_bounds).collect();
        Geometry { meshes, mesh_bounds, placed }
    }
}

fn place(object: &ObjectDescription, shutter: Shutter, sound: &[bool], report: &mut Report) -> Option<Placed> {
    let to_world = transform(&object.name, &object.transform, &object.source, report);
    let moving = to_world.and_then(|placed| moving(object, placed, shutter, report));
    let (to_world, motion) = moving.map_or((None, None), |(to_world, motion)| (Some(to_world), motion));
    let geometry = match object.shape {
        ShapeDescription::Mesh { mesh } => {
            let mesh = mesh.filter(|&i| sound.get(i).copied().unwrap_or(false))?;
            ObjectGeometry::Mesh { mesh: MeshId(mesh as u32), to_world: to_world? }
        }
        _ => {
            let shape = match shape(&object.shape) {
                Ok(shape) => shape?,
                Err(error) => {
                    let problem = Problem::new(format!("`{}` is no shape: {error}", object.name));
                    report.problem(problem.at(&object.source));
                    return None;
                }
            };
            ObjectGeometry::Shape { shape: at_shutter(shape, shutter), to_world: to_world? }
        }
    };
    Some(Placed { geometry, motion })
}

/// The shape as an instant sees it.
fn at_shutter(shape: Shape, shutter: Shutter) -> Shape {
    match shape {
        Shape::HeightField(field) if shutter.is_instant() && field.travels() => {
            Shape::HeightField(field.frozen(shutter.open))
        }
        shape => shape,
    }
}

/// The exact shape; `Ok(None)` for a mesh.
fn shape(described: &ShapeDescription) -> Result<Option<Shape>, ShapeError> {
    let shape = match described {
        ShapeDescription::Sphere { centre, radius } => Shape::Sphere(Sphere::new(Point3::from(*centre), *radius)?),
        ShapeDescription::Cylinder { base, top, radius } => {
            Shape::Cylinder(Cylinder::new(Point3::from(*base), Point3::from(*top), *radius)?)
        }
        ShapeDescription::Torus { centre, axis, major_radius, minor_radius } => {
            Shape::Torus(Torus::new(Point3::from(*centre), Vec3::from(*axis), *major_radius, *minor_radius)?)
        }
        ShapeDescription::Disk { centre, normal, radius } => {
            Shape::Disk(Disk::new(Point3::from(*centre), Vec3::from(*normal), *radius)?)
        }
        ShapeDescription::Rectangle { centre, a, b } => {
            Shape::Rectangle(Rectangle::new(Point3::from(*centre), Vec3::from(*a), Vec3::from(*b))?)
        }
        ShapeDescription::HeightField { centre, half_size, up, x_axis, waves } => {
            let wave = |w: &WaveDescription| Wave {
                amplitude: w.amplitude,
                wave_vector: Vec2::from(w.wave_vector),
                phase: w.phase,
                rate: -w.speed * Vec2::from(w.wave_vector).length(),
            };
            let (x_axis, up) = (Vec3::from(*x_axis), Vec3::from(*up));
            let waves = waves.iter().map(wave).collect();
            Shape::HeightField(HeightField::new(Point3::from(*centre), x_axis, up, Vec2::from(*half_size), waves)?)
        }
        ShapeDescription::Mesh { .. } => return Ok(None),
    };
    Ok(Some(shape))
}

/// The product of steps that the object `name` goes through, or `None` after reporting one that cannot be inverted.
pub(super) fn transform(
    name: &str,
    steps: &[TransformStep],
    source: &Source,
    report: &mut Report,
) -> Option<Transform> {
    let mut product = Some(Transform::IDENTITY);
    for step in steps {
        let map = step_transform(step).filter(is_regular);
        if map.is_none() {
            let message = format!("the transform of `{name}` is singular: it flattens the object");
            let help = "scales must differ from 0, an axis must have a length, a matrix needs independent columns";
            report.problem(Problem::new(message).help(help).at(&step.source));
        }
        product = product.zip(map).map(|(outer, inner)| outer.compose(&inner));
    }
    if product.is_some_and(|p| !is_regular(&p)) {
        let message = format!("the product of the transforms of `{name}` is not finite or singular");
        report.problem(Problem::new(message).help("check the scales").at(source));
        return None;
    }
    product
}

fn step_transform(step: &TransformStep) -> Option<Transform> {
    match step.map {
        TransformMap::Translate(t) => Transform::new([Vec3::X, Vec3::Y, Vec3::Z], Vec3::from(t)),
        TransformMap::Rotate { axis, degrees } => {
            let axis = Dir3::new(Vec3::from(axis))?;
            degrees.is_finite().then(|| Transform::rotate(axis, degrees.to_radians()))
        }
        TransformMap::Scale(s) => Transform::scale(Vec3::from(s)),
        TransformMap::Matrix(rows) => {
            let column = |c: usize| Vec3::new(rows[0][c], rows[1][c], rows[2][c]);
            Transform::new([column(0), column(1), column(2)], column(3))
        }
    }
}

fn is_regular(t: &Transform) -> bool {
    let [a, b, c] = t.columns();
    let volume = a.cross(b).dot(c).abs();
    let product = a.length() * b.length() * c.length();
    t.translation().is_finite() && product.is_finite() && product > 0.0 && volume > SINGULAR * product
}

/// Glass whose mesh is not the boundary of a solid bends light wrongly, which is hard to see in a picture.
fn warn_about_glass(description: &SceneDescription, sound: &[bool], materials: &Materials, report: &mut Report) {
    let mut checked = vec![false; sound.len()];
    for object in &description.objects {
        let material = materials.lookup(&object.material.name);
        let glass = material.is_some_and(Material::has_inside);
        let ShapeDescription::Mesh { mesh: Some(mesh) } = object.shape else { continue };
        if !glass || !sound.get(mesh).copied().unwrap_or(false) || std::mem::replace(&mut checked[mesh], true) {
            continue;
        }
        let described = &description.meshes[mesh];
        let topology = Topology::of(&described.mesh);
        let mut warn = |what: String, prim: usize, help: &str| {
            let warning = Problem::new(format!("the dielectric `{}` {what}", object.name));
            report.warning(warning.help(help).at(&described.triangle_source(prim)));
        };
        let edges = |n: usize| if n == 1 { "1 edge".to_owned() } else { format!("{n} edges") };
        if let Some((count, prim)) = topology.open_edges {
            let help = "light that enters there never leaves; close the mesh";
            warn(format!("is not closed: {} with one triangle only", edges(count)), prim, help);
        }
        if let Some((count, prim)) = topology.crowded_edges {
            warn(format!("is no surface: {} with more than two triangles", edges(count)), prim, "remove inner faces");
        }
        if let Some((count, prim)) = topology.flipped_edges {
            let help = "inside and outside differ there; make the windings agree";
            warn(format!("has {} whose triangles face opposite ways", edges(count)), prim, help);
        }
        if topology.is_closed() && described.mesh.signed_volume() < 0.0 {
            let help = "triangles must run counter-clockwise seen from outside; reverse them or swap ior and exterior";
            warn("is inside out: its triangles face inwards".to_owned(), 0, help);
        }
    }
}
