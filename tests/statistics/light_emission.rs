//! Where light starts and where it goes, against the densities that lights claim.

use std::f64::consts::PI;
use std::rc::Rc;

use pdembree::light::{Aim, AreaLight, DirectionalLight, Emission, EnvironmentLight, Light, PointLight, SpotLight};
use pdembree::math::{Frame, Normal3, Point3, Transform, Vec3};
use pdembree::radiometry::{Intensity, Irradiance, Radiance};
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::TriangleMesh;
use pdembree::scene::light::BeamExtent;
use pdembree::shape::{Disk, Rectangle, Shape, Sphere};

use crate::support::evenness::{about, evenness, in_cone, on_disk};
use crate::support::lights::{COLOUR, SCENE, dir, tetrahedron};
use crate::support::statistics::{assert_plausible, chi2_test};

const SEED: u64 = 31;

/// Coordinates of an emission that are even over the unit cube.
type Coordinates = Box<dyn Fn(&Emission) -> Vec<f64>>;

/// 1/p_a in m² and 1/p_w in sr at an emission.
type Cells = Box<dyn Fn(&Emission) -> (Option<f64>, Option<f64>)>;

/// What makes a light's samples even, with the densities that this means.
struct Even {
    name: &'static str,
    light: Rc<dyn Light>,
    aim: Aim,
    coordinates: Coordinates,
    cells: Cells,
}

const AIM_CENTRE: Point3 = Point3::new(0.3, -0.4, 0.2);
const AIM: Aim = Aim::Sphere { centre: AIM_CENTRE, radius: 0.7 };
const POSITION: Point3 = Point3::new(0.4, 2.5, 0.3);

/// 1 − cos of the half angle under which the aim is seen.
fn aim_height(x: Point3) -> f64 {
    1.0 - (1.0 - 0.49 / x.distance_squared(AIM_CENTRE)).sqrt()
}

/// A case whose densities are the same everywhere.
fn even(
    name: &'static str,
    light: Rc<dyn Light>,
    aim: Aim,
    cells: (Option<f64>, Option<f64>),
    coordinates: impl Fn(&Emission) -> Vec<f64> + 'static,
) -> Even {
    Even { name, light, aim, coordinates: Box::new(coordinates), cells: Box::new(move |_| cells) }
}

const WHOLE: f64 = 4.0 * PI;

/// Sources of directions.
fn points_and_spots() -> Vec<Even> {
    let down = dir(0.2, -1.0, 0.1);
    let intensity = Intensity(COLOUR);
    let point = Rc::new(PointLight { position: POSITION, intensity });
    let spot = Rc::new(SpotLight::new(POSITION, down, intensity, 0.9, 0.8));
    let to_aim = (AIM_CENTRE - POSITION).normalize();
    let height = aim_height(POSITION);
    vec![
        even("point", point.clone(), Aim::Everywhere, (None, Some(WHOLE)), |e| {
            in_cone(Vec3::Z, e.direction, 2.0).to_vec()
        }),
        even("aimed point", point, AIM, (None, Some(2.0 * PI * height)), move |e| {
            in_cone(to_aim, e.direction, height).to_vec()
        }),
        even("spot", spot, Aim::Everywhere, (None, Some(2.0 * PI * 0.2)), move |e| {
            in_cone(down, e.direction, 0.2).to_vec()
        }),
    ]
}

/// Sources of positions.
fn beams() -> Vec<Even> {
    let down = dir(0.2, -1.0, 0.1);
    let frame = Frame::from_unit(down);
    let beam = |extent| Rc::new(DirectionalLight::new(down, Irradiance(COLOUR), &extent, SCENE).expect("has area"));
    let (a, b) = (Vec3::new(1.0, 0.2, 0.0) * 0.3, down.cross(Vec3::new(1.0, 0.2, 0.0)) * 0.2);
    let rectangle = beam(BeamExtent::Rectangle { centre: POSITION, a, b });
    let disk = beam(BeamExtent::Disk { centre: POSITION, radius: 0.8 });
    let area = 4.0 * a.length() * b.length();
    vec![
        even("rectangle beam", rectangle, Aim::Everywhere, (Some(area), None), move |e| {
            let x = e.origin - POSITION;
            [x.dot(a) / a.length_squared(), x.dot(b) / b.length_squared()].map(|c| 0.5 * (c + 1.0)).to_vec()
        }),
        even("disk beam", disk, Aim::Everywhere, (Some(PI * 0.64), None), move |e| {
            on_disk(&frame, e.origin - POSITION, 0.8).to_vec()
        }),
        even("aimed sun", beam(BeamExtent::Unbounded), AIM, (Some(PI * 0.49), None), move |e| {
            on_disk(&frame, e.origin - AIM_CENTRE, 0.7).to_vec()
        }),
    ]
}

/// Light from everywhere, at everything and at the aim.
fn environments() -> Vec<Even> {
    let light = Rc::new(EnvironmentLight { radiance: Radiance(COLOUR), scene: SCENE });
    [("environment", Aim::Everywhere, SCENE.centre, SCENE.radius), ("aimed environment", AIM, AIM_CENTRE, 0.7)]
        .map(|(name, aim, centre, radius)| {
            even(name, light.clone(), aim, (Some(PI * radius * radius), Some(WHOLE)), move |e| {
                let x = on_disk(&Frame::from_unit(e.direction), e.origin - centre, radius);
                [x, in_cone(Vec3::Z, e.direction, 2.0)].concat()
            })
        })
        .into()
}

const LIFT: Vec3 = Vec3::new(0.2, 2.0, 0.0);

fn area_light(shape: Shape, two_sided: bool) -> Rc<AreaLight> {
    let lifted = Transform::translate(LIFT);
    Rc::new(AreaLight::from_shape(&shape, &lifted, Radiance(COLOUR), two_sided).expect("has area"))
}

fn normal(e: &Emission) -> Normal3 {
    e.normal.expect("a surface")
}

/// 1/p_w of cosine-weighted directions.
fn cosine_cell(e: &Emission) -> f64 {
    PI / normal(e).dot(e.direction).abs()
}

fn rectangles() -> Vec<Even> {
    let (a, b) = (Vec3::new(0.5, 0.0, 0.0), Vec3::new(0.0, 0.0, 0.3));
    let rectangle = Shape::Rectangle(Rectangle::new(Point3::ORIGIN, b, a).expect("a rectangle"));
    let within = move |e: &Emission| {
        let x = e.origin - (Point3::ORIGIN + LIFT);
        vec![0.5 * (1.0 + x.dot(a) / a.length_squared()), 0.5 * (1.0 + x.dot(b) / b.length_squared())]
    };
    vec![
        Even {
            name: "rectangle",
            light: area_light(rectangle.clone(), false),
            aim: Aim::Everywhere,
            coordinates: Box::new(move |e| [within(e), about(normal(e), e.direction).to_vec()].concat()),
            cells: Box::new(|e| (Some(0.6), Some(cosine_cell(e)))),
        },
        Even {
            name: "two-sided rectangle",
            light: area_light(rectangle.clone(), true),
            aim: Aim::Everywhere,
            coordinates: Box::new(move |e| {
                // Both hemispheres stacked: the cosine's square with its sign.
                let [turn, square] = about(normal(e), e.direction);
                let signed = square.copysign(normal(e).dot(e.direction));
                [within(e), vec![turn, 0.5 * (1.0 + signed)]].concat()
            }),
            cells: Box::new(|e| (Some(0.6), Some(2.0 * cosine_cell(e)))),
        },
        Even {
            name: "aimed two-sided rectangle",
            light: area_light(rectangle, true),
            aim: AIM,
            coordinates: Box::new(move |e| {
                let axis = (AIM_CENTRE - e.origin).normalize();
                [within(e), in_cone(axis, e.direction, aim_height(e.origin)).to_vec()].concat()
            }),
            cells: Box::new(|e| (Some(0.6), Some(2.0 * PI * aim_height(e.origin)))),
        },
    ]
}

fn round_lights() -> Vec<Even> {
    let sphere = Shape::Sphere(Sphere::new(Point3::ORIGIN, 0.5).expect("a sphere"));
    let disk = Shape::Disk(Disk::new(Point3::ORIGIN, Vec3::Y, 0.6).expect("a disk"));
    vec![
        Even {
            name: "disk",
            light: area_light(disk, false),
            aim: Aim::Everywhere,
            coordinates: Box::new(|e| {
                let x = on_disk(&Frame::from_unit(normal(e)), e.origin - (Point3::ORIGIN + LIFT), 0.6);
                [x, about(normal(e), e.direction)].concat()
            }),
            cells: Box::new(|e| (Some(PI * 0.36), Some(cosine_cell(e)))),
        },
        Even {
            name: "sphere",
            light: area_light(sphere, false),
            aim: Aim::Everywhere,
            coordinates: Box::new(|e| [in_cone(Vec3::Z, normal(e), 2.0), about(normal(e), e.direction)].concat()),
            cells: Box::new(|e| (Some(PI), Some(cosine_cell(e)))),
        },
    ]
}

#[test]
fn emissions_fill_positions_and_directions_evenly() {
    let all: Vec<Even> =
        [points_and_spots(), beams(), environments(), rectangles(), round_lights()].into_iter().flatten().collect();
    for (i, case) in all.iter().enumerate() {
        let mut stream = Stream::new(SEED, Purpose::Test, 0, i as u64);
        let mut draw = || {
            let ([a, b], [c, d]) = (stream.uniform2(), stream.uniform2());
            let e = case.light.emit([a, b, c, d], &case.aim).expect("these maps waste nothing");
            let cells = (case.cells)(&e);
            for (pdf, cell) in [(e.pdf_a.map(|p| p.get()), cells.0), (e.pdf_w.map(|p| p.get()), cells.1)] {
                assert_eq!(pdf.is_some(), cell.is_some(), "{}", case.name);
                let product = pdf.zip(cell).map_or(1.0, |(p, c)| p * c);
                // The closed forms lose digits where a cone is narrow: 1 − cos here is above 1e-2.
                assert!((product - 1.0).abs() <= 1e-12, "{}: density times cell is {product}", case.name);
            }
            (case.coordinates)(&e)
        };
        let ticks = if draw().len() == 2 { 20 } else { 6 };
        let p = evenness(ticks, 60_000, draw);
        assert_plausible(p, all.len(), format!("{}, seed {SEED}", case.name));
    }
}

/// The triangle of the tetrahedron in whose plane a point lies.
fn face_of(mesh: &TriangleMesh, p: Point3) -> usize {
    let off = |prim: usize| {
        let [a, b, c] = mesh.corners(prim as u32);
        Normal3::new((b - a).cross(c - a)).map_or(f64::INFINITY, |n| n.dot(p - a).abs())
    };
    (0..mesh.triangles.len()).min_by(|&i, &j| off(i).total_cmp(&off(j))).expect("it has faces")
}

#[test]
fn a_mesh_emits_from_its_triangles_by_area() {
    const DRAWS: usize = 50_000;
    let mesh = tetrahedron();
    let light = AreaLight::from_mesh(&mesh, &Transform::IDENTITY, Radiance(COLOUR), false).expect("has area");
    let area = |prim: usize| {
        let [a, b, c] = mesh.corners(prim as u32);
        0.5 * (b - a).cross(c - a).length()
    };
    let mut stream = Stream::new(SEED, Purpose::Test, 1, 0);
    let mut counts = vec![0u64; mesh.triangles.len()];
    for _ in 0..DRAWS {
        let ([a, b], [c, d]) = (stream.uniform2(), stream.uniform2());
        let e = light.emit([a, b, c, d], &Aim::Everywhere).expect("no aim to miss");
        counts[face_of(&mesh, e.origin)] += 1;
        assert!((e.pdf_a.expect("a surface").get() * light.area() - 1.0).abs() < 1e-12);
    }
    let expected: Vec<f64> = (0..counts.len()).map(|prim| area(prim) / light.area() * DRAWS as f64).collect();
    assert_plausible(chi2_test(&counts, &expected), 1, format!("{counts:?} against {expected:?}, seed {SEED}"));
}
