//! Quartets of the warps: inverse(sample(u)) = u, Jacobian = difference, |∂x/∂u × ∂x/∂v| · pdf = 1, samples against
//! the density.

use std::f64::consts::PI;

use pdembree::math::{Dir3, Point3, Vec2, Vec3};
use pdembree::medium::HenyeyGreenstein;
use pdembree::sampling::warp::{
    ConcentricDisk, CosineHemisphere, CylinderSphere, Parallelogram, Triangle, UniformCone, UniformHemisphere,
    UniformSphere, Warp,
};
use pdembree::sampling::{Purpose, Stream};

use crate::support::quartet::{difference, with};
use crate::support::statistics::{assert_plausible, chi2_test};

const SEED: u64 = 20070;

const PARALLELOGRAM: Parallelogram =
    Parallelogram { centre: Point3::new(1.0, 2.0, 3.0), a: Vec3::new(0.5, 0.1, -0.2), b: Vec3::new(0.3, -0.8, 0.4) };
const TRIANGLE: Triangle =
    Triangle { corners: [Point3::new(1.0, 2.0, 3.0), Point3::new(2.0, 2.5, 2.0), Point3::new(0.7, 4.0, 3.3)] };

/// Whatever a warp gives, as a vector.
trait Vector {
    fn vector(self) -> Vec3;
}
impl Vector for Vec2 {
    fn vector(self) -> Vec3 {
        self.extend(0.0)
    }
}
impl Vector for Vec3 {
    fn vector(self) -> Vec3 {
        self
    }
}
impl Vector for Dir3 {
    fn vector(self) -> Vec3 {
        self.to_vec()
    }
}
impl Vector for Point3 {
    fn vector(self) -> Vec3 {
        self.to_vec()
    }
}

/// Lines of the unit square on which a map is not smooth, as functions that are zero there.
type Seams = fn([f64; 2]) -> Vec<f64>;

fn smooth(_: [f64; 2]) -> Vec<f64> {
    vec![]
}
fn diagonals([u, v]: [f64; 2]) -> Vec<f64> {
    vec![u - v, u + v - 1.0]
}
/// The octahedron's edges.
fn octahedral([u, v]: [f64; 2]) -> Vec<f64> {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    vec![a, b, a.abs() + b.abs() - 1.0]
}

/// Checks the quartet at random points; `size` is the largest length that `sample` gives.
fn check_quartet<W: Warp>(name: &str, warp: &W, size: f64, seams: Seams)
where
    W::Out: Vector,
    W::Tangent: Vector,
{
    let mut stream = Stream::new(SEED, Purpose::Test, 0, 0);
    for i in 0..2000 {
        let u = stream.uniform2();
        let x = warp.sample(u);
        let jacobian = warp.jacobian(u).map(Vector::vector);
        let at = format!("{name} at u = {u:?} (draw {i} of seed {SEED})");

        let back = warp.inverse(x).unwrap_or_else(|| panic!("{at}: no inverse of its own sample"));
        // Rounding of x, as u sees it through the inverse Jacobian, whose entries are |column|·pdf.
        let steepness = warp.pdf(x).get() * jacobian[0].length().max(jacobian[1].length());
        for k in 0..2 {
            let bound = 32.0 * f64::EPSILON * (1.0 + size * steepness);
            assert!((back[k] - u[k]).abs() <= bound, "{at}: inverse gives {back:?}, bound {bound:e}");
        }

        for k in 0..2 {
            // The difference needs room on both sides.
            let room = seams(u).into_iter().fold(u[k].min(1.0 - u[k]), |room, s| room.min(s.abs()));
            if room < 1e-3 {
                continue;
            }
            let (expected, bound) = difference(|t| warp.sample(with(u, k, t)).vector(), u[k], size);
            assert!((jacobian[k] - expected).length() <= bound, "{at}: column {k} {} ≠ {expected}", jacobian[k]);
        }

        let det = jacobian[0].cross(jacobian[1]).length() * warp.pdf(x).get();
        // Near the horizon 1 − r² loses digits, which both factors feel.
        let bound = 32.0 * f64::EPSILON * (1.0 + size * steepness).powi(2);
        assert!((det - 1.0).abs() <= bound, "{at}: |det|·pdf = {det}, bound {bound:e}");
    }
}

/// Mean cosines of phase functions.
const PHASES: [f64; 5] = [-0.6, 0.0, 1e-9, 0.3, 0.8];

#[test]
fn quartets_of_all_warps() {
    check_quartet("concentric disk", &ConcentricDisk, 1.0, diagonals);
    check_quartet("cosine hemisphere", &CosineHemisphere, 1.0, diagonals);
    check_quartet("uniform sphere", &UniformSphere, 1.0, octahedral);
    check_quartet("cylinder", &CylinderSphere, 1.0, smooth);
    check_quartet("uniform hemisphere", &UniformHemisphere, 1.0, diagonals);
    for cos in [0.999_999, 0.8, 0.0, -0.7] {
        check_quartet(&format!("cone of cosine {cos}"), &UniformCone::from_cos(cos), 1.0, diagonals);
    }
    check_quartet("narrow cone", &UniformCone::from_sin_squared(1e-12), 1.0, diagonals);
    check_quartet("parallelogram", &PARALLELOGRAM, 5.0, smooth);
    check_quartet("triangle", &TRIANGLE, 5.0, diagonals);
    for g in PHASES {
        check_quartet(&format!("phase function of g = {g}"), &HenyeyGreenstein::new(g), 1.0, diagonals);
    }
}

/// Corners, edges and centre of the unit square, where maps have their seams and singular points.
fn edge_points() -> Vec<[f64; 2]> {
    let top = 1.0 - f64::EPSILON / 2.0;
    let ticks = [0.0, f64::MIN_POSITIVE, 0.25, 0.5, 0.75, top];
    ticks.iter().flat_map(|&a| ticks.iter().map(move |&b| [a, b])).collect()
}

fn check_edges<W: Warp>(name: &str, warp: &W)
where
    W::Out: Vector,
    W::Tangent: Vector,
{
    for u in edge_points() {
        let x = warp.sample(u);
        assert!(x.vector().is_finite(), "{name}: sample({u:?}) is not finite");
        assert!(warp.pdf(x).get() > 0.0, "{name}: a sample at {u:?} has no density");
        assert!(warp.jacobian(u).map(Vector::vector).iter().all(|c| c.is_finite()), "{name}: Jacobian at {u:?}");
        let back = warp.inverse(x).unwrap_or_else(|| panic!("{name}: no inverse at {u:?}"));
        // Seams are folded onto themselves: another u may stand for the same point, but it must be the same point.
        let (again, first) = (warp.sample(back).vector(), x.vector());
        // Half the digits survive where a map has a square root.
        assert!((again - first).length() <= 4.0 * f64::EPSILON.sqrt() * (1.0 + first.length()), "{name} at {u:?}");
    }
}

#[test]
fn the_edges_of_the_unit_square_are_safe() {
    check_edges("concentric disk", &ConcentricDisk);
    check_edges("cosine hemisphere", &CosineHemisphere);
    check_edges("uniform sphere", &UniformSphere);
    check_edges("cylinder", &CylinderSphere);
    check_edges("uniform hemisphere", &UniformHemisphere);
    check_edges("cone", &UniformCone::from_cos(0.3));
    check_edges("narrow cone", &UniformCone::from_sin_squared(1e-14));
    check_edges("parallelogram", &PARALLELOGRAM);
    check_edges("triangle", &TRIANGLE);
    for g in PHASES {
        check_edges("phase function", &HenyeyGreenstein::new(g));
    }
}

/// Chi² of 100 000 directions in 10 × 12 cells of equal solid angle in [z_min, 1] × azimuth, `share` giving the
/// probability of the band [z0, z1].
fn directions_p_value<W: Warp<Out = Dir3>>(warp: &W, z_min: f64, share: impl Fn(f64, f64) -> f64) -> f64 {
    const BANDS: usize = 10;
    const SECTORS: usize = 12;
    const DRAWS: usize = 100_000;
    let mut stream = Stream::new(SEED, Purpose::Test, 1, 0);
    let mut observed = vec![0u64; BANDS * SECTORS + 1];
    for _ in 0..DRAWS {
        let w = warp.sample(stream.uniform2());
        let band = (w.z - z_min) / (1.0 - z_min) * BANDS as f64;
        let sector = (w.y.atan2(w.x) / (2.0 * PI) + 0.5) * SECTORS as f64;
        // The last cell collects what should not be there; rounding at its rim stays inside.
        let cell = if band < -1e-9 {
            BANDS * SECTORS
        } else {
            (band.max(0.0) as usize).min(BANDS - 1) * SECTORS + (sector as usize).min(SECTORS - 1)
        };
        observed[cell] += 1;
    }
    let z = |band: usize| z_min + (1.0 - z_min) * band as f64 / BANDS as f64;
    let mut expected: Vec<f64> = (0..BANDS * SECTORS)
        .map(|cell| share(z(cell / SECTORS), z(cell / SECTORS + 1)) * DRAWS as f64 / SECTORS as f64)
        .collect();
    expected.push(0.0);
    chi2_test(&observed, &expected)
}

#[test]
fn directions_follow_their_densities() {
    let cone = |cos: f64| (UniformCone::from_cos(cos), cos);
    let n = 7 + PHASES.len();
    let p = directions_p_value(&CosineHemisphere, 0.0, |a, b| b * b - a * a);
    assert_plausible(p, n, format!("cosine hemisphere, seed {SEED}"));
    let p = directions_p_value(&UniformSphere, -1.0, |a, b| 0.5 * (b - a));
    assert_plausible(p, n, format!("uniform sphere, seed {SEED}"));
    let p = directions_p_value(&CylinderSphere, -1.0, |a, b| 0.5 * (b - a));
    assert_plausible(p, n, format!("cylinder, seed {SEED}"));
    let p = directions_p_value(&UniformHemisphere, 0.0, |a, b| b - a);
    assert_plausible(p, n, format!("uniform hemisphere, seed {SEED}"));
    for (warp, cos) in [cone(0.8), cone(0.0), cone(-0.7)] {
        let p = directions_p_value(&warp, cos, |a, b| (b - a) / (1.0 - cos));
        assert_plausible(p, n, format!("cone of cosine {cos}, seed {SEED}"));
    }
    for g in PHASES {
        // ∫ p dω up to a cosine μ, over 2π: (1 − g²)/(2g) (1/√(1 + g² − 2gμ) − 1/(1 + g)), as a difference of roots.
        let up_to = |mu: f64| {
            let (root, end) = ((1.0 + g * g - 2.0 * g * mu).sqrt(), 1.0 + g);
            (1.0 - g * g) * (1.0 + mu) / ((end + root) * root * end)
        };
        let p = directions_p_value(&HenyeyGreenstein::new(g), -1.0, |a, b| up_to(b) - up_to(a));
        assert_plausible(p, n, format!("phase function of g = {g}, seed {SEED}"));
    }
}

#[test]
fn points_follow_their_densities() {
    const DRAWS: usize = 100_000;
    let mut stream = Stream::new(SEED, Purpose::Test, 2, 0);
    // Disk: rings of equal area × sectors.
    let mut disk = vec![0u64; 120];
    // Triangle: the nine similar triangles of a third of its size, by floor of 3·barycentrics.
    let mut triangle = vec![0u64; 9];
    let mut parallelogram = vec![0u64; 64];
    for _ in 0..DRAWS {
        let x = ConcentricDisk.sample(stream.uniform2());
        let (ring, sector) = (x.length_squared() * 10.0, (x.y.atan2(x.x) / (2.0 * PI) + 0.5) * 12.0);
        disk[(ring as usize).min(9) * 12 + (sector as usize).min(11)] += 1;

        let [p0, p1, p2] = TRIANGLE.corners;
        let (e1, e2, d) = (p1 - p0, p2 - p0, TRIANGLE.sample(stream.uniform2()) - p0);
        let n = e1.cross(e2);
        let b1 = 3.0 * d.cross(e2).dot(n) / n.length_squared();
        let b2 = 3.0 * e1.cross(d).dot(n) / n.length_squared();
        let (i, j) = ((b1 as usize).min(2), (b2 as usize).min(2));
        let upside_down = usize::from(b1.fract() + b2.fract() > 1.0);
        // Rows of 3, 2 and 1 upright triangles with 2, 1 and 0 others between them.
        let row_start = [0, 5, 8][j];
        triangle[(row_start + 2 * i + upside_down).min(8)] += 1;

        let d = PARALLELOGRAM.sample(stream.uniform2()) - PARALLELOGRAM.centre;
        let n = PARALLELOGRAM.a.cross(PARALLELOGRAM.b);
        let s = d.cross(PARALLELOGRAM.b).dot(n) / n.length_squared();
        let t = PARALLELOGRAM.a.cross(d).dot(n) / n.length_squared();
        let tick = |x: f64| (((x + 1.0) * 4.0) as usize).min(7);
        parallelogram[tick(s) * 8 + tick(t)] += 1;
    }
    for (name, counts) in [("disk", disk), ("triangle", triangle), ("parallelogram", parallelogram)] {
        let expected = vec![DRAWS as f64 / counts.len() as f64; counts.len()];
        assert_plausible(chi2_test(&counts, &expected), 3, format!("{name}, seed {SEED}"));
    }
}

#[test]
fn a_cone_that_opens_moves_its_directions_as_the_derivative_says() {
    let mut stream = Stream::new(SEED, Purpose::Test, 3, 0);
    for cos in [0.99, 0.5, -0.2] {
        for _ in 0..100 {
            let u = stream.uniform2();
            let height = 1.0 - cos;
            let direction = |h: f64| UniformCone::from_cos(1.0 - h).sample(u).to_vec();
            let (expected, bound) = difference(direction, height, 1.0);
            let cone = UniformCone::from_cos(cos);
            let got = cone.height_derivative(cone.sample(u));
            assert!((got - expected).length() <= bound, "cos {cos}, u = {u:?}: {got} ≠ {expected} ± {bound:e}");
        }
    }
}
