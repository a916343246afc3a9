//! Shapes: spheres, cylinders and disks as exact ones where they are whole, everything else as meshes · object space.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

use glam::{DMat4, DVec3};

use super::budget::Budget;
use super::meshes;
use super::parameters::{Parameters, shortened};
use crate::import::mesh_file::MeshFile;
use crate::import::ply;
use crate::scene::description::{MeshDescription, ShapeDescription};
use crate::scene::error::{Problem, Problems};
use crate::scene::mesh::TriangleMesh;

/// Cells of a part of a sphere from pole to pole.
const MERIDIAN_CELLS: f64 = 64.0;

/// A shape and what lamps need to know of it.
#[derive(Debug)]
pub(super) struct Shape {
    pub description: ShapeDescription,
    /// m² in object space, of shapes that are whole.
    pub area: Option<f64>,
}

/// The meshes of a file.
pub(super) struct Shapes<'a> {
    folder: &'a Path,
    pub meshes: Vec<MeshDescription>,
    /// By the file and whether it is turned inside out.
    files: HashMap<(PathBuf, bool), usize>,
}

impl<'a> Shapes<'a> {
    pub fn new(folder: &'a Path) -> Shapes<'a> {
        Shapes { folder, meshes: Vec::new(), files: HashMap::new() }
    }

    /// `Shape "kind" …`. `reversed` meshes and disks face the other way.
    pub fn describe(
        &mut self,
        kind: &str,
        ps: &Parameters,
        reversed: bool,
        budget: &mut Budget,
    ) -> Result<Shape, Problems> {
        let mesh = match kind {
            "sphere" => return self.sphere(ps, reversed, budget).map_err(Problems::from),
            "cylinder" => return self.cylinder(ps, reversed, budget).map_err(Problems::from),
            "disk" => return self.disk(ps, reversed, budget).map_err(Problems::from),
            "plymesh" => return self.ply(ps, reversed, budget),
            "trianglemesh" => meshes::triangles(ps, budget)?,
            "bilinearmesh" => meshes::bilinear(ps, budget)?,
            "loopsubdiv" => meshes::subdivided(ps, budget)?,
            "curve" => {
                return Err(ps.cannot("the shape \"curve\" cannot be rendered", "export it as a mesh").into());
            }
            other => {
                const KINDS: &str = "sphere, cylinder, disk, trianglemesh, plymesh, bilinearmesh and loopsubdiv can";
                let message = format!("the shape \"{}\" cannot be rendered", shortened(other));
                return Err(ps.cannot(message, KINDS).into());
            }
        };
        Ok(self.keep(mesh, ps, reversed)?)
    }

    fn keep(&mut self, mut mesh: TriangleMesh, ps: &Parameters, reversed: bool) -> Result<Shape, Problem> {
        meshes::check_finite(&mesh, ps)?;
        if reversed {
            meshes::reverse(&mut mesh);
        }
        self.meshes.push(MeshDescription { source: ps.source.clone(), mesh, triangle_lines: Vec::new() });
        let description = ShapeDescription::Mesh { mesh: Some(self.meshes.len() - 1) };
        Ok(Shape { description, area: None })
    }

    fn ply(&mut self, ps: &Parameters, reversed: bool, budget: &mut Budget) -> Result<Shape, Problems> {
        let Some(name) = ps.text("filename")? else {
            return Err(ps.problem("a plymesh needs \"string filename\"", "name the file").into());
        };
        let path = self.folder.join(name);
        if ps.has("displacement") {
            return Err(ps.cannot("displaced meshes cannot be rendered", "bake the displacement into it").into());
        }
        let key = (path, reversed);
        if let Some(known) = self.files.get(&key) {
            return Ok(Shape { description: ShapeDescription::Mesh { mesh: Some(*known) }, area: None });
        }
        let placed = |all: Problems| Problems(all.0.into_iter().map(|p| p.at_unless_placed(&ps.source)).collect());
        let MeshFile { source, mut mesh, triangle_lines, .. } = ply::read(&key.0, true).map_err(placed)?;
        budget.earn(mesh.positions.len() * size_of::<[f32; 3]>());
        meshes::face_normals(&mut mesh);
        if reversed {
            meshes::reverse(&mut mesh);
        }
        self.meshes.push(MeshDescription { source, mesh, triangle_lines });
        let index = self.meshes.len() - 1;
        self.files.insert(key, index);
        Ok(Shape { description: ShapeDescription::Mesh { mesh: Some(index) }, area: None })
    }

    fn sphere(&mut self, ps: &Parameters, reversed: bool, budget: &mut Budget) -> Result<Shape, Problem> {
        let radius = ps.positive("radius", 1.0)?;
        let cut = |z: f64| z.clamp(-radius, radius);
        let (low, high) = ordered(cut(ps.number("zmin", -radius)?), cut(ps.number("zmax", radius)?), ps)?;
        let turn = turn(ps)?;
        if low == -radius && high == radius && turn == TAU {
            let description = ShapeDescription::Sphere { centre: [0.0; 3], radius };
            return Ok(Shape { description, area: Some(4.0 * PI * radius * radius) });
        }
        let [south, north] = [low, high].map(|z| (z / radius).clamp(-1.0, 1.0).acos());
        let rows = (MERIDIAN_CELLS * (south - north) / PI).ceil().max(1.0) as u32;
        let at = |[cos, sin]: [f64; 2], v: f64| {
            let theta = south + (north - south) * v;
            let around = if theta.cos().abs() < 1.0 { theta.sin() } else { 0.0 };
            let n = DVec3::new(around * cos, around * sin, theta.cos());
            (radius * n, n)
        };
        let mesh = meshes::round(turn, rows, at, budget, ps)?;
        self.keep(mesh, ps, reversed)
    }

    fn cylinder(&mut self, ps: &Parameters, reversed: bool, budget: &mut Budget) -> Result<Shape, Problem> {
        let radius = ps.positive("radius", 1.0)?;
        let (low, high) = ordered(ps.number("zmin", -1.0)?, ps.number("zmax", 1.0)?, ps)?;
        let turn = turn(ps)?;
        if turn == TAU {
            let (base, top) = ([0.0, 0.0, low], [0.0, 0.0, high]);
            let description = ShapeDescription::Cylinder { base, top, radius };
            return Ok(Shape { description, area: Some(TAU * radius * (high - low)) });
        }
        let at = |[cos, sin]: [f64; 2], v: f64| {
            let n = DVec3::new(cos, sin, 0.0);
            (radius * n + DVec3::Z * (low + (high - low) * v), n)
        };
        let mesh = meshes::round(turn, 1, at, budget, ps)?;
        self.keep(mesh, ps, reversed)
    }

    fn disk(&mut self, ps: &Parameters, reversed: bool, budget: &mut Budget) -> Result<Shape, Problem> {
        let (radius, inner) = (ps.positive("radius", 1.0)?, ps.number("innerradius", 0.0)?);
        let (height, turn) = (ps.number("height", 0.0)?, turn(ps)?);
        if !(0.0..radius).contains(&inner) {
            return Err(ps.problem(format!("`innerradius` is {inner}"), "it must be from 0 to below the radius"));
        }
        if inner == 0.0 && turn == TAU {
            let normal = [0.0, 0.0, if reversed { -1.0 } else { 1.0 }];
            let description = ShapeDescription::Disk { centre: [0.0, 0.0, height], normal, radius };
            return Ok(Shape { description, area: Some(PI * radius * radius) });
        }
        // v runs inwards.
        let at = |[cos, sin]: [f64; 2], v: f64| {
            let r = radius + (inner - radius) * v;
            (DVec3::new(r * cos, r * sin, height), DVec3::Z)
        };
        let mut mesh = meshes::round(turn, 1, at, budget, ps)?;
        // u × v is −z there.
        meshes::face_normals(&mut mesh);
        self.keep(mesh, ps, reversed)
    }

    /// Gives the mesh texture coordinates if it has none.
    pub fn texture(&mut self, index: usize, budget: &mut Budget) -> Result<(), Problem> {
        let described = &mut self.meshes[index];
        if described.mesh.uvs.is_empty() && !described.mesh.triangles.is_empty() {
            budget.spend(meshes::size_with_texture_coordinates(&described.mesh), 1, &described.source)?;
            described.mesh = meshes::with_texture_coordinates(&described.mesh);
        }
        Ok(())
    }

    /// m² of each of pbrt's own shapes, which a mesh's triangles are.
    pub fn area(&self, shape: &Shape, to_world: &DMat4, lamp: &Parameters) -> Result<f64, Problem> {
        let found = match shape.description {
            ShapeDescription::Mesh { mesh: Some(index) } => meshes::common_area(&self.meshes[index].mesh, to_world),
            _ => shape.area,
        };
        found.ok_or_else(|| {
            let message = "pbrt gives each triangle the whole `power`, which triangles of different sizes cannot show";
            lamp.problem(message, "give the radiance `L` instead")
        })
    }
}

fn ordered(low: f64, high: f64, ps: &Parameters) -> Result<(f64, f64), Problem> {
    if low == high {
        return Err(ps.problem("`zmin` and `zmax` are the same", "they must differ"));
    }
    Ok((low.min(high), low.max(high)))
}

/// `phimax` in radians.
fn turn(ps: &Parameters) -> Result<f64, Problem> {
    let degrees = ps.positive("phimax", 360.0)?.min(360.0);
    Ok(if degrees == 360.0 { TAU } else { degrees.to_radians() })
}
