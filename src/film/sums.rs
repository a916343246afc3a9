//! The sums of a picture, or of a part of one, and the means they stand for.

use super::error::{MeanError, Moments, Noise};
use super::exact::ExactSum;
use super::image::{Channel, Image};
use super::layer::BEAUTY;
use super::layout::{GroupShare, Layout};
use super::matte::Counts;
use super::refused::Refused;
use super::splat::SplatBuffer;
use super::tile::{PixelBounds, Tile};
use super::under_way::{Exposure, UnderWay, UnitSet};
use crate::radiometry::Spectrum;
use crate::scene::settings::Layer;

/// Exact sums per pixel and layer over all passes so far, of a rectangle of a picture's pixels.
///
/// A picture's value is (sum of eye samples) / (samples taken) + (sum of splats) / (passes); with the same number of
/// samples in every pass that is the mean of the passes.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    pub(crate) bounds: PixelBounds,
    pub(crate) layout: Layout,
    pub(crate) sums: Vec<ExactSum>,
    pub(crate) taken: Vec<u64>,
    /// Of each of the layout's mattes.
    pub(crate) mattes: Vec<Vec<Counts>>,
    /// Same records as `sums`; empty until the first splat.
    pub(crate) splats: Vec<ExactSum>,
    /// Number of the first pass, and how many were ended.
    pub(crate) first_pass: u32,
    pub(crate) passes: u32,
    pub(crate) moments: Vec<Moments>,
    pub(crate) under_way: UnderWay,
    pub(crate) refused: Refused,
}

impl Film {
    /// For the part `bounds` of a picture, from pass `first_pass` on.
    pub fn new(bounds: PixelBounds, first_pass: u32, layout: Layout) -> Film {
        let pixels = bounds.pixels();
        Film {
            bounds,
            sums: vec![ExactSum::default(); pixels * layout.stride()],
            mattes: vec![vec![Counts::default(); pixels]; layout.mattes().len()],
            layout,
            taken: vec![0; pixels],
            splats: Vec::new(),
            first_pass,
            passes: 0,
            moments: vec![Moments::default(); pixels],
            under_way: UnderWay::new(pixels),
            refused: Refused::default(),
        }
    }

    /// The pixels that it holds.
    pub fn bounds(&self) -> PixelBounds {
        self.bounds
    }
    pub fn layout(&self) -> &Layout {
        &self.layout
    }
    /// Number of the first pass.
    pub fn first_pass(&self) -> u32 {
        self.first_pass
    }
    /// Passes that were ended.
    pub fn passes(&self) -> u32 {
        self.passes
    }
    /// Number of the pass under way.
    pub fn pass(&self) -> u32 {
        self.first_pass + self.passes
    }
    pub fn refused(&self) -> &Refused {
        &self.refused
    }
    /// The units of the pass under way that were added.
    pub fn added(&self, exposure: Exposure) -> &UnitSet {
        &self.under_way.added[exposure as usize]
    }
    /// Whether a pass is under way.
    pub fn is_between_passes(&self) -> bool {
        self.under_way.is_empty()
    }

    /// Adds a unit of [`Exposure::Eye`].
    pub fn add_tile(&mut self, unit: usize, tile: &Tile) {
        assert_eq!(tile.layout, self.layout, "tiles are made from their film's layout");
        let stride = self.layout.stride();
        for (line, to) in self.rows_of(&tile.bounds).enumerate() {
            let from = line * to.len();
            let records = to.start * stride..to.end * stride;
            for (sum, &value) in self.sums[records].iter_mut().zip(&tile.sums[from * stride..]) {
                sum.merge(value);
            }
            for (counts, own) in self.mattes.iter_mut().zip(&tile.mattes) {
                counts[to.clone()].iter_mut().zip(&own[from..]).for_each(|(sum, term)| sum.merge(term));
            }
            let pixels = self.under_way.luminance[to.clone()].iter_mut().zip(&mut self.taken[to]);
            let tile_pixels = tile.sums[from * stride..].chunks_exact(stride).zip(&tile.taken[from..]);
            for ((luminance, sum), (record, &taken)) in pixels.zip(tile_pixels) {
                *sum += u64::from(taken);
                let [r, g, b] = [0, 1, 2].map(|c| record[c].value() / f64::from(taken.max(1)));
                luminance.add(Spectrum::rgb(r, g, b).luminance());
            }
        }
        self.refused.merge(&tile.refused);
        self.under_way.added[Exposure::Eye as usize].insert(unit);
    }

    /// Adds a unit of light paths.
    pub fn add_splats(&mut self, exposure: Exposure, unit: usize, buffer: &SplatBuffer) {
        self.refused.merge(&buffer.refused);
        self.under_way.added[exposure as usize].insert(unit);
        if buffer.splats.is_empty() {
            return;
        }
        let stride = self.layout.stride();
        if self.splats.is_empty() {
            self.splats = vec![ExactSum::default(); self.sums.len()];
        }
        for splat in &buffer.splats {
            let record = &mut self.splats[splat.pixel as usize * stride..][..stride];
            let value = splat.value.to_array();
            for (sum, v) in record.iter_mut().zip(value) {
                sum.add(v);
            }
            let layers = splat.kind.layers();
            for (_, offset) in self.layout.offsets().filter(|(layer, _)| layers.contains(layer)) {
                for (sum, v) in record[offset..].iter_mut().zip(value) {
                    sum.add(v);
                }
            }
            let is_of_splat = |share: &GroupShare| (share.part, share.group) == (splat.kind.part, splat.kind.group);
            for (_, offset) in self.layout.shares().filter(|(share, _)| is_of_splat(share)) {
                for (sum, v) in record[offset..].iter_mut().zip(value) {
                    sum.add(v);
                }
            }
            self.under_way.luminance[splat.pixel as usize].add(splat.value.luminance());
        }
    }

    /// Ends a pass: what is added from now on belongs to the next one.
    pub fn end_pass(&mut self) {
        self.passes += 1;
        for (moments, luminance) in self.moments.iter_mut().zip(&mut self.under_way.luminance) {
            moments.add(std::mem::take(luminance).value());
        }
        self.under_way.added = Default::default();
    }

    /// Adds the passes of another film of the same pixels; neither has a pass under way.
    pub fn add_passes(&mut self, other: &Film) {
        assert_eq!((self.bounds, &self.layout), (other.bounds, &other.layout), "films of the same pixels");
        self.passes += other.passes;
        self.first_pass = self.first_pass.min(other.first_pass);
        self.place(other);
    }

    /// Puts a film of some of this one's pixels, none of which were rendered, into its place.
    pub fn paste(&mut self, part: &Film) {
        assert!(self.bounds.contains_all(&part.bounds) && self.layout == part.layout, "a part of this film");
        assert!(self.passes == 0 || self.passes == part.passes, "the same passes everywhere");
        (self.first_pass, self.passes) = (part.first_pass, part.passes);
        self.place(part);
    }

    /// Adds the sums of a film of some of this one's pixels.
    fn place(&mut self, part: &Film) {
        let stride = self.layout.stride();
        if self.splats.is_empty() && !part.splats.is_empty() {
            self.splats = vec![ExactSum::default(); self.sums.len()];
        }
        let merge = |sums: &mut [ExactSum], terms: &[ExactSum]| {
            sums.iter_mut().zip(terms).for_each(|(sum, &term)| sum.merge(term));
        };
        for (line, to) in self.rows_of(&part.bounds).enumerate() {
            let from = line * to.len()..(line + 1) * to.len();
            let (to_records, from_records) =
                (to.start * stride..to.end * stride, from.start * stride..from.end * stride);
            merge(&mut self.sums[to_records.clone()], &part.sums[from_records.clone()]);
            if !part.splats.is_empty() {
                merge(&mut self.splats[to_records], &part.splats[from_records]);
            }
            self.taken[to.clone()].iter_mut().zip(&part.taken[from.clone()]).for_each(|(sum, term)| *sum += term);
            for (sums, terms) in self.mattes.iter_mut().zip(&part.mattes) {
                sums[to.clone()].iter_mut().zip(&terms[from.clone()]).for_each(|(sum, term)| sum.merge(term));
            }
            self.moments[to].iter_mut().zip(&part.moments[from]).for_each(|(sum, term)| sum.merge(term));
        }
        self.refused.merge(&part.refused);
    }

    /// The pixels of each row of `bounds`, numbered row by row within this film.
    fn rows_of(&self, bounds: &PixelBounds) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
        let (width, row) = (self.bounds.width() as usize, bounds.width() as usize);
        let x = (bounds.x0 - self.bounds.x0) as usize;
        let rows = (bounds.y0 - self.bounds.y0) as usize..(bounds.y1 - self.bounds.y0) as usize;
        rows.map(move |y| y * width + x..y * width + x + row)
    }

    /// The mean luminance of each pixel over the ended passes, and how well it is known; none before the second pass.
    pub fn mean_errors(&self) -> Option<Vec<MeanError>> {
        self.moments.iter().map(|moments| moments.mean_error(self.passes)).collect()
    }

    /// How noisy the picture of the ended passes is; none before the second pass, or without light.
    pub fn noise(&self) -> Option<Noise> {
        Noise::of(&self.moments, self.passes)
    }

    /// The picture so far. Units of a pass under way are in it; before the first pass ends it counts as one, so that a
    /// partial picture has its right scale.
    pub fn resolve(&self) -> Image {
        let stride = self.layout.stride();
        let variance = self.layout.offsets().find(|&(layer, _)| layer == Layer::Variance).map(|(_, offset)| offset);
        let of_hits = self.layout.offsets().filter(|(layer, _)| layer.is_of_hits());
        let of_hits: Vec<usize> = of_hits.flat_map(|(layer, first)| first..first + layer.channels().len()).collect();
        // Splats of a pass under way are not all there yet: the picture is a little dark rather than too bright.
        let splatting = [Exposure::LightToCasters, Exposure::LightToAll].iter().any(|&e| !self.added(e).is_empty());
        let passes = f64::from((self.passes + u32::from(splatting)).max(1));
        let channels = self.layout.channel_names().enumerate().map(|(place, name)| {
            let mean = |pixel: usize| {
                let record = pixel * stride;
                // The samples that hit: the sum of coverages.
                let count =
                    if of_hits.contains(&place) { self.sums[record + ALPHA].value() } else { self.taken[pixel] as f64 };
                let mean = if count > 0.0 { self.sums[record + place].value() / count } else { 0.0 };
                mean + self.splats.get(record + place).map_or(0.0, |sum| sum.value() / passes)
            };
            let error = |pixel: usize| {
                self.moments[pixel].mean_error(self.passes).map_or(0.0, |known| known.standard_error.powi(2))
            };
            let value = |pixel| if variance == Some(place) { error(pixel) } else { mean(pixel) };
            Channel { name, samples: (0..self.taken.len()).map(|p| value(p) as f32).collect() }
        });
        let mattes = self.layout.mattes().iter().zip(&self.mattes);
        let mattes = mattes.flat_map(|(matte, counts)| matte.channels(counts, &self.taken));
        let channels = channels.chain(mattes.map(|(name, samples)| Channel { name, samples }));
        Image { width: self.bounds.width(), height: self.bounds.height(), channels: channels.collect() }
    }
}

/// Place of the coverage in a record.
const ALPHA: usize = BEAUTY.len() - 1;
