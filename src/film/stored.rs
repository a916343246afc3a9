//! A film as bytes: its shape, which says how many there are, and its sums, all little-endian.

use std::io::{self, Read, Write};

use serde::{Deserialize, Serialize};

use super::error::Moments;
use super::exact::{ExactSquares, ExactSum};
use super::layout::Layout;
use super::matte::Counts;
use super::refused::Refused;
use super::sums::Film;
use super::tile::PixelBounds;
use super::under_way::{UnderWay, UnitSet};
use crate::scene::GroupLayer;
use crate::scene::settings::Layer;

/// All of a film but its sums.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FilmShape {
    pub bounds: PixelBounds,
    pub layers: Vec<String>,
    /// Names of what each matte tells apart.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    names: Vec<Vec<String>>,
    pub first_pass: u32,
    pub passes: u32,
    has_splats: bool,
    refused: Refused,
    /// Of the pass under way: words of its unit sets.
    added: [Vec<u64>; 3],
}

/// The most pixels that a file may claim: 2³¹, as EXR counts.
const MAX_PIXELS: u64 = 1 << 31;

fn invalid(reason: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason.into())
}

impl FilmShape {
    fn layout(&self) -> io::Result<Layout> {
        let (mut layers, mut grouped) = (Vec::new(), Vec::new());
        for name in &self.layers {
            match (Layer::from_name(name), GroupLayer::from_name(name)) {
                (Some(layer), _) => layers.push(layer),
                (None, Some(layer)) => grouped.push(layer),
                (None, None) => return Err(invalid(format!("no layer {name:?}"))),
            }
        }
        let layout = Layout::of(&layers, &grouped);
        if layout.mattes().len() != self.names.len() {
            return Err(invalid("its mattes have no names"));
        }
        let mut names = self.names.iter();
        Ok(layout.naming(|_| names.next().cloned().unwrap_or_default()))
    }

    fn pixels(&self) -> io::Result<usize> {
        let PixelBounds { x0, y0, x1, y1 } = self.bounds;
        match (x1.checked_sub(x0), y1.checked_sub(y0)) {
            (Some(w), Some(h)) if u64::from(w) * u64::from(h) <= MAX_PIXELS => Ok(w as usize * h as usize),
            _ => Err(invalid("its pixels make no rectangle")),
        }
    }
}

impl Film {
    pub fn shape(&self) -> FilmShape {
        FilmShape {
            bounds: self.bounds,
            layers: self.layout.names(),
            names: self.layout.mattes().iter().map(|matte| matte.names.to_vec()).collect(),
            first_pass: self.first_pass,
            passes: self.passes,
            has_splats: !self.splats.is_empty(),
            refused: self.refused.clone(),
            added: self.under_way.added.each_ref().map(|units| units.words().to_vec()),
        }
    }

    /// Writes the sums in the order that [`Film::read_sums`] expects.
    pub fn write_sums(&self, out: &mut impl Write) -> io::Result<()> {
        write_all(out, &self.sums, |sum| sum.to_le_bytes())?;
        write_all(out, &self.splats, |sum| sum.to_le_bytes())?;
        write_all(out, &self.taken, |n| n.to_le_bytes())?;
        write_all(out, &self.moments, |moments| moments.sum.to_le_bytes())?;
        write_all(out, &self.moments, |moments| moments.squares.to_le_bytes())?;
        write_all(out, &self.under_way.luminance, |sum| sum.to_le_bytes())?;
        self.mattes.iter().flatten().try_for_each(|counts| write_counts(out, counts))
    }

    /// # Errors
    /// There are fewer bytes than the shape says, or it makes no sense.
    pub fn read_sums(shape: &FilmShape, from: &mut impl Read) -> io::Result<Film> {
        let (layout, pixels) = (shape.layout()?, shape.pixels()?);
        shape.first_pass.checked_add(shape.passes).ok_or_else(|| invalid("its passes have no number"))?;
        let records = pixels * layout.stride();
        let sums = read_all(from, records, ExactSum::from_le_bytes)?;
        let splats = read_all(from, if shape.has_splats { records } else { 0 }, ExactSum::from_le_bytes)?;
        let taken = read_all(from, pixels, u64::from_le_bytes)?;
        let means = read_all(from, pixels, ExactSum::from_le_bytes)?;
        let squares = read_all(from, pixels, ExactSquares::from_le_bytes)?;
        let luminance = read_all(from, pixels, ExactSum::from_le_bytes)?;
        let mattes = layout.mattes().iter().map(|matte| read_counts(from, pixels, matte.names.len()));
        let mattes = mattes.collect::<io::Result<Vec<_>>>()?;
        let added = shape.added.clone().map(UnitSet::from_words);
        Ok(Film {
            bounds: shape.bounds,
            layout,
            sums,
            taken,
            mattes,
            splats,
            first_pass: shape.first_pass,
            passes: shape.passes,
            moments: means.into_iter().zip(squares).map(|(sum, squares)| Moments { sum, squares }).collect(),
            under_way: UnderWay { luminance, added },
            refused: shape.refused.clone(),
        })
    }
}

/// Values that go through one call of the writer, and so through one call of the digest.
const BLOCK: usize = 4096;

fn write_all<T, const N: usize>(out: &mut impl Write, values: &[T], bytes: impl Fn(&T) -> [u8; N]) -> io::Result<()> {
    for block in values.chunks(BLOCK) {
        let block: Vec<u8> = block.iter().flat_map(&bytes).collect();
        out.write_all(&block)?;
    }
    Ok(())
}

fn read_all<T, const N: usize>(from: &mut impl Read, count: usize, value: impl Fn([u8; N]) -> T) -> io::Result<Vec<T>> {
    // Grows with what is really there, so that a wrong count costs no memory.
    let mut values = Vec::new();
    let mut bytes = vec![0; BLOCK * N];
    while values.len() < count {
        let block = &mut bytes[..BLOCK.min(count - values.len()) * N];
        from.read_exact(block)?;
        values.extend(block.as_chunks().0.iter().map(|&chunk| value(chunk)));
    }
    Ok(values)
}

/// The number of things, then each with its count, in the order of their numbers.
fn write_counts(out: &mut impl Write, Counts(counts): &Counts) -> io::Result<()> {
    out.write_all(&(counts.len() as u32).to_le_bytes())?;
    counts.iter().try_for_each(|(thing, count)| {
        out.write_all(&thing.to_le_bytes())?;
        out.write_all(&count.to_le_bytes())
    })
}

/// Of `pixels` pixels; things are numbered below `things`.
fn read_counts(from: &mut impl Read, pixels: usize, things: usize) -> io::Result<Vec<Counts>> {
    let mut all = Vec::new();
    for _ in 0..pixels {
        let mut counts = Counts::default();
        for _ in 0..u32::from_le_bytes(bytes_of(from)?) {
            let thing = u32::from_le_bytes(bytes_of(from)?);
            let is_new = counts.0.insert(thing, u64::from_le_bytes(bytes_of(from)?)).is_none();
            if !is_new || thing as usize >= things {
                return Err(invalid("its mattes make no sense"));
            }
        }
        all.push(counts);
    }
    Ok(all)
}

fn bytes_of<const N: usize>(from: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    from.read_exact(&mut bytes)?;
    Ok(bytes)
}
