//! Loop's subdivision: a mesh of triangles, refined some times, its vertices moved to where endless refinement takes them
//! and given the limit's normals · object space.
//!
//! Rules and limits by `[Loop87]` and `[Hoppe94]`; the boundary of an open mesh is a cubic B-spline.

use std::collections::HashMap;

use glam::DVec3;

/// Points and triangles over them, as they are refined.
pub(super) struct Control {
    pub points: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

/// The neighbours of a vertex.
struct Ring {
    /// In order about the vertex, counter-clockwise; from one end of the boundary to the other where it is open.
    around: Vec<u32>,
    is_boundary: bool,
}

/// The limit's points and unit normals.
pub(super) struct Limit {
    pub points: Vec<DVec3>,
    pub normals: Vec<DVec3>,
}

impl Control {
    /// Why it cannot be subdivided, if it cannot: an edge of more than two triangles or of two that run along it in the same
    /// direction, or a vertex at which the surface only touches itself.
    pub fn check(&self) -> Result<(), &'static str> {
        let mut edges = HashMap::new();
        for edge in self.edges() {
            if edge[0] == edge[1] {
                return Err("has a triangle that names a vertex twice");
            }
            if edges.insert(edge, ()).is_some() {
                return Err("has an edge of triangles that face opposite ways, or of more than two");
            }
        }
        self.rings().map(drop).ok_or("touches itself at a vertex")
    }

    fn edges(&self) -> impl Iterator<Item = [u32; 2]> {
        self.triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]])
    }

    /// The ring of each vertex; of one without triangles it is empty. `None` if a vertex has more than one fan.
    fn rings(&self) -> Option<Vec<Ring>> {
        // For each vertex, what comes after what.
        let mut next: Vec<Vec<[u32; 2]>> = vec![Vec::new(); self.points.len()];
        for [a, b, c] in &self.triangles {
            next[*a as usize].push([*b, *c]);
            next[*b as usize].push([*c, *a]);
            next[*c as usize].push([*a, *b]);
        }
        next.iter().map(|steps| ring(steps)).collect()
    }

    /// Each triangle becomes four.
    pub fn refined(&self) -> Option<Control> {
        let rings = self.rings()?;
        let moved = |(vertex, ring): (usize, &Ring)| self.even(vertex, ring);
        let mut points: Vec<DVec3> = rings.iter().enumerate().map(moved).collect();
        let mut opposite: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
        for [a, b, c] in &self.triangles {
            for ([from, to], apex) in [([a, b], c), ([b, c], a), ([c, a], b)] {
                opposite.entry([*from.min(to), *from.max(to)]).or_default().push(*apex);
            }
        }
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let mut triangles = Vec::with_capacity(4 * self.triangles.len());
        for [a, b, c] in &self.triangles {
            let [ab, bc, ca] = [[*a, *b], [*b, *c], [*c, *a]].map(|[from, to]| {
                let edge = [from.min(to), from.max(to)];
                *middles.entry(edge).or_insert_with(|| {
                    points.push(self.odd(edge, &opposite[&edge]));
                    points.len() as u32 - 1
                })
            });
            triangles.extend([[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]);
        }
        Some(Control { points, triangles })
    }

    fn point(&self, vertex: u32) -> DVec3 {
        self.points[vertex as usize]
    }

    fn sum(&self, vertices: &[u32]) -> DVec3 {
        vertices.iter().map(|v| self.point(*v)).sum()
    }

    /// A new vertex on an edge with these opposite corners.
    fn odd(&self, [a, b]: [u32; 2], apexes: &[u32]) -> DVec3 {
        let ends = self.point(a) + self.point(b);
        match apexes {
            [left, right] => 0.375 * ends + 0.125 * (self.point(*left) + self.point(*right)),
            _ => 0.5 * ends,
        }
    }

    /// Where an old vertex goes.
    fn even(&self, vertex: usize, ring: &Ring) -> DVec3 {
        let own = self.points[vertex];
        match &ring.around[..] {
            [] => own,
            [first, .., last] if ring.is_boundary => 0.75 * own + 0.125 * (self.point(*first) + self.point(*last)),
            around => {
                let weight = interior_weight(around.len());
                (1.0 - around.len() as f64 * weight) * own + weight * self.sum(around)
            }
        }
    }

    /// Where endless refinement takes the vertices, and the normals there. A vertex without triangles stays, its normal is +z.
    pub fn limit(&self) -> Option<Limit> {
        let rings = self.rings()?;
        let mut faces = vec![DVec3::ZERO; self.points.len()];
        for [a, b, c] in &self.triangles {
            let normal = (self.point(*b) - self.point(*a)).cross(self.point(*c) - self.point(*a));
            [a, b, c].iter().for_each(|v| faces[**v as usize] += normal);
        }
        let point = |(vertex, ring): (usize, &Ring)| self.limit_point(vertex, ring);
        let normal = |(vertex, ring): (usize, &Ring)| {
            let [s, t] = self.tangents(vertex, ring);
            // Where the tangents say nothing, the triangles' mean does.
            s.cross(t).try_normalize().or(faces[vertex].try_normalize()).unwrap_or(DVec3::Z)
        };
        let points = rings.iter().enumerate().map(point).collect();
        Some(Limit { points, normals: rings.iter().enumerate().map(normal).collect() })
    }

    fn limit_point(&self, vertex: usize, ring: &Ring) -> DVec3 {
        let own = self.points[vertex];
        match &ring.around[..] {
            [] => own,
            // Of a cubic B-spline, which the refined boundary goes to.
            [first, .., last] if ring.is_boundary => (4.0 * own + self.point(*first) + self.point(*last)) / 6.0,
            around => {
                let n = around.len() as f64;
                let weight = 1.0 / (n + 0.375 / interior_weight(around.len()));
                (1.0 - n * weight) * own + weight * self.sum(around)
            }
        }
    }

    /// Along and across the limit surface at a vertex; s × t is on the side that triangles face.
    fn tangents(&self, vertex: usize, ring: &Ring) -> [DVec3; 2] {
        let (own, around) = (self.points[vertex], &ring.around[..]);
        if !ring.is_boundary {
            let step = std::f64::consts::TAU / around.len() as f64;
            let weighted = |f: fn(f64) -> f64| {
                let term = |(i, v): (usize, &u32)| f(step * i as f64) * self.point(*v);
                around.iter().enumerate().map(term).sum::<DVec3>()
            };
            return [weighted(f64::cos), weighted(f64::sin)];
        }
        let [first, .., last] = around else { return [DVec3::ZERO; 2] };
        let (first, last) = (self.point(*first), self.point(*last));
        let across = match around.len() {
            2 => first + last - 2.0 * own,
            3 => self.point(around[1]) - own,
            4 => 2.0 * (self.point(around[1]) + self.point(around[2])) - first - last - 2.0 * own,
            n => {
                let step = std::f64::consts::PI / (n - 1) as f64;
                let inner = (1..n - 1).map(|i| {
                    let weight = (2.0 * step.cos() - 2.0) * (step * i as f64).sin();
                    weight * self.point(around[i])
                });
                -(step.sin() * (first + last) + inner.sum::<DVec3>())
            }
        };
        // From the last to the first the boundary runs so that the surface is on its left.
        [first - last, across]
    }
}

/// The weight of each neighbour of an old vertex of the valence `n` `[Loop87]`, 3/16 for three.
fn interior_weight(n: usize) -> f64 {
    if n == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * n as f64) }
}

/// Steps from neighbour to neighbour put together; `None` where they are no single fan.
fn ring(steps: &[[u32; 2]]) -> Option<Ring> {
    let after: HashMap<u32, u32> = steps.iter().map(|[from, to]| (*from, *to)).collect();
    let ends: std::collections::HashSet<u32> = steps.iter().map(|[_, to]| *to).collect();
    if after.len() != steps.len() || ends.len() != steps.len() {
        return None;
    }
    let mut starts = steps.iter().map(|[from, _]| *from).filter(|from| !ends.contains(from));
    let (start, another) = (starts.next(), starts.next());
    if another.is_some() {
        return None;
    }
    let Some(first) = start.or(steps.first().map(|[from, _]| *from)) else {
        return Some(Ring { around: Vec::new(), is_boundary: false });
    };
    let mut around = vec![first];
    let mut at = first;
    while let Some(next) = after.get(&at).filter(|next| **next != first) {
        around.push(*next);
        at = *next;
    }
    let expected = if start.is_some() { steps.len() + 1 } else { steps.len() };
    (around.len() == expected).then_some(Ring { around, is_boundary: start.is_some() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn octahedron() -> Control {
        let points = vec![DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        let side = |i: u32| [i, (i + 1) % 4];
        let up = (0..4).map(|i| [side(i)[0], side(i)[1], 4]);
        let down = (0..4).map(|i| [side(i)[1], side(i)[0], 5]);
        Control { points, triangles: up.chain(down).collect() }
    }

    /// A square of 4 × 4 cells in the plane z = 0, which any rule must leave there.
    fn sheet() -> Control {
        let points = (0..25).map(|i| DVec3::new(f64::from(i % 5), f64::from(i / 5), 0.0)).collect();
        let cell = |i: u32| {
            let corner = i % 4 + 5 * (i / 4);
            [[corner, corner + 1, corner + 6], [corner, corner + 6, corner + 5]]
        };
        Control { points, triangles: (0..16).flat_map(cell).collect() }
    }

    /// For valence 4, β = 3/32: 4 · 3/32 = 3/8 of the neighbours, whose mean is 0; the limit weight is 1/(4 + 4) = 1/8.
    #[test]
    fn an_octahedron_goes_where_the_rules_say() {
        let control = octahedron();
        control.check().expect("closed");
        let limit = control.limit().expect("rings");
        for (point, (normal, old)) in limit.points.iter().zip(limit.normals.iter().zip(&control.points)) {
            assert!((*point - 0.5 * *old).length() < 1e-15 && (*normal - *old).length() < 1e-15);
        }
        let refined = control.refined().expect("rings");
        assert_eq!((refined.points.len(), refined.triangles.len()), (18, 32));
        assert!((refined.points[0] - 0.625 * DVec3::X).length() < 1e-15);
    }

    /// The limit does not depend on how often it is refined before.
    #[test]
    fn refinement_keeps_the_limit() {
        for control in [octahedron(), sheet()] {
            let limit = control.limit().expect("rings");
            let again = control.refined().and_then(|c| c.refined()).and_then(|c| c.limit()).expect("rings");
            for vertex in 0..control.points.len() {
                assert!((limit.points[vertex] - again.points[vertex]).length() < 1e-14, "{vertex}");
                assert!((limit.normals[vertex] - again.normals[vertex]).length() < 1e-12, "{vertex}");
            }
        }
    }

    #[test]
    fn a_sheet_stays_flat_and_faces_the_same_side() {
        let limit = sheet().refined().and_then(|c| c.limit()).expect("rings");
        assert!(limit.points.iter().all(|p| p.z == 0.0));
        for (point, normal) in limit.points.iter().zip(&limit.normals) {
            assert!((*normal - DVec3::Z).length() < 1e-12, "{point}: {normal}");
        }
    }

    #[test]
    fn what_is_no_surface_is_refused() {
        let mut control = octahedron();
        control.triangles.push([0, 1, 5]);
        assert!(control.check().expect_err("three at an edge").contains("edge"));
        let bow = Control { points: vec![DVec3::ZERO; 5], triangles: vec![[0, 1, 2], [0, 3, 4]] };
        assert!(bow.check().expect_err("a bow tie").contains("touches"));
    }
}
