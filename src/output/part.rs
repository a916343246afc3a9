//! A render in the middle, as a file: what it belongs to, which passes and pixels it holds, and its sums.
//!
//! Checkpoints and the parts that a farm renders are the same thing. The file is, in this order: [`MAGIC`]; the length of
//! the header as a little-endian `u64`; the header, JSON; the sums, little-endian and squeezed by Zstandard; BLAKE3 of all
//! before. A file that is cut or changed anywhere has another digest and is refused.

use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::atomic;
use super::error::{PartError, WriteError};
use super::sidecar::{BackendIdentity, Program, SceneIdentity};
use crate::film::{Film, FilmShape};

/// The first bytes of every part; the number grows with the layout.
pub const MAGIC: &[u8; 16] = b"pdembree part 1\n";

/// The usual ending of a part's name.
pub const EXTENSION: &str = "pdpart";

const DIGEST: usize = 32;

/// How hard to squeeze: the fastest. Half of the bytes are noise that no level makes smaller.
const LEVEL: i32 = 1;

/// What has to be the same for two renders to be parts of one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    pub program: Program,
    pub backend: BackendIdentity,
    /// Digest of the scene's contents.
    pub contents: String,
    pub resolution: [u32; 2],
    /// Every setting by its name, but for the number of passes.
    pub settings: BTreeMap<String, serde_json::Value>,
}

impl Identity {
    /// What differs from `other`, in words; nothing if both are parts of one render.
    pub fn differences(&self, other: &Identity) -> Vec<String> {
        let mut found = Vec::new();
        let mut differ = |name: &str, mine: &dyn fmt::Display, others: &dyn fmt::Display| {
            found.push(format!("{name}: {mine} and {others}"));
        };
        if self.program != other.program {
            differ("program", &self.program, &other.program);
        }
        if self.backend != other.backend {
            differ("backend", &self.backend.version, &other.backend.version);
        }
        if self.resolution != other.resolution {
            let size = |[w, h]: [u32; 2]| format!("{w} x {h}");
            differ("resolution", &size(self.resolution), &size(other.resolution));
        }
        let mut names: Vec<&String> = self.settings.keys().chain(other.settings.keys()).collect();
        names.sort();
        names.dedup();
        for name in names {
            let [mine, others] = [self, other].map(|who| who.settings.get(name).cloned().unwrap_or_default());
            if mine != others {
                differ(name, &mine, &others);
            }
        }
        if self.contents != other.contents {
            let short = |digest: &str| digest.get(..12).unwrap_or(digest).to_owned();
            differ("scene contents", &short(&self.contents), &short(&other.contents));
        }
        found
    }
}

/// What is known of a render in the middle, beside its film.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartInfo {
    pub identity: Identity,
    /// Where the scene came from.
    pub scene: SceneIdentity,
    /// Passes of the whole render, as far as whoever rendered this knew.
    pub wanted_passes: u32,
    /// What the render did so far; its conductor writes and reads it.
    pub report: serde_json::Value,
}

/// A render in the middle.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    pub info: PartInfo,
    pub film: Film,
}

#[derive(Serialize, Deserialize)]
struct Header {
    info: PartInfo,
    film: FilmShape,
}

/// Writes a part, whole or not at all.
pub fn write(path: &Path, info: &PartInfo, film: &Film) -> Result<(), WriteError> {
    atomic::write_with(path, |file| encode(BufWriter::new(file), info, film))
}

/// Writes a part's bytes to `out`.
pub fn encode(out: impl Write, info: &PartInfo, film: &Film) -> io::Result<()> {
    let header = Header { info: info.clone(), film: film.shape() };
    let header = serde_json::to_vec(&header)?;
    let mut out = Hashing { out, hasher: blake3::Hasher::new() };
    out.write_all(MAGIC)?;
    out.write_all(&(header.len() as u64).to_le_bytes())?;
    out.write_all(&header)?;
    let mut squeezed = zstd::Encoder::new(&mut out, LEVEL)?;
    film.write_sums(&mut squeezed)?;
    squeezed.finish()?;
    let digest = out.hasher.finalize();
    out.out.write_all(digest.as_bytes())?;
    out.out.flush()
}

/// Reads a part.
///
/// # Errors
/// There is no such file, it is none of ours, it is of another layout, or it is not whole.
pub fn read(path: &Path) -> Result<Part, PartError> {
    let bytes = std::fs::read(path).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => PartError::Missing { path: path.to_owned() },
        _ => PartError::Io { path: path.to_owned(), source },
    })?;
    decode(&bytes, path)
}

/// Reads a part from its bytes, which came from `path`.
pub fn decode(bytes: &[u8], path: &Path) -> Result<Part, PartError> {
    let damaged = |reason: &str| PartError::Damaged { path: path.to_owned(), reason: reason.to_owned() };
    if !bytes.starts_with(MAGIC) {
        let same_kind = MAGIC.iter().zip(bytes).take_while(|(a, b)| a == b).count();
        return Err(match same_kind {
            n if n == bytes.len() => damaged("it ends within its first bytes"),
            // All but the number.
            14.. => PartError::OtherLayout { path: path.to_owned() },
            _ => PartError::NotAPart { path: path.to_owned() },
        });
    }
    let (content, digest) =
        bytes.split_at_checked(bytes.len().saturating_sub(DIGEST)).ok_or_else(|| damaged("it is too short"))?;
    if content.len() < MAGIC.len() + 8 || blake3::hash(content).as_bytes() != digest {
        return Err(damaged("its digest is not that of its content"));
    }
    let rest = &content[MAGIC.len()..];
    let (length, rest) = rest.split_first_chunk::<8>().ok_or_else(|| damaged("it has no header"))?;
    let length = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX);
    let (header, sums) = rest.split_at_checked(length).ok_or_else(|| damaged("its header is cut"))?;
    let header: Header = serde_json::from_slice(header).map_err(|e| damaged(&e.to_string()))?;
    let mut sums = zstd::Decoder::with_buffer(sums).map_err(|e| damaged(&e.to_string()))?;
    let film = Film::read_sums(&header.film, &mut sums).map_err(|e| damaged(&e.to_string()))?;
    match sums.read(&mut [0]) {
        Ok(0) => {}
        _ => return Err(damaged("there is more in it than its header says")),
    }
    Ok(Part { info: header.info, film })
}

/// The digest at the end of a part's file, as it stands there; none where there is no part.
pub fn digest(path: &Path) -> Option<[u8; DIGEST]> {
    std::fs::read(path).ok()?.last_chunk().copied()
}

/// Passes bytes on and digests them.
struct Hashing<W> {
    out: W,
    hasher: blake3::Hasher,
}

impl<W: Write> Write for Hashing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
