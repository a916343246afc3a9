//! The height field of sines · metres, own frame · (u, v) = (x/hx + 1, y/hy + 1)/2.

use super::error::{ShapeError, direction, finite_point, positive};
use super::{LocalSurface, Parametrisation};
use crate::differential::ShapeOperator;
use crate::math::{Bounds3, Frame, Normal3, Point3, Ray, Vec2, Vec3};

/// One term amplitude · sin(wave_vector·(x, y) + phase + rate · time): metres, radians per metre, radians, radians per
/// second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    pub amplitude: f64,
    pub wave_vector: Vec2,
    pub phase: f64,
    /// −|wave vector| times the speed along it; 0 for a wave that stands still.
    pub rate: f64,
}

/// z = Σ waves over |x| ≤ hx, |y| ≤ hy; its normal is on the side of +z. Without waves it is flat.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    centre: Point3,
    half_size: Vec2,
    waves: Vec<Wave>,
    frame: Frame,
    /// Σ |amplitude|, a bound of |z|.
    highest: f64,
}

/// Height and its first and second derivatives by x and y.
struct Relief {
    z: f64,
    gradient: Vec2,
    zxx: f64,
    zxy: f64,
    zyy: f64,
}

impl HeightField {
    /// The field's z axis is `up`, its x axis as near to `x_axis` as it can be.
    ///
    /// # Errors
    /// Numbers that are not finite, a half size that is not positive, an axis without length, an `x_axis` along `up`.
    pub fn new(
        centre: Point3,
        x_axis: Vec3,
        up: Vec3,
        half_size: Vec2,
        waves: Vec<Wave>,
    ) -> Result<HeightField, ShapeError> {
        let centre = finite_point("centre", centre)?;
        let (x, _) = direction("x axis", x_axis)?;
        let (up, _) = direction("up axis", up)?;
        if x.cross(up).length() < 1e-9 {
            return Err(ShapeError::Parallel { first: "x axis", second: "up axis" });
        }
        positive("half size in x", half_size.x)?;
        positive("half size in y", half_size.y)?;
        for wave in &waves {
            if !(wave.amplitude.is_finite()
                && wave.wave_vector.is_finite()
                && wave.phase.is_finite()
                && wave.rate.is_finite())
            {
                return Err(ShapeError::NotFinite { what: "list of waves" });
            }
        }
        let frame = Frame::from_normal_and_x(Normal3::from_unit(up), x);
        let highest = waves.iter().map(|w| w.amplitude.abs()).sum();
        Ok(HeightField { centre, half_size, waves, frame, highest })
    }
    pub fn centre(&self) -> Point3 {
        self.centre
    }
    pub fn half_size(&self) -> Vec2 {
        self.half_size
    }
    /// x, y and up.
    pub fn frame(&self) -> Frame {
        self.frame
    }
    pub fn waves(&self) -> &[Wave] {
        &self.waves
    }

    /// Whether it changes with time.
    pub fn travels(&self) -> bool {
        self.waves.iter().any(|wave| wave.rate != 0.0)
    }
    /// The field as it is at `time`, for ever.
    pub fn frozen(&self, time: f64) -> HeightField {
        let still = |wave: &Wave| Wave { phase: wave.phase + wave.rate * time, rate: 0.0, ..*wave };
        HeightField { waves: self.waves.iter().map(still).collect(), ..self.clone() }
    }

    /// The velocity of the point over (x, y), straight up or down, and its gradient.
    pub(super) fn velocity_at(&self, p: Point3, time: f64) -> Option<(Vec3, glam::DMat3)> {
        if !self.travels() {
            return None;
        }
        let at = self.frame.project(p - self.centre);
        let (mut rising, mut slope) = (0.0, Vec2::ZERO);
        for wave in &self.waves {
            let (sin, cos) = (wave.wave_vector.dot(at) + wave.phase + wave.rate * time).sin_cos();
            rising += wave.amplitude * wave.rate * cos;
            slope -= wave.wave_vector * (wave.amplitude * wave.rate * sin);
        }
        let across = self.frame.t * slope.x + self.frame.b * slope.y;
        Some((self.frame.n * rising, super::outer(self.frame.n, across)))
    }

    fn relief(&self, at: Vec2, time: f64) -> Relief {
        let mut relief = Relief { z: 0.0, gradient: Vec2::ZERO, zxx: 0.0, zxy: 0.0, zyy: 0.0 };
        for wave in &self.waves {
            let k = wave.wave_vector;
            let (sin, cos) = (k.dot(at) + (wave.phase + wave.rate * time)).sin_cos();
            let (sin, cos) = (wave.amplitude * sin, wave.amplitude * cos);
            relief.z += sin;
            relief.gradient += k * cos;
            relief.zxx -= k.x * k.x * sin;
            relief.zxy -= k.x * k.y * sin;
            relief.zyy -= k.y * k.y * sin;
        }
        relief
    }

    pub(super) fn intersect(&self, ray: &Ray) -> Option<f64> {
        let origin = self.frame.to_local(ray.origin - self.centre);
        let direction = self.frame.to_local(ray.direction);
        let (near, far) = self.clip(origin, direction, ray.t_min, ray.t_max)?;
        let t = self.march((origin, direction), ray.time, (near, far), near == ray.t_min)?;
        (t > ray.t_min && t < ray.t_max).then_some(t)
    }

    /// The part of [t_min, t_max] inside the box around the field.
    fn clip(&self, o: Vec3, d: Vec3, t_min: f64, t_max: f64) -> Option<(f64, f64)> {
        // A flat field must not lose its box; the crests must be inside.
        let thick = self.highest * (1.0 + 1e-9) + 1e-9 * self.half_size.max_element();
        let half = self.half_size.extend(thick);
        let (mut near, mut far) = (t_min, t_max);
        for axis in 0..3 {
            if d[axis] != 0.0 {
                let (a, b) = ((-half[axis] - o[axis]) / d[axis], (half[axis] - o[axis]) / d[axis]);
                near = near.max(a.min(b));
                far = far.min(a.max(b));
            } else if o[axis].abs() > half[axis] {
                return None;
            }
        }
        (near <= far && near.is_finite() && far.is_finite()).then_some((near, far))
    }

    /// First root in [near, far] of g(t) = z(t) − height.
    ///
    /// With |g''| ≤ M, the sign of g holds as long as |g| + sign(g) g' h − M h²/2 > 0: steps as long as that skip no
    /// root. Near a simple root they are Newton's, near a near miss they are √(2|g|/M) (the Lipschitz marching of
    /// `[Kalra89]` with a bound of the second derivative).
    ///
    /// `from_start`: `near` is where the ray starts, so that a root there, within rounding, is the surface it left.
    fn march(&self, (o, d): (Vec3, Vec3), time: f64, (near, far): (f64, f64), from_start: bool) -> Option<f64> {
        let across = d.truncate();
        let bend: f64 = self.waves.iter().map(|w| w.amplitude.abs() * w.wave_vector.dot(across).powi(2)).sum();
        let along = |t: f64| {
            let p = o + d * t;
            let relief = self.relief(p.truncate(), time);
            (p.z - relief.z, d.z - relief.gradient.dot(across))
        };
        let mut t = near;
        let (mut g, mut slope) = along(t);
        let mut side = g.signum();
        if from_start && g.abs() < 8.0 * f64::EPSILON * (o.abs().max_element() + self.highest) {
            // The step below for g = 0, half of it: the ray is off the surface and has met nothing.
            side = slope.signum();
            t += slope.abs() / bend;
            if t > far || t.is_nan() {
                return None;
            }
            (g, slope) = along(t);
        }
        // What rounding of t leaves undecided; also what makes the loop finite.
        let least = 4.0 * f64::EPSILON * near.abs().max(far.abs());
        while side * g > 0.0 {
            let (height, fall) = (side * g, -side * slope);
            let root = (fall * fall + 2.0 * bend * height).sqrt();
            let step = if fall > 0.0 {
                2.0 * height / (fall + root)
            } else if bend > 0.0 {
                (root - fall) / bend
            } else {
                f64::INFINITY
            };
            if step < least {
                return Some(t);
            }
            t += step;
            if t > far || t.is_nan() {
                return None;
            }
            (g, slope) = along(t);
        }
        // Zero or, by rounding, just beyond: a last Newton step puts t back.
        let corrected = t - g / slope;
        Some(if corrected.is_finite() && (corrected - t).abs() < 1e3 * least { corrected.clamp(near, far) } else { t })
    }

    pub(super) fn bounds(&self) -> Bounds3 {
        let half = self.frame.t.abs() * self.half_size.x
            + self.frame.b.abs() * self.half_size.y
            + self.frame.n.abs() * self.highest;
        Bounds3 { min: self.centre - half, max: self.centre + half }
    }

    pub(super) fn surface_at(&self, p: Point3, time: f64) -> LocalSurface {
        let at = self.frame.project(p - self.centre);
        let relief = self.relief(at, time);
        let slope = relief.gradient;
        let length = (1.0 + slope.length_squared()).sqrt();
        let n = (-slope).extend(1.0) / length;
        // S = (I − N Nᵀ) H/|g| for the implicit z − height(x, y) = 0, whose Hessian is minus the height's.
        let hessian = glam::DMat3::from_cols(
            Vec3::new(-relief.zxx, -relief.zxy, 0.0),
            Vec3::new(-relief.zxy, -relief.zyy, 0.0),
            Vec3::ZERO,
        );
        let local = (glam::DMat3::IDENTITY - super::outer(n, n)) * hessian * (1.0 / length);
        let axes = glam::DMat3::from_cols(self.frame.t, self.frame.b, self.frame.n);
        LocalSurface {
            p: self.centre + self.frame.to_world(at.extend(relief.z)),
            n: Normal3::from_unit(self.frame.to_world(n)),
            shape: ShapeOperator::from_matrix(axes * local * axes.transpose()),
        }
    }

    pub(super) fn parametrisation_at(&self, p: Point3, time: f64) -> Parametrisation {
        let at = self.frame.project(p - self.centre);
        let slope = self.relief(at, time).gradient;
        Parametrisation {
            uv: (at / self.half_size + Vec2::ONE) * 0.5,
            dpdu: self.frame.to_world(Vec3::new(1.0, 0.0, slope.x)) * (2.0 * self.half_size.x),
            dpdv: self.frame.to_world(Vec3::new(0.0, 1.0, slope.y)) * (2.0 * self.half_size.y),
        }
    }
}
