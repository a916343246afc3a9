//! Photons as a PLY file that Blender and MeshLab open: binary, little-endian; one loose point for each photon and one
//! polygon for its footprint · metres, world frame.
//!
//! Vertices carry the receiver's normal, an 8-bit sRGB colour (flux over the brightest photon's) and the flux in W.

use std::path::Path;

use super::atomic;
use super::error::WriteError;
use super::png::srgb8;

/// One photon as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DumpedPhoton {
    pub position: [f32; 3],
    /// Unit normal of the receiver.
    pub normal: [f32; 3],
    /// W, linear Rec.709.
    pub flux: [f32; 3],
    /// Conjugate semi-axes of the footprint's ellipse: its rim is p + a cos t + b sin t.
    pub axes: [[f32; 3]; 2],
}

/// Vertices that PLY readers can index with the signed 32-bit integers that some of them use.
const MAX_VERTICES: usize = i32::MAX as usize;

/// Writes the photons with footprints of `segments` corners (at least 3), whole or not at all.
pub fn write(path: &Path, photons: &[DumpedPhoton], segments: usize) -> Result<(), WriteError> {
    let segments = segments.clamp(3, 255);
    let corners = 1 + segments;
    if photons.len() > MAX_VERTICES / corners {
        let reason = format!("{} photons need more than {MAX_VERTICES} vertices; write fewer", photons.len());
        return Err(WriteError::Unfit { path: path.to_owned(), reason });
    }
    let mut ply = header(photons.len(), segments).into_bytes();
    let brightest = photons.iter().flat_map(|p| p.flux).fold(f32::MIN_POSITIVE, f32::max);
    for photon in photons {
        let colour = photon.flux.map(|f| srgb8(f64::from(f / brightest)));
        put_vertex(&mut ply, photon.position, photon, colour);
        for k in 0..segments {
            let (sin, cos) = (std::f32::consts::TAU * k as f32 / segments as f32).sin_cos();
            let [a, b] = photon.axes;
            let rim = std::array::from_fn(|i| photon.position[i] + a[i] * cos + b[i] * sin);
            put_vertex(&mut ply, rim, photon, colour);
        }
    }
    for photon in 0..photons.len() {
        ply.push(segments as u8);
        let first = photon * corners + 1;
        (first..first + segments).for_each(|corner| ply.extend((corner as u32).to_le_bytes()));
    }
    atomic::write(path, &ply)
}

fn header(photons: usize, segments: usize) -> String {
    let floats =
        ["x", "y", "z", "nx", "ny", "nz", "flux_r", "flux_g", "flux_b"].map(|n| format!("property float {n}\n"));
    let colours = ["red", "green", "blue"].map(|n| format!("property uchar {n}\n"));
    format!(
        "ply\nformat binary_little_endian 1.0\ncomment photons and footprints of pdembree; metres, W\n\
         element vertex {}\n{}{}element face {photons}\nproperty list uchar uint vertex_indices\nend_header\n",
        photons * (1 + segments),
        floats.concat(),
        colours.concat()
    )
}

fn put_vertex(ply: &mut Vec<u8>, position: [f32; 3], photon: &DumpedPhoton, colour: [u8; 3]) {
    for value in [position, photon.normal, photon.flux].as_flattened() {
        ply.extend(value.to_le_bytes());
    }
    ply.extend(colour);
}
