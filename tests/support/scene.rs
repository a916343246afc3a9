//! Scenes made by hand, for tests that need no importer.

use pdembree::math::{Bounds3, Point3, Ray, Transform, Vec3};
use pdembree::radiometry::Spectrum;
use pdembree::scene::camera::PixelFilter;
use pdembree::scene::{
    CameraModel, CameraSettings, Caustics, LightGroups, LightPhotons, Material, MaterialId, Media, MeshId, Object,
    ObjectGeometry, RenderSettings, Scene, Shutter, Textured, TriangleMesh,
};
use pdembree::shape::Shape;

/// Objects in the given places, all of one matte material; object i is `geometry[i]`.
pub fn scene(geometry: Vec<ObjectGeometry>, meshes: Vec<TriangleMesh>) -> Scene {
    let mesh_bounds: Vec<Bounds3> = meshes.iter().map(TriangleMesh::swept_bounds).collect();
    let object = |geometry: ObjectGeometry| {
        let bounds = geometry.bounds(&mesh_bounds);
        let (name, material, caustics) = ("test object".into(), MaterialId(0), Caustics::default());
        Object { name, geometry, motion: None, bounds, material, light: None, caustics }
    };
    let objects: Vec<Object> = geometry.into_iter().map(object).collect();
    let bounds = objects.iter().fold(Bounds3::EMPTY, |all, object| all.union(object.bounds));
    Scene {
        objects,
        meshes,
        materials: vec![Material::Lambert { albedo: Textured::Constant(Spectrum::ONE) }],
        material_names: vec!["matte".into()],
        textures: vec![],
        media: Media::default(),
        lights: vec![],
        light_motions: vec![],
        light_groups: LightGroups::default(),
        light_photons: LightPhotons::default(),
        camera: CameraSettings {
            model: CameraModel::Perspective { fov_x: 1.0 },
            position: Point3::new(0.0, 0.0, 5.0),
            target: Point3::ORIGIN,
            up: Vec3::Y,
            resolution: [4, 4],
            filter: PixelFilter::Box,
            motion: vec![],
        },
        shutter: Shutter::instant(0.0),
        settings: RenderSettings::default(),
        bounds,
        hash: String::new(),
        contents: String::new(),
    }
}

pub fn shape_scene(shape: Shape, to_world: Transform) -> Scene {
    scene(vec![ObjectGeometry::Shape { shape, to_world }], vec![])
}

pub fn mesh_scene(mesh: TriangleMesh, to_world: Transform) -> Scene {
    scene(vec![ObjectGeometry::Mesh { mesh: MeshId(0), to_world }], vec![mesh])
}

/// A convex polyhedron of 128 triangles in the unit sphere: an octahedron halved twice. Flat.
pub fn geode() -> TriangleMesh {
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    let mut faces: Vec<[Vec3; 3]> = Vec::new();
    for (sx, sy) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
        let (a, b) = if sx * sy > 0.0 { (x * sx, y * sy) } else { (y * sy, x * sx) };
        faces.extend([[a, b, z], [b, a, -z]]);
    }
    for _ in 0..2 {
        faces = faces
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = ((a + b).normalize(), (b + c).normalize(), (c + a).normalize());
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    TriangleMesh {
        colours: Vec::new(),
        deformation: None,
        positions: faces.iter().flatten().map(|p| p.to_array().map(|c| c as f32)).collect(),
        normals: vec![],
        uvs: vec![],
        triangles: (0..faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    }
}

/// A ray from `origin` towards `to`, unit direction.
pub fn ray_towards(origin: Point3, to: Point3) -> Ray {
    Ray { origin, direction: (to - origin).normalize(), t_min: 0.0, t_max: f64::INFINITY, time: 0.0 }
}
