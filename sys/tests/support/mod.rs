//! Helpers of the tests: a generator with a printed seed, an icosphere, a sphere as user geometry, brute force.

#![allow(dead_code, reason = "each test binary uses its own part")]

use embree4_sys::{Device, Ray, UserGeometry, UserHit, UserRay};

pub type Vec3 = [f64; 3];

pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn scale(a: Vec3, s: f64) -> Vec3 {
    a.map(|x| x * s)
}

pub fn normalize(a: Vec3) -> Vec3 {
    scale(a, 1.0 / dot(a, a).sqrt())
}

/// A device; `EMBREE4_SYS_TEST_CONFIG` chooses, for example, other instructions: `isa=sse2`. The last bit of a
/// triangle's `t` differs between them, so no test may count on it.
pub fn device() -> Device {
    let config = std::env::var("EMBREE4_SYS_TEST_CONFIG").unwrap_or_default();
    Device::with_config(&config).expect("the tests need a working Embree")
}

pub fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, direction, t_near: 0.0, t_far: f64::INFINITY, time: 0.0 }
}

/// SplitMix64 [Steele et al. 2014]: enough for test inputs, and the seed is the whole state.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2.0_f64.powi(-53)
    }

    /// Uniform in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    pub fn in_cube(&mut self) -> Vec3 {
        [self.signed(), self.signed(), self.signed()]
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let p = self.in_cube();
            if (1e-4..1.0).contains(&dot(p, p)) {
                return normalize(p);
            }
        }
    }
}

/// Spheres, one primitive each, intersected in f64 in closed form.
pub struct Spheres(pub Vec<(Vec3, f64)>);

impl Spheres {
    /// The two roots of |o + t d − c| = r, in order; the numerically stable form.
    pub fn roots(&self, prim: u32, origin: Vec3, direction: Vec3) -> Option<[f64; 2]> {
        let (center, radius) = self.0[prim as usize];
        let (o, a) = (sub(origin, center), dot(direction, direction));
        let b = dot(o, direction);
        // Distance of the centre from the line, without the cancellation of b² − a c.
        let closest = sub(o, scale(direction, b / a));
        let discriminant = a * (radius * radius - dot(closest, closest));
        if discriminant < 0.0 {
            return None;
        }
        let q = -(b + discriminant.sqrt().copysign(b));
        let (t0, t1) = (q / a, (dot(o, o) - radius * radius) / q);
        Some([t0.min(t1), t0.max(t1)])
    }
}

impl UserGeometry for Spheres {
    fn primitives(&self) -> u32 {
        self.0.len() as u32
    }

    fn bounds(&self, prim: u32) -> ([f32; 3], [f32; 3]) {
        let (center, radius) = self.0[prim as usize];
        (center.map(|x| (x - radius) as f32), center.map(|x| (x + radius) as f32))
    }

    fn intersect(&self, prim: u32, ray: &UserRay) -> Option<UserHit> {
        let roots = self.roots(prim, ray.origin, ray.direction)?;
        let t = roots.into_iter().find(|t| (ray.t_near..=ray.t_far).contains(t))?;
        Some(UserHit { t, u: f64::from(prim) + 0.1, v: t / 3.0, part: 0 })
    }
}

/// A unit icosphere, closed, every edge shared by two triangles.
pub fn icosphere(levels: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points: Vec<Vec3> = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ]
    .into_iter()
    .map(normalize)
    .collect();
    let mut faces: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push(normalize(add(points[a as usize], points[b as usize])));
                points.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    (points.into_iter().map(|p| p.map(|x| x as f32)).collect(), faces)
}

/// Nearest triangle in f64: (t, u, v), by Cramer's rule [MollerTrumbore97].
pub fn triangle(corners: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<(f64, f64, f64)> {
    let [a, b, c] = corners;
    let (e1, e2, s) = (sub(b, a), sub(c, a), sub(origin, a));
    let (p, q) = (cross(direction, e2), cross(s, e1));
    let determinant = dot(e1, p);
    let (u, v, t) = (dot(s, p) / determinant, dot(direction, q) / determinant, dot(e2, q) / determinant);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0).then_some((t, u, v))
}

/// Corners of a mesh's triangle.
pub fn corners(vertices: &[[f32; 3]], triangle: [u32; 3]) -> [Vec3; 3] {
    triangle.map(|index| vertices[index as usize].map(f64::from))
}
