//! pdembree: a renderer for the light that a glass, a ring or a wave focuses.
//!
//! The modules stand in the order of the data's way; each imports only modules above it:
//!
//! 1. `math`, `radiometry`, `sampling`, `differential`, `shape`: the vocabulary;
//! 2. `scene`, `import`: a scene file becomes a description, a description becomes a scene;
//! 3. `backend`, `surface`, `medium`, `light`: rays fly and meet surfaces and media, lights emit;
//! 4. `photon`: emit → trace → map;
//! 5. `camera`, `estimate`, `film`, `output`: gather → film → EXR;
//! 6. `render`: the conductors; `distribute`: many of them; `study`, `report`: how good a picture is.
#![forbid(unsafe_code)]

pub mod math;
pub mod radiometry;
pub mod sampling;
pub mod differential;
pub mod shape;
pub mod scene;
pub mod import;
pub mod light;
pub mod backend;
pub mod surface;
pub mod medium;
pub mod world;
pub mod photon;
pub mod camera;
pub mod estimate;
pub mod film;
pub mod output;
pub mod render;
pub mod distribute;
pub mod study;
pub mod report;

pub mod doc;
