//! Lights of every kind with aims near and far, for tests.

use std::rc::Rc;
use std::sync::Arc;

use pdembree::light::{
    Aim, AreaLight, DirectionalLight, EnvironmentLight, Light, PanoramaLight, PointLight, SceneSphere, SpotLight,
};
use pdembree::math::{Dir3, Frame, Point3, Transform, Vec3};
use pdembree::radiometry::{Intensity, Irradiance, Radiance, Spectrum};
use pdembree::scene::light::BeamExtent;
use pdembree::scene::panorama::{Part, Projection};
use pdembree::scene::texture::{Placement, Texels, Wrap};
use pdembree::scene::{ImageTexture, Panorama, TriangleMesh};
use pdembree::shape::{Cylinder, Disk, Rectangle, Shape, Sphere, Torus};

/// A light, an aim, and what they are.
pub struct Case {
    pub name: String,
    pub light: Rc<dyn Light>,
    pub aim: Aim,
}

pub const SCENE: SceneSphere = SceneSphere { centre: Point3::new(0.5, 0.2, -0.1), radius: 4.0 };
pub const COLOUR: Spectrum = Spectrum::rgb(3.0, 2.0, 0.5);

pub fn dir(x: f64, y: f64, z: f64) -> Dir3 {
    Dir3::new(Vec3::new(x, y, z)).expect("not zero")
}

/// Scaled unevenly, turned and moved.
pub fn skewed() -> Transform {
    Transform::translate(Vec3::new(0.3, 2.0, -0.4))
        .compose(&Transform::rotate(dir(1.0, 2.0, 0.5), 0.8))
        .compose(&Transform::scale(Vec3::new(1.0, 0.6, -1.4)).expect("invertible"))
}

/// A tetrahedron with faces of different sizes and a degenerate triangle, outward.
pub fn tetrahedron() -> TriangleMesh {
    TriangleMesh {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.7, 0.0], [0.0, 0.0, 0.4]],
        triangles: vec![[0, 2, 1], [0, 1, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
        ..TriangleMesh::default()
    }
}

/// Every shape that can emit, in object space.
pub fn shapes() -> Vec<(&'static str, Shape)> {
    let origin = Point3::ORIGIN;
    vec![
        ("sphere", Shape::Sphere(Sphere::new(Point3::new(0.1, 0.2, 0.3), 0.5).expect("a sphere"))),
        ("cylinder", Shape::Cylinder(Cylinder::new(origin, Point3::new(0.3, 0.8, 0.2), 0.3).expect("a cylinder"))),
        ("torus", Shape::Torus(Torus::new(origin, Vec3::new(0.2, 1.0, 0.1), 0.6, 0.2).expect("a torus"))),
        ("disk", Shape::Disk(Disk::new(origin, Vec3::new(0.2, -1.0, 0.1), 0.5).expect("a disk"))),
        (
            "rectangle",
            Shape::Rectangle(
                Rectangle::new(origin, Vec3::new(0.5, 0.0, 0.0), Vec3::new(0.0, 0.0, 0.3)).expect("a rectangle"),
            ),
        ),
    ]
}

/// Texels over four decades, dark ones among them, mirrored and turned.
pub fn panorama(projection: Projection) -> Panorama {
    let (width, height) = match projection {
        Projection::LatLong => (8, 4),
        Projection::Octahedral => (6, 6),
    };
    let texel = |i: usize| {
        let bright = [1.0, 0.02, 0.3, 0.0, 20.0, 0.1, 0.5][i % 7] as f32;
        [bright, 0.5 * bright, 2.0 * bright]
    };
    let texels = (0..width * height).map(texel).collect();
    let wrap = [Wrap::Repeat; 2];
    let texels = Texels::new(width, height, texels);
    let image = ImageTexture { texels, wrap, placement: Placement::IDENTITY };
    let frame = Frame::from_unit(dir(0.3, 0.8, -0.4));
    let axes = [frame.t, -frame.b, frame.n].map(Dir3::from_unit);
    Panorama { image: Arc::new(image), projection, axes, factor: COLOUR, part: Part::All }
}

pub fn lights() -> Vec<(String, Rc<dyn Light>)> {
    let intensity = Intensity(COLOUR);
    let irradiance = Irradiance(COLOUR);
    let radiance = Radiance(COLOUR);
    let position = Point3::new(0.4, 2.5, 0.3);
    let down = dir(0.2, -1.0, 0.1);
    let mut all: Vec<(String, Rc<dyn Light>)> = vec![
        ("point".into(), Rc::new(PointLight { position, intensity })),
        ("spot".into(), Rc::new(SpotLight::new(position, down, intensity, 0.9, 0.8))),
        ("sharp spot".into(), Rc::new(SpotLight::new(position, down, intensity, 0.95, 0.95))),
        ("wide spot".into(), Rc::new(SpotLight::new(position, down, intensity, 0.3, -0.4))),
        ("environment".into(), Rc::new(EnvironmentLight { radiance, scene: SCENE })),
    ];
    for (name, extent) in [
        ("sun", BeamExtent::Unbounded),
        ("disk beam", BeamExtent::Disk { centre: position, radius: 0.8 }),
        (
            "rectangle beam",
            BeamExtent::Rectangle {
                centre: position,
                a: Vec3::new(1.0, 0.2, 0.0) * 0.7,
                b: down.cross(Vec3::new(1.0, 0.2, 0.0)),
            },
        ),
    ] {
        let beam = DirectionalLight::new(down, irradiance, &extent, SCENE).expect("has area");
        all.push((name.into(), Rc::new(beam)));
    }
    for projection in [Projection::LatLong, Projection::Octahedral] {
        let light = PanoramaLight::new(panorama(projection), SCENE).expect("not black");
        all.push((format!("{projection:?} panorama"), Rc::new(light)));
    }
    for two_sided in [false, true] {
        let side = if two_sided { "two-sided" } else { "one-sided" };
        for (moved, to_world) in [("", Transform::translate(Vec3::new(0.2, 2.0, 0.0))), ("skewed ", skewed())] {
            for (name, shape) in shapes() {
                let light = AreaLight::from_shape(&shape, &to_world, radiance, two_sided).expect("has area");
                all.push((format!("{side} {moved}{name}"), Rc::new(light)));
            }
            let light = AreaLight::from_mesh(&tetrahedron(), &to_world, radiance, two_sided).expect("has area");
            all.push((format!("{side} {moved}mesh"), Rc::new(light)));
        }
    }
    all
}

/// Every light with every aim: none, a small sphere aside, a middling one below, one around everything.
pub fn cases() -> Vec<Case> {
    let aims = [
        ("everywhere", Aim::Everywhere),
        ("a small sphere", Aim::Sphere { centre: Point3::new(1.2, 0.0, 0.3), radius: 0.2 }),
        ("a sphere below", Aim::Sphere { centre: Point3::new(0.2, -0.2, 0.1), radius: 0.9 }),
        ("a near sphere", Aim::Sphere { centre: Point3::new(0.4, 1.2, 0.3), radius: 1.2 }),
        ("a sphere around", Aim::Sphere { centre: Point3::new(0.3, 1.0, 0.0), radius: 3.8 }),
    ];
    lights()
        .into_iter()
        .flat_map(|(name, light)| {
            aims.map(|(aim_name, aim)| Case { name: format!("{name} → {aim_name}"), light: Rc::clone(&light), aim })
        })
        .collect()
}
