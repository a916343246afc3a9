//! Where a surface ends at another one: the part of a footprint that would lie behind a wall is mirrored back at it.
//!
//! A footprint is flat and knows no walls. What it spreads behind one lights nothing, and every corner of a room would lose
//! up to half of its light. The photon's mirror image behind the wall brings back just that part: an even light stays even
//! to the edge, and no flux is lost (the reflection method of density estimates, `[Silverman86 2.10]`). Walls are found by
//! rays through the air just over the footprint; a wall that stops only some of them mirrors as large a part.

use super::footprint::TangentForm;
use super::record::{MIN_NORMAL_COSINE, Photon};
use crate::math::{Dir3, Frame, Point3, Ray, Vec3};
use crate::world::World;

/// Rays over a footprint, evenly around its ellipse: what reaches a wall between two of them is within the last seventh of
/// its radius, where kernels are about zero.
const PROBES: usize = 6;
/// A wall reaches down to that part of the height up to which things count as the surface.
const LOW: f64 = 1.0 / 16.0;
/// Walls that are mirrored at, at most: those of a room.
const MAX_WALLS: usize = 4;
/// Images at most; a footprint as wide as its room has some twenty.
const MAX_IMAGES: usize = 32;
/// Images nearer to each other than this part of the footprint's radius are the same one.
const SAME_PLACE: f64 = 1e-4;

/// A plane that cuts a footprint, in its tangent plane.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wall {
    /// Unit tangent vector away from the wall.
    away: Vec3,
    /// A point of the line in which the wall meets the tangent plane.
    foot: Point3,
    /// Which part of what lies behind it is cut off.
    share: f64,
}

/// The images of a photon behind the walls that cut its footprint at `time`.
pub fn images(world: &World, photon: &Photon, time: f64) -> Vec<Photon> {
    let frame = photon.frame();
    let walls = walls(world, photon, time, &frame);
    let mut all: Vec<Photon> = Vec::new();
    // Two walls have images of images: some of them in either order, which are the same where the walls are at right angles.
    let (mut next, nearby) = (0, SAME_PLACE * photon.form().trace().sqrt());
    while next <= all.len() && all.len() < MAX_IMAGES {
        let original = if next == 0 { *photon } else { all[next - 1] };
        for image in walls.iter().flatten().filter_map(|wall| mirrored(&original, wall, &frame)) {
            let known = |other: &Photon| other.position().distance(image.position()) < nearby;
            if !known(photon) && !all.iter().any(known) {
                all.push(image);
            }
        }
        next += 1;
    }
    all
}

/// `photon` behind `wall`, if its footprint reaches over it.
fn mirrored(photon: &Photon, wall: &Wall, frame: &Frame) -> Option<Photon> {
    let form = photon.form();
    let away = frame.project(wall.away);
    let distance = (photon.position() - wall.foot).dot(wall.away);
    let reach = form.along(away).sqrt();
    if distance <= 0.0 || distance >= reach {
        return None;
    }
    Some(photon.moved(
        photon.position() - wall.away * (2.0 * distance),
        photon.flux() * wall.share,
        form.mirrored(away),
    ))
}

/// The walls that probes met.
fn walls(world: &World, photon: &Photon, time: f64, frame: &Frame) -> [Option<Wall>; MAX_WALLS] {
    let (p, n) = (photon.position(), photon.normal());
    // What is lower than that counts as the surface itself.
    let up = n * photon.thickness().copysign(photon.wi().dot(n));
    let probes = probes(&photon.form(), frame);
    let steep = |height: f64, probe: Vec3| {
        let ray = Ray { t_max: probe.length(), time, ..Ray::new(p + up * height, Dir3::new(probe)?) };
        let si = world.first_surface(&ray)?;
        (si.ng.dot(n).abs() < MIN_NORMAL_COSINE).then(|| (si.p, towards(si.ng.to_vec(), -ray.direction)))
    };
    let met = probes.map(|probe| {
        // Under what hovers the surface goes on.
        let (q, nw) = steep(1.0, probe).and_then(|_| steep(LOW, probe))?;
        Some(Wall::new(p, n, q, nw))
    });
    let mut walls = [None; MAX_WALLS];
    for wall in met.iter().flatten().flatten() {
        let same = |known: &Wall| known.away.dot(wall.away) > MIN_NORMAL_COSINE;
        if !walls.iter().flatten().any(same)
            && let Some(free) = walls.iter_mut().find(|place| place.is_none())
        {
            *free = Some(*wall);
        }
    }
    for wall in walls.iter_mut().flatten() {
        let behind = |probe: &Vec3| (p + *probe - wall.foot).dot(wall.away) < 0.0;
        let crossing = || probes.iter().zip(&met).filter(|(probe, _)| behind(probe));
        wall.share = crossing().filter(|(_, met)| met.is_some()).count() as f64 / crossing().count().max(1) as f64;
    }
    walls
}

impl Wall {
    /// The wall through `q` with the normal `nw` on this side, for a footprint about `p` with normal `n`; `None` for one
    /// that hangs over `p`.
    fn new(p: Point3, n: Vec3, q: Point3, nw: Vec3) -> Option<Wall> {
        let across = nw - n * n.dot(nw);
        let distance = nw.dot(p - q) / across.length();
        let away = across.normalize();
        (distance > 0.0).then(|| Wall { away, foot: p - away * distance, share: 1.0 })
    }
}

fn towards(n: Vec3, w: Vec3) -> Vec3 {
    if n.dot(w) < 0.0 { -n } else { n }
}

/// From the footprint's middle to its rim.
fn probes(form: &TangentForm, frame: &Frame) -> [Vec3; PROBES] {
    let ([minor, major], along) = form.principal();
    let a = (frame.t * along.x + frame.b * along.y) * major.sqrt();
    let b = (frame.b * along.x - frame.t * along.y) * minor.sqrt();
    std::array::from_fn(|k| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / PROBES as f64).sin_cos();
        a * cos + b * sin
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import;
    use crate::math::Normal3;
    use crate::radiometry::{Flux, Spectrum};

    /// The corner of a floor, z = 0, and two walls, x = 0 and y = 0, of a metre's height.
    fn corner() -> World {
        let rectangle = |centre: [f64; 3], a: [f64; 3], b: [f64; 3]| {
            format!("[[objects]]\nshape = \"rectangle\"\ncentre = {centre:?}\na = {a:?}\nb = {b:?}\nmaterial = \"m\"\n")
        };
        let text = [
            "format = 1\n[camera]\ntype = \"orthographic\"\nposition = [5, 5, 5]\ntarget = [0, 0, 0]\nwidth = 1\n\
             resolution = [4, 4]\n[materials.m]\ntype = \"lambert\"\nalbedo = 0.5\n"
                .to_owned(),
            rectangle([5.0, 5.0, 0.0], [5.0, 0.0, 0.0], [0.0, 5.0, 0.0]),
            rectangle([0.0, 5.0, 0.5], [0.0, 5.0, 0.0], [0.0, 0.0, 0.5]),
            rectangle([5.0, 0.0, 0.5], [5.0, 0.0, 0.0], [0.0, 0.0, -0.5]),
            "[[lights]]\ntype = \"point\"\nposition = [5.0, 5.0, 5.0]\nintensity = 1\n".to_owned(),
        ];
        World::new(import::load_text("corner.toml".as_ref(), &text.concat(), &[]).expect("a sound scene").scene)
            .expect("a sound world")
    }

    fn photon(p: [f64; 2], radius: f64) -> Photon {
        let form = TangentForm { xx: radius * radius, xy: 0.0, yy: radius * radius };
        Photon::new(Point3::new(p[0], p[1], 0.0), Dir3::Z, Normal3::Z, Flux(Spectrum::ONE), form, 0)
    }

    #[test]
    fn a_footprint_in_a_corner_has_three_images_and_one_in_the_middle_none() {
        let world = corner();
        let places = |p, radius| {
            let mut all: Vec<[i64; 2]> = images(&world, &photon(p, radius), 0.0)
                .iter()
                .map(|image| [image.position().x, image.position().y].map(|x| (x * 1e4).round() as i64))
                .collect();
            all.sort_unstable();
            all
        };
        assert_eq!(places([0.2, 0.1], 0.3), [[-2000, -1000], [-2000, 1000], [2000, -1000]]);
        assert_eq!(places([0.2, 4.0], 0.3), [[-2000, 40_000]]);
        assert_eq!(places([4.0, 4.0], 0.3), [[0; 2]; 0]);
        for image in images(&world, &photon([0.2, 0.1], 0.3), 0.0) {
            assert!((image.flux().0.mean() - 1.0).abs() < 1e-6, "{}", image.flux().0.mean());
        }
    }
}
