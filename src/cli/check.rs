//! `pdembree check SCENE`

use std::process::ExitCode;

use pdembree::scene::{LightSource, ObjectGeometry, Scene};

use super::console::{Verbosity, print};
use super::failure::Failure;
use super::scene::SceneArgs;
use super::work::world;

/// Read and assemble a scene, and report everything that is wrong with it
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
}

pub fn run(args: &Args, verbosity: Verbosity) -> Result<ExitCode, Failure> {
    let loaded = args.scene.load(verbosity)?;
    let summary = summary(&loaded.scene);
    // What only the backend and the lights can find: geometry beyond f32, lights without area.
    world(loaded.scene)?;
    if !verbosity.quiet {
        print(&format!("{}: ok, {summary}\n", args.scene.scene.display()))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// What a scene holds, in one line.
pub fn summary(scene: &Scene) -> String {
    let triangles = triangles(scene);
    let area = scene.lights.iter().filter(|light| matches!(light, LightSource::Area { .. })).count();
    let [width, height] = scene.camera.resolution;
    format!(
        "{} objects, {triangles} triangles, {} materials, {} lights ({area} of area), {width} x {height} pixels",
        scene.objects.len(),
        scene.materials.len(),
        scene.lights.len()
    )
}

/// Triangles that rays can meet, those of instances each time.
pub fn triangles(scene: &Scene) -> usize {
    let of = |geometry: &ObjectGeometry| match geometry {
        ObjectGeometry::Mesh { mesh, .. } => scene.meshes[mesh.index()].triangles.len(),
        ObjectGeometry::Shape { .. } => 0,
    };
    scene.objects.iter().map(|object| of(&object.geometry)).sum()
}
