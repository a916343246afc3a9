//! All beams of a pass of one kind, and which of them a ray may cross.
//!
//! Beams are cut into pieces, so that the boxes around them are narrow, and a tree stands over the pieces' boxes. A crossing
//! belongs to the piece in which it lies on the beam's axis, so that none is counted twice.

use super::beam::Beam;
use super::index::{BoxTree, OuterBox, SlabRay};
use super::order::ZCurve;
use crate::math::Bounds3;
use crate::medium::Way;
use crate::scene::Medium;

/// Pieces per beam in the mean; twice as many made rays no faster.
const PIECES: f64 = 16.0;
/// Pieces of one beam at most.
const MOST_PIECES: f64 = 1024.0;

/// A code on the curve and an index, by which pieces are sorted.
const BYTES_PER_KEY: u64 = 16;
/// Of the tree.
const BYTES_PER_BOX: u64 = 27;

/// Beams with a tree over them.
#[derive(Debug)]
pub struct BeamMap {
    pub beams: Vec<Beam>,
    pieces: Vec<Piece>,
    tree: BoxTree,
}

/// A part of a beam between two distances, m.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    beam: u32,
    pub from: f64,
    pub to: f64,
    /// How much of the medium lies before it, m of density one.
    pub column: f64,
}

impl BeamMap {
    /// Bytes that each of the beams takes while their map is built: itself, in a list that has grown to twice its length, and
    /// its pieces with their keys and the boxes over them.
    pub const BYTES_PER_BEAM: u64 =
        2 * size_of::<Beam>() as u64 + PIECES as u64 * (size_of::<Piece>() as u64 + BYTES_PER_KEY + BYTES_PER_BOX);

    /// The map of all, which go through these media; the same whatever order they come in.
    pub fn new(mut beams: Vec<Beam>, media: &[Medium]) -> BeamMap {
        beams.sort_by_cached_key(Beam::bits);
        let length: f64 = beams.iter().map(|beam| beam.length).sum();
        let step = length / (PIECES * beams.len() as f64);
        let mut pieces = Vec::new();
        for (i, beam) in (0..).zip(&beams) {
            let count = (beam.length / step).ceil().clamp(1.0, MOST_PIECES);
            let place = |k: f64| beam.length * (k / count);
            let mut column = 0.0;
            for (from, to) in (0..count as u32).map(|k| (place(k.into()), place(f64::from(k) + 1.0))) {
                pieces.push(Piece { beam: i, from, to, column });
                let medium = &media[beam.medium.index()];
                column += Way { medium, origin: beam.origin, w: beam.w, from, to }.column();
            }
        }
        let middle = |piece: &Piece| beams[piece.beam as usize].at(0.5 * (piece.from + piece.to));
        let curve = ZCurve::through(&Bounds3::from_points(pieces.iter().map(middle)));
        // A stable sort: pieces at one place keep the order of their beams.
        pieces.sort_by_cached_key(|piece| curve.code(middle(piece)));
        let boxed = |i: usize| {
            let Piece { beam, from, to, .. } = pieces[i];
            let beam = &beams[beam as usize];
            let ends = OuterBox::new(beam.at(from), beam.half_extents(from, to));
            ends.union(OuterBox::new(beam.at(to), beam.half_extents(from, to)))
        };
        let tree = BoxTree::build(pieces.len(), boxed);
        BeamMap { beams, pieces, tree }
    }

    /// Leads `visit` to the pieces whose boxes overlap that of a place.
    pub fn over(&self, place: OuterBox, mut visit: impl FnMut(&Beam, &Piece)) {
        self.tree.around(place, |i| self.show(i, &mut visit));
    }

    /// Leads `visit` to the pieces whose boxes the ray meets: the beam, and which part of it is this piece's.
    #[inline(always)]
    pub fn along(&self, ray: &SlabRay, mut visit: impl FnMut(&Beam, &Piece)) {
        self.tree.along(ray, |i| self.show(i, &mut visit));
    }

    #[inline(always)]
    fn show(&self, i: usize, visit: &mut impl FnMut(&Beam, &Piece)) {
        let piece = &self.pieces[i];
        visit(&self.beams[piece.beam as usize], piece);
    }
}
