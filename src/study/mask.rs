//! The pixels that a reference by light paths can hold: those through which the eye meets matt surfaces first.
//!
//! A light path cannot be connected to the eye over a mirror or through glass, so what a mirror shows of the caustic is
//! missing in its picture.

use crate::camera::Camera;
use crate::math::{Point2, Vec2};
use crate::render::BadCamera;
use crate::sampling::qmc;
use crate::world::World;

/// Rays through a pixel.
const RAYS: u64 = 64;

/// True for the pixels in which no ray meets a surface with a delta lobe first, row by row.
pub fn directly_seen(world: &World) -> Result<Vec<bool>, BadCamera> {
    let camera = Camera::new(&world.scene.camera).ok_or(BadCamera)?;
    let [width, height] = world.scene.camera.resolution;
    let matt = |x: u32, y: u32| {
        (0..RAYS).all(|i| {
            let [u, v] = qmc::golden_lattice(i, RAYS);
            let ray = camera.ray(Point2::new(f64::from(x) + u, f64::from(y) + v), Vec2::ZERO).ray;
            world.first_surface(&ray).is_none_or(|si| !world.bsdf_unfiltered(&si).has_delta())
        })
    };
    let row = |y| (0..width).map(move |x| matt(x, y));
    Ok((0..height).flat_map(row).collect())
}
