//! A stored photon in storage precision: 64 bytes, one cache line.

use super::footprint::TangentForm;
use crate::math::{Dir3, Frame, Normal3, Point3, Vec2, Vec3, float};
use crate::radiometry::{Flux, Spectrum};

/// A photon where it met a surface that scatters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Photon {
    position: [f32; 3],
    /// W, already divided by the number of photons emitted.
    flux: [f32; 3],
    /// Towards where the photon came from.
    wi: [f32; 3],
    /// Geometric normal of the receiver.
    normal: [f32; 3],
    /// (xx, xy, yy) in the frame that [`Frame::from_unit`] makes of the stored normal.
    form: [f32; 3],
    /// How often a surface scattered it on its way; with [`SWEPT`], that in the lowest 7 bits and its sweep in the others.
    tail: u32,
}

/// Says that a record has a sweep.
const SWEPT: u32 = 1 << 31;
/// Bounces that a record with a sweep has room for.
const MAX_SWEPT_BOUNCES: u32 = 127;

/// A receiver of radius of curvature R rises by h²/2R over a footprint of width h: a tenth covers h up to R/5.
const THICKNESS: f64 = 0.1;
/// Below this cosine a photon skims its surface, and sliding along its direction would go far.
const MIN_SLIDE_COSINE: f64 = 0.1;

/// Surfaces turned further than this from a photon's own are not lit by it (cosine of the angle).
pub const MIN_NORMAL_COSINE: f64 = 0.9;

const _: () = assert!(size_of::<Photon>() == 64);

impl Photon {
    /// `form` is in the axes of [`Photon::frame_of`] the same normal.
    pub fn new(p: Point3, wi: Dir3, normal: Normal3, flux: Flux, form: TangentForm, bounces: u32) -> Photon {
        Photon {
            position: p.as_vec3().to_array(),
            flux: flux.0.to_array().map(|c| c as f32),
            wi: wi.as_vec3().to_array(),
            normal: normal.as_vec3().to_array(),
            form: [form.xx as f32, form.xy as f32, form.yy as f32],
            tail: bounces & !SWEPT,
        }
    }
    /// With the way that its light goes, half of it before and half of it after its place, in the axes of
    /// [`Photon::frame_of`]; `None` where there is no room for that.
    pub fn over(self, sweep: Vec2) -> Option<Photon> {
        let code = super::sweep::encode(sweep).filter(|_| self.tail <= MAX_SWEPT_BOUNCES)?;
        Some(Photon { tail: SWEPT | code << 7 | self.tail, ..self })
    }
    /// That way, if it has one.
    pub fn sweep(&self) -> Option<Vec2> {
        (self.tail & SWEPT != 0).then(|| super::sweep::decode(self.tail >> 7 & 0xff_ffff))
    }
    /// A form around all that its kernel can reach, [`Photon::form`] but for sweeps: an ellipse Q swept along D reaches
    /// √(nᵀQn) + |n·D|/2 ≤ √(nᵀ (2 Q + D Dᵀ/2) n) in every direction n.
    #[inline]
    pub fn outer_form(&self) -> TangentForm {
        if self.tail & SWEPT == 0 { self.form() } else { self.swept_form() }
    }
    /// Out of the way of all that is not swept.
    #[cold]
    #[inline(never)]
    fn swept_form(&self) -> TangentForm {
        let Vec2 { x, y } = self.sweep().unwrap_or(Vec2::ZERO);
        self.form().scaled(2.0).plus(TangentForm { xx: x * x, xy: x * y, yy: y * y }.scaled(0.5))
    }
    /// The tangent frame in which a photon on a surface with this normal keeps its footprint: that of the normal as
    /// it is stored, so that reading needs nothing but the record.
    pub fn frame_of(normal: Normal3) -> Frame {
        Frame::from_unit(widened(normal.as_vec3().to_array()))
    }
    pub fn position(&self) -> Point3 {
        Point3::from_f32(self.position)
    }
    pub fn wi(&self) -> Vec3 {
        widened(self.wi)
    }
    pub fn normal(&self) -> Vec3 {
        widened(self.normal)
    }
    pub fn flux(&self) -> Flux {
        Flux(Spectrum::from(self.flux.map(f64::from)))
    }
    pub fn form(&self) -> TangentForm {
        let [xx, xy, yy] = self.form.map(f64::from);
        TangentForm { xx, xy, yy }
    }
    pub fn frame(&self) -> Frame {
        Frame::from_unit(self.normal())
    }
    /// How far from the photon's tangent plane a surface still counts as the one it lit, m.
    pub fn thickness(&self) -> f64 {
        THICKNESS * self.outer_form().trace().sqrt() + float::origin_offset(self.position().abs().max_element())
    }
    /// The direction in which points beside the tangent plane are carried into it, of length 1/cos: along the photon,
    /// as parallel light would go, or along the normal for a photon that skims its surface.
    pub fn slide(&self) -> Vec3 {
        let (wi, n) = (self.wi(), self.normal());
        let cos = wi.dot(n);
        if cos.abs() < MIN_SLIDE_COSINE { n } else { wi / cos }
    }
    /// How often a surface scattered it, by a wide lobe, before this one.
    pub fn bounces(&self) -> u32 {
        if self.tail & SWEPT == 0 { self.tail } else { self.tail & MAX_SWEPT_BOUNCES }
    }
    /// The same light elsewhere on the same plane.
    pub fn moved(&self, p: Point3, flux: Flux, form: TangentForm) -> Photon {
        let position = p.as_vec3().to_array();
        let flux = flux.0.to_array().map(|c| c as f32);
        Photon { position, flux, form: [form.xx as f32, form.xy as f32, form.yy as f32], ..*self }
    }
    /// All that it is, for an order among photons.
    pub fn bits(&self) -> [u32; 16] {
        let [[a, b, c], [d, e, f], [g, h, i], [j, k, l], [m, n, o]] =
            [self.position, self.flux, self.wi, self.normal, self.form].map(|v| v.map(f32::to_bits));
        [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, self.tail]
    }
}

fn widened(v: [f32; 3]) -> Vec3 {
    Vec3::from_array(v.map(f64::from))
}
