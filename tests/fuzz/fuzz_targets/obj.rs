//! Any text as an OBJ file: a mesh whose indices are in range, or problems, never a panic.
#![no_main]

use std::path::Path;

use pdembree::import::obj::{Wanted, parse};

libfuzzer_sys::fuzz_target!(|text: &str| pdembree_fuzz::bounded(text.len(), || {
    for normals in [false, true] {
        match parse(Path::new("/nonexistent/m.obj"), text, Wanted { normals, materials: true }) {
            Ok(file) => {
                let count = file.mesh.positions.len() as u32;
                assert!(file.mesh.triangles.as_flattened().iter().all(|i| *i < count));
                assert_eq!(file.triangle_lines.len(), file.mesh.triangles.len());
            }
            Err(problems) => assert!(!problems.is_empty()),
        }
    }
}));
