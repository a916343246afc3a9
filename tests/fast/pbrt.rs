//! pbrt files: what becomes of their cameras, shapes, materials, textures and lights, and what is refused, with its place.

use std::path::Path;

use proptest::prelude::{ProptestConfig, any, prop, proptest};

use pdembree::import::imported::Imported;
use pdembree::import::pbrt::{is_pbrt, parse};
use pdembree::import::{Override, load, load_text};
use pdembree::math::Vec3;
use pdembree::scene::description::{
    CameraModelDescription, LightModel, MaterialModel, Parameter, ShapeDescription, TransformMap,
};
use pdembree::scene::settings::Method;

fn parsed(text: &str) -> Imported {
    parse(Path::new("t.pbrt"), text, false).unwrap_or_else(|problems| panic!("{problems}\n{text}"))
}

fn refused(text: &str) -> String {
    match parse(Path::new("t.pbrt"), text, false) {
        Ok(_) => panic!("it is read: {text}"),
        Err(problems) => problems.to_string(),
    }
}

/// A world of these directives.
fn world(text: &str) -> Imported {
    parsed(&format!("WorldBegin\n{text}"))
}

fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(x, y)| (x - y).abs() <= 1e-9 * (1.0 + y.abs()))
}

/// Of the only object's transform, the image of a point.
fn placed(scene: &Imported, object: usize, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let [step] = &scene.objects[object].transform[..] else { panic!("one step") };
    let TransformMap::Matrix(rows) = step.map else { panic!("a matrix") };
    rows.map(|[a, b, c, t]| a * x + b * y + c * z + t)
}

/// What stands to the right of pbrt's camera, in its left-handed space, stands to the right of ours.
#[test]
fn the_camera_sees_the_same_picture_whether_its_transform_mirrors_or_not() {
    let rest = "LookAt 1 2 3  4 6 3  0 0 1\nCamera \"perspective\" \"float fov\" 60\nWorldBegin\n";
    for (mirror, sign) in [("", 1.0), ("Scale -1 1 1\n", -1.0)] {
        let scene = parsed(&format!("{mirror}{rest}Shape \"sphere\""));
        let camera = &scene.camera;
        let point = |p: [f64; 3]| Vec3::from(placed(&scene, 0, p));
        let eye = Vec3::from(camera.position);
        let ahead = Vec3::from(camera.target) - eye;
        let right = ahead.cross(Vec3::from(camera.up));
        assert!((point([1.0, 2.0, 3.0]) - eye).length() < 1e-12);
        assert!((point([4.0, 6.0, 3.0]) - eye - ahead * 5.0).length() < 1e-12);
        // up × ahead in the file's numbers: to the right, or with the mirror to the left.
        let seen = point([1.0 - 0.8 * sign, 2.0 + 0.6 * sign, 3.0]) - eye;
        assert!((seen - right).length() < 1e-12, "{mirror}: {seen:?} {right:?}");
    }
}

/// fov is that of the shorter side: tan(x/2) = aspect tan(fov/2) in a wide picture.
#[test]
fn the_angle_of_view_is_that_of_the_shorter_side() {
    for (width, height, expected) in
        [(400, 200, 2.0 * (2.0 * 30f64.to_radians().tan()).atan()), (200, 400, 60f64.to_radians())]
    {
        let scene = parsed(&format!(
            "Film \"rgb\" \"integer xresolution\" {width} \"integer yresolution\" {height}\n\
             Camera \"perspective\" \"float fov\" 60 WorldBegin"
        ));
        let CameraModelDescription::Perspective { fov_degrees } = scene.camera.model else { panic!("perspective") };
        assert!((fov_degrees - expected.to_degrees()).abs() < 1e-9, "{width}: {fov_degrees}");
        assert_eq!(scene.camera.resolution, [width, height]);
    }
    let lens = parsed("Camera \"perspective\" \"float lensradius\" .1 \"float focaldistance\" 3 WorldBegin").camera;
    let CameraModelDescription::ThinLens { lens_radius, focus_distance, .. } = lens.model else { panic!("a lens") };
    assert_eq!([lens_radius, focus_distance], [0.1, 3.0]);
    let flat = parsed("Camera \"orthographic\" \"float screenwindow\" [-3.2 3.2 -1.8 1.8] WorldBegin").camera;
    assert_eq!(flat.model, CameraModelDescription::Orthographic { width: 6.4 });
}

#[test]
fn settings_are_taken_over() {
    let scene = parsed(
        "Sampler \"stratified\" \"integer xsamples\" 3 \"integer ysamples\" 2 \"integer seed\" 7\n\
         Integrator \"sppm\" \"integer maxdepth\" 9 \"integer photonsperiteration\" 1234 WorldBegin",
    );
    let s = &scene.settings;
    assert_eq!((s.spp, s.seed, s.max_depth, s.max_bounces, s.photons), (6, 7, 10, 8, 1234));
    assert_eq!(parsed("Integrator \"lightpath\" WorldBegin").settings.method, Method::LightTrace);
}

#[test]
fn transforms_multiply_from_the_right_and_are_restored() {
    let scene = world(
        "Translate 1 0 0 AttributeBegin Rotate 90 0 0 1 Scale 2 2 2 Shape \"sphere\" AttributeEnd\n\
         CoordinateSystem \"here\" Identity ConcatTransform [1 0 0 0  0 1 0 0  0 0 1 0  5 6 7 1] Shape \"sphere\"\n\
         CoordSysTransform \"here\" Shape \"sphere\" Transform [0 0 1 0  1 0 0 0  0 1 0 0  0 0 0 1] Shape \"sphere\"",
    );
    // x is turned over.
    for (object, point, expected) in [
        (0, [1.0, 0.0, 0.0], [-1.0, 2.0, 0.0]),
        (1, [0.0; 3], [-5.0, 6.0, 7.0]),
        (2, [0.0; 3], [-1.0, 0.0, 0.0]),
        (3, [1.0, 2.0, 3.0], [-2.0, 3.0, 1.0]),
    ] {
        assert!(near(placed(&scene, object, point), expected), "{object}: {:?}", placed(&scene, object, point));
    }
}

#[test]
fn instances_show_a_mesh_that_is_kept_once() {
    let scene = world(
        "ObjectBegin \"o\" Translate 0 0 1 Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] ObjectEnd\n\
         Translate 3 0 0 ObjectInstance \"o\" Rotate 180 0 0 1 ObjectInstance \"o\"",
    );
    assert_eq!((scene.objects.len(), scene.meshes.len()), (2, 1));
    assert!(near(placed(&scene, 0, [1.0, 0.0, 0.0]), [-4.0, 0.0, 1.0]));
    assert!(near(placed(&scene, 1, [1.0, 0.0, 0.0]), [-2.0, 0.0, 1.0]));
    assert_ne!(scene.objects[0].name, scene.objects[1].name);
}

fn lights(text: &str) -> Vec<LightModel> {
    world(text).lights.iter().map(|light| light.model.clone()).collect()
}

#[test]
fn lights_have_pbrts_units() {
    use std::f64::consts::PI;
    let [LightModel::Point { position, intensity }] =
        lights("LightSource \"point\" \"rgb I\" [1 2 3] \"point3 from\" [1 2 3] \"float scale\" 2")[..]
    else {
        panic!("a point")
    };
    assert_eq!((position, intensity), ([-1.0, 2.0, 3.0], [2.0, 4.0, 6.0]));
    let [LightModel::Point { intensity, .. }] = lights("LightSource \"point\" \"float power\" 100")[..] else {
        panic!("a point")
    };
    assert!(near(intensity, [100.0 / (4.0 * PI); 3]));
    let [LightModel::Directional { direction, irradiance, .. }] =
        lights("LightSource \"distant\" \"point3 from\" [0 0 2] \"point3 to\" [1 0 0] \"float illuminance\" 7")[..]
    else {
        panic!("a sun")
    };
    assert_eq!((direction, irradiance), ([-1.0, 0.0, -2.0], [7.0; 3]));
    let [LightModel::Environment { radiance }] = lights("LightSource \"infinite\" \"float illuminance\" 2")[..] else {
        panic!("a sky")
    };
    assert!(near(radiance, [2.0 / PI; 3]));
    let [LightModel::Spot { angle_degrees, penumbra_degrees, intensity, .. }] =
        lights("LightSource \"spot\" \"float coneangle\" 60 \"float conedeltaangle\" 60 \"float power\" 3")[..]
    else {
        panic!("a spot")
    };
    // ∫ of the smooth step over the cap: 2π ((1 − 1) + (1 − 1/2)/2) = π/2.
    assert_eq!([angle_degrees, penumbra_degrees], [60.0; 2]);
    assert!(near(intensity, [6.0 / PI; 3]));
    // Rec.709's luminance of a black body is 1, times the scale; it is reddish.
    let [LightModel::Point { intensity: [r, g, b], .. }] =
        lights("LightSource \"point\" \"blackbody I\" 3000 \"float scale\" 5")[..]
    else {
        panic!("a point")
    };
    assert!((0.2126 * r + 0.7152 * g + 0.0722 * b - 5.0).abs() < 0.01 && r > g && g > b, "{r} {g} {b}");
    assert_eq!(lights("LightSource \"point\" \"float scale\" 0"), []);
}

#[test]
fn area_lights_follow_the_state_and_power_is_each_shapes() {
    let scene = world(
        "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"float scale\" 2 \"bool twosided\" true\n\
         Shape \"disk\" AttributeEnd Shape \"disk\"\n\
         AreaLightSource \"diffuse\" \"float power\" 6 Shape \"sphere\" \"float radius\" .5",
    );
    let emissions: Vec<_> =
        scene.objects.iter().map(|o| o.emission.as_ref().map(|e| (e.radiance, e.two_sided))).collect();
    assert_eq!(emissions[..2], [Some(([2.0, 4.0, 6.0], true)), None]);
    // π · (area π) · L = 6.
    let radiance = emissions[2].expect("a lamp").0;
    assert!(near(radiance, [6.0 / std::f64::consts::PI.powi(2); 3]), "{radiance:?}");
    assert!(refused("WorldBegin AreaLightSource \"diffuse\" \"float power\" 6 Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [0 0 0 1 0 0 1 1 0 0 3 0]").contains("whole `power`"));
}

#[test]
fn meshes_face_their_normals_and_orientation_can_be_reversed() {
    let z = |text: &str| {
        let scene = world(text);
        let [a, b, c] = scene.meshes[0].mesh.corners(0);
        (b - a).cross(c - a).z.signum()
    };
    let mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]";
    assert_eq!(z(mesh), 1.0);
    assert_eq!(z(&format!("ReverseOrientation {mesh}")), -1.0);
    assert_eq!(z(&format!("{mesh} \"normal N\" [0 0 -1 0 0 -1 0 0 -2]")), -1.0);
    let scene = world("ReverseOrientation Material \"dielectric\" Shape \"sphere\" Shape \"disk\"");
    assert_eq!(scene.objects[0].material.name, "dielectric (inside out)");
    let turned = scene.materials.iter().find(|m| m.name == "dielectric (inside out)").expect("described");
    assert_eq!(turned.model, MaterialModel::Dielectric { ior: 1.0, exterior: 1.5, fresnel: true });
    let ShapeDescription::Disk { normal, .. } = scene.objects[1].shape else { panic!("a disk") };
    assert_eq!(normal, [0.0, 0.0, -1.0]);
}

/// Areas of parts of round shapes, and of a patch and a subdivided cube of known kind.
#[test]
fn parts_of_shapes_are_meshes_of_their_area() {
    use std::f64::consts::PI;
    for (shape, area, tolerance) in [
        ("\"sphere\" \"float radius\" 2 \"float zmin\" 0", 8.0 * PI, 1e-3),
        ("\"sphere\" \"float phimax\" 90", PI, 1e-3),
        ("\"cylinder\" \"float phimax\" 180 \"float zmax\" 2", 3.0 * PI, 1e-3),
        ("\"disk\" \"float innerradius\" .5", 0.75 * PI, 1e-3),
        ("\"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 3 0 2 3 0]", 6.0, 1e-6),
    ] {
        let scene = world(&format!("Shape {shape}"));
        let found = scene.meshes[0].mesh.area();
        assert!((found - area).abs() < tolerance * area, "{shape}: {found}, not {area}");
        let mesh = &scene.meshes[0].mesh;
        for (prim, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(prim as u32);
            let normal = mesh.normals.get(triangle[0] as usize).map_or([0.0, 0.0, 1.0], |n| n.map(f64::from));
            assert!((b - a).cross(c - a).dot(Vec3::from(normal)) > 0.0, "{shape}: triangle {prim}");
        }
    }
    let bent = world("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]");
    assert_eq!(bent.meshes[0].mesh.triangles.len(), 512);
    let octahedron = "\"integer indices\" [0 1 4 1 2 4 2 3 4 3 0 4 1 0 5 2 1 5 3 2 5 0 3 5] \"point3 P\" [1 0 0 0 1 0 -1 0 0 0 -1 0 0 0 1 0 0 -1]";
    let ball = world(&format!("Shape \"loopsubdiv\" \"integer levels\" 3 {octahedron}"));
    let mesh = &ball.meshes[0].mesh;
    assert_eq!(mesh.triangles.len(), 8 * 64);
    assert_eq!(mesh.positions[0], [0.5, 0.0, 0.0]);
    assert!(mesh.signed_volume() > 0.0);
}

fn model(text: &str) -> MaterialModel {
    let scene = world(&format!("{text} Shape \"sphere\""));
    assert_eq!(scene.materials.len(), 1, "{text}");
    scene.materials[0].model
}

#[test]
fn materials_become_the_models_of_this_house() {
    assert_eq!(model(""), MaterialModel::Lambert { albedo: Parameter::Constant([0.5; 3]) });
    assert_eq!(
        model("Material \"coateddiffuse\" \"rgb reflectance\" [.1 .2 .3] \"float eta\" 1.4"),
        MaterialModel::Plastic { albedo: Parameter::Constant([0.1, 0.2, 0.3]), ior: 1.4 }
    );
    let MaterialModel::RoughConductor { roughness: Parameter::Constant(roughness), .. } =
        model("Material \"conductor\" \"float roughness\" .0625")
    else {
        panic!("rough copper")
    };
    // α = √0.0625 = 1/4, whose artist's number is 1/2.
    assert_eq!(roughness, 0.5);
    let MaterialModel::RoughDielectric { roughness: Parameter::Constant(roughness), .. } =
        model("Material \"dielectric\" \"float roughness\" .25 \"bool remaproughness\" false")
    else {
        panic!("rough glass")
    };
    assert_eq!(roughness, 0.5);
    assert_eq!(
        model("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\""),
        MaterialModel::Dielectric { ior: 1.5168, exterior: 1.0, fresnel: true }
    );
    let MaterialModel::Conductor { eta, k } = model("Material \"conductor\" \"rgb reflectance\" [.5 .5 .5]") else {
        panic!("a smooth metal")
    };
    // r = ((η − 1)² + k²)/((η + 1)² + k²).
    assert!(eta == [1.0; 3] && (k[0] * k[0] / (4.0 + k[0] * k[0]) - 0.5).abs() < 1e-12);
    let MaterialModel::Principled { ior, thin: true, .. } = model("Material \"thindielectric\"") else {
        panic!("thin")
    };
    // F = 0.04 on one face, 2F/(1 + F) on both.
    assert!((((ior - 1.0) / (ior + 1.0)).powi(2) - 0.08 / 1.04).abs() < 1e-12);
    let two = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [1 0 0]\n\
               MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [0 1 0]\n";
    let mixed = format!("{two}Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .25");
    assert_eq!(model(&mixed), MaterialModel::Lambert { albedo: Parameter::Constant([0.75, 0.25, 0.0]) });
    assert_eq!(world("Material \"interface\" Shape \"sphere\"").objects.len(), 0);
    let named = world(&format!("{two}NamedMaterial \"b\" Shape \"sphere\""));
    assert_eq!((named.objects[0].material.name.as_str(), named.materials.len()), ("b", 1));
}

#[test]
fn checks_alternate_from_the_first_at_the_origin() {
    let scene = world(
        "Texture \"c\" \"spectrum\" \"checkerboard\" \"float uscale\" 4 \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 0 1]\n\
         Texture \"d\" \"spectrum\" \"scale\" \"texture tex\" \"c\" \"float scale\" .5\n\
         Material \"diffuse\" \"texture reflectance\" \"d\"\n\
         Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]",
    );
    let image = &scene.textures[0].image;
    let at = |u: f64, v: f64| {
        let [s, t] = image.placement.rows.map(|[a, b, c]| (a * u + b * v + c).rem_euclid(1.0));
        let (width, height) = (image.texels.width(), image.texels.height());
        let (x, y) = ((s * width as f64) as usize, ((1.0 - t) * height as f64) as usize);
        image.texels.texel(y.min(height - 1) * width + x)
    };
    assert_eq!(at(0.1, 0.5), [0.5, 0.0, 0.0]);
    assert_eq!(at(0.3, 0.5), [0.0, 0.0, 0.5]);
    assert_eq!(at(0.6, 0.5), [0.5, 0.0, 0.0]);
    // A mesh without texture coordinates has pbrt's.
    assert_eq!(scene.meshes[0].mesh.uvs, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
}

#[test]
fn what_is_wrong_is_named_with_its_place() {
    for (text, expected) in [
        ("Shap \"sphere\"", "t.pbrt:1:1: there is no directive `Shap` (did you mean Shape?)"),
        (
            "WorldBegin\n  Shape \"sphere\" \"float radus\" 2",
            "t.pbrt:2:18: `radus` is no parameter of Shape \"sphere\" (did you mean `radius`?)",
        ),
        ("WorldBegin Shape \"sphere\" \"float radius\" [1 x]", "t.pbrt:1:45: `x` is no finite number"),
        ("WorldBegin Shape \"sphere\" \"integer radius\" 1", "`radius` must be of type float"),
        ("WorldBegin Shape \"sphere\" \"float radius\" inf", "`inf` is no finite number"),
        ("WorldBegin Shape \"sphere\" \"float radius\" -1", "`radius` is -1 (it must be above 0)"),
        ("WorldBegin Shape \"sphere", "t.pbrt:1:18: this text has no closing quotation mark"),
        ("WorldBegin Shape \"cone\"", "the shape \"cone\" cannot be rendered"),
        ("WorldBegin LightSource \"goniometric\"", "the light \"goniometric\" cannot be rendered"),
        ("WorldBegin LightSource \"projection\"", "the light \"projection\" cannot be rendered"),
        ("WorldBegin Material \"hair\" Shape \"sphere\"", "the material \"hair\" cannot be rendered"),
        ("WorldBegin NamedMaterial \"a\" Shape \"sphere\"", "there is no material \"a\""),
        (
            "WorldBegin Material \"diffuse\" \"texture reflectance\" \"a\" Shape \"sphere\"",
            "there is no spectrum texture \"a\"",
        ),
        ("WorldBegin Material \"diffuse\" \"rgb reflectance\" [2 0 0] Shape \"sphere\"", "reflects [2.0, 0.0, 0.0]"),
        (
            "WorldBegin Material \"conductor\" \"spectrum eta\" \"metal-Ag-et\" Shape \"sphere\"",
            "did you mean \"metal-Ag-eta\"?",
        ),
        ("WorldBegin AttributeBegin", "t.pbrt:1:12: AttributeBegin has no AttributeEnd"),
        ("AttributeEnd", "t.pbrt:1:1: AttributeEnd ends what nothing began"),
        ("WorldBegin AttributeBegin ObjectEnd", "ObjectEnd ends what AttributeBegin at t.pbrt:1:12 began"),
        ("WorldBegin ObjectInstance \"o\"", "there is no object \"o\""),
        ("Shape \"sphere\"", "Shape stands before WorldBegin"),
        ("WorldBegin Camera \"perspective\"", "Camera stands behind WorldBegin"),
        ("LookAt 0 0 0 0 0 0 0 0 1", "LookAt looks nowhere"),
        ("Translate 1 2", "Translate needs 3 numbers"),
        ("Transform [0 0 0 1 0 0 0 0 0 0 0 0 0 0 0 1]", "Transform is no affine map"),
        ("Scale 1 2 1 Camera \"perspective\" WorldBegin", "stretches or flattens"),
        ("Camera \"realistic\" WorldBegin", "the camera \"realistic\" cannot be rendered"),
        ("Film \"image\" WorldBegin", "there is no film \"image\""),
        (
            "WorldBegin Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]",
            "`indices` has 3, but there are 3 vertices",
        ),
        ("WorldBegin Shape \"trianglemesh\" \"point3 P\" [0 0 0 1]", "`P` has 4 numbers, no multiple of 3"),
        ("WorldBegin Shape \"plymesh\" \"string filename\" \"none.ply\"", "cannot read none.ply"),
        ("WorldBegin Include \"none.pbrt\"", "cannot read none.pbrt"),
        ("\"a\"", "t.pbrt:1:1: a directive is missing here"),
    ] {
        let found = refused(text);
        assert!(found.contains(expected), "{text}\nexpected: {expected}\nfound: {found}");
    }
    let two = refused("WorldBegin\nShape \"cone\"\nLightSource \"sun\"");
    assert!(two.contains("t.pbrt:2:1: ") && two.contains("t.pbrt:3:1: "), "{two}");
}

#[test]
fn lenient_reading_leaves_out_what_cannot_be_rendered_but_nothing_that_is_wrong() {
    let text = "WorldBegin LightSource \"goniometric\" LightSource \"point\" Material \"hair\" Shape \"sphere\" Shape \"curve\"";
    let scene = parse(Path::new("t.pbrt"), text, true).map_err(|p| p.to_string()).expect("lenient");
    assert_eq!((scene.objects.len(), scene.lights.len()), (1, 1));
    let told: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
    for what in ["goniometric", "hair", "curve"] {
        assert!(told.iter().any(|warning| warning.contains(what) && warning.contains("t.pbrt:1:")), "{told:?}");
    }
    assert!(parse(Path::new("t.pbrt"), "WorldBegin Shape \"sphere\" \"float radius\" -1", true).is_err());
}

const SCENE: &str = "LookAt 0 -4 2 0 0 0 0 0 1\nCamera \"perspective\" \"float fov\" 40\nWorldBegin\n\
    LightSource \"point\" \"point3 from\" [1 1 4]\nMaterial \"dielectric\"\nAttributeBegin\nShape \"sphere\"\nAttributeEnd\n\
    Texture \"t\" \"float\" \"checkerboard\" \"integer dimension\" 2\nMaterial \"diffuse\" \"rgb reflectance\" [.2 .4 .6]\n\
    Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [-2 -2 -1 2 -2 -1 0 2 -1]\n";

#[test]
fn files_within_files_are_read_and_end() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name);
    let write = |name: &str, text: &str| std::fs::write(file(name), text).expect("written");
    write("a.pbrt", &format!("{SCENE}Include \"b.pbrt\"\nShape \"sphere\"\nImport \"b.pbrt\"\nShape \"sphere\""));
    write("b.pbrt", "Translate 0 0 1\nShape \"sphere\"\n");
    let scene =
        load(&file("a.pbrt"), &[Override::new("camera.resolution", "[4, 3]"), Override::new("render.spp", "2")]);
    let scene = scene.unwrap_or_else(|problems| panic!("{problems}")).scene;
    assert_eq!((scene.objects.len(), scene.settings.spp, scene.camera.resolution), (6, 2, [4, 3]));
    let heights: Vec<f64> = scene.objects[2..].iter().map(|o| o.bounds.centre().z).collect();
    assert_eq!(heights, [1.0, 1.0, 2.0, 1.0], "Include moves what comes after it, Import does not");

    write("loop.pbrt", "WorldBegin Include \"loop2.pbrt\"");
    write("loop2.pbrt", "Include \"loop2.pbrt\" Include \"loop2.pbrt\"");
    let problems = load(&file("loop.pbrt"), &[]).expect_err("endless");
    assert!(problems.to_string().contains("go deeper than 32"), "{problems}");

    let toml = "format = 1\ninclude = \"a.pbrt\"\n[camera]\nresolution = [8, 6]\n[materials.dielectric]\ntype = \"mirror\"\nreflectance = 1\n";
    let included = load_text(&file("s.toml"), toml, &[]).unwrap_or_else(|problems| panic!("{problems}")).scene;
    assert_eq!((included.objects.len(), included.camera.resolution, included.settings.spp), (6, [8, 6], 16));
    assert!(is_pbrt(Path::new("x.PBRT")) && !is_pbrt(Path::new("x.toml")));
}

/// Shapes times instances: a short file, a large scene.
#[test]
fn a_short_file_does_not_become_a_large_scene() {
    let shapes = "Shape \"sphere\"\n".repeat(2000);
    let instances = "ObjectInstance \"o\"\n".repeat(2000);
    let found = refused(&format!("WorldBegin ObjectBegin \"o\"\n{shapes}ObjectEnd\n{instances}"));
    assert!(found.contains("far larger than the files"), "{}", &found[..found.len().min(500)]);
    let cells = "Shape \"loopsubdiv\" \"integer levels\" 10 \"point3 P\" [0 0 0 1 0 0 0 1 0]\n";
    assert!(refused(&format!("WorldBegin {cells}")).contains("far larger than the files"));
}

#[test]
fn deep_and_endless_mixes_end_in_a_message() {
    let text = "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [\"a\" \"a\"] \"float amount\" 1\n\
                NamedMaterial \"a\" Shape \"sphere\"";
    assert!(refused(text).contains("mixes of mixes go deeper"));
    let deep = format!("{}{}", "AttributeBegin ".repeat(100_000), "AttributeEnd ".repeat(100_000));
    parsed(&deep);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn a_damaged_file_is_read_or_refused(
        cuts in prop::collection::vec((any::<prop::sample::Index>(), any::<prop::sample::Index>(), prop::sample::select(vec![
            "", "nan", "-1", "1e300", "[", "]", "\"", "\"float x\"", "Shape", "AttributeEnd", "#", "é", "\\", "0 0 0",
        ])), 1..4),
        lenient in any::<bool>(),
    ) {
        let mut text: Vec<char> = SCENE.chars().collect();
        for (from, length, with) in cuts {
            let start = from.index(text.len() + 1);
            let end = (start + length.index(12)).min(text.len());
            text.splice(start..end, with.chars());
        }
        let text: String = text.into_iter().collect();
        match parse(Path::new("/nonexistent/t.pbrt"), &text, lenient) {
            Ok(scene) => {
                for described in &scene.meshes {
                    let count = described.mesh.positions.len() as u32;
                    assert!(described.mesh.triangles.as_flattened().iter().all(|i| *i < count));
                }
            }
            Err(problems) => assert!(!problems.is_empty()),
        }
    }
}
