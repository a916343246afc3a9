//! A picture cut into tiles for several machines.

use super::exposure::TILE_SIZE;
use crate::film::PixelBounds;

/// Tile `j` of `m`, both from the command line: the picture is cut into `m` rectangles of about equal size, numbered row
/// by row from 0, whose corners lie on those of the units of work.
///
/// `None`: `j` is none of 0 … `m` − 1, or there are fewer units than tiles.
pub fn tile([width, height]: [u32; 2], j: u32, m: u32) -> Option<PixelBounds> {
    let (columns, rows) = (width.div_ceil(TILE_SIZE), height.div_ceil(TILE_SIZE));
    if j >= m || u64::from(m) > most([width, height]) {
        return None;
    }
    let (across, down) = grid(columns, rows, m)?;
    // Row r of the grid holds the tiles from m·r/down on; rows may differ by one tile.
    let first = |row: u32| (u64::from(m) * u64::from(row) / u64::from(down)) as u32;
    let row = (0..down).rev().find(|&row| first(row) <= j)?;
    let (column, in_row) = (j - first(row), first(row + 1) - first(row));
    debug_assert!(in_row <= across);
    let cut = |blocks: u32, k: u32, n: u32| (u64::from(blocks) * u64::from(k) / u64::from(n)) as u32 * TILE_SIZE;
    Some(PixelBounds {
        x0: cut(columns, column, in_row),
        x1: cut(columns, column + 1, in_row).min(width),
        y0: cut(rows, row, down),
        y1: cut(rows, row + 1, down).min(height),
    })
}

/// How many tiles a picture can be cut into.
pub fn most([width, height]: [u32; 2]) -> u64 {
    u64::from(width.div_ceil(TILE_SIZE)) * u64::from(height.div_ceil(TILE_SIZE))
}

/// The grid of at least `m` cells, with at most one unfilled in each row, whose tiles are nearest to squares.
fn grid(columns: u32, rows: u32, m: u32) -> Option<(u32, u32)> {
    let candidates = (1..=rows.min(m)).map(|down| (m.div_ceil(down), down)).filter(|&(across, _)| across <= columns);
    let aspect = |&(across, down): &(u32, u32)| {
        let side = |blocks: u32, n: u32| f64::from(blocks) / f64::from(n);
        (side(columns, across) / side(rows, down)).ln().abs()
    };
    candidates.min_by(|a, b| aspect(a).total_cmp(&aspect(b)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Every pixel is in one tile, no tile is empty, corners lie on units.
        #[test]
        fn tiles_cover_the_picture_once(width in 1u32..400, height in 1u32..400, m in 1u32..40) {
            let units = most([width, height]);
            let tiles: Option<Vec<PixelBounds>> = (0..m).map(|j| tile([width, height], j, m)).collect();
            prop_assert_eq!(tiles.is_some(), u64::from(m) <= units, "{} units", units);
            let Some(tiles) = tiles else { return Ok(()) };
            prop_assert_eq!(tiles.iter().map(PixelBounds::pixels).sum::<usize>(), (width * height) as usize);
            for (i, a) in tiles.iter().enumerate() {
                prop_assert!(a.pixels() > 0 && a.x0 % TILE_SIZE == 0 && a.y0 % TILE_SIZE == 0, "{:?}", a);
                prop_assert!(tiles[..i].iter().all(|b| !a.overlaps(b)), "{:?}", tiles);
            }
            prop_assert_eq!(tile([width, height], m, m), None);
        }
    }
}
