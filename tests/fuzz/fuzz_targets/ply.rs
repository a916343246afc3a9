//! Any bytes as a PLY file: a mesh whose indices are in range, or problems, never a panic.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| pdembree_fuzz::bounded(bytes.len(), || {
    match pdembree::import::ply::parse(Path::new("m.ply"), bytes, true) {
        Ok(file) => {
            let count = file.mesh.positions.len() as u32;
            assert!(file.mesh.triangles.as_flattened().iter().all(|i| *i < count));
        }
        Err(problems) => assert!(!problems.is_empty()),
    }
}));
