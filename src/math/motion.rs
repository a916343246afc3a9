//! Where a moving body is at a time: key frames, between them a turn at a constant rate about a fixed axis (slerp), and a
//! translation and a stretch that change linearly. World frame, metres, seconds.
//!
//! A key's map is taken apart into x ↦ T + R P x: a translation, a rotation, and the symmetric stretch of the polar
//! decomposition `[Higham86]`, which is the scale itself where scales come first. Between the keys at t₀ and t₁, with
//! s = (t − t₀)/(t₁ − t₀),
//!
//!   T(s) = T₀ + s (T₁ − T₀),   R(s) = exp(s θ \[a\]×) R₀,   P(s) = P₀ + s (P₁ − P₀),
//!
//! where θ ≤ π about a is the turn R₁ R₀ᵀ. Symmetric positive definite maps form a convex cone, so that P(s) never becomes
//! singular. Before the first key and after the last one the body stands still.

use super::bounds::Bounds3;
use super::transform::Transform;
use super::vector::{Point3, Vec3};

/// A body's place at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    /// s.
    time: f64,
    /// A point c of the body is at `translation` + `rotation` (`stretch` c + `offset`).
    translation: Vec3,
    rotation: glam::DMat3,
    stretch: glam::DMat3,
    offset: Vec3,
    /// The turn to the next key: a unit axis in the world and an angle in [0, π).
    axis: Vec3,
    angle: f64,
}

/// Why keys are no motion. Numbers are those of keys, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MotionError {
    #[error("a motion needs at least two keys")]
    TooFewKeys,
    #[error("key {later} is not later than the key before it")]
    Order { later: usize },
    #[error("key {later} mirrors the object, or ceases to, which no motion can do")]
    Mirrors { later: usize },
    #[error("from key {earlier} to the next the object turns by half a turn, which may go either way")]
    HalfTurn { earlier: usize },
}

/// From this angle on the axis of a turn, and with it the way round, is a matter of rounding.
const HALF_TURN: f64 = std::f64::consts::PI - 1e-6;

/// Largest turn between two places of which [`Motion::bounds`] takes the corners, radians.
const BOUNDS_STEP: f64 = 0.0625;

/// A motion through key frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    keys: Vec<Key>,
}

impl Motion {
    /// Through `keys`, (time in seconds, map), of a body that `placed` has put into the world first.
    ///
    /// # Errors
    /// Less than two keys, times that do not increase, a change of handedness, a turn that may go either way.
    pub fn new(keys: &[(f64, Transform)], placed: &Transform) -> Result<Motion, MotionError> {
        if keys.len() < 2 {
            return Err(MotionError::TooFewKeys);
        }
        let mut keys: Vec<Key> = keys.iter().map(|(time, map)| Key::new(*time, map, placed)).collect();
        for i in 1..keys.len() {
            // Written so that a NaN fails.
            if !(keys[i].time > keys[i - 1].time && keys[i].time.is_finite()) {
                return Err(MotionError::Order { later: i });
            }
            if (keys[i].stretch.determinant() < 0.0) != (keys[i - 1].stretch.determinant() < 0.0) {
                return Err(MotionError::Mirrors { later: i });
            }
            let (axis, angle) = axis_and_angle(keys[i].rotation * keys[i - 1].rotation.transpose());
            if angle >= HALF_TURN {
                return Err(MotionError::HalfTurn { earlier: i - 1 });
            }
            (keys[i - 1].axis, keys[i - 1].angle) = (axis, angle);
        }
        Ok(Motion { keys })
    }

    /// The body's place at `time`. Never inlined: what stands still must not pay for the room of it.
    #[inline(never)]
    pub fn at(&self, time: f64) -> Transform {
        let (from, to, s) = self.between(time);
        let rotation = turn(from.axis, s * from.angle) * from.rotation;
        let stretch = from.stretch + (to.stretch - from.stretch) * s;
        let offset = from.offset.lerp(to.offset, s);
        let translation = from.translation.lerp(to.translation, s) + rotation * offset;
        Transform::of_product(rotation, stretch, translation)
    }

    /// How the body moves at `time` about the world point `p` of it: the velocity there, and its gradient, with which the
    /// velocity at x is v + L (x − p).
    ///
    /// From x = T + R (S c + o), with the turn ω = θ' a and a dot for d/dt, L = \[ω\]× + R Ṡ S⁻¹ Rᵀ and
    /// v = Ṫ + ω × (x − T) + R (Ṡ c + ȯ).
    pub fn velocity(&self, time: f64, p: Point3) -> (Vec3, glam::DMat3) {
        if time < self.keys[0].time || time > self.keys[self.keys.len() - 1].time {
            return (Vec3::ZERO, glam::DMat3::ZERO);
        }
        let (from, to, s) = self.between(time);
        let rate = 1.0 / (to.time - from.time);
        let rotation = turn(from.axis, s * from.angle) * from.rotation;
        let stretch = from.stretch + (to.stretch - from.stretch) * s;
        let stretching = (to.stretch - from.stretch) * rate;
        let omega = from.axis * (from.angle * rate);
        let spoke = p.to_vec() - from.translation.lerp(to.translation, s);
        let own = stretch.inverse() * (rotation.transpose() * spoke - from.offset.lerp(to.offset, s));
        let growth = rotation * (stretching * own + (to.offset - from.offset) * rate);
        let turning = glam::DMat3::from_cols(omega.cross(Vec3::X), omega.cross(Vec3::Y), omega.cross(Vec3::Z));
        (
            (to.translation - from.translation) * rate + omega.cross(spoke) + growth,
            turning + rotation * stretching * stretch.inverse() * rotation.transpose(),
        )
    }

    /// Whether the body stands still from `open` to `close`.
    pub fn is_still(&self, open: f64, close: f64) -> bool {
        self.segments(open, close).all(|(from, to, ..)| {
            from.angle == 0.0
                && (from.translation, from.stretch, from.offset) == (to.translation, to.stretch, to.offset)
        })
    }

    /// A box around all places, from `open` to `close`, of a body that fills the box `own` in its own space.
    ///
    /// At one time the body lies in the hull of the box's corners where they are then; so what is around the eight corners'
    /// paths is around the body. Between two keys a corner c goes along q(s) = T(s) + R(s) y(s), y(s) = P(s) c + o(s) linear,
    /// and since R' = θ \[a\]× R,
    ///
    ///   |q''| = |θ² a×(a×Ry) + 2 θ a×(R y')| ≤ θ² max(|y(0)|, |y(1)|) + 2 θ |y'|.
    ///
    /// Over a step of Δs a path leaves its chord by at most Δs²/8 · max |q''|, and the chord lies in the box of its ends.
    pub fn bounds(&self, own: &Bounds3, open: f64, close: f64) -> Bounds3 {
        if own.is_empty() {
            return *own;
        }
        let start = own.transformed(&self.at(open)).union(own.transformed(&self.at(close)));
        self.segments(open, close).fold(start, |all, segment| all.union(self.bounds_of_segment(own, segment)))
    }

    fn bounds_of_segment(&self, own: &Bounds3, (from, to, start, end): (&Key, &Key, f64, f64)) -> Bounds3 {
        let steps = ((end - start) / (to.time - from.time) * from.angle / BOUNDS_STEP).ceil().max(1.0);
        let step = (end - start) / (to.time - from.time) / steps;
        let leaves = |corner: Point3| {
            let [y0, y1] = [from, to].map(|key| key.stretch * corner.to_vec() + key.offset);
            let curvature = from.angle * (from.angle * y0.length().max(y1.length()) + 2.0 * (y1 - y0).length());
            0.125 * step * step * curvature
        };
        let margin = own.corners().into_iter().map(leaves).fold(0.0, f64::max);
        let time = |i: f64| start + (end - start) * (i / steps);
        let places = (0..=steps as u32).map(|i| own.transformed(&self.at(time(f64::from(i)))));
        places.fold(Bounds3::EMPTY, Bounds3::union).expanded(margin)
    }

    /// The keys before and after `time`, and how far between them it is, in [0, 1].
    fn between(&self, time: f64) -> (&Key, &Key, f64) {
        let later = self.keys[1..self.keys.len() - 1].iter().take_while(|key| key.time <= time).count();
        let (from, to) = (&self.keys[later], &self.keys[later + 1]);
        (from, to, ((time - from.time) / (to.time - from.time)).clamp(0.0, 1.0))
    }

    /// Every pair of keys with what of the time between them lies in the interval.
    fn segments(&self, open: f64, close: f64) -> impl Iterator<Item = (&Key, &Key, f64, f64)> {
        self.keys.windows(2).filter_map(move |pair| {
            let (start, end) = (pair[0].time.max(open), pair[1].time.min(close));
            (start < end).then_some((&pair[0], &pair[1], start, end))
        })
    }
}

impl Key {
    fn new(time: f64, map: &Transform, placed: &Transform) -> Key {
        let [x, y, z] = map.columns();
        let linear = glam::DMat3::from_cols(x, y, z);
        let (rotation, stretch) = polar(linear);
        let [x, y, z] = placed.columns();
        Key {
            time,
            translation: map.translation(),
            rotation,
            stretch: stretch * glam::DMat3::from_cols(x, y, z),
            offset: stretch * placed.translation(),
            axis: Vec3::Z,
            angle: 0.0,
        }
    }
}

/// M = R P with a rotation R and a symmetric P, definite with the sign of det M, by Newton's iteration
/// R ← ½ (R + R⁻ᵀ) `[Higham86]`, which converges quadratically for every regular M.
fn polar(m: glam::DMat3) -> (glam::DMat3, glam::DMat3) {
    const STEPS: usize = 64;
    let sign = m.determinant().signum();
    let mut r = m * sign;
    for _ in 0..STEPS {
        let next = (r + r.inverse().transpose()) * 0.5;
        let change = (next - r).to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
        r = next;
        if change <= 1e-15 {
            break;
        }
    }
    let p = r.transpose() * m;
    (r, (p + p.transpose()) * 0.5)
}

/// Rotation by `angle` radians about the unit vector `axis`; exactly the identity for no angle.
fn turn(axis: Vec3, angle: f64) -> glam::DMat3 {
    if angle == 0.0 { glam::DMat3::IDENTITY } else { glam::DMat3::from_axis_angle(axis, angle) }
}

/// The unit axis and the angle in [0, π] of a rotation; exactly 0 for the identity.
fn axis_and_angle(r: glam::DMat3) -> (Vec3, f64) {
    if r == glam::DMat3::IDENTITY {
        return (Vec3::Z, 0.0);
    }
    let q = glam::DQuat::from_mat3(&r).normalize();
    let q = if q.w < 0.0 { -q } else { q };
    let sine = q.xyz().length();
    // Rounding of two equal rotations is no turn.
    if sine < 1e-15 { (Vec3::Z, 0.0) } else { (q.xyz() / sine, 2.0 * sine.atan2(q.w)) }
}
