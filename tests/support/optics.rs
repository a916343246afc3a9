//! A bench: rays with their columns through surfaces in a given order, by the renderer's own intersection, interaction
//! and event rules.

use pdembree::backend::RawHit;
use pdembree::differential::{Column, Differential, Refraction, ShapeOperator, reflect, refract, transfer};
use pdembree::math::{Dir3, Normal3, Point3, Ray, Transform, Vec3};
use pdembree::scene::{ObjectGeometry, ObjectId, Scene};
use pdembree::shape::{Disk, Shape, Sphere};
use pdembree::surface::Interaction;

use super::scene::scene;

/// A ray of light with its four columns.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    pub p: Point3,
    pub w: Dir3,
    pub columns: Differential<4>,
}

/// What happens at a surface.
#[derive(Clone, Copy, Debug)]
pub enum Act {
    Mirror,
    /// Refraction with n_incident / n_transmitted; total reflection ends the path.
    Refract(f64),
    /// The columns are carried to the surface and the ray goes on as it was.
    Land,
}

/// The unit columns of PHOTON_DIFFERENTIALS 1.4: u = normalize(x × D), v = D × u, both as positions (columns 0, 1) and
/// as directions (2, 3).
pub fn beam(p: Point3, direction: Vec3) -> Beam {
    let w = Dir3::new(direction).expect("a direction");
    let u = Vec3::X.cross(w.to_vec()).normalize();
    let v = w.cross(u);
    let columns = [Column::position(u), Column::position(v), Column::direction(u), Column::direction(v)];
    Beam { p, w, columns: Differential::new(columns) }
}

impl Beam {
    /// The beam of the parameter's value `step` for column `k`: to first order in position, on the unit sphere in
    /// direction.
    pub fn stepped(&self, k: usize, step: f64) -> Beam {
        let column = self.columns.column(k);
        let w = Dir3::new(self.w.to_vec() + column.dw * step).expect("near a unit vector");
        Beam { p: self.p + column.dx * step, w, ..*self }
    }
    pub fn dx(&self, k: usize) -> Vec3 {
        self.columns.dx.get(k)
    }
    pub fn dw(&self, k: usize) -> Vec3 {
        self.columns.dw.get(k)
    }
    /// Area of the parallelogram of two positional derivatives.
    pub fn area(&self, a: usize, b: usize) -> f64 {
        self.dx(a).cross(self.dx(b)).length()
    }
    /// Free flight: to the point at distance `s`, columns on the plane across the ray.
    pub fn flown(&self, s: f64) -> Beam {
        let across = Normal3::from_unit(self.w.to_vec());
        Beam { p: self.p + self.w * s, columns: transfer(&self.columns, self.w, s, across), ..*self }
    }
    /// Distance at which column `k`, without its part along the ray, is shortest: the caustic of a plane bundle.
    pub fn focus(&self, k: usize) -> f64 {
        let across = self.dx(k) - self.w * self.w.dot(self.dx(k));
        -across.dot(self.dw(k)) / self.dw(k).length_squared()
    }
    /// The three-vector columns behind a surface given by numbers alone.
    pub fn turned(&self, n: Normal3, shape: &ShapeOperator, act: Act) -> Option<Beam> {
        let (w, columns) = match act {
            Act::Land => (self.w, self.columns),
            Act::Mirror => reflect(&self.columns, self.w, n, shape),
            Act::Refract(eta) => match refract(&self.columns, self.w, n, shape, eta) {
                Refraction::Transmitted(w, columns) => (w, columns),
                Refraction::TotalReflection(..) => return None,
            },
        };
        Some(Beam { w, columns, ..*self })
    }
}

/// Surfaces by number.
pub struct Bench {
    pub scene: Scene,
}

impl Bench {
    pub fn new(shapes: Vec<Shape>) -> Bench {
        let still = |shape| ObjectGeometry::Shape { shape, to_world: Transform::IDENTITY };
        Bench { scene: scene(shapes.into_iter().map(still).collect(), vec![]) }
    }

    /// Where a beam meets object `object` after more than a millionth of a metre.
    pub fn meet(&self, beam: &Beam, object: usize) -> Option<Interaction> {
        let ray = Ray { origin: beam.p, direction: beam.w.to_vec(), t_min: 1e-6, t_max: f64::INFINITY, time: 0.0 };
        let t = match &self.scene.objects[object].geometry {
            ObjectGeometry::Mesh { .. } => 1.0, // a plane is found from anywhere
            ObjectGeometry::Shape { shape, to_world } => {
                let own = Ray {
                    origin: to_world.inverse_point(ray.origin),
                    direction: to_world.inverse_vector(ray.direction),
                    ..ray
                };
                shape.intersect(&own)?
            }
        };
        let hit = RawHit { t, object: ObjectId(object as u32), primitive: 0, uv: [1.0 / 3.0; 2] };
        Some(Interaction::from_hit(&self.scene, &ray, &hit)).filter(|at| at.exact)
    }

    /// One leg: fly to an object, act there.
    pub fn leg(&self, beam: &Beam, object: usize, act: Act) -> Option<Beam> {
        let at = self.meet(beam, object)?;
        let landed = Beam { p: at.p, columns: transfer(&beam.columns, beam.w, at.t, at.ng), ..*beam };
        landed.turned(at.ns, &at.shape, act)
    }

    pub fn trace(&self, beam: &Beam, legs: &[(usize, Act)]) -> Option<Beam> {
        legs.iter().try_fold(*beam, |beam, &(object, act)| self.leg(&beam, object, act))
    }
}

/// A disk of radius 1000 in the plane z = `z`.
pub fn floor(z: f64) -> Shape {
    Shape::Disk(Disk::new(Point3::new(0.0, 0.0, z), Vec3::Z, 1000.0).expect("valid"))
}

pub fn unit_ball() -> Shape {
    Shape::Sphere(Sphere::new(Point3::ORIGIN, 1.0).expect("valid"))
}

/// The zero of a function that changes sign between `lo` and `hi`, by halving.
pub fn zero(mut lo: f64, mut hi: f64, f: impl Fn(f64) -> f64) -> f64 {
    let rising = f(hi) > 0.0;
    assert!((f(lo) > 0.0) != rising, "no change of sign between {lo} and {hi}");
    for _ in 0..100 {
        let middle = 0.5 * (lo + hi);
        if (f(middle) > 0.0) == rising { hi = middle } else { lo = middle }
    }
    0.5 * (lo + hi)
}
