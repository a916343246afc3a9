//! Bad input: one message with its place for each file of the corpus, and no panic whatever happens to a file.

use std::path::{Path, PathBuf};

use proptest::prelude::{ProptestConfig, any, prop, proptest};
use proptest::strategy::Strategy;

use pdembree::import::obj::{self, Wanted};
use pdembree::import::{load, load_text, ply};

use crate::support::data::root;

fn corpus(folder: &str, extension: &str) -> Vec<PathBuf> {
    let folder = root().join("tests/corpus").join(folder);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == extension));
    files.sort();
    assert!(!files.is_empty(), "{} has no .{extension} file", folder.display());
    files
}

/// Every scene says in its first two lines where its problem is and what is said about it.
#[test]
fn every_invalid_scene_is_refused_with_its_place_and_reason() {
    let mut wrong = Vec::new();
    for path in corpus("invalid", "toml") {
        let text = std::fs::read_to_string(&path).expect("readable");
        let header = |line: usize, key: &str| {
            let value = text.lines().nth(line).and_then(|l| l.strip_prefix(key));
            value.unwrap_or_else(|| panic!("{}: line {} must start with `{key}`", path.display(), line + 1)).to_owned()
        };
        let (place, message) = (header(0, "# at: "), header(1, "# message: "));
        match load(&path, &[]) {
            Ok(_) => wrong.push(format!("{}: loads", path.display())),
            Err(problems) => {
                assert!(!problems.is_empty());
                let expected = |p: &String| p.contains(&format!("/{place}")) && p.contains(&message);
                if !problems.iter().map(ToString::to_string).any(|p| expected(&p)) {
                    wrong.push(format!("{}: expected `{place}` and `{message}`, got\n{problems}", path.display()));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_valid_scene_loads() {
    for path in corpus("valid", "toml") {
        let loaded = load(&path, &[]).unwrap_or_else(|problems| panic!("{problems}"));
        assert!(!loaded.scene.objects.is_empty());
    }
}

#[test]
fn a_missing_scene_is_a_missing_input_and_a_folder_is_no_scene() {
    let problems = load(Path::new("no/such/scene.toml"), &[]).expect_err("missing");
    assert!(problems.only_missing_inputs());
    assert!(problems.to_string().contains("cannot read no/such/scene.toml"), "{problems}");
    assert!(load(root(), &[]).expect_err("a folder").only_missing_inputs());
    let content = load(&root().join("tests/corpus/invalid/no_light.toml"), &[]).expect_err("no light");
    assert!(!content.only_missing_inputs());
}

#[test]
fn deep_nesting_ends_in_a_message() {
    for text in ["[".repeat(100_000), format!("a = {}", "[".repeat(100_000)), format!("a = {}", "{a=".repeat(100_000))]
    {
        load_text(Path::new("deep.toml"), &text, &[]).expect_err("no scene");
    }
}

/// What happens to files.
#[derive(Clone, Debug)]
enum Damage {
    Truncate,
    /// Replaces bytes.
    Overwrite(Vec<u8>),
    Delete(usize),
    /// Repeats a piece.
    Repeat(usize),
}

fn damages() -> impl Strategy<Value = Vec<(f64, Damage)>> {
    let texts = prop::sample::select(vec![
        "nan",
        "inf",
        "-1",
        "0",
        "1e39",
        "99999999999",
        "[",
        "]",
        "\"",
        "\n",
        "=",
        "/",
        "f ",
        "\\",
    ]);
    let one = proptest::prop_oneof![
        proptest::strategy::Just(Damage::Truncate),
        prop::collection::vec(any::<u8>(), 1..4).prop_map(Damage::Overwrite),
        texts.prop_map(|text| Damage::Overwrite(text.as_bytes().to_vec())),
        (1_usize..40).prop_map(Damage::Delete),
        (1_usize..40).prop_map(Damage::Repeat),
    ];
    prop::collection::vec((0.0..1.0_f64, one), 1..5)
}

fn damaged(original: &[u8], damages: &[(f64, Damage)]) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for (place, damage) in damages {
        let at = (place * bytes.len() as f64) as usize;
        let end = |length: usize| (at + length).min(bytes.len());
        match damage {
            Damage::Truncate => bytes.truncate(at),
            Damage::Overwrite(new) => drop(bytes.splice(at..end(new.len()), new.iter().copied())),
            Damage::Delete(length) => drop(bytes.drain(at..end(*length))),
            Damage::Repeat(length) => {
                let piece = bytes[at..end(*length)].to_vec();
                bytes.splice(at..at, piece);
            }
        }
    }
    bytes
}

fn valid(name: &str) -> Vec<u8> {
    std::fs::read(root().join("tests/corpus/valid").join(name)).expect("readable")
}

const BOTH: Wanted = Wanted { normals: true, materials: true };

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_scenes_never_panic(damages in damages(), which in 0_usize..3) {
        let name = ["every_material.toml", "every_shape.toml", "every_light.toml"][which];
        let text = String::from_utf8_lossy(&damaged(&valid(name), &damages)).into_owned();
        if let Err(problems) = load_text(&root().join("tests/corpus/valid").join(name), &text, &[]) {
            assert!(!problems.is_empty());
        }
    }

    #[test]
    fn damaged_objs_never_panic(damages in damages()) {
        let text = String::from_utf8_lossy(&damaged(&valid("two_materials.obj"), &damages)).into_owned();
        let path = root().join("tests/corpus/valid/two_materials.obj");
        match obj::parse(&path, &text, BOTH) {
            Ok(file) => assert_eq!(file.triangle_lines.len(), file.mesh.triangles.len()),
            Err(problems) => assert!(!problems.is_empty()),
        }
    }

    #[test]
    fn damaged_plys_never_panic(damages in damages(), binary in any::<bool>()) {
        let original = valid(if binary { "tetrahedron.ply" } else { "inverted_cube.ply" });
        match ply::parse(Path::new("damaged.ply"), &damaged(&original, &damages), true) {
            Ok(file) => {
                let count = file.mesh.positions.len() as u32;
                assert!(file.mesh.triangles.as_flattened().iter().all(|i| *i < count));
            }
            Err(problems) => assert!(!problems.is_empty()),
        }
    }
}
