//! Any text as a scene file: a scene or problems, never a panic. Files that it names are looked for where none are.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|text: &str| pdembree_fuzz::bounded(text.len(), || {
    if let Err(problems) = pdembree::import::load_text(Path::new("/nonexistent/scene.toml"), text, &[]) {
        assert!(!problems.is_empty());
    }
}));
