//! The f64 ray–triangle test of the backends `brute` and `obvhs`.
//!
//! Unit: the ray's and the corners' common one; `t` in units of the ray's direction. Frame: any. The ray's dominant
//! axis becomes z by a permutation, a shear puts the ray onto that axis, and three edge functions say on which side of
//! each edge it passes [Woop13 3].
//!
//! **Edge rule**: edges and corners belong to the triangle. A corner's sheared position depends on corner and ray
//! alone, so two triangles with a common edge see the same two points. Rounding a product is monotonic, so an edge
//! function a·b − c·d, computed without fused operations, is never of the wrong sign: it can only become zero, and
//! zero counts as inside. A ray through a common edge or corner therefore hits at least one of the triangles around
//! it. Seen exactly edge-on, where all three functions vanish, a triangle has no hit.

use crate::math::{Point3, Ray, Vec3};

/// A hit with p = (1−u−v) p0 + u p1 + v p2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// In units of the ray's direction.
    pub t: f64,
    pub u: f64,
    pub v: f64,
}

/// A ray prepared for many triangles.
#[derive(Clone, Copy, Debug)]
pub struct ShearedRay {
    origin: Vec3,
    /// The dominant axis of the direction, last, and the other two.
    axes: [usize; 3],
    /// d_x/d_z, d_y/d_z, 1/d_z of the permuted direction [Woop13 3.1].
    shear: [f64; 3],
    t_min: f64,
    time: f64,
}

impl ShearedRay {
    pub fn new(ray: &Ray) -> ShearedRay {
        let d = ray.direction.to_array();
        let magnitude = d.map(f64::abs);
        let z = (1..3).fold(0, |best, axis| if magnitude[axis] > magnitude[best] { axis } else { best });
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        ShearedRay {
            origin: ray.origin.to_vec(),
            axes: [x, y, z],
            shear: [d[x] / d[z], d[y] / d[z], 1.0 / d[z]],
            t_min: ray.t_min,
            time: ray.time,
        }
    }

    /// When it flies.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The hit with t in (t_min of the ray, `end`), from either side.
    pub fn intersect(&self, corners: [Point3; 3], end: f64) -> Option<TriangleHit> {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = corners.map(|p| self.to_sheared(p));
        // Twice the signed areas opposite to the corners: unnormalised weights of p0, p1, p2.
        let w0 = cx * by - cy * bx;
        let w1 = ax * cy - ay * cx;
        let w2 = bx * ay - by * ax;
        let outside = (w0 < 0.0 || w1 < 0.0 || w2 < 0.0) && (w0 > 0.0 || w1 > 0.0 || w2 > 0.0);
        let area = w0 + w1 + w2;
        if outside || area == 0.0 {
            return None;
        }
        let t = (w0 * az + w1 * bz + w2 * cz) / area * self.shear[2];
        // Written so that a NaN fails.
        (t > self.t_min && t < end).then(|| TriangleHit { t, u: w1 / area, v: w2 / area })
    }

    /// A corner relative to the origin: sheared x and y, and its unscaled depth along the dominant axis.
    fn to_sheared(self, p: Point3) -> [f64; 3] {
        let q = (p.to_vec() - self.origin).to_array();
        let z = q[self.axes[2]];
        [q[self.axes[0]] - self.shear[0] * z, q[self.axes[1]] - self.shear[1] * z, z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Dir3;

    const CORNERS: [Point3; 3] = [Point3::new(0.0, 0.0, 2.0), Point3::new(1.0, 0.0, 2.0), Point3::new(0.0, 1.0, 3.0)];

    fn ray(origin: [f64; 3], towards: Point3) -> Ray {
        let origin = Point3::from(origin);
        Ray { origin, direction: towards - origin, t_min: 0.0, t_max: f64::INFINITY, time: 0.0 }
    }

    #[test]
    fn weights_and_distance_are_the_points_own() {
        // Inside: by rounding, a corner or an edge belongs to any of the triangles that share it.
        for (u, v) in [(0.25, 0.5), (0.0625, 0.0625), (0.875, 0.0625), (0.0625, 0.875), (0.125, 0.25), (0.5, 0.25)] {
            let p = CORNERS[0] + (CORNERS[1] - CORNERS[0]) * u + (CORNERS[2] - CORNERS[0]) * v;
            for origin in [[0.0, 0.0, 0.0], [3.0, -1.0, 9.0], [-5.0, 0.25, 2.0]] {
                let r = ray(origin, p);
                let hit = ShearedRay::new(&r).intersect(CORNERS, r.t_max).expect("aimed at the triangle");
                // The points above are exact in f64, so what is left is a few roundings of numbers below 16.
                let bound = 64.0 * f64::EPSILON;
                assert!(
                    (hit.t - 1.0).abs() < bound && (hit.u - u).abs() < bound && (hit.v - v).abs() < bound,
                    "{hit:?}"
                );
            }
        }
    }

    #[test]
    fn the_interval_is_open() {
        let r = ray([0.25, 0.25, 0.0], Point3::new(0.25, 0.25, 2.25));
        let hit = |t_min, end| ShearedRay::new(&Ray { t_min, ..r }).intersect(CORNERS, end).map(|h| h.t);
        assert_eq!(hit(0.0, 2.0), Some(1.0));
        assert_eq!(hit(1.0, 2.0), None);
        assert_eq!(hit(0.0, 1.0), None);
        assert_eq!(hit(1.0f64.next_down(), 1.0f64.next_up()), Some(1.0));
    }

    #[test]
    fn edge_on_and_degenerate_triangles_are_not_hit() {
        let flat = [Point3::ORIGIN, Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
        let along = Ray::new(Point3::new(-1.0, 0.25, 0.0), Dir3::X);
        assert_eq!(ShearedRay::new(&along).intersect(flat, f64::INFINITY), None);
        let point = [Point3::new(0.0, 0.25, 0.0); 3];
        assert_eq!(ShearedRay::new(&along).intersect(point, f64::INFINITY), None);
    }
}
