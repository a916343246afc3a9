//! One photon's footprint over many points: the inner loop of the estimate, eight points at once.
//!
//! The formula is that of [`super::pair`]. With (t, b) the footprint's own axes, so that Q_photon = diag(a², b²), and the
//! eye sample's axes e₁, e₂ in them,
//!
//! det(Q + E) = a²b² + a² Σ y² + b² Σ x² + (e₁ × e₂)²  and  dᵀ adj(Q + E) d = b² d_x² + a² d_y² + Σ (e × d)²
//!
//! are sums of squares: nothing cancels, so that single precision is enough for the thinnest footprint. Numbers are in
//! units of the longer axis, and no sum is contracted: every processor gives the same bits.
#![expect(clippy::needless_range_loop, reason = "one loop over the lanes of several arrays compiles to vectors")]

use std::ops::ControlFlow;

use pulp::NullaryFnOnce;

use super::kernel;
use super::pair;
use super::receivers::{Block, Eight, Receivers, Sums, Vec3Eight};
use crate::math::{Point3, Vec3};
use crate::photon::Photon;
use crate::photon::index::{Boxes, Lanes, Visitor, WIDTH};
use crate::photon::record::MIN_NORMAL_COSINE;
use crate::scene::settings::KernelShape;

/// The shortest unit of length, m²: for footprints without extent, which are only as wide as the eye's.
const SMALLEST_UNIT_SQUARED: f64 = 1e-12;

/// Beyond the rounding of the tests that only decide what to look at more closely.
const MARGIN: f32 = 1e-4;

/// A photon's footprint made ready for many points. Vectors in the world's frame.
pub struct Splat<'a> {
    photon: &'a Photon,
    kernel: KernelShape,
    position: Point3,
    n: [f32; 3],
    /// The footprint's axes, by the unit of length.
    axes: [[f32; 3]; 2],
    /// o ↦ d, by the unit of length.
    plane: [[f32; 3]; 2],
    /// a², b² in squares of the unit.
    square: [f32; 2],
    /// Inverse square of the unit of length, 1/m².
    per_area: f32,
    slide: [f32; 3],
    wi: [f32; 3],
    flux: [f32; 3],
    /// Square of the shorter semi-axis, m².
    minor: f32,
    /// How far over the photon's plane its light reaches, m.
    thickness: f32,
    /// Whether the kernel is swept along a segment: then what is here of it is around all that it reaches, and each point
    /// is weighed by itself.
    is_swept: bool,
    /// What limits |d_x|, |d_y| and the height for boxes that may be reached.
    limits: [f32; 3],
}

impl<'a> Splat<'a> {
    pub fn new(photon: &'a Photon, kernel: KernelShape) -> Splat<'a> {
        let (frame, slide) = (photon.frame(), photon.slide());
        let ([minor, major], along) = photon.outer_form().principal();
        let axes = [frame.t * along.x + frame.b * along.y, frame.b * along.x - frame.t * along.y];
        let unit = major.max(SMALLEST_UNIT_SQUARED).sqrt();
        let scaled = axes.map(|axis| axis / unit);
        let narrow = |v: Vec3| v.as_vec3().to_array();
        let square = [major, minor].map(|square| (square / (unit * unit)) as f32);
        let thickness = photon.thickness() as f32;
        Splat {
            photon,
            kernel,
            position: photon.position(),
            n: narrow(frame.n),
            axes: scaled.map(narrow),
            plane: scaled.map(|axis| narrow(axis - frame.n * axis.dot(slide))),
            square,
            per_area: (1.0 / (unit * unit)) as f32,
            slide: narrow(slide),
            wi: narrow(photon.wi()),
            flux: photon.flux().0.to_array().map(|c| c as f32),
            minor: minor as f32,
            is_swept: photon.sweep().is_some(),
            thickness,
            // Boxes hold the eye's footprints: an axis of the sum of both is not longer than the sum of their axes.
            limits: [square[0].sqrt(), square[1].sqrt(), thickness].map(|limit| limit * (1.0 + MARGIN)),
        }
    }

    /// Whether it counts for some points of a range of [`Block::shared_above`].
    pub fn has(&self, part: Part, [least, greatest]: [f32; 2]) -> bool {
        match part {
            Part::Whole => true,
            Part::Narrow => self.minor <= greatest,
            Part::Wide => self.minor > least,
        }
    }

    /// Those of eight boxes of points that the footprint may reach: long thin footprints fill little of their own box.
    #[inline(always)]
    fn may_reach(&self, boxes: &Boxes) -> Lanes {
        let position = self.position.as_vec3().to_array();
        let rows = [self.plane[0], self.plane[1], self.n];
        let mut reached = [false; WIDTH];
        for i in 0..WIDTH {
            let (mut centre, mut half) = ([0.0f32; 3], [0.0f32; 3]);
            for k in 0..3 {
                centre[k] = 0.5 * (boxes.lo[k][i] + boxes.hi[k][i]) - position[k];
                // What rounding can move the box by.
                half[k] = 0.5 * (boxes.hi[k][i] - boxes.lo[k][i]) + centre[k].abs() * (4.0 * f32::EPSILON);
            }
            let mut inside = true;
            for (row, limit) in rows.iter().zip(self.limits) {
                let (middle, extent) = (dot(row, &centre), dot(&row.map(f32::abs), &half));
                // An empty box gives NaN or −∞, which are not below anything.
                inside &= middle.abs() <= limit + extent;
            }
            reached[i] = inside;
        }
        Lanes::from(reached)
    }

    /// K(dᵀ Q⁻¹ d)/√det Q in 1/m², 0 where the footprint does not reach the point or belongs to another surface.
    #[inline(always)]
    fn weights(&self, block: &Block, part: Part) -> Option<Eight> {
        let base = (block.origin - self.position).as_vec3().to_array();
        let [a2, b2] = self.square;
        let (mut dx, mut dy, mut near) = ([0.0f32; WIDTH], [0.0f32; WIDTH], [false; WIDTH]);
        for i in 0..WIDTH {
            let o = [base[0] + block.p[0][i], base[1] + block.p[1][i], base[2] + block.p[2][i]];
            dx[i] = dot(&self.plane[0], &o);
            dy[i] = dot(&self.plane[1], &o);
            // Within Q + λ, which is nowhere narrower than Q + E.
            let (a2, b2) = (a2 + block.widest_eye[i] * self.per_area, b2 + block.widest_eye[i] * self.per_area);
            let inside = b2 * (dx[i] * dx[i]) + a2 * (dy[i] * dy[i]) <= a2 * b2 * (1.0 + MARGIN);
            let height = dot(&self.n, &o);
            near[i] = inside & (height.abs() <= self.thickness);
        }
        if part != Part::Whole {
            for i in 0..WIDTH {
                near[i] &= (self.minor > block.shared_above[i]) == (part == Part::Wide);
            }
        }
        if !Lanes::from(near).any() {
            return None;
        }
        let (mut forms, mut determinants, mut lit) = ([0.0f32; WIDTH], [0.0f32; WIDTH], [false; WIDTH]);
        for i in 0..WIDTH {
            let [e, g] = [0, 1].map(|k| lane(&block.eye[k], i));
            let [ex, ey] = [0, 1].map(|k| dot(&self.axes[k], &e));
            let [gx, gy] = [0, 1].map(|k| dot(&self.axes[k], &g));
            let area = ex * gy - gx * ey;
            let determinant = a2 * b2 + (a2 * (ey * ey + gy * gy) + b2 * (ex * ex + gx * gx)) + area * area;
            let [across_e, across_g] = [ey * dx[i] - ex * dy[i], gy * dx[i] - gx * dy[i]];
            let form = b2 * (dx[i] * dx[i]) + a2 * (dy[i] * dy[i]) + (across_e * across_e + across_g * across_g);
            let facing = dot(&lane(&block.ng, i), &self.n) >= MIN_NORMAL_COSINE as f32;
            lit[i] = near[i] & facing & (form < determinant);
            (forms[i], determinants[i]) = (form, determinant);
        }
        if !Lanes::from(lit).any() {
            return None;
        }
        let (mut t, mut scale) = ([0.0f32; WIDTH], [0.0f32; WIDTH]);
        for i in 0..WIDTH {
            // Chosen before dividing: a branch around a division would part the eight.
            let (form, determinant, own) =
                if lit[i] { (forms[i], determinants[i], self.per_area) } else { (1.0, 1.0, 0.0) };
            let inverse = 1.0 / determinant;
            t[i] = form * inverse;
            scale[i] = inverse.sqrt() * (dot(&lane(&block.ng, i), &self.slide).abs() * own);
        }
        let mut weights = kernel::evaluate_eight(self.kernel, &t);
        for i in 0..WIDTH {
            weights[i] *= scale[i];
        }
        Some(weights)
    }

    /// Adds the photon's light to a block's sums, but for lanes whose BSDF has to be asked.
    #[inline(always)]
    fn add(&self, weights: &Eight, block: &Block, sums: &mut Sums) {
        let mut reflected = [0.0f32; WIDTH];
        for i in 0..WIDTH {
            let cos_s = dot(&lane(&block.ns, i), &self.wi);
            reflected[i] = if cos_s > 0.0 { weights[i] } else { 0.0 };
        }
        if !block.smooth {
            for i in 0..WIDTH {
                let cos_s = dot(&lane(&block.ns, i), &self.wi);
                let cos_g = dot(&lane(&block.ng, i), &self.wi) * block.side[i];
                // The cosine of the shading normal in place of the geometric one that the footprint's area has.
                let (cos_s, cos_g) = if (cos_s > 0.0) & (cos_g > 0.0) { (cos_s, cos_g) } else { (0.0, 1.0) };
                reflected[i] *= cos_s / cos_g;
            }
        }
        for k in 0..3 {
            for i in 0..WIDTH {
                sums.radiance[k][i] += f64::from(reflected[i] * (block.f[k][i] * self.flux[k]));
            }
        }
        for i in 0..WIDTH {
            sums.density[i] += f64::from(weights[i]);
        }
    }

    /// As [`Splat::add`], of a swept footprint.
    fn add_swept(&self, part: Part, receivers: &mut Receivers, b: usize) {
        for lane in 0..receivers.lanes(b) {
            let is_wide = self.minor > receivers.blocks[b].shared_above[lane];
            if part != Part::Whole && is_wide != (part == Part::Wide) {
                continue;
            }
            let point = receivers.point(b, lane);
            let weight = pair::weight(self.photon, self.kernel, point);
            if weight > 0.0 {
                let reflected = pair::reflected(self.photon, point) * weight;
                let sums = &mut receivers.sums[b];
                for (channel, value) in sums.radiance.iter_mut().zip(reflected.to_array()) {
                    channel[lane] += value;
                }
                sums.density[lane] += weight;
            }
        }
    }

    /// As [`Splat::add`], for the other lanes.
    fn add_uneven(&self, weights: &Eight, receivers: &mut Receivers, b: usize) {
        for lane in receivers.blocks[b].uneven.filter(|lane| weights[lane] > 0.0) {
            let reflected = pair::reflected(self.photon, receivers.point(b, lane)) * f64::from(weights[lane]);
            for (channel, value) in receivers.sums[b].radiance.iter_mut().zip(reflected.to_array()) {
                channel[lane] += value;
            }
        }
    }
}

#[inline(always)]
fn lane(v: &Vec3Eight, i: usize) -> [f32; 3] {
    [v[0][i], v[1][i], v[2][i]]
}

#[inline(always)]
fn dot(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// For which of the points a footprint counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// For all.
    Whole,
    /// For those it is narrow for.
    Narrow,
    /// For those it is wide for.
    Wide,
}

/// A splat with the points it goes to: what is compiled for each kind of processor.
pub struct Splatting<'a, 'b> {
    pub splat: &'b Splat<'a>,
    pub part: Part,
    pub receivers: &'b mut Receivers<'a>,
}

impl NullaryFnOnce for Splatting<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Splatting { splat, part, receivers } = self;
        let Receivers { tree, blocks, sums, weighed, .. } = receivers;
        let (uneven, swept) = (Vec::new(), Vec::new());
        let mut over = OverBlocks { splat, part, blocks, sums, weighed, uneven, swept };
        tree.lead(&mut over);
        let OverBlocks { uneven, swept, .. } = over;
        for (b, weights) in uneven {
            splat.add_uneven(&weights, receivers, b);
        }
        for b in swept {
            splat.add_swept(part, receivers, b);
        }
    }
}

/// On its way through the blocks.
struct OverBlocks<'a> {
    splat: &'a Splat<'a>,
    part: Part,
    blocks: &'a [Block],
    sums: &'a mut [Sums],
    weighed: &'a mut u64,
    /// Blocks with BSDFs that have to be asked.
    uneven: Vec<(usize, Eight)>,
    /// Blocks that a swept footprint may reach.
    swept: Vec<usize>,
}

impl Visitor for OverBlocks<'_> {
    #[inline(always)]
    fn enter(&mut self, _: usize, boxes: &Boxes) -> Lanes {
        self.splat.may_reach(boxes)
    }
    #[inline(always)]
    fn visit(&mut self, b: usize) -> ControlFlow<()> {
        if !self.splat.has(self.part, self.blocks[b].shared_range) {
            return ControlFlow::Continue(());
        }
        *self.weighed += WIDTH as u64;
        if self.splat.is_swept {
            self.swept.push(b);
            return ControlFlow::Continue(());
        }
        if let Some(weights) = self.splat.weights(&self.blocks[b], self.part) {
            self.splat.add(&weights, &self.blocks[b], &mut self.sums[b]);
            if self.blocks[b].uneven.any() {
                self.uneven.push((b, weights));
            }
        }
        ControlFlow::Continue(())
    }
}
