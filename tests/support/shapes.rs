//! One shape of every kind in general position, each with its own second description as an implicit function.

use pdembree::math::{Point3, Vec2, Vec3};
use pdembree::sampling::{Purpose, Stream};
use pdembree::shape::{Cylinder, Disk, HeightField, Rectangle, Shape, Sphere, Torus, Wave};

/// A shape and what a test may know of it without the shape's own code.
pub struct Known {
    pub name: &'static str,
    pub shape: Shape,
    /// Zero on the (unbounded) surface, of different signs on its sides.
    pub implicit: Box<dyn Fn(Point3) -> f64>,
    /// Whether a point of the unbounded surface belongs to the shape.
    pub inside: Box<dyn Fn(Point3) -> bool>,
    /// A sphere around the shape.
    pub centre: Point3,
    pub reach: f64,
}

pub fn random(index: u64) -> Stream {
    Stream::new(20_261_122, Purpose::Test, 0, index)
}

/// Uniform on the unit sphere.
pub fn random_direction(stream: &mut Stream) -> Vec3 {
    let [a, b] = stream.uniform2();
    let z = 2.0 * a - 1.0;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
    Vec3::new(r * cos, r * sin, z)
}

fn p(x: f64, y: f64, z: f64) -> Point3 {
    Point3::new(x, y, z)
}

fn sphere() -> Known {
    let (c, r) = (p(0.3, -0.2, 0.7), 0.8);
    Known {
        name: "sphere",
        shape: Shape::Sphere(Sphere::new(c, r).expect("valid")),
        implicit: Box::new(move |x| x.distance(c) - r),
        inside: Box::new(|_| true),
        centre: c,
        reach: r,
    }
}

fn cylinder() -> Known {
    let (base, top, r) = (p(0.1, -0.4, 0.2), p(0.7, 0.5, 1.3), 0.45);
    let length = top.distance(base);
    let axis = (top - base) / length;
    Known {
        name: "cylinder",
        shape: Shape::Cylinder(Cylinder::new(base, top, r).expect("valid")),
        implicit: Box::new(move |x| (x - base).cross(axis).length() - r),
        inside: Box::new(move |x| (0.0..=length).contains(&(x - base).dot(axis))),
        centre: p(0.4, 0.05, 0.75),
        reach: (0.25 * length * length + r * r).sqrt(),
    }
}

fn torus(name: &'static str, major: f64, minor: f64) -> Known {
    let (c, axis) = (p(-0.2, 0.4, 0.1), Vec3::new(0.3, 0.5, 1.0));
    let unit = axis.normalize();
    Known {
        name,
        shape: Shape::Torus(Torus::new(c, axis, major, minor).expect("valid")),
        implicit: Box::new(move |x| {
            let along = (x - c).dot(unit);
            let around = (x - c).cross(unit).length();
            (around - major).hypot(along) - minor
        }),
        inside: Box::new(|_| true),
        centre: c,
        reach: major + minor,
    }
}

fn disk() -> Known {
    let (c, n, r) = (p(0.5, 0.1, -0.3), Vec3::new(-0.2, 0.9, 0.4), 0.7);
    let unit = n.normalize();
    Known {
        name: "disk",
        shape: Shape::Disk(Disk::new(c, n, r).expect("valid")),
        implicit: Box::new(move |x| (x - c).dot(unit)),
        inside: Box::new(move |x| x.distance(c) <= r),
        centre: c,
        reach: r,
    }
}

fn rectangle() -> Known {
    let (c, a, b) = (p(0.5, 0.1, -0.3), Vec3::new(0.6, 0.2, -0.1), Vec3::new(-0.1, 0.5, 0.4));
    let n = a.cross(b).normalize();
    Known {
        name: "rectangle",
        shape: Shape::Rectangle(Rectangle::new(c, a, b).expect("valid")),
        implicit: Box::new(move |x| (x - c).dot(n)),
        inside: Box::new(move |x| {
            (x - c).dot(a).abs() <= a.length_squared() && (x - c).dot(b).abs() <= b.length_squared()
        }),
        centre: c,
        reach: (a.length_squared() + b.length_squared()).sqrt(),
    }
}

fn height_field() -> Known {
    let (c, half) = (p(0.2, -0.1, 0.4), Vec2::new(0.9, 0.6));
    let up = Vec3::new(0.1, 0.2, 1.0);
    let z = up.normalize();
    let x = (Vec3::X - z * z.x).normalize();
    let y = z.cross(x);
    let terms =
        [(0.12, Vec2::new(7.0, 2.0), 0.3), (0.05, Vec2::new(-3.0, 11.0), 1.7), (-0.02, Vec2::new(20.0, 9.0), 0.0)];
    let waves = terms.map(|(amplitude, wave_vector, phase)| Wave { amplitude, wave_vector, phase, rate: 0.0 }).to_vec();
    let local = move |q: Point3| Vec3::new((q - c).dot(x), (q - c).dot(y), (q - c).dot(z));
    Known {
        name: "height_field",
        shape: Shape::HeightField(HeightField::new(c, Vec3::X, up, half, waves).expect("valid")),
        implicit: Box::new(move |q| {
            let l = local(q);
            l.z - terms.iter().map(|(a, k, phase)| a * (k.dot(l.truncate()) + phase).sin()).sum::<f64>()
        }),
        inside: Box::new(move |q| local(q).x.abs() <= half.x && local(q).y.abs() <= half.y),
        centre: c,
        reach: half.length() + 0.2,
    }
}

/// Every kind of shape, the torus both fat and thin.
pub fn all() -> Vec<Known> {
    vec![sphere(), cylinder(), torus("torus", 1.0, 0.4), torus("ring", 1.0, 0.03), disk(), rectangle(), height_field()]
}

impl Known {
    /// A point on the shape, by shooting at it from outside.
    pub fn point(&self, stream: &mut Stream) -> Point3 {
        for _ in 0..10_000 {
            let from = self.centre + random_direction(stream) * (2.0 * self.reach);
            let to = self.centre + random_direction(stream) * (self.reach * stream.uniform().cbrt());
            let ray =
                pdembree::math::Ray { origin: from, direction: to - from, t_min: 0.0, t_max: f64::INFINITY, time: 0.0 };
            if let Some(t) = self.shape.intersect(&ray) {
                return self.shape.surface_at(ray.at(t), 0.0).p;
            }
        }
        panic!("{}: no ray of 10 000 hits it", self.name);
    }
}
