//! Media without chance: what is where along rays, closed forms of transmittance, walls, and beams over an eye's ray.

use pdembree::estimate::beams::{EyeSegment, Place, radiance, radiance_at};
use pdembree::estimate::collisions;
use pdembree::import::load_text;
use pdembree::math::{Dir3, Point3, Ray, Vec3};
use pdembree::medium::{Inside, Profile};
use pdembree::photon::beam_map::BeamMap;
use pdembree::photon::collision_map::CollisionMap;
use pdembree::photon::footprint::Spread;
use pdembree::photon::{Beam, BeamWidth};
use pdembree::radiometry::{Flux, Spectrum};
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::settings::{FootprintRule, KernelShape};
use pdembree::scene::{Medium, MediumId};
use pdembree::world::World;

use crate::support::statistics::Moments;

/// A ball of smoke of radius 2 about the origin, in it one of clear glass and a smaller one of ink, that overlaps a third one of
/// higher priority, and haze around all of it.
const NESTED: &str = r#"
format = 1
atmosphere = "haze"
[camera]
type = "perspective"
position = [0, 0, 9]
target = [0, 0, 0]
fov_degrees = 40
resolution = [4, 4]
[media.haze]
sigma_s = 0.01
[media.smoke]
sigma_a = [0.1, 0.2, 0.3]
sigma_s = 0.2
[media.ink]
sigma_a = 1
sigma_s = 0.5
scale = 2
[media.milk]
sigma_s = 5
[materials.smoke]
type = "interface"
interior = "smoke"
[materials.glass]
type = "dielectric"
ior = 1.5
priority = 1
[materials.ink]
type = "interface"
interior = "ink"
priority = 2
[materials.milk]
type = "interface"
interior = "milk"
priority = 3
[[objects]]
shape = "sphere"
centre = [0, 0, 0]
radius = 2
material = "smoke"
[[objects]]
shape = "sphere"
centre = [0, 1, 0]
radius = 0.5
material = "glass"
[[objects]]
shape = "sphere"
centre = [0, -1, 0]
radius = 0.5
material = "ink"
[[objects]]
shape = "sphere"
centre = [0.4, -1, 0]
radius = 0.5
material = "milk"
[[objects]]
shape = "sphere"
centre = [0, 0, 6]
radius = 0.1
material = "smoke"
[[lights]]
type = "point"
position = [0, 5, 0]
intensity = 1
"#;

fn world(scene: &str) -> World {
    let loaded = load_text("media.toml".as_ref(), scene, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    World::new(loaded.scene).expect("a world")
}

fn between(a: Point3, b: Point3) -> Ray {
    let w = Dir3::new(b - a).expect("two points");
    Ray { t_max: a.distance(b), ..Ray::new(a, w) }
}

#[test]
fn a_point_knows_what_it_is_inside_of() {
    let world = world(NESTED);
    let inside = |x, y, z| world.inside(Point3::new(x, y, z), 0.0).objects().map(|o| o.0).collect::<Vec<_>>();
    assert!(inside(0.0, 5.0, 0.0).is_empty());
    assert_eq!(inside(0.0, 0.0, 0.0), [0]);
    assert_eq!(inside(0.0, 1.0, 0.0), [0, 1]);
    let both = inside(0.25, -1.0, 0.0);
    assert!(both[0] == 0 && both.len() == 3 && both.contains(&2) && both.contains(&3), "{both:?}");
}

/// An open surface, a pool's, has its inside under it as far as it goes, and nothing beside and above it.
#[test]
fn a_point_is_inside_of_the_open_surface_above_it() {
    let pool = "format = 1\n[camera]\ntype = \"perspective\"\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\n\
        fov_degrees = 40\nresolution = [4, 4]\n\
        [media.water]\nsigma_s = 0.1\n[materials.water]\ntype = \"dielectric\"\nior = 1.3\ninterior = \"water\"\n\
        [[objects]]\nshape = \"height_field\"\ncentre = [0, 0, 0]\nhalf_size = [2, 2]\nup = [0, 1, 0]\nx_axis = [1, 0, 0]\n\
        material = \"water\"\nwaves = [{ amplitude = 0.1, wave_vector = [3, 1], phase = 0 }]\n\
        [[lights]]\ntype = \"point\"\nposition = [0, 3, 0]\nintensity = 1\n";
    let world = world(pool);
    let inside = |x, y| world.inside(Point3::new(x, y, 0.0), 0.0).objects().count();
    assert_eq!([inside(0.3, -1.0), inside(-1.9, -7.0)], [1, 1]);
    assert_eq!([inside(0.3, 1.0), inside(2.1, -1.0), inside(-5.0, -5.0)], [0, 0, 0]);
}

/// Along x at y = −1: haze, smoke to the ink, ink to the milk, milk, smoke again. −ln T is the sum of σ_t times lengths; each
/// crossing starts the ray anew, off the surface by `origin_offset` at most twice.
#[test]
fn transmittance_is_that_of_the_media_in_turn() {
    let world = world(NESTED);
    let regions = world.regions.as_ref().expect("media");
    let ray = between(Point3::new(-3.0, -1.0, 0.0), Point3::new(3.0, -1.0, 0.0));
    let found = world.transmittance(regions, &ray, Inside::NOTHING).expect("nothing in between");
    let half = 3f64.sqrt();
    let smoke = [0.3, 0.4, 0.5];
    // The haze reaches from the sphere around all objects, whose box is [−2, 2]² × [−2, 6.1].
    let radius = 0.5 * (16.0f64 + 16.0 + 8.1 * 8.1).sqrt();
    let reach = (radius * radius - 1.0 - 2.05 * 2.05).sqrt().min(3.0);
    let offset = 6.0 * pdembree::math::float::origin_offset(3.0);
    for (found, smoke) in found.to_array().into_iter().zip(smoke) {
        let depth = 0.01 * 2.0 * (reach - half) + smoke * (half - 0.5 + half - 0.9) + 3.0 * 0.4 + 5.0 * 1.0;
        assert!((-found.ln() - depth).abs() < 5.0 * 2.0 * offset, "{} not {depth}", -found.ln());
    }
    // Through the glass no shadow ray goes.
    let through = between(Point3::new(-3.0, 1.0, 0.0), Point3::new(3.0, 1.0, 0.0));
    assert_eq!(world.transmittance(regions, &through, Inside::NOTHING), None);
}

/// A wall of 1 mm in fog: of rays from all over one side to all over the other none gets through, nor does one that comes out of
/// a slab of 1 mm of ink forget that it was in there.
#[test]
fn nothing_leaks_through_a_wall_of_a_millimetre() {
    let wall = |z: &str, normal: &str| {
        format!(
            "[[objects]]\nshape = \"rectangle\"\ncentre = [0, 0, {z}]\na = [5, 0, 0]\nb = [0, {normal}, 0]\nmaterial = \"wall\"\n"
        )
    };
    let scene = format!(
        "{}[materials.wall]\ntype = \"lambert\"\nalbedo = 0.5\n{}{}",
        NESTED.replace("[[objects]]\nshape = \"sphere\"\ncentre = [0, 0, 6]\nradius = 0.1\nmaterial = \"smoke\"\n", ""),
        wall("3", "5"),
        wall("3.001", "-5")
    );
    let world = world(&scene);
    let regions = world.regions.as_ref().expect("media");
    let mut stream = Stream::new(7, Purpose::Test, 0, 0);
    for i in 0..20_000 {
        let mut point = |z: f64| Point3::new(8.0 * stream.uniform() - 4.0, 8.0 * stream.uniform() - 4.0, z);
        let (a, b) = (point(2.0), point(4.0));
        let ray = between(a, b);
        assert_eq!(world.transmittance(regions, &ray, world.inside(a, 0.0)), None, "ray {i}");
        // Along the edges of the two rectangles' triangles, too: through their middle.
        let c = Point3::new(-a.x, -a.y, 4.0);
        assert_eq!(world.transmittance(regions, &between(a, c), world.inside(a, 0.0)), None, "ray {i}");
    }
}

static FOG: Medium =
    Medium { absorption: Spectrum::splat(0.3), scattering: Spectrum::splat(0.5), asymmetry: 0.0, density: None };

/// An even sheet of `n` beams in a lattice, `breadth` × 1 m across `w` about the line that `towards` leaves along, of unit
/// irradiance.
fn sheet(n: u64, breadth: f64, w: Dir3, towards: Vec3, width: BeamWidth) -> BeamMap {
    let z = Vec3::Z;
    let across = w.cross(z);
    let golden = 0.618_033_988_749_894_9;
    let beam = |i: u64| {
        let (u, v) = ((i as f64 + 0.5) / n as f64, (i as f64 * golden).fract());
        let origin = Point3::ORIGIN + across * (breadth * (u - 0.5)) + z * (v - 0.5) + towards;
        let flux = Flux(Spectrum::splat(breadth / n as f64));
        Beam { origin, w, length: 10.0, flux, medium: MediumId(0), bounces: 0, width }
    };
    BeamMap::new((0..n).map(beam).collect(), std::slice::from_ref(&FOG))
}

fn segment(origin: Point3) -> EyeSegment<'static> {
    let w = Dir3::new(Vec3::Y).expect("a direction");
    let eye = [(Vec3::ZERO, Vec3::ZERO); 2];
    let (id, medium, profile) = (MediumId(0), &FOG, Profile::Even);
    EyeSegment { origin, w, length: 2.0, id, medium, profile, eye, bounces: 0 }
}

fn seen(map: &BeamMap, kernel: KernelShape, origin: Point3) -> f64 {
    radiance(map, kernel, &segment(origin)).0.g()
}

/// PHOTON_DIFFERENTIALS 8: a parallel beam of unit irradiance along x, seen across over 2 m at a depth of 0.7 m; and one at 35°
/// to the eye's ray. L = σ_s/(4π) ∫ e^(−σ_t (s_b + s_e)) ds_e = 0.0226738072 and 0.0187496567.
const ORACLES: [(f64, f64); 2] = [(90.0, 0.022_673_807_2), (35.0, 0.018_749_656_7)];

/// A lattice of 10 000 beams is within 0.1 % of the closed form wherever the eye looks through it; of the many places the
/// standard deviation is below a thousandth.
#[test]
fn a_lattice_of_beams_gives_light_scattered_once() {
    for (degrees, expected) in ORACLES {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let w = Dir3::new(Vec3::new(sin, cos, 0.0)).expect("a direction");
        let map = sheet(10_000, 2.2, w, Vec3::ZERO, BeamWidth::disc(0.2));
        let places = 200;
        let mut stream = Stream::new(3, Purpose::Test, 0, 0);
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..places {
            let origin = Point3::new(0.7, 0.0, 0.4 * (stream.uniform() - 0.5));
            let origin = if degrees == 90.0 { origin - Vec3::Y } else { origin };
            let ratio = seen(&map, KernelShape::Epanechnikov, origin) / expected;
            sum += ratio;
            squares += ratio * ratio;
        }
        let mean = sum / f64::from(places);
        let deviation = (squares / f64::from(places) - mean * mean).max(0.0).sqrt();
        println!("{degrees}°: ratio {mean:.6}, relative standard deviation {deviation:.6}");
        assert!((mean - 1.0).abs() < 1e-3 && deviation < 1e-3, "{degrees}°: {mean} ± {deviation}");
    }
}

/// How estimates that ask places add up to what a ray sees: ∫ T σ_s L_in ds over 2 m by the midpoint rule in 100 steps, whose
/// relative error is (σ_t h)²/24 = 10⁻⁵.
fn over_places(origin: Point3, light: impl Fn(&Place) -> Spectrum) -> f64 {
    let (w, steps) = (Dir3::new(Vec3::Y).expect("a direction"), 100);
    let h = 2.0 / f64::from(steps);
    let at = |k: i32| {
        let s = (f64::from(k) + 0.5) * h;
        let place = Place { p: origin + w * s, w, id: MediumId(0), medium: &FOG, eye: [Vec3::ZERO; 2], bounces: 0 };
        (FOG.transmittance(s) * FOG.scattering * light(&place)).g() * h
    };
    (0..steps).map(at).sum()
}

/// Light scattered once as each estimate that asks points, or from places, sees it, by footprints and by discs of one radius:
/// within 0.1 % and four standard errors over independent maps. Discs of 0.1 m blur e^(−σ_t s) by a part of
/// (0.1 · 0.8)²/12 = 0.05 %.
#[test]
fn every_estimate_gives_light_scattered_once() {
    let kernel = KernelShape::Epanechnikov;
    let columns = Spread::Columns { rule: FootprintRule::Quadratic, scale: 2.0 };
    for (spread, radius) in [(columns, 0.2), (Spread::Disc { radius: 0.1 }, 0.1)] {
        for (degrees, expected) in ORACLES {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let w = Dir3::new(Vec3::new(sin, cos, 0.0)).expect("a direction");
            let mut ratios = [Moments::default(); 3];
            for map in 0..8 {
                let mut stream = Stream::new(5, Purpose::Test, 1, map);
                let shift = w.cross(Vec3::Z) * (0.02 * stream.uniform()) + Vec3::Z * (0.02 * stream.uniform());
                let beams = sheet(4000, 2.6, w, shift, BeamWidth::disc(radius));
                let points = CollisionMap::new(beams.beams.clone(), std::slice::from_ref(&FOG), 48, spread, |way| {
                    Stream::new(6, Purpose::Test, map as u32, way)
                });
                let (mut sums, places) = ([0.0; 3], 5);
                for _ in 0..places {
                    let origin = Point3::new(0.7, 0.0, 0.4 * (stream.uniform() - 0.5));
                    let origin = if degrees == 90.0 { origin - Vec3::Y } else { origin };
                    let found = [
                        collisions::radiance(&points, kernel, &segment(origin)).0.g(),
                        over_places(origin, |place| radiance_at(&beams, kernel, place).0),
                        over_places(origin, |place| collisions::radiance_at(&points, kernel, place).0),
                    ];
                    sums.iter_mut().zip(found).for_each(|(sum, found)| *sum += found / expected / f64::from(places));
                }
                ratios.iter_mut().zip(sums).for_each(|(ratio, sum)| ratio.push(sum));
            }
            for (name, ratio) in ["ray_points", "place_beams", "place_points"].into_iter().zip(ratios) {
                println!("{degrees}°, {spread:?}, {name}: {ratio}");
                let error = ratio.standard_error();
                assert!((ratio.mean - 1.0).abs() < 1e-3 + 4.0 * error && error < 4e-3, "{degrees}° {name}: {ratio}");
            }
        }
    }
}
