//! What a cross-check found: counts by kind of ray and class, the worst differences, examples that can be replayed.

use serde::{Deserialize, Serialize};

use super::{Query, RayKind};
use crate::backend::RawHit;
use crate::math::{Point3, Ray, Vec3};

/// Examples kept of each class.
pub const EXAMPLES_PER_CLASS: usize = 4;

/// Classes of disagreement; the rules are in the module's header.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    Tie,
    Edge,
    IntervalEnd,
    TBeyond,
    UvBeyond,
    Unexplained,
}

impl Class {
    /// Whether f32 rounding accounts for it.
    pub fn is_explained(self) -> bool {
        matches!(self, Class::Tie | Class::Edge | Class::IntervalEnd)
    }
}

/// Counts of one kind of ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    pub rays: u64,
    /// Not finite or out of bounds: both backends miss.
    pub refused: u64,
    /// Rays on which at least one backend has a hit.
    pub hits: u64,
    pub tie: u64,
    pub edge: u64,
    pub interval_end: u64,
    pub t_beyond: u64,
    pub uv_beyond: u64,
    pub unexplained: u64,
}

impl Counts {
    /// Rays whose answers differ by more than the bounds of the same primitive's t and uv.
    pub fn disagreements(&self) -> u64 {
        self.tie + self.edge + self.interval_end + self.not_explained()
    }
    /// Disagreements that f32 rounding does not account for.
    pub fn not_explained(&self) -> u64 {
        self.t_beyond + self.uv_beyond + self.unexplained
    }
    fn of_mut(&mut self, class: Class) -> &mut u64 {
        match class {
            Class::Tie => &mut self.tie,
            Class::Edge => &mut self.edge,
            Class::IntervalEnd => &mut self.interval_end,
            Class::TBeyond => &mut self.t_beyond,
            Class::UvBeyond => &mut self.uv_beyond,
            Class::Unexplained => &mut self.unexplained,
        }
    }
    fn merge(&mut self, other: &Counts) {
        self.rays += other.rays;
        self.refused += other.refused;
        self.hits += other.hits;
        self.tie += other.tie;
        self.edge += other.edge;
        self.interval_end += other.interval_end;
        self.t_beyond += other.t_beyond;
        self.uv_beyond += other.uv_beyond;
        self.unexplained += other.unexplained;
    }
}

/// Largest differences between the two backends' hits on the same primitive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Worst {
    /// |t − t'| / max(t, t'), of hits farther away than the bound of the difference.
    pub relative_t: f64,
    /// |t − t'| over its bound.
    pub t_of_bound: f64,
    /// Largest difference of u or v.
    pub uv: f64,
    /// The same over its bound.
    pub uv_of_bound: f64,
}

impl Worst {
    pub(super) fn merge(&mut self, other: &Worst) {
        self.relative_t = self.relative_t.max(other.relative_t);
        self.t_of_bound = self.t_of_bound.max(other.t_of_bound);
        self.uv = self.uv.max(other.uv);
        self.uv_of_bound = self.uv_of_bound.max(other.uv_of_bound);
    }
}

/// A ray as the bits of its numbers, hexadecimal: text that gives the same ray back, infinities included.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RayBits {
    pub origin: [String; 3],
    pub direction: [String; 3],
    pub t_min: String,
    pub t_max: String,
    pub time: String,
}

impl RayBits {
    pub fn of(ray: &Ray) -> RayBits {
        let bits = |x: f64| format!("{:016x}", x.to_bits());
        RayBits {
            origin: ray.origin.to_array().map(bits),
            direction: ray.direction.to_array().map(bits),
            t_min: bits(ray.t_min),
            t_max: bits(ray.t_max),
            time: bits(ray.time),
        }
    }
    /// The ray again; `None` where a text is no hexadecimal number.
    pub fn to_ray(&self) -> Option<Ray> {
        let number = |text: &String| u64::from_str_radix(text, 16).ok().map(f64::from_bits);
        let triple = |[x, y, z]: &[String; 3]| Some([number(x)?, number(y)?, number(z)?]);
        Some(Ray {
            origin: Point3::from(triple(&self.origin)?),
            direction: Vec3::from_array(triple(&self.direction)?),
            t_min: number(&self.t_min)?,
            t_max: number(&self.t_max)?,
            time: number(&self.time)?,
        })
    }
}

/// A hit as the report shows it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReportedHit {
    pub object: u32,
    pub primitive: u32,
    pub t: f64,
    pub uv: [f64; 2],
}

impl From<RawHit> for ReportedHit {
    fn from(hit: RawHit) -> ReportedHit {
        ReportedHit { object: hit.object.0, primitive: hit.primitive, t: hit.t, uv: hit.uv }
    }
}

/// One disagreement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Example {
    /// Number of the ray in the run.
    pub index: u64,
    pub kind: RayKind,
    pub class: Class,
    pub ray: RayBits,
    /// First hits of the two backends.
    pub a: Option<ReportedHit>,
    pub b: Option<ReportedHit>,
}

impl Example {
    pub(super) fn new(index: u64, query: &Query, class: Class, a: Option<RawHit>, b: Option<RawHit>) -> Example {
        let (a, b) = (a.map(ReportedHit::from), b.map(ReportedHit::from));
        Example { index, kind: query.kind, class, ray: RayBits::of(&query.ray), a, b }
    }
}

/// Findings of one unit of rays, or of many merged in order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    pub camera: Counts,
    pub shadow: Counts,
    pub photon: Counts,
    pub worst: Worst,
    /// The first [`EXAMPLES_PER_CLASS`] of each class.
    pub examples: Vec<Example>,
}

impl Report {
    /// Adds the findings of the rays that follow.
    pub fn merge(&mut self, later: Report) {
        self.camera.merge(&later.camera);
        self.shadow.merge(&later.shadow);
        self.photon.merge(&later.photon);
        self.worst.merge(&later.worst);
        for example in later.examples {
            self.keep(example);
        }
    }

    /// All kinds of rays together.
    pub fn total(&self) -> Counts {
        let mut total = self.camera;
        total.merge(&self.shadow);
        total.merge(&self.photon);
        total
    }

    /// Share of the rays whose disagreement is not explained: what the cross-check's exit code hangs on.
    pub fn unexplained_rate(&self) -> f64 {
        let total = self.total();
        if total.rays == 0 { 0.0 } else { total.not_explained() as f64 / total.rays as f64 }
    }

    pub(super) fn counts_mut(&mut self, kind: RayKind) -> &mut Counts {
        match kind {
            RayKind::Camera => &mut self.camera,
            RayKind::Shadow => &mut self.shadow,
            RayKind::Photon => &mut self.photon,
        }
    }

    pub(super) fn add(&mut self, example: Example) {
        *self.counts_mut(example.kind).of_mut(example.class) += 1;
        self.keep(example);
    }

    fn keep(&mut self, example: Example) {
        let kept = self.examples.iter().filter(|e| e.class == example.class).count();
        if kept < EXAMPLES_PER_CLASS {
            self.examples.push(example);
        }
    }
}
