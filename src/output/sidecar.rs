//! The birth certificate of a picture: what made it, from what, and what happened on the way. JSON beside the picture.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::atomic;
use super::error::WriteError;
use crate::film::{Cause, Refused};
use crate::scene::texture::TextureReport;

/// Number of the certificate's layout; it grows when a reader of the old one would be misled.
pub const SCHEMA: u32 = 1;

/// Which build rendered.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    pub name: String,
    pub version: String,
    /// Commit of the sources, `-dirty` behind it if they were changed; absent if the build did not know.
    pub commit: Option<String>,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneIdentity {
    pub path: PathBuf,
    /// Digest of the scene's contents, without the settings.
    pub hash: String,
}

impl Program {
    /// This build.
    pub fn this() -> Program {
        Program {
            name: env!("CARGO_PKG_NAME").to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: option_env!("PDEMBREE_COMMIT").map(str::to_owned),
        }
    }
}

impl std::fmt::Display for Program {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let commit = self.commit.as_ref().map_or_else(String::new, |commit| format!(" ({commit})"));
        write!(f, "{} {}{commit}", self.name, self.version)
    }
}

/// Who answered the ray queries.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BackendIdentity {
    pub name: String,
    pub version: String,
}

/// Wall-clock time of one kind of work, all passes together.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Phase {
    pub name: String,
    pub seconds: f64,
}

/// A sample that the film refused.
#[derive(Clone, Debug, Serialize)]
pub struct RefusedPlace {
    pub x: u32,
    pub y: u32,
    pub pass: u32,
    pub cause: &'static str,
}

/// How many samples the film refused, and where the first of them were.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RefusedSamples {
    pub not_a_number: u64,
    pub too_large: u64,
    pub negative: u64,
    pub first: Vec<RefusedPlace>,
}

impl From<&Refused> for RefusedSamples {
    fn from(refused: &Refused) -> RefusedSamples {
        let cause = |cause| match cause {
            Cause::NotANumber => "not_a_number",
            Cause::TooLarge => "too_large",
            Cause::Negative => "negative",
        };
        let place =
            |r: &crate::film::RefusedSample| RefusedPlace { x: r.x, y: r.y, pass: r.pass, cause: cause(r.cause) };
        RefusedSamples {
            not_a_number: refused.not_a_number,
            too_large: refused.too_large,
            negative: refused.negative,
            first: refused.first.iter().map(place).collect(),
        }
    }
}

/// Everything that one needs to trust a picture, or to make it again.
#[derive(Clone, Debug, Default, Serialize)]
pub struct BirthCertificate {
    pub schema: u32,
    pub program: Program,
    /// Command and arguments.
    pub command: Vec<String>,
    pub scene: SceneIdentity,
    /// Pixels.
    pub resolution: [u32; 2],
    /// Every setting by the name that scene files and the command line give it.
    pub settings: BTreeMap<String, serde_json::Value>,
    pub backend: BackendIdentity,
    /// Number of the first pass.
    pub first_pass: u32,
    pub passes: u32,
    /// How noisy the picture is, see `film::Noise`; absent for one pass.
    pub noise: Option<f64>,
    pub photons_emitted: u64,
    pub photons_stored: u64,
    /// What became of photons and rays, by cause.
    pub counters: BTreeMap<String, u64>,
    /// The same for each light, in the order of the scene's lights.
    pub lights: Vec<BTreeMap<String, u64>>,
    /// What became of the photons that may bounce, which bring light that was scattered before.
    pub bounced_photons: BTreeMap<String, u64>,
    /// The same of those whose ways through media become beams, each of which counts as stored; empty where there are none.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub beam_photons: BTreeMap<String, u64>,
    pub refused_samples: RefusedSamples,
    /// Whether its beauty was denoised; what was rendered is then in the layer `noisy`.
    pub denoised: bool,
    /// Digest of all channels of the picture: equal for equal pixels, whatever the file's format.
    pub pixels: String,
    pub warnings: Vec<String>,
    pub threads: usize,
    /// Wall-clock time from the start of the program until the picture was whole.
    pub seconds: f64,
    /// Wall-clock time of the rendering alone, added up over resumes and machines.
    pub render_seconds: f64,
    pub phases: Vec<Phase>,
    /// Peak resident memory of the process.
    pub peak_memory_bytes: Option<u64>,
    /// What textures took; absent where there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub textures: Option<TextureReport>,
    /// Digest of the parts that the picture was put together from.
    pub parts: Option<String>,
}

impl BirthCertificate {
    /// Where the certificate of `picture` stands: `a.exr` → `a.exr.json`.
    pub fn path_beside(picture: &Path) -> PathBuf {
        let mut name = picture.as_os_str().to_owned();
        name.push(".json");
        PathBuf::from(name)
    }

    /// Writes it beside `picture`, whole or not at all.
    pub fn write_beside(&self, picture: &Path) -> Result<(), WriteError> {
        self.write(&BirthCertificate::path_beside(picture))
    }

    /// Writes it to `path`, whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        let unfit = |e: serde_json::Error| WriteError::Unfit { path: path.to_owned(), reason: e.to_string() };
        let mut text = serde_json::to_vec_pretty(self).map_err(unfit)?;
        text.push(b'\n');
        atomic::write(path, &text)
    }

    /// The short form for a picture's own header: name and value. What differs between two runs that must give the
    /// same file (times, threads, the command) is left out unless `with_circumstances`.
    pub fn attributes(&self, with_circumstances: bool) -> Vec<(String, String)> {
        let text = |value: &serde_json::Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let mut all: Vec<(String, String)> =
            self.settings.iter().map(|(name, value)| (name.clone(), text(value))).collect();
        let mut add = |name: &str, value: String| all.push((name.to_owned(), value));
        add("version", self.program.version.clone());
        if let Some(commit) = &self.program.commit {
            add("commit", commit.clone());
        }
        add("sceneHash", self.scene.hash.clone());
        add("photonsEmitted", self.photons_emitted.to_string());
        add("photonsStored", self.photons_stored.to_string());
        add("backendVersion", self.backend.version.clone());
        if with_circumstances {
            add("scene", self.scene.path.display().to_string());
            add("command", self.command.join(" "));
            add("threads", self.threads.to_string());
            add("seconds", format!("{:.3}", self.seconds));
            if let Some(bytes) = self.peak_memory_bytes {
                add("peakMemoryBytes", bytes.to_string());
            }
        }
        all
    }
}
