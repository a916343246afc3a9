//! Two facts for the program: where Embree is at run time, and which commit it was built from.
//!
//! The header is found and linked by `sys/build.rs`; an Embree outside of the system's
//! folders (`EMBREE_PREFIX`) is not on the loader's path either, so the binaries carry its folder.

use std::path::Path;
use std::process::Command;

/// What the commit stands for: everything that the build reads.
const SOURCES: [&str; 5] = ["src", "sys", "build.rs", "Cargo.toml", "Cargo.lock"];

fn main() {
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
    }
    // Set by embree4-sys (`links = "embree"`) when a prefix was given; absent without the feature.
    if let Ok(folder) = std::env::var("DEP_EMBREE_LIBDIR") {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{folder}");
    }
    tell_commit();
}

/// Sets `PDEMBREE_COMMIT` for birth certificates. Without git or its data nothing is told.
fn tell_commit() {
    // The log of HEAD grows with every commit and checkout. Cargo would run this each time for a file that is missing.
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]).filter(|log| Path::new(log).exists()) {
        println!("cargo::rerun-if-changed={log}");
    }
    let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) else { return };
    let changed = git(&[&["status", "--porcelain", "--"], &SOURCES[..]].concat()).is_none_or(|list| !list.is_empty());
    let mark = if changed { "-dirty" } else { "" };
    println!("cargo::rustc-env=PDEMBREE_COMMIT={commit}{mark}");
}

/// What git printed, or `None` if it failed or is not installed.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
