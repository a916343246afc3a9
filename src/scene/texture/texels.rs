//! The texels of an image in their place: in memory, or in tiles of a file · linear Rec.709, row 0 at the top.

use std::sync::Arc;

use super::TextureMemory;
use super::memory::{Claim, TILE};
use super::raster::Raster;
use super::samples::{Curve, Kind, Samples};

/// An image's texels. A clone shares them.
#[derive(Clone, Debug)]
pub struct Texels {
    width: usize,
    height: usize,
    place: Place,
    curve: Arc<Curve>,
    memory: TextureMemory,
    /// For the coarser levels of what is whole.
    promise: Option<Arc<Claim>>,
}

#[derive(Clone, Debug)]
enum Place {
    Whole(Arc<Whole>),
    Tiled(Tiles),
}

#[derive(Debug)]
struct Whole {
    samples: Samples,
    _claim: Option<Claim>,
}

/// Tiles of [`TILE`]² texels, row by row, in the textures' file; those at the right and lower borders are filled up.
#[derive(Clone, Copy, Debug)]
struct Tiles {
    start: u64,
    kind: Kind,
    /// Tiles in a row.
    across: usize,
}

impl Tiles {
    fn tile_size(&self) -> usize {
        TILE * TILE * self.kind.size()
    }

    /// Where a tile begins in the file.
    fn at(&self, x: usize, y: usize) -> u64 {
        self.start + ((y * self.across + x) * self.tile_size()) as u64
    }

    /// Writes all of an image; `None` if that cannot be.
    fn write(raster: &Raster, memory: &TextureMemory) -> Option<Tiles> {
        let kind = raster.samples.kind();
        let (across, down) = (raster.width.div_ceil(TILE), raster.height.div_ceil(TILE));
        let mut tiles = Tiles { start: 0, kind, across };
        tiles.start = memory.reserve((across * down * tiles.tile_size()) as u64)?;
        let (row_size, tile_row) = (raster.width * kind.size(), TILE * kind.size());
        for y in 0..down {
            let mut band = vec![0; across * tiles.tile_size()];
            let rows = y * TILE * raster.width..((y + 1) * TILE).min(raster.height) * raster.width;
            for (j, row) in raster.samples.to_bytes(rows).chunks(row_size).enumerate() {
                for (x, part) in row.chunks(tile_row).enumerate() {
                    band[x * tiles.tile_size() + j * tile_row..][..part.len()].copy_from_slice(part);
                }
            }
            if !memory.write(&band, tiles.at(0, y)) {
                return None;
            }
        }
        Some(tiles)
    }
}

impl Texels {
    /// In memory, outside any limit.
    pub fn new(width: usize, height: usize, colours: Vec<[f32; 3]>) -> Texels {
        Texels::place(Raster::of_colours(width, height, colours), &TextureMemory::unlimited())
    }

    /// Whole where there is room for it and its coarser levels or the file fails, else in tiles.
    pub(super) fn place(raster: Raster, memory: &TextureMemory) -> Texels {
        let kind = raster.samples.kind();
        let coarser = (raster.samples.len() * kind.coarser_size()).div_ceil(3) as u64;
        if !is_small(&raster)
            && !memory.has_room(raster.samples.size() + coarser)
            && let Some(tiles) = Tiles::write(&raster, memory)
        {
            return Texels::at(raster, Place::Tiled(tiles), memory, None);
        }
        let promise = Some(Arc::new(memory.claim(coarser)));
        let claim = Some(memory.claim(raster.samples.size()));
        Texels::whole(raster, claim, memory, promise)
    }

    fn whole(mut raster: Raster, claim: Option<Claim>, memory: &TextureMemory, promise: Option<Arc<Claim>>) -> Texels {
        let samples = std::mem::replace(&mut raster.samples, Samples::Grey(Vec::new()));
        Texels::at(raster, Place::Whole(Arc::new(Whole { samples, _claim: claim })), memory, promise)
    }

    fn at(raster: Raster, place: Place, memory: &TextureMemory, promise: Option<Arc<Claim>>) -> Texels {
        let Raster { width, height, curve, .. } = raster;
        Texels { width, height, place, curve, memory: memory.clone(), promise }
    }

    /// A coarser level of this one: in memory if this is, or if it is small.
    pub fn coarser(&self, width: usize, height: usize, colours: Vec<[f32; 3]>) -> Texels {
        let raster = Raster::of_colours(width, height, colours);
        if self.promise.is_some() {
            return Texels::whole(raster, None, &self.memory, self.promise.clone());
        }
        let tiles = if is_small(&raster) { None } else { Tiles::write(&raster, &self.memory) };
        match tiles {
            Some(tiles) => Texels::at(raster, Place::Tiled(tiles), &self.memory, None),
            None => {
                let claim = Some(self.memory.claim(raster.samples.size()));
                Texels::whole(raster, claim, &self.memory, None)
            }
        }
    }

    pub fn width(&self) -> usize {
        self.width
    }

    pub fn height(&self) -> usize {
        self.height
    }

    pub fn len(&self) -> usize {
        self.width * self.height
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What bounds the place that they take.
    pub fn memory(&self) -> &TextureMemory {
        &self.memory
    }

    /// The `k`th texel, row by row.
    pub fn texel(&self, k: usize) -> [f32; 3] {
        self.cursor().texel(k % self.width, k / self.width)
    }

    /// For looking at texels that are close together.
    pub fn cursor(&self) -> Cursor<'_> {
        Cursor { texels: self, near: [const { None }; 4] }
    }

    /// For reading all from the top.
    pub fn rows(&self) -> Rows<'_> {
        Rows { texels: self, band: None, row: Vec::with_capacity(self.width) }
    }

    /// The least and the largest value of each component.
    pub fn extremes(&self) -> [[f32; 3]; 2] {
        let mut rows = self.rows();
        let mut extremes = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for j in 0..self.height {
            for texel in rows.row(j) {
                extremes[0] = std::array::from_fn(|c| extremes[0][c].min(texel[c]));
                extremes[1] = std::array::from_fn(|c| extremes[1][c].max(texel[c]));
            }
        }
        extremes
    }

    /// `f` of the component's number and its value, in each component of each texel; bytes stay where they are.
    pub fn mapped(&self, f: impl Fn(usize, f32) -> f32) -> Texels {
        let kind = match &self.place {
            Place::Whole(whole) => whole.samples.kind(),
            Place::Tiled(tiles) => tiles.kind,
        };
        if let Kind::GreyBytes | Kind::Bytes = kind {
            let coarser = (self.len() * kind.coarser_size()).div_ceil(3) as u64;
            let promise = self.promise.is_some().then(|| Arc::new(self.memory.claim(coarser)));
            return Texels { curve: Arc::new(self.curve.mapped(f)), promise, ..self.clone() };
        }
        let mut colours = Vec::with_capacity(self.len());
        let mut rows = self.rows();
        for j in 0..self.height {
            colours.extend(rows.row(j).iter().map(|texel| [0, 1, 2].map(|c| f(c, texel[c]))));
        }
        Texels::place(Raster::of_colours(self.width, self.height, colours), &self.memory)
    }
}

/// Not larger than a tile would be.
fn is_small(raster: &Raster) -> bool {
    raster.samples.len() <= TILE * TILE
}

/// Equal texels, wherever they are.
impl PartialEq for Texels {
    fn eq(&self, other: &Texels) -> bool {
        let (mut a, mut b) = (self.rows(), other.rows());
        (self.width, self.height) == (other.width, other.height) && (0..self.height).all(|j| a.row(j) == b.row(j))
    }
}

/// Looks at texels that are close together: of each two tiles side by side and above each other it keeps the last.
pub struct Cursor<'a> {
    texels: &'a Texels,
    near: [Option<(u64, Arc<Samples>)>; 4],
}

impl Cursor<'_> {
    /// Indices inside the image.
    pub fn texel(&mut self, i: usize, j: usize) -> [f32; 3] {
        match &self.texels.place {
            Place::Whole(whole) => whole.samples.texel(j * self.texels.width + i, &self.texels.curve),
            Place::Tiled(tiles) => self.tiled(*tiles, i, j),
        }
    }

    fn tiled(&mut self, tiles: Tiles, i: usize, j: usize) -> [f32; 3] {
        let (x, y) = (i / TILE, j / TILE);
        let at = tiles.at(x, y);
        let slot = &mut self.near[y % 2 * 2 + x % 2];
        if slot.as_ref().is_none_or(|(kept, _)| *kept != at) {
            *slot = None;
        }
        let (_, tile) = slot.get_or_insert_with(|| (at, self.texels.memory.tile(at, tiles.kind)));
        tile.texel(j % TILE * TILE + i % TILE, &self.texels.curve)
    }
}

/// Reads rows in their order.
pub struct Rows<'a> {
    texels: &'a Texels,
    /// A row of tiles.
    band: Option<(usize, Samples)>,
    row: Vec<[f32; 3]>,
}

impl Rows<'_> {
    /// The `j`th row. Fast if it is not far below the one before.
    pub fn row(&mut self, j: usize) -> &[[f32; 3]] {
        let Texels { width, place, curve, memory, .. } = self.texels;
        self.row.clear();
        match place {
            Place::Whole(whole) => {
                let samples = &whole.samples;
                self.row.extend((0..*width).map(|i| samples.texel(j * width + i, curve)));
            }
            Place::Tiled(tiles) => {
                let y = j / TILE;
                if self.band.as_ref().is_none_or(|(kept, _)| *kept != y) {
                    self.band = None;
                }
                let read = || (y, memory.passing(tiles.at(0, y), tiles.kind, tiles.across * TILE * TILE));
                let (_, band) = self.band.get_or_insert_with(read);
                let place = |i: usize| i / TILE * TILE * TILE + j % TILE * TILE + i % TILE;
                self.row.extend((0..*width).map(|i| band.texel(place(i), curve)));
            }
        }
        &self.row
    }
}
