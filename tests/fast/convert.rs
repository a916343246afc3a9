//! Files of other programs as scene files: the same scene written again, and what of several things in a file is chosen.

use std::path::{Path, PathBuf};

use pdembree::import::{Override, convert, load, load_text};
use pdembree::scene::Material;
use serde_json::json;

use crate::support::data::{root, shared};
use crate::support::gltf::Gltf;

/// glTF and pbrt files that are sound.
fn files() -> Vec<PathBuf> {
    let entries = |folder: &Path| -> Vec<PathBuf> {
        std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect()
    };
    let mut files = entries(&root().join("tests/corpus/pbrt"));
    for folder in ["gltf/15_transmission", "gltf/17_ior", "gltf/cameras", "gltf/02_node_hierarchy"] {
        files.extend(shared(folder).iter().flat_map(|folder| entries(folder)));
    }
    files.retain(|path| path.extension().is_some_and(|e| e == "gltf" || e == "glb" || e == "pbrt"));
    files
}

/// `convert` compares digests of everything that can change a pixel; here the text is seen to hold what it should, and to be
/// the same scene from another folder.
#[test]
fn converted_files_are_the_same_scenes() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = files();
    assert!(files.len() >= 4, "{files:?}");
    for (i, file) in files.iter().enumerate() {
        let place = folder.path().join(format!("{i}.toml"));
        let converted = convert(file, &place, false).unwrap_or_else(|problems| panic!("{problems}"));
        std::fs::write(&place, &converted.text).expect("written");
        let same = |path: &Path| load(path, &[]).unwrap_or_else(|problems| panic!("{problems}")).scene.hash;
        assert_eq!(same(&place), same(file), "{}:\n{}", file.display(), converted.text);
        for part in ["format = 1\n", "\n[camera]\n", "\n[render]\n", "\n[[lights]]\n"] {
            assert!(converted.text.contains(part), "{}: no {part:?} in\n{}", file.display(), converted.text);
        }
    }
}

/// What is written wins over the file: each number of the text changes the scene.
#[test]
fn a_converted_file_can_be_changed() {
    let file = root().join("tests/corpus/pbrt/materials.pbrt");
    let text = convert(&file, Path::new("s.toml"), false).unwrap_or_else(|problems| panic!("{problems}")).text;
    let place = root().join("tests/corpus/pbrt/s.toml");
    let text = text.replace("tests/corpus/pbrt/", "");
    let hash =
        |text: &str| load_text(&place, text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}")).scene.hash;
    let plain = hash(&text);
    for key in ["fov_degrees = ", "ior = ", "position = ["] {
        let at = text.find(key).unwrap_or_else(|| panic!("no {key} in\n{text}")) + key.len();
        let changed = format!("{}1{}", &text[..at], &text[at..]);
        let changed = if key == "fov_degrees = " { format!("{}1.5\n#{}", &text[..at], &text[at..]) } else { changed };
        assert_ne!(hash(&changed), plain, "{key}");
    }
}

#[test]
fn names_of_any_letters_are_written() {
    let mut file = Gltf::triangle().set("/meshes/0/primitives/0/material", json!(0));
    file.push("materials", json!({"name": "\"ä\\\n\u{7f} 水\""}));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.gltf");
    std::fs::write(&path, file.text()).expect("written");
    let converted =
        convert(&path, &folder.path().join("t.toml"), false).unwrap_or_else(|problems| panic!("{problems}"));
    assert!(converted.text.contains("include = \"t.gltf\"") && converted.text.contains("水"), "{}", converted.text);
}

/// Two cameras and two variants by their names; a wrong name is told with those that there are.
#[test]
fn a_camera_and_a_variant_are_chosen_by_name() {
    let mut file = Gltf::triangle();
    for (node, name) in ["front", "side"].into_iter().enumerate() {
        file.push(
            "cameras",
            json!({"type": "perspective", "perspective": {"yfov": 0.5, "znear": 1}, "name": format!("lens {name}")}),
        );
        file.push("nodes", json!({"camera": node, "name": name, "translation": [node, 0, 5]}));
    }
    for name in ["red", "green"] {
        file.push("materials", json!({"name": name, "pbrMetallicRoughness": {"metallicFactor": 0}}));
    }
    let variants = json!({"mappings": [{"material": 1, "variants": [1]}]});
    let file = file
        .set("/scenes/0/nodes", json!([0, 1, 2]))
        .set("/extensions", json!({"KHR_materials_variants": {"variants": [{"name": "day"}, {"name": "night"}]}}))
        .set("/meshes/0/primitives/0/material", json!(0))
        .set("/meshes/0/primitives/0/extensions", json!({"KHR_materials_variants": variants}));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.gltf");
    std::fs::write(&path, file.text()).expect("written");
    let with =
        |key: &str, name: &str| load(&path, &[Override::new(key, format!("{name:?}"))]).map(|loaded| loaded.scene);
    let sound = |key: &str, name: &str| with(key, name).unwrap_or_else(|problems| panic!("{problems}"));
    for (name, x) in [("front", 0.0), ("side", 1.0), ("lens front", 0.0), ("lens side", 1.0)] {
        assert_eq!(sound("camera.from", name).camera.position.x, x, "{name}");
    }
    for (name, material) in [("day", "red"), ("night", "green")] {
        let scene = sound("variant", name);
        assert!(matches!(scene.materials[..], [Material::Principled { .. }]));
        assert_eq!(scene.material_names, [material], "{name}");
    }
    for (key, name, help) in
        [("camera.from", "sied", "did you mean `side`?"), ("variant", "dusk", "it has: day, night")]
    {
        let said = with(key, name).map(drop).expect_err("no such name").to_string();
        assert!(said.contains(&format!("`{name}`")) && said.contains(help), "{said}");
    }
    let alone = load_text(Path::new("s.toml"), "format = 1\nvariant = \"day\"\n", &[]).map(drop).expect_err("nothing");
    assert!(alone.to_string().contains("s.toml:2:11"), "{alone}");
}
