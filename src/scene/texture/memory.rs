//! Memory for textures, bounded: what finds no room lies in tiles of a temporary file and is read when it is looked at.
//!
//! Images are held whole as long as they and their coarser levels fit into three quarters of the limit. From the first one that does
//! not, large images are tiles, and what is left of the limit is for tiles that were read lately. No value depends on where
//! it lies.
//!
//! Lookups cannot fail. Where the file does, they give black and the failure is kept: whoever renders asks for it before a pass counts.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use quick_cache::sync::{Cache, DefaultLifecycle};
use quick_cache::{DefaultHashBuilder, OptionsBuilder, Weighter};
use serde::Serialize;

use super::samples::{Kind, Samples};

/// Texels along a tile.
pub(super) const TILE: usize = 64;

/// The textures' temporary file failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "cannot {doing} the temporary file of textures in {folder}: {reason}; set TMPDIR to a folder on a disk with room, or give more --texture-memory"
)]
pub struct TextureError {
    doing: &'static str,
    folder: String,
    reason: String,
}

/// What textures took, for the birth certificate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct TextureReport {
    /// The limit.
    pub limit_bytes: u64,
    /// Held whole, coarser levels included.
    pub held_bytes: u64,
    /// In the temporary file.
    pub file_bytes: u64,
    /// The most that was held, tiles included.
    pub peak_bytes: u64,
    /// How often a lookup asked for a tile.
    pub tile_lookups: u64,
    /// How often it had to be read.
    pub tile_misses: u64,
}

/// Shared by all images of a scene.
#[derive(Clone)]
pub struct TextureMemory(Arc<Shared>);

struct Shared {
    limit: u64,
    held: AtomicU64,
    peak: AtomicU64,
    /// Made for the first image that has no room.
    store: OnceLock<Option<Store>>,
    failure: OnceLock<TextureError>,
    lookups: AtomicU64,
    misses: AtomicU64,
}

/// The file, and what was read of it.
struct Store {
    file: File,
    length: AtomicU64,
    tiles: Cache<u64, Arc<Samples>, Bytes>,
}

#[derive(Clone)]
struct Bytes;

impl Weighter<u64, Arc<Samples>> for Bytes {
    fn weight(&self, _: &u64, tile: &Arc<Samples>) -> u64 {
        tile.size()
    }
}

impl Store {
    fn new(room: u64) -> io::Result<Store> {
        let file = tempfile::tempfile()?;
        let items = room / (TILE * TILE * Kind::Bytes.size()) as u64;
        let options = OptionsBuilder::new().estimated_items_capacity(items as usize).weight_capacity(room).build();
        let options = options.map_err(|error| io::Error::other(error.to_string()))?;
        let tiles = Cache::with_options(options, Bytes, DefaultHashBuilder::default(), DefaultLifecycle::default());
        Ok(Store { file, length: AtomicU64::new(0), tiles })
    }

    fn read(&self, at: u64, kind: Kind, texels: usize) -> io::Result<Samples> {
        let mut bytes = vec![0; texels * kind.size()];
        self.file.read_exact_at(&mut bytes, at)?;
        Ok(Samples::from_bytes(kind, &bytes))
    }
}

impl TextureMemory {
    /// Without a word from the user.
    pub const USUAL: u64 = 2 << 30;

    /// `limit` in bytes.
    pub fn new(limit: u64) -> TextureMemory {
        TextureMemory(Arc::new(Shared {
            limit,
            held: AtomicU64::new(0),
            peak: AtomicU64::new(0),
            store: OnceLock::new(),
            failure: OnceLock::new(),
            lookups: AtomicU64::new(0),
            misses: AtomicU64::new(0),
        }))
    }

    pub fn unlimited() -> TextureMemory {
        TextureMemory::new(u64::MAX)
    }

    /// The first thing that went wrong.
    pub fn failure(&self) -> Option<&TextureError> {
        self.0.failure.get()
    }

    pub fn report(&self) -> TextureReport {
        let get = |count: &AtomicU64| count.load(Ordering::Relaxed);
        TextureReport {
            limit_bytes: self.0.limit,
            held_bytes: get(&self.0.held),
            file_bytes: self.store().map_or(0, |store| get(&store.length)),
            peak_bytes: get(&self.0.peak),
            tile_lookups: get(&self.0.lookups),
            tile_misses: get(&self.0.misses),
        }
    }

    /// Whether that many bytes may be held.
    pub(super) fn has_room(&self, bytes: u64) -> bool {
        let most = self.0.limit / 4 * 3;
        self.0.store.get().is_none() && self.0.held.load(Ordering::Relaxed).saturating_add(bytes) <= most
    }

    /// Counts bytes as held until the claim is dropped.
    pub(super) fn claim(&self, bytes: u64) -> Claim {
        self.0.held.fetch_add(bytes, Ordering::Relaxed);
        self.note_peak(0);
        Claim { memory: self.clone(), bytes }
    }

    /// With so many bytes that are not counted yet.
    fn note_peak(&self, more: u64) {
        let tiles = more + self.store().map_or(0, |store| store.tiles.weight());
        self.0.peak.fetch_max(self.0.held.load(Ordering::Relaxed) + tiles, Ordering::Relaxed);
    }

    fn store(&self) -> Option<&Store> {
        self.0.store.get().and_then(Option::as_ref)
    }

    /// A place for that many bytes in the file, which is made where there is none yet; `None` after a failure.
    pub(super) fn reserve(&self, bytes: u64) -> Option<u64> {
        let room = self.0.limit.saturating_sub(self.0.held.load(Ordering::Relaxed));
        let store = self.0.store.get_or_init(|| self.noted("make", Store::new(room)));
        Some(store.as_ref()?.length.fetch_add(bytes, Ordering::Relaxed))
    }

    /// Whether it was written.
    pub(super) fn write(&self, bytes: &[u8], at: u64) -> bool {
        self.store().is_some_and(|store| self.noted("write to", store.file.write_all_at(bytes, at)).is_some())
    }

    /// The tile that was written `at` there.
    pub(super) fn tile(&self, at: u64, kind: Kind) -> Arc<Samples> {
        let read = |store: &Store| {
            self.0.misses.fetch_add(1, Ordering::Relaxed);
            let tile = store.read(at, kind, TILE * TILE)?;
            self.note_peak(tile.size());
            Ok(Arc::new(tile))
        };
        self.0.lookups.fetch_add(1, Ordering::Relaxed);
        let found = self.store().and_then(|store| {
            let tile = store.tiles.get_or_insert_with(&at, || read(store));
            self.noted("read", tile)
        });
        found.unwrap_or_else(|| Arc::new(Samples::from_bytes(kind, &vec![0; TILE * TILE * kind.size()])))
    }

    /// Texels that are not worth keeping, as they are read once from end to end.
    pub(super) fn passing(&self, at: u64, kind: Kind, texels: usize) -> Samples {
        let found = self.store().and_then(|store| self.noted("read", store.read(at, kind, texels)));
        found.unwrap_or_else(|| Samples::from_bytes(kind, &vec![0; texels * kind.size()]))
    }

    /// Keeps the first failure.
    fn noted<T>(&self, doing: &'static str, result: io::Result<T>) -> Option<T> {
        result.map_err(|error| self.fail(doing, &error)).ok()
    }

    fn fail(&self, doing: &'static str, error: &io::Error) {
        let folder = std::env::temp_dir().display().to_string();
        self.0.failure.get_or_init(|| TextureError { doing, folder, reason: error.to_string() });
    }

    /// Takes from the file what is in it, as a disk that fails does.
    #[cfg(test)]
    pub(crate) fn break_file(&self) {
        let store = self.store().expect("something is in the file");
        store.file.set_len(0).expect("it can be cut");
        store.tiles.clear();
    }
}

impl Default for TextureMemory {
    fn default() -> TextureMemory {
        TextureMemory::new(TextureMemory::USUAL)
    }
}

impl std::fmt::Debug for TextureMemory {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("TextureMemory").field(&self.report()).finish()
    }
}

/// Bytes that are held.
#[derive(Debug)]
pub(super) struct Claim {
    memory: TextureMemory,
    bytes: u64,
}

impl Drop for Claim {
    fn drop(&mut self) {
        self.memory.0.held.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}
