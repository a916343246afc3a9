//! glTF files: what becomes of their meshes, nodes, cameras, lights and materials, and what is refused.

use std::path::Path;

use proptest::prelude::{ProptestConfig, any, prop, proptest};
use serde_json::{Value, json};

use pdembree::import::gltf::{is_gltf, parse};
use pdembree::import::imported::Imported;
use pdembree::import::{Override, load, load_text};
use pdembree::scene::description::{CameraModelDescription, LightModel, TransformMap};
use pdembree::scene::error::Problems;
use pdembree::scene::{LightSource, TriangleMesh};

use crate::support::data::shared;
use crate::support::gltf::{F32, Gltf, U8, U16, U32, floats, indices};

fn read(file: &Gltf) -> Imported {
    parse(Path::new("t.gltf"), &file.text()).unwrap_or_else(|problems| panic!("{problems}\n{}", file.json))
}

fn refused(bytes: &[u8]) -> String {
    match parse(Path::new("t.gltf"), bytes) {
        Ok(_) => panic!("it is read"),
        Err(problems) => problems.to_string(),
    }
}

fn only_mesh(scene: &Imported) -> &TriangleMesh {
    assert_eq!(scene.meshes.len(), 1);
    &scene.meshes[0].mesh
}

/// A unit square in the xy plane, cut into the triangles of a primitive.
fn square(mode: u32, kind: u32, corners: &[u32]) -> Gltf {
    let mut file = Gltf::new();
    let square = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    let positions = file.accessor("VEC3", F32, 4, &square);
    let corners = file.accessor("SCALAR", kind, corners.len(), &indices(kind, corners));
    file.push(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": positions}, "indices": corners, "mode": mode}]}),
    );
    file
}

#[test]
fn triangles_strips_and_fans_of_any_index_type_are_the_same_square() {
    for (mode, corners) in [(4, vec![0, 1, 2, 0, 2, 3]), (5, vec![0, 1, 3, 2]), (6, vec![0, 1, 2, 3])] {
        for kind in [U8, U16, U32] {
            let scene = read(&square(mode, kind, &corners));
            let mesh = only_mesh(&scene);
            assert_eq!(mesh.area(), 1.0, "mode {mode} type {kind}");
            for prim in 0..2 {
                let [a, b, c] = mesh.corners(prim);
                assert_eq!((b - a).cross(c - a).z, 1.0, "mode {mode} type {kind}: faces +z");
            }
        }
    }
}

#[test]
fn embedded_binary_and_external_buffers_hold_the_same() {
    let file = Gltf::triangle();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a b.bin"), &file.bytes).expect("written");
    let outside = parse(&folder.path().join("t.gltf"), &file.text_with("a%20b.bin")).expect("external");
    let binary = parse(Path::new("t.glb"), &file.glb()).expect("binary");
    let embedded = read(&file);
    assert_eq!(only_mesh(&embedded), only_mesh(&binary));
    assert_eq!(only_mesh(&embedded), only_mesh(&outside));
    // v runs upwards here.
    assert_eq!(only_mesh(&embedded).uvs, [[0.0f32; 2]; 0], "no image, no coordinates");
    let missing = parse(&folder.path().join("t.gltf"), &file.text_with("c.bin")).map(drop).expect_err("no such file");
    assert!(missing.only_missing_inputs() && missing.to_string().contains("c.bin"), "{missing}");
}

#[test]
fn vertices_have_their_colours() {
    for (dimensions, kind, data) in [
        ("VEC3", F32, floats(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0])),
        ("VEC4", U8, [255, 0, 0, 9, 0, 255, 0, 9, 0, 0, 255, 9].to_vec()),
    ] {
        let mut file = Gltf::triangle();
        let colours = file.accessor(dimensions, kind, 3, &data);
        let file = file.set("/meshes/0/primitives/0/attributes/COLOR_0", json!(colours));
        assert_eq!(
            only_mesh(&read(&file)).colours,
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            "{dimensions}"
        );
        let plain = loaded(&Gltf::triangle(), &[]).expect("a scene").scene.hash;
        assert_ne!(loaded(&file, &[]).expect("a scene").scene.hash, plain);
    }
}

#[test]
fn sparse_accessors_replace_some_values_of_what_is_there_or_of_zeros() {
    let sparse = |file: &mut Gltf| {
        let indices = file.view(&indices(U16, &[2]));
        let values = file.view(&floats(&[0.0, 5.0, 0.0]));
        json!({"count": 1, "indices": {"bufferView": indices, "componentType": U16}, "values": {"bufferView": values}})
    };
    let mut file = Gltf::triangle();
    let replaced = sparse(&mut file);
    let file = file.set("/accessors/0/sparse", replaced);
    assert_eq!(only_mesh(&read(&file)).positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 5.0, 0.0]]);

    let mut file = Gltf::triangle();
    let replaced = sparse(&mut file);
    let zeros = json!({"componentType": F32, "count": 3, "type": "VEC3", "sparse": replaced});
    let file = file.set("/accessors/0", zeros);
    assert_eq!(only_mesh(&read(&file)).positions, [[0.0; 3], [0.0; 3], [0.0, 5.0, 0.0]]);
}

/// T R S of a parent and a matrix of its child: a quarter turn about z, doubled, moved, after a move along x.
#[test]
fn nodes_place_their_meshes_by_all_of_their_ancestors() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mut file = Gltf::triangle().set(
        "/nodes/0",
        json!({"translation": [0, 0, 7], "rotation": [0, 0, half, half], "scale": [2, 2, 2], "children": [1, 2]}),
    );
    file.push("nodes", json!({"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]}));
    file.push("nodes", json!({"mesh": 0, "scale": [0, 0, 0]}));
    let scene = read(&file);
    assert_eq!((scene.objects.len(), scene.meshes.len()), (1, 1), "one is scaled to nothing");
    let TransformMap::Matrix(rows) = scene.objects[0].transform[0].map else { panic!("a matrix") };
    // (x, y, z) ↦ 2 (−y, x + 3, z) + (0, 0, 7).
    let expected = [[0.0, -2.0, 0.0, 0.0], [2.0, 0.0, 0.0, 6.0], [0.0, 0.0, 2.0, 7.0]];
    for (found, expected) in rows.as_flattened().iter().zip(expected.as_flattened()) {
        assert!((found - expected).abs() < 1e-6, "{rows:?}");
    }
}

#[test]
fn a_mesh_that_is_shown_twice_is_kept_once() {
    let mut file = Gltf::triangle().set("/scenes/0/nodes", json!([0, 1]));
    file.push("nodes", json!({"mesh": 0, "translation": [0, 0, 1]}));
    let scene = read(&file);
    assert_eq!((scene.objects.len(), scene.meshes.len()), (2, 1));
    assert_ne!(scene.objects[0].name, scene.objects[1].name);
}

fn with_camera(camera: Value) -> Gltf {
    let mut file = Gltf::triangle().set("/scenes/0/nodes", json!([0, 1]));
    // A quarter turn about y: −z becomes −x.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    file.push("nodes", json!({"camera": 0, "translation": [4, 0, 0], "rotation": [0, half, 0, half]}));
    file.push("cameras", camera);
    file
}

/// tan(x/2) = aspect · tan(y/2).
#[test]
fn cameras_look_along_their_z_with_the_width_of_their_angle() {
    let file = with_camera(json!({"type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 2, "znear": 1}}));
    let camera = read(&file).camera;
    let CameraModelDescription::Perspective { fov_degrees } = camera.model else { panic!("{:?}", camera.model) };
    let expected = 2.0 * (2.0 * 0.35f64.tan()).atan().to_degrees();
    assert!((fov_degrees - expected).abs() < 1e-5, "{fov_degrees}, not {expected}");
    assert_eq!(camera.resolution, [960, 480]);
    for (found, expected) in [(camera.position, [4.0, 0.0, 0.0]), (camera.target, [3.0, 0.0, 0.0])] {
        assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-6), "{found:?}");
    }
    let file =
        with_camera(json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 3, "zfar": 9, "znear": 0}}));
    let camera = read(&file).camera;
    assert_eq!(camera.model, CameraModelDescription::Orthographic { width: 2.0 });
    assert_eq!(camera.resolution, [320, 960]);
}

#[test]
fn candela_and_lux_become_watts() {
    let lights = json!([
        {"type": "point", "intensity": 683, "color": [1, 0.5, 0]},
        {"type": "directional", "intensity": 1366},
        {"type": "spot", "intensity": 68.3, "range": 9, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}},
        {"type": "point", "intensity": 0},
    ]);
    let mut file = Gltf::triangle().set("/scenes/0/nodes", json!([0, 1, 2, 3, 4]));
    for i in 0..4 {
        let node = json!({"translation": [0, i, 0], "extensions": {"KHR_lights_punctual": {"light": i}}});
        file.push("nodes", node);
    }
    let file = file
        .set("/extensionsUsed", json!(["KHR_lights_punctual"]))
        .set("/extensions", json!({"KHR_lights_punctual": {"lights": lights}}));
    let scene = read(&file);
    let models: Vec<LightModel> = scene.lights.iter().map(|light| light.model.clone()).collect();
    let [LightModel::Point { intensity, .. }, LightModel::Directional { irradiance, direction, .. }, ref spot] =
        models[..]
    else {
        panic!("{models:?}")
    };
    let LightModel::Spot { position, target, intensity: in_cone, angle_degrees, penumbra_degrees } = *spot else {
        panic!("{spot:?}")
    };
    assert_eq!(intensity, [1.0, 0.5, 0.0]);
    assert_eq!(irradiance, [2.0; 3]);
    assert_eq!(direction, [0.0, 0.0, -1.0]);
    assert!((in_cone[0] - 0.1).abs() < 1e-6);
    assert_eq!((position, target), ([0.0, 2.0, 0.0], [0.0, 2.0, -1.0]));
    assert!((angle_degrees - 0.5f64.to_degrees()).abs() < 1e-5, "{angle_degrees}");
    assert!((penumbra_degrees - 0.3f64.to_degrees()).abs() < 1e-5, "{penumbra_degrees}");
    let warning = scene.warnings[0].to_string();
    assert!(warning.contains("lights of intensity 0; the range of lights"), "{warning}");
}

#[test]
fn emissive_meshes_are_area_lights_of_their_strength() {
    let mut file = Gltf::triangle().set("/meshes/0/primitives/0/material", json!(0));
    let strength = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 8.0}});
    let material = json!({"emissiveFactor": [1, 0.5, 0], "doubleSided": true, "extensions": strength});
    file.push("materials", material);
    let emission = read(&file).objects[0].emission.clone().expect("a light");
    assert_eq!((emission.radiance, emission.two_sided), ([8.0, 4.0, 0.0], true));
}

/// After the distance, 0.5 m, the colour is what is left: σ_a = −ln(c)/0.5. Thin glass and what is not coloured has no inside.
#[test]
fn the_attenuation_of_solid_glass_is_a_medium_that_absorbs() {
    let glass = |thickness: f64, colour: [f64; 3]| {
        let volume = json!({"thicknessFactor": thickness, "attenuationDistance": 0.5, "attenuationColor": colour});
        let extensions =
            json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_volume": volume});
        let material = json!([{"name": "glass", "extensions": extensions}]);
        read(&Gltf::triangle().set("/materials", material).set("/meshes/0/primitives/0/material", json!(0)))
    };
    let coloured = glass(1.0, [0.5, 1.0, 0.25]);
    let [medium] = &coloured.media[..] else { panic!("{:?}", coloured.media) };
    let ln2 = std::f64::consts::LN_2;
    for (sigma, expected) in medium.sigma_a.into_iter().zip([2.0 * ln2, 0.0, 4.0 * ln2]) {
        assert!((sigma - expected).abs() < 1e-12, "{sigma}, not {expected}");
    }
    assert_eq!(medium.sigma_s, [0.0; 3]);
    let interior = coloured.materials[0].interior.as_ref().and_then(|i| i.medium.as_ref()).expect("a medium inside");
    assert_eq!(interior.name, medium.name);
    assert!(glass(0.0, [0.5, 1.0, 0.25]).media.is_empty());
    assert!(glass(1.0, [1.0; 3]).media.is_empty());
}

#[test]
fn what_is_ignored_is_listed_once_by_name() {
    let mut file = Gltf::triangle()
        .set("/extensionsUsed", json!(["KHR_materials_sheen", "EXT_other"]))
        .set("/extensionsRequired", json!(["KHR_materials_sheen"]))
        .set("/meshes/0/primitives/0/material", json!(0));
    file.push("materials", json!({"occlusionTexture": {"index": 0}}));
    file.push("textures", json!({"source": 0}));
    file.push("images", json!({"uri": "unread.png"}));
    file.push("animations", json!({"channels": [], "samplers": []}));
    let warnings: Vec<String> = read(&file).warnings.iter().map(ToString::to_string).collect();
    assert_eq!(warnings, ["t.gltf: not rendered: EXT_other; KHR_materials_sheen; animations; occlusionTexture"]);
}

/// A change of a sound file, and what is said about it.
#[test]
fn files_that_break_the_format_are_refused_with_what_is_wrong() {
    let attributes = "/meshes/0/primitives/0/attributes";
    for (pointer, value, message) in [
        ("/asset/version", json!("1.0"), "this is glTF 1.0"),
        ("/scene", json!("a"), "invalid type"),
        ("/scene", json!(4), "`scene` names something that is not in the file"),
        ("/nodes/0/mesh", json!(7), "`nodes[0].mesh` names something that is not in the file"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(9), "attributes.POSITION` names something that is not"),
        ("/textures", json!([{"source": 0}]), "`textures[0].source` names something that is not in the file"),
        ("/images", json!([{"bufferView": 0}]), "`images[0]` needs a `uri`, or a `bufferView` with its `mimeType`"),
        ("/images", json!([{}]), "`images[0]` needs a `uri`"),
        (
            "/nodes/0/extensions",
            json!({"KHR_lights_punctual": {"light": 0}}),
            "`nodes[0].extensions.KHR_lights_punctual.light` names something that is not in the file",
        ),
        ("/nodes/0/children", json!([0]), "nodes[0] has two parents, or is its own ancestor"),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "requires the extension KHR_draco_mesh_compression",
        ),
        ("/meshes/0/primitives/0/mode", json!(9), "has a value that the format does not know"),
        (attributes, json!({}), "is missing"),
        (attributes, json!({"POSITION": 1}), "accessors[1] holds Vec2 of F32"),
        ("/accessors/0/count", json!(0), "accessors[0]"),
        ("/accessors/0/count", json!(4), "accessors[0] reaches out of its buffer view"),
        ("/accessors/0/count", json!(4_000_000_000_u64), "accessors[0] reaches out of its buffer view"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "accessors[0] reaches out of its buffer view"),
        ("/accessors/0/componentType", json!(U16), "accessors[0] holds Vec3 of U16"),
        ("/bufferViews/0/byteLength", json!(4000), "accessors[0] reaches out of its buffer view"),
        ("/bufferViews/0/byteStride", json!(4), "accessors[0] reaches out of its buffer view"),
        ("/buffers", json!([{"byteLength": 99}]), "buffers[0]: it has no `uri`"),
        ("/buffers", json!([{"byteLength": 99, "uri": "data:;base64,AAAA"}]), "should have 99 bytes, but there are 3"),
        ("/buffers", json!([{"byteLength": 9, "uri": "https://example.org/a"}]), "is no file beside this one"),
    ] {
        let said = refused(&Gltf::triangle().set(pointer, value.clone()).text());
        assert!(said.starts_with("t.gltf") && said.contains(message), "{pointer} = {value}: {said}");
    }
    for (file, message) in [
        (square(4, U16, &[0, 1, 4]), "an index is 4, but there are 4 vertices"),
        (square(4, U16, &[0, 1, 2, 3]), "4 corners make no triangles"),
    ] {
        let said = refused(&file.text());
        assert!(said.contains("meshes[0].primitives[0]") && said.contains(message), "{said}");
    }
}

#[test]
fn no_claim_makes_the_reader_allocate_far_more_than_the_file_holds() {
    let zeros = json!({"componentType": F32, "count": 4_000_000_000_u64, "type": "VEC3"});
    let mut file = Gltf::triangle();
    let (i, v) = (file.view(&indices(U32, &[2])), file.view(&floats(&[0.0; 3])));
    let sparse = json!({"count": 1, "indices": {"bufferView": i, "componentType": U32}, "values": {"bufferView": v}});
    let file = file.set("/accessors/0", zeros).set("/accessors/0/sparse", sparse);
    assert!(refused(&file.text()).contains("more than the file has bytes"));

    let mut file = Gltf::triangle();
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    file.json["meshes"][0]["primitives"] = Value::Array(vec![primitive; 1000]);
    assert!(refused(&file.text()).contains("far larger than the buffers they lie in"));
}

fn loaded(file: &Gltf, overrides: &[Override]) -> Result<pdembree::import::Loaded, Problems> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.glb");
    std::fs::write(&path, file.glb()).expect("written");
    assert!(is_gltf(&path));
    load(&path, overrides)
}

/// Without camera and lights there are stand-ins and words about them; settings and single values of the camera come from
/// the command line.
#[test]
fn a_file_alone_is_a_scene() {
    let overrides = [Override::new("render.spp", "3"), Override::new("camera.resolution", "[12, 8]")].to_vec();
    let all = loaded(&Gltf::triangle(), &overrides).expect("a scene");
    let said: Vec<String> = all.warnings.iter().map(ToString::to_string).collect();
    assert!(said.iter().any(|w| w.contains("has no light")), "{said:?}");
    let scene = all.scene;
    assert_eq!((scene.settings.spp, scene.camera.resolution), (3, [12, 8]));
    assert!(matches!(scene.lights[..], [LightSource::Environment { .. }, LightSource::Directional { .. }]));
    let (centre, radius) = scene.bounds.bounding_sphere();
    let ahead = (scene.camera.target - scene.camera.position).normalize();
    assert!((scene.camera.target - centre).length() < 1e-6 * radius && ahead.z < -0.8, "{:?}", scene.camera);
    let alone = loaded(&Gltf::triangle(), &[]).expect("a scene");
    assert!(alone.warnings.iter().any(|w| w.to_string().contains("has no camera")));
    assert_ne!(alone.scene.hash, scene.hash);
    let wrong = loaded(&Gltf::triangle(), &[Override::new("render.spp", "0.5")]).map(drop).expect_err("half a sample");
    assert!(wrong.to_string().contains("-D render.spp=0.5"), "{wrong}");
}

/// A scene file takes a glTF file in and has its own word on materials, lights and single values of the camera.
#[test]
fn a_scene_file_includes_a_gltf_file_and_overrides_it() {
    let light = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    let mut file = with_camera(json!({"type": "perspective", "perspective": {"yfov": 0.7, "znear": 1}}))
        .set("/meshes/0/primitives/0/material", json!(0))
        .set("/extensions", light)
        .set("/nodes/0/extensions", json!({"KHR_lights_punctual": {"light": 0}}));
    file.push("materials", json!({"name": "Paint"}));
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("t.glb"), file.glb()).expect("written");
    let scene = |text: &str| {
        let text = format!("format = 1\ninclude = \"t.glb\"\n{text}");
        load_text(&folder.path().join("s.toml"), &text, &[])
    };
    let plain = scene("").unwrap_or_else(|problems| panic!("{problems}")).scene;
    assert!(matches!(plain.lights[..], [LightSource::Point { .. }]));
    assert_eq!((plain.camera.resolution, plain.camera.position.x), ([960, 720], 4.0));
    let own = "[camera]\nresolution = [4, 3]\n[materials.Paint]\ntype = \"mirror\"\nreflectance = 0.5\n\
               [[objects]]\nshape = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1\nmaterial = \"Paint\"\n\
               [[lights]]\ntype = \"environment\"\nradiance = 1\n";
    let own = scene(own).unwrap_or_else(|problems| panic!("{problems}")).scene;
    assert!(matches!(own.lights[..], [LightSource::Environment { .. }]));
    assert_eq!((own.camera.resolution, own.camera.position.x), ([4, 3], 4.0));
    assert!(own.objects.len() == 2 && matches!(own.materials[..], [pdembree::scene::Material::Mirror { .. }]));
    for (name, message) in [("x.gltf", "cannot read"), ("x.obj", "`x.obj` is no file that can be included")] {
        let text = format!("format = 1\ninclude = \"{name}\"\n");
        let said = load_text(&folder.path().join("s.toml"), &text, &[]).map(drop).expect_err("no file").to_string();
        assert!(said.contains("s.toml:2:11") && said.contains(message), "{said}");
    }
}

#[test]
fn the_invalid_files_of_the_shared_data_are_refused() {
    for (name, message) in [
        ("IncorrectVertexArrays/Cube.gltf", "35 corners make no triangles"),
        ("IndexOutOfRange/AllIndicesOutOfRange.gltf", "an index is 65535"),
        ("IndexOutOfRange/IndexOutOfRange.gltf", "an index is 255"),
        ("MissingBin/BoxTextured.gltf", "cannot read"),
        ("SchemaFailures/sceneWrongType.gltf", "invalid type: string \"hello\""),
    ] {
        let Some(path) = shared(&format!("gltf/invalid/{name}")) else { return };
        let problems = load(&path, &[]).map(drop).expect_err("refused");
        let said = problems.to_string();
        assert!(problems.len() == 1 && said.contains(name.split('/').next_back().expect("a name")), "{said}");
        assert!(said.contains(message), "{said}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_never_panic(places in prop::collection::vec((0.0..1.0_f64, any::<u8>()), 1..6), binary in any::<bool>()) {
        let file = square(4, U16, &[0, 1, 2, 0, 2, 3]);
        let mut bytes = if binary { file.glb() } else { file.text() };
        for (place, byte) in places {
            let at = (place * bytes.len() as f64) as usize;
            // Digits are what numbers are made of.
            bytes[at] = if byte < 128 { b'0' + byte % 10 } else { byte };
        }
        if let Err(problems) = parse(Path::new("damaged.gltf"), &bytes) {
            assert!(!problems.is_empty());
        }
    }
}
