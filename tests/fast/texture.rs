//! Filtered texture lookups against closed forms: constants, ramps, second moments, gratings, wraps.

use pdembree::math::Vec2;
use pdembree::radiometry::Spectrum;
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::texture::{Placement, Texels, Wrap};
use pdembree::scene::{ImageTexture, TextureId, Textured};
use pdembree::surface::mipmap::MipMap;
use pdembree::surface::{Lookup, Textures};

const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror];
const POINT: [Vec2; 2] = [Vec2::ZERO; 2];

/// An image of `f(i, j)`, i to the right, j downwards.
fn image(width: usize, height: usize, wrap: Wrap, f: impl Fn(f64, f64) -> f64) -> ImageTexture {
    let texel = |k: usize| [f((k % width) as f64, (k / width) as f64) as f32; 3];
    let texels = (0..width * height).map(texel).collect();
    ImageTexture { texels: Texels::new(width, height, texels), wrap: [wrap; 2], placement: Placement::IDENTITY }
}

/// A footprint given in texels of a square image, columns turned by `angle`.
fn footprint(size: usize, major: f64, minor: f64, angle: f64) -> [Vec2; 2] {
    let (sin, cos) = angle.sin_cos();
    [major * Vec2::new(cos, -sin), minor * Vec2::new(sin, cos)].map(|d| d / size as f64)
}

/// J Jᵀ/4 + I/8 as (xx, xy, yy) in texels, rows downwards: what a lookup's covariance should be.
fn covariance(size: usize, columns: [Vec2; 2]) -> [f64; 3] {
    let [a, b] = columns.map(|d| d * Vec2::new(size as f64, -(size as f64)));
    let [xx, xy, yy] = [a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y];
    [0.25 * xx + 0.125, 0.25 * xy, 0.25 * yy + 0.125]
}

/// The uv of a point given in texels.
fn at(size: usize, i: f64, j: f64) -> Vec2 {
    Vec2::new((i + 0.5) / size as f64, 1.0 - (j + 0.5) / size as f64)
}

/// Footprints from magnified to some texels wide, round and long: (major, minor, angle).
const FOOTPRINTS: [(f64, f64, f64); 9] = [
    (0.0, 0.0, 0.0),
    (0.3, 0.1, 1.0),
    (1.0, 1.0, 0.0),
    (2.0, 0.5, 0.5),
    (3.0, 3.0, 0.0),
    (5.0, 1.0, 2.0),
    (6.0, 4.0, -0.7),
    (12.0, 1.5, 0.3),
    (9.0, 9.0, 0.0),
];

#[test]
fn a_constant_image_is_constant_to_the_last_bit() {
    let mut stream = Stream::new(4, Purpose::Test, 0, 0);
    for wrap in WRAPS {
        for (width, height) in [(1, 1), (7, 3), (64, 64), (1, 100)] {
            let map = MipMap::new(&image(width, height, wrap, |_, _| 0.3));
            for _ in 0..200 {
                let uv = Vec2::from_array(stream.uniform2()) * 6.0 - 3.0;
                let size = 10f64.powf(4.0 * stream.uniform() - 3.0);
                let d = [Vec2::from_array(stream.uniform2()) * size, Vec2::from_array(stream.uniform2()) * size];
                assert_eq!(map.filtered(uv, d), Spectrum::splat(f64::from(0.3f32)), "{width}×{height} {uv} {d:?}");
            }
        }
    }
}

#[test]
fn a_ramp_is_its_value_at_the_centre() {
    let size = 256;
    let map = MipMap::new(&image(size, size, Wrap::Clamp, |i, j| 2.0 * i - 5.0 * j));
    let mut stream = Stream::new(5, Purpose::Test, 0, 0);
    for (major, minor, angle) in FOOTPRINTS {
        for _ in 0..50 {
            let [i, j] = stream.uniform2().map(|x| 127.0 + 2.0 * x);
            let got = map.filtered(at(size, i, j), footprint(size, major, minor, angle)).r();
            let expected = 2.0 * i - 5.0 * j;
            assert!((got - expected).abs() < 1e-9, "({major}, {minor}, {angle}) at {i} {j}: {got}, not {expected}");
        }
    }
}

/// v = 0 is the lower edge of the bottom row, u = 0 the left edge.
#[test]
fn rows_run_from_the_top() {
    let corner = |i: f64, j: f64| i + 10.0 * j;
    let map = MipMap::new(&image(2, 2, Wrap::Clamp, corner));
    // Far outside, a clamped image has its corners' values.
    assert_eq!(map.filtered(Vec2::new(-3.0, 4.0), POINT).r(), corner(0.0, 0.0));
    assert_eq!(map.filtered(Vec2::new(3.0, 4.0), POINT).r(), corner(1.0, 0.0));
    assert_eq!(map.filtered(Vec2::new(-3.0, -4.0), POINT).r(), corner(0.0, 1.0));
    assert_eq!(map.filtered(Vec2::new(3.0, -4.0), POINT).r(), corner(1.0, 1.0));
}

/// Second moments measured by looking up x², xy and y²: their mean over points all over four texels, the period of the
/// coarsest level that these footprints reach, and the largest distance of one from what it should be, over the trace.
fn measured_covariance(size: usize, columns: [Vec2; 2], shifts: usize) -> ([f64; 3], f64) {
    let middle = (size / 2) as f64;
    let f = [|x: f64, _: f64| x * x, |x: f64, y: f64| x * y, |_: f64, y: f64| y * y];
    let maps = f.map(|f| MipMap::new(&image(size, size, Wrap::Clamp, move |i, j| f(i - middle, j - middle))));
    let expected = covariance(size, columns);
    let mut mean = [0.0; 3];
    let mut worst = 0.0f64;
    for a in 0..shifts {
        for b in 0..shifts {
            let [x, y] = [a, b].map(|k| 4.0 * (k as f64 + 0.5) / shifts as f64);
            for k in 0..3 {
                let got = maps[k].filtered(at(size, middle + x, middle + y), columns).r() - f[k](x, y);
                mean[k] += got / (shifts * shifts) as f64;
                worst = worst.max((got - expected[k]).abs() / (expected[0] + expected[2]));
            }
        }
    }
    (mean, worst)
}

/// How far second moments of a kernel of variance `sigma2`, sampled at texels, are from the kernel's own, relative to
/// it. By Poisson's sum the moment and the norm each ripple with the point's place within its texel, by the kernel's
/// transform at the whole frequencies: Σ |∫ x² k cos(2πf·q)|/σ² + |∫ k cos(2πf·q)|, here for the cut Gaussian and the
/// harmonics to the third.
fn ripple(sigma2: f64) -> f64 {
    let cut = (9.0 * sigma2 / 0.880_201_8).sqrt();
    // More spokes than radians in 2π · cut · |f| at the last harmonic, so that the rule in φ is exact.
    let (rings, spokes) = (120, 192);
    let integral = |f: [i32; 2]| {
        let (mut plain, mut squared) = (0.0, 0.0);
        for i in 0..rings {
            let r = cut * (f64::from(i) + 0.5) / f64::from(rings);
            let k = (-4.5 * (r / cut).powi(2)).exp() - (-4.5f64).exp();
            for j in 0..spokes {
                let (sin, cos) = (std::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(spokes)).sin_cos();
                let wave = (std::f64::consts::TAU * r * (f64::from(f[0]) * cos + f64::from(f[1]) * sin)).cos();
                plain += k * r * wave;
                squared += k * r * wave * (r * cos).powi(2);
            }
        }
        [plain, squared]
    };
    let [norm, moment] = integral([0, 0]);
    let whole = (-3..=3).flat_map(|a| (-3..=3).map(move |b| [a, b])).filter(|f| *f != [0, 0]);
    whole.map(integral).map(|[plain, squared]| (plain / norm).abs() + (squared / moment).abs()).sum()
}

/// The ripple for a footprint: of the finest level with variance minor²/4 + 1/8, or of a coarser one, where the variance
/// is 1/3 or more.
fn ripple_of(minor: f64) -> f64 {
    let finest = ripple(0.25 * minor * minor + 0.125);
    if minor * minor < (20.0 - 2.5) / 3.0 { finest } else { ripple(1.0 / 3.0) }
}

#[test]
fn the_covariance_is_that_of_pixel_and_texel() {
    let size = 256;
    for (major, minor, angle) in FOOTPRINTS {
        let columns = footprint(size, major, minor, angle);
        let expected = covariance(size, columns);
        let (mean, worst) = measured_covariance(size, columns, 16);
        let bound = ripple_of(major.min(minor));
        assert!(worst < bound, "({major}, {minor}, {angle}): off by {worst}, bound {bound}");
        // What putting the centre of mass right changes is of second order in the ripple.
        for k in 0..3 {
            let off = (mean[k] - expected[k]).abs() / (expected[0] + expected[2]);
            assert!(off < bound * bound, "({major}, {minor}, {angle}): {mean:?}, not {expected:?}, bound {bound}");
        }
    }
}

/// A grating cos(k·x) comes out times E cos(k·q) with q the kernel: by Taylor's theorem 1 − s²/2 + [0, m₄/24], s² =
/// kᵀΣk, m₄ ≤ 3 s⁴ as neither the cut Gaussian nor a level's box has longer tails than a Gaussian. The Gaussian mean
/// e^(−s²/2) lies in the same interval, so the two are within s⁴/8 and what the ripple of the covariance makes in s²/2.
#[test]
fn gratings_fade_as_under_a_gaussian() {
    let size = 256;
    let mut stream = Stream::new(6, Purpose::Test, 0, 0);
    let mut checked = 0;
    for (major, minor, angle) in FOOTPRINTS {
        let columns = footprint(size, major, minor, angle);
        let [xx, xy, yy] = covariance(size, columns);
        let off = ripple_of(minor) * (xx + yy);
        for _ in 0..20 {
            // A wave vector that makes s² of the order of 0.1.
            let k = (Vec2::from_array(stream.uniform2()) - 0.5) * (1.5 / (xx + yy).sqrt());
            let phase = 6.0 * stream.uniform();
            let [i, j] = stream.uniform2().map(|x| 127.0 + 2.0 * x);
            let map = MipMap::new(&image(size, size, Wrap::Clamp, |i, j| (k.x * i + k.y * j + phase).cos()));
            let got = map.filtered(at(size, i, j), columns).r();
            let s2 = k.x * k.x * xx + 2.0 * k.x * k.y * xy + k.y * k.y * yy;
            let expected = (k.x * i + k.y * j + phase).cos() * (-0.5 * s2).exp();
            let bound = s2 * s2 / 8.0 + 0.5 * off * k.length_squared() + 1e-6;
            // An odd kernel would show in the sine: the ripple of the third moment is within the same terms.
            assert!((got - expected).abs() < bound, "({major}, {minor}, {angle}) {k}: {got}, not {expected} ± {bound}");
            checked += u32::from(bound < 0.05);
        }
    }
    assert!(checked > 50, "only {checked} of the bounds were tight");
}

/// The same against brute force: a random smooth image, point-sampled densely under the Gaussian.
#[test]
fn a_lookup_is_the_mean_of_many_points_under_the_ellipse() {
    let size = 128;
    let mut stream = Stream::new(7, Purpose::Test, 0, 0);
    let waves: Vec<(Vec2, f64)> =
        (0..6).map(|_| ((Vec2::from_array(stream.uniform2()) - 0.5) * 0.3, 6.0 * stream.uniform())).collect();
    let value = |x: f64, y: f64| waves.iter().map(|(k, phase)| (k.x * x + k.y * y + phase).cos()).sum::<f64>();
    let map = MipMap::new(&image(size, size, Wrap::Clamp, value));
    for (major, minor, angle) in FOOTPRINTS.into_iter().filter(|f| f.0 <= 6.0) {
        let columns = footprint(size, major, minor, angle);
        let [xx, xy, yy] = covariance(size, columns);
        let off = ripple_of(minor) * (xx + yy);
        // Cholesky: (x, y) = L (a, b) has the covariance when a and b are standard normal.
        let l11 = xx.sqrt();
        let (l21, l22) = (xy / l11, (yy - xy * xy / xx).sqrt());
        for _ in 0..10 {
            let [i, j] = stream.uniform2().map(|x| 60.0 + 8.0 * x);
            let (mut sum, mut weights) = (0.0, 0.0);
            for a in -30..=30 {
                for b in -30..=30 {
                    let (a, b) = (f64::from(a) / 6.0, f64::from(b) / 6.0);
                    let weight = (-0.5 * (a * a + b * b)).exp();
                    sum += weight * value(i + l11 * a, j + l21 * a + l22 * b);
                    weights += weight;
                }
            }
            let got = map.filtered(at(size, i, j), columns).r();
            // The bounds of the single gratings, added up.
            let bound: f64 = waves
                .iter()
                .map(|(k, _)| {
                    let s2 = k.x * k.x * xx + 2.0 * k.x * k.y * xy + k.y * k.y * yy;
                    s2 * s2 / 8.0 + 0.5 * off * k.length_squared() + 1e-6
                })
                .sum();
            let expected = sum / weights;
            assert!((got - expected).abs() < bound, "({major}, {minor}, {angle}): {got}, not {expected} ± {bound}");
        }
    }
}

/// Magnified, the squares are black and white; level 1 of a checkerboard is grey already; between, a Gaussian of variance
/// σ² an axis leaves e^(−π²σ²) of the contrast (|k|² = 2π²) and a cut one at most its ripple.
#[test]
fn a_checkerboard_becomes_grey() {
    let size = 64;
    let map = MipMap::new(&image(size, size, Wrap::Repeat, |i, j| (i + j) % 2.0));
    for (i, j) in [(3.0, 5.0), (10.0, 21.0)] {
        let centre = map.filtered(at(size, i, j), POINT).r();
        assert!((centre - (i + j) % 2.0).abs() < 0.1, "the middle of a square: {centre}");
        assert!((map.filtered(at(size, i + 0.5, j), POINT).r() - 0.5).abs() < 1e-12, "its border");
    }
    let mut stream = Stream::new(8, Purpose::Test, 0, 0);
    let mut contrast = |width: f64| {
        let away = (0..200).map(|_| {
            let uv = Vec2::from_array(stream.uniform2());
            2.0 * (map.filtered(uv, footprint(size, width, width, 0.4)).r() - 0.5).abs()
        });
        away.fold(0.0, f64::max)
    };
    for width in [1.0, 1.5, 2.0] {
        let sigma2 = 0.25 * width * width + 0.125;
        let (seen, left) = (contrast(width), (-std::f64::consts::PI.powi(2) * sigma2).exp());
        assert!(seen < left + ripple(sigma2), "{width}: {seen}");
    }
    for width in [3.0, 4.0, 8.0, 1000.0] {
        assert!(contrast(width) < 1e-6, "{width}");
    }
}

#[test]
fn images_go_on_beyond_their_borders_as_they_should() {
    let mut stream = Stream::new(9, Purpose::Test, 0, 0);
    for (width, height) in [(16, 16), (9, 5)] {
        let noise: Vec<f64> = (0..width * height).map(|_| stream.uniform()).collect();
        let texture = |wrap| MipMap::new(&image(width, height, wrap, |i, j| noise[j as usize * width + i as usize]));
        let [repeat, clamp, mirror] = WRAPS.map(texture);
        for _ in 0..500 {
            let uv = Vec2::from_array(stream.uniform2());
            let wide = 0.5 * stream.uniform();
            let d = [Vec2::new(wide, 0.3 * wide), Vec2::new(-0.2 * wide, wide)];
            let flipped = d.map(|d| Vec2::new(-d.x, d.y));
            let same = |a: Spectrum, b: Spectrum| assert!((a.r() - b.r()).abs() < 1e-9, "{uv} {d:?}: {a:?} {b:?}");
            same(repeat.filtered(uv, d), repeat.filtered(uv + Vec2::new(3.0, -2.0), d));
            same(mirror.filtered(uv, d), mirror.filtered(uv + Vec2::new(4.0, -2.0), d));
            same(mirror.filtered(uv, d), mirror.filtered(Vec2::new(-uv.x, uv.y), flipped));
            same(mirror.filtered(uv, d), mirror.filtered(Vec2::new(2.0 - uv.x, uv.y), flipped));
            same(clamp.filtered(Vec2::new(-9.0, uv.y), POINT), clamp.filtered(Vec2::new(-1e30, uv.y), POINT));
            let values = [&repeat, &clamp, &mirror].map(|m| m.filtered(uv, d).r());
            assert!(values.iter().all(|v| (0.0..=1.0).contains(v)), "{uv} {d:?}: {values:?} leaves the image's range");
        }
    }
}

#[test]
fn a_footprint_without_bounds_sees_the_mean() {
    let mut stream = Stream::new(10, Purpose::Test, 0, 0);
    let noise: Vec<f64> = (0..35).map(|_| stream.uniform()).collect();
    let map = MipMap::new(&image(7, 5, Wrap::Repeat, |i, j| noise[j as usize * 7 + i as usize]));
    let mean = noise.iter().sum::<f64>() / 35.0;
    for far in [100.0, 1e100, 1e200, f64::INFINITY, f64::NAN] {
        let got = map.filtered(Vec2::new(0.3, 0.6), [Vec2::new(far, 0.0), Vec2::new(0.0, far)]).r();
        // Texels are stored in f32.
        assert!((got - mean).abs() < 1e-6, "{far}: {got}, not {mean}");
    }
}

/// A needle a thousand times longer than wide is widened to a sixteenth of its length, and reads no more than that.
#[test]
fn needles_are_widened() {
    let size = 1024;
    let columns = footprint(size, 48.0, 0.048, 0.0);
    let map = MipMap::new(&image(size, size, Wrap::Clamp, |_, j| (j - 512.0).powi(2)));
    // The widened minor axis has a 256th of the major one's variance; averaged over a period of the level.
    let expected = (0.25 * 48.0f64.powi(2) + 0.125) / 256.0;
    let n = 32;
    let mean = (0..n)
        .map(|k| {
            let y = 2.0 * f64::from(k) / f64::from(n);
            map.filtered(at(size, 512.0, 512.0 + y), columns).r() - y * y
        })
        .sum::<f64>()
        / f64::from(n);
    assert!((mean - expected).abs() < ripple(1.0 / 3.0) * expected, "{mean}, not {expected}");
}

#[test]
fn a_factor_tints_an_image() {
    let mut texture = image(4, 4, Wrap::Repeat, |_, _| 0.0);
    texture.texels = Texels::new(4, 4, vec![[0.25, 0.5, 0.75]; 16]);
    let textures = Textures::new(&[texture]);
    let colour = Textured::Image { texture: TextureId(0), factor: Spectrum::rgb(2.0, 1.0, 0.5) };
    assert_eq!(textures.colour(&colour, &Lookup::default()), Spectrum::rgb(0.5, 0.5, 0.375));
    let number = Textured::Image { texture: TextureId(0), factor: 2.0 };
    assert_eq!(textures.number(&number, &Lookup::default()), 1.0);
    assert_eq!(textures.number(&Textured::Constant(0.7), &Lookup::default()), 0.7);
}

/// An image of columns goes on as its wrapping across says, one of rows as that upwards does.
#[test]
fn each_axis_wraps_in_its_own_way() {
    let values = |x: f64| (3.0 * x).sin().abs();
    let along: [fn(f64, f64) -> f64; 2] = [|i, _| i, |_, j| j];
    for (axis, along) in along.into_iter().enumerate() {
        let image = |wrap| ImageTexture { wrap, ..image(8, 8, Wrap::Repeat, |i, j| values(along(i, j))) };
        let map = MipMap::new(&image([Wrap::Clamp, Wrap::Mirror]));
        let same = MipMap::new(&image([[Wrap::Clamp, Wrap::Mirror][axis]; 2]));
        let other = MipMap::new(&image([[Wrap::Mirror, Wrap::Clamp][axis]; 2]));
        let mut differ = 0;
        for (i, j) in [(-3.0, -2.5), (2.0, 9.0), (11.25, 17.0), (5.0, -8.0), (-1.0, 12.0)] {
            let found = map.filtered(at(8, i, j), POINT).r();
            assert!((found - same.filtered(at(8, i, j), POINT).r()).abs() < 1e-12, "({i}, {j}): {found}");
            differ += u32::from((found - other.filtered(at(8, i, j), POINT).r()).abs() > 1e-3);
        }
        assert!(differ > 1, "axis {axis}");
    }
}

/// A placed image is the image at M uv + t, its footprint M d.
#[test]
fn a_placed_image_is_looked_up_where_its_map_leads() {
    let size = 64;
    let value = |i: f64, j: f64| (0.2 * i + 0.05 * j).sin().abs();
    let plain = image(size, size, Wrap::Repeat, value);
    let rows = [[0.6, -0.8, 0.1], [1.6, 1.2, -0.3]];
    let placed = MipMap::new(&ImageTexture { placement: Placement { rows }, ..plain.clone() });
    let plain = MipMap::new(&plain);
    let linear = |d: Vec2| Vec2::new(0.6 * d.x - 0.8 * d.y, 1.6 * d.x + 1.2 * d.y);
    let mut stream = Stream::new(8, Purpose::Test, 0, 0);
    for (major, minor, angle) in FOOTPRINTS {
        let (uv, d) = (Vec2::from_array(stream.uniform2()), footprint(size, major, minor, angle));
        let expected = plain.filtered(linear(uv) + Vec2::new(0.1, -0.3), d.map(linear));
        assert!((placed.filtered(uv, d).r() - expected.r()).abs() < 1e-12, "{major} {minor}");
    }
}
