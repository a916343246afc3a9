//! Small worlds and the rays that cross them. Metres.

use std::sync::Arc;

use pdembree::math::{Bounds3, Dir3, Motion, Point3, Ray, Transform, Vec2, Vec3};
use pdembree::sampling::stream::{Purpose, Stream};
use pdembree::scene::deformation::VertexFrame;
use pdembree::scene::{Deformation, MeshId, Object, ObjectGeometry, Scene, Shutter, TriangleMesh};
use pdembree::shape::{Cylinder, Disk, HeightField, Rectangle, Shape, Sphere, Torus, Wave};

/// Numbers of one test case.
pub struct Numbers(Stream);

impl Numbers {
    pub fn new(seed: u64) -> Numbers {
        Numbers(Stream::new(seed, Purpose::Test, 0, 0))
    }
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }
    pub fn index(&mut self, length: usize) -> usize {
        ((self.0.uniform() * length as f64) as usize).min(length - 1)
    }
    pub fn in_cube(&mut self, half: f64) -> Vec3 {
        Vec3::new(self.between(-half, half), self.between(-half, half), self.between(-half, half))
    }
    pub fn direction(&mut self) -> Dir3 {
        loop {
            let v = self.in_cube(1.0);
            if v.length_squared() <= 1.0
                && let Some(direction) = Dir3::new(v)
            {
                return direction;
            }
        }
    }
}

pub fn placed(mesh: u32, to_world: Transform) -> ObjectGeometry {
    ObjectGeometry::Mesh { mesh: MeshId(mesh), to_world }
}

pub fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> TriangleMesh {
    TriangleMesh { positions, triangles, ..TriangleMesh::default() }
}

/// One of each exact shape, within a few metres.
pub fn shapes() -> Vec<(&'static str, Shape)> {
    let at = Point3::new(0.1, -0.2, 0.3);
    let up = Vec3::new(0.2, 1.0, -0.3);
    let wave = |amplitude, x, y, phase| Wave { amplitude, wave_vector: Vec2::new(x, y), phase, rate: 3.0 * amplitude };
    let waves = vec![wave(0.1, 5.0, 1.0, 0.3), wave(0.05, -3.0, 7.0, 1.0)];
    vec![
        ("sphere", Shape::Sphere(Sphere::new(at, 0.9).expect("sound"))),
        ("cylinder", Shape::Cylinder(Cylinder::new(at, at + up, 0.6).expect("sound"))),
        ("torus", Shape::Torus(Torus::new(at, up, 0.8, 0.3).expect("sound"))),
        ("disk", Shape::Disk(Disk::new(at, up, 1.1).expect("sound"))),
        ("rectangle", Shape::Rectangle(Rectangle::new(at, Vec3::X, up.cross(Vec3::X)).expect("sound"))),
        (
            "height field",
            Shape::HeightField(HeightField::new(at, Vec3::X, up, Vec2::new(1.0, 0.7), waves).expect("sound")),
        ),
    ]
}

/// Unconnected triangles of sizes over three decades, some of them slivers.
pub fn soup(seed: u64, count: usize) -> TriangleMesh {
    let mut numbers = Numbers::new(seed);
    let mut positions = Vec::new();
    for i in 0..count {
        let centre = numbers.in_cube(1.0);
        let size = 10f64.powf(numbers.between(-2.5, 0.0));
        let thin = if i % 7 == 0 { 1e-3 } else { 1.0 };
        let (a, b) = (numbers.in_cube(size), numbers.in_cube(size * thin));
        positions.extend([centre, centre + a, centre + b].map(|p| p.to_array().map(|x| x as f32)));
    }
    let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    mesh(positions, triangles)
}

/// A closed unit sphere of 20 · 4^level triangles, counter-clockwise from outside.
pub fn icosphere(level: u32) -> TriangleMesh {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let corners =
        [[-1.0, g, 0.0], [1.0, g, 0.0], [-1.0, -g, 0.0], [1.0, -g, 0.0], [0.0, -1.0, g], [0.0, 1.0, g]].into_iter();
    let corners = corners.chain([[0.0, -1.0, -g], [0.0, 1.0, -g], [g, 0.0, -1.0], [g, 0.0, 1.0]]);
    let corners = corners.chain([[-g, 0.0, -1.0], [-g, 0.0, 1.0]]);
    let mut points: Vec<Vec3> = corners.map(|c| Vec3::from_array(c).normalize()).collect();
    let mut triangles: Vec<[u32; 3]> = vec![
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
    for _ in 0..level {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        let split = |[a, b, c]: [u32; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    mesh(points.into_iter().map(|p| p.to_array().map(|x| x as f32)).collect(), triangles)
}

/// Rotated, scaled differently along each axis, moved; every other one mirrored.
pub fn placements(seed: u64, count: usize) -> Vec<Transform> {
    let mut numbers = Numbers::new(seed);
    let place = |i: usize| {
        let mirror = if i.is_multiple_of(2) { -1.0 } else { 1.0 };
        let factors =
            Vec3::new(mirror * numbers.between(0.2, 1.5), numbers.between(0.2, 1.5), numbers.between(0.2, 1.5));
        let scale = Transform::scale(factors).expect("no factor is zero");
        let turn = Transform::rotate(numbers.direction(), numbers.between(0.0, 6.0));
        Transform::translate(numbers.in_cube(2.0)).compose(&turn).compose(&scale)
    };
    (0..count).map(place).collect()
}

/// A motion of what `placed` has put into the world, over three keys from 0 to 1 s, with wide turns and changes of scale.
pub fn motion(numbers: &mut Numbers, placed: &Transform) -> Motion {
    let mut key = |time| {
        let scale = Vec3::splat(1.0) + numbers.in_cube(0.4);
        let turn = Transform::rotate(numbers.direction(), numbers.between(0.0, 1.4));
        let map = Transform::translate(numbers.in_cube(0.7)).compose(&turn);
        (time, map.compose(&Transform::scale(scale).expect("no factor is zero")))
    };
    Motion::new(&[key(0.0), key(0.3), key(1.0)], placed).expect("turns below half a turn")
}

/// The scene with every object moving from 0 to 1 s, the shutter's interval.
pub fn moving(seed: u64, mut scene: Scene) -> Scene {
    let mut numbers = Numbers::new(seed);
    let meshes: Vec<Bounds3> = scene.meshes.iter().map(TriangleMesh::swept_bounds).collect();
    scene.shutter = Shutter { open: 0.0, close: 1.0 };
    for object in &mut scene.objects {
        let motion = motion(&mut numbers, object.geometry.to_world());
        object.bounds = Object::swept_bounds(&object.geometry, Some(&motion), scene.shutter, &meshes);
        object.motion = Some(Arc::new(motion));
        scene.bounds = scene.bounds.union(object.bounds);
    }
    scene
}

/// The mesh changing its shape over four frames from before 0 to after 1 s: every vertex goes its own way, normals turn.
pub fn deforming(seed: u64, mesh: TriangleMesh) -> TriangleMesh {
    let mut numbers = Numbers::new(seed);
    let mut frame = |_| {
        let mut moved = |v: &[f32; 3]| (Point3::from_f32(*v).to_vec() + numbers.in_cube(0.3)).to_array();
        let positions = mesh.positions.iter().map(|p| moved(p).map(|x| x as f32)).collect();
        let unit = |n: [f64; 3]| Vec3::from_array(n).normalize().to_array().map(|x| x as f32);
        VertexFrame { positions, normals: mesh.normals.iter().map(|n| unit(moved(n))).collect() }
    };
    let frames: Vec<VertexFrame> = (0..4).map(&mut frame).collect();
    let deformation = Deformation { start: -0.2, interval: 0.5, frames };
    let middle = deformation.at(0.5);
    TriangleMesh {
        positions: middle.positions,
        normals: middle.normals,
        deformation: Some(Arc::new(deformation)),
        ..mesh
    }
}

/// Rays at random times from 0 to 1 s towards the cube of the given half width, from near and far; some along an axis, some with a bounded interval.
pub fn rays(seed: u64, count: usize, half: f64) -> Vec<Ray> {
    let mut numbers = Numbers::new(seed);
    let ray = |i: usize| {
        let target = Point3::from_vec(numbers.in_cube(half));
        let distance = half * [0.1, 2.0, 2.0, 50.0][i % 4];
        let direction = match i % 10 {
            0 => [Dir3::X, Dir3::Y, Dir3::Z, -Dir3::X, -Dir3::Y, -Dir3::Z][numbers.index(6)],
            _ => numbers.direction(),
        };
        let ray = Ray::new(target - direction * distance, direction);
        match i % 5 {
            1 => Ray { t_min: distance * 0.9, ..ray },
            2 => Ray { t_max: distance, ..ray },
            _ => ray,
        }
    };
    let rays: Vec<Ray> = (0..count).map(ray).collect();
    rays.into_iter().map(|ray| ray.at_time(numbers.between(0.0, 1.0))).collect()
}
