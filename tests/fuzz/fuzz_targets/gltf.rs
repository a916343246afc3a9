//! Any bytes as a glTF file: objects whose meshes are there and sound, or problems, never a panic.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| pdembree_fuzz::bounded(bytes.len(), || {
    match pdembree::import::gltf::parse(Path::new("m.gltf"), bytes) {
        Ok(scene) => {
            for described in &scene.meshes {
                let count = described.mesh.positions.len() as u32;
                assert!(described.mesh.triangles.as_flattened().iter().all(|i| *i < count));
            }
        }
        Err(problems) => assert!(!problems.is_empty()),
    }
}));
