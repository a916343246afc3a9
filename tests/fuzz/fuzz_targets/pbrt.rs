//! Any text as a pbrt file: objects whose meshes are there and sound, or problems, never a panic.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|text: &str| pdembree_fuzz::bounded(text.len(), || {
    for lenient in [false, true] {
        match pdembree::import::pbrt::parse(Path::new("/nonexistent/s.pbrt"), text, lenient) {
            Ok(scene) => {
                for described in &scene.meshes {
                    let count = described.mesh.positions.len() as u32;
                    assert!(described.mesh.triangles.as_flattened().iter().all(|i| *i < count));
                }
            }
            Err(problems) => assert!(!problems.is_empty()),
        }
    }
}));
