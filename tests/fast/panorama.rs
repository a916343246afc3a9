//! Environments of images: the right way round from every format, the density of their map, closed forms of their light.

use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

use pdembree::camera::Camera;
use pdembree::import::{load, load_text};
use pdembree::light::{Aim, EnvironmentLight, Light, Lights, PanoramaLight};
use pdembree::math::{Dir3, Point2, Point3, Vec2, Vec3};
use pdembree::radiometry::{Radiance, Spectrum};
use pdembree::sampling::piecewise::{Grid, PiecewiseConstant};
use pdembree::sampling::{Purpose, Stream};
use pdembree::scene::light::LightSource;
use pdembree::scene::panorama::{Part, Projection};
use pdembree::scene::texture::{Placement, Texels, Wrap};
use pdembree::scene::{ImageTexture, LightId, Panorama, PhotonChoice, Scene};

use crate::support::gltf::Gltf;
use crate::support::lights::{COLOUR, SCENE};
use crate::support::panorama::{label, middles, write_lat_long, write_octahedral};
use crate::support::quartet::{difference, with};
use crate::support::statistics::{assert_plausible, chi2_test};

const SEED: u64 = 77;

fn image(width: usize, height: usize, texel: impl Fn(usize, usize) -> f32) -> Arc<ImageTexture> {
    let texels = (0..width * height).map(|i| [texel(i % width, i / width); 3]).collect();
    let wrap = [Wrap::Repeat; 2];
    let texels = Texels::new(width, height, texels);
    Arc::new(ImageTexture { texels, wrap, placement: Placement::IDENTITY })
}

/// +z up, the middle of a lat-long image at +x.
fn upright(image: Arc<ImageTexture>, projection: Projection) -> Panorama {
    Panorama { image, projection, axes: [Dir3::X, Dir3::Y, Dir3::Z], factor: COLOUR, part: Part::All }
}

fn light(panorama: Panorama) -> PanoramaLight {
    PanoramaLight::new(panorama, SCENE).expect("not black")
}

/// Part of the pixels that show what is written in their direction. Linear light is compared with the label's.
fn agreement(scene: &Scene) -> f64 {
    let camera = Camera::new(&scene.camera).expect("a camera");
    let lights = Lights::new(scene).expect("lights");
    let [width, height] = scene.camera.resolution;
    let linear = |c: u8| {
        let x = f64::from(c) / 255.0;
        if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    let shows = |x: u32, y: u32| {
        let ray = camera.ray(Point2::new(f64::from(x) + 0.5, f64::from(y) + 0.5), Vec2::ZERO);
        let seen: Spectrum = lights.environments().map(|(_, light)| light.environment_radiance(ray.direction).0).sum();
        let written = label(ray.direction.to_vec()).map(linear);
        seen.to_array().into_iter().zip(written).all(|(seen, written)| (seen - written).abs() < 1e-3)
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    pixels.filter(|&(x, y)| shows(x, y)).count() as f64 / f64::from(width * height)
}

/// Wide views from the middle of the scene, in each direction.
fn views(name: &str, make: impl Fn(&str) -> Scene) {
    for (ahead, _) in middles() {
        let up = if ahead.y == 0.0 { Vec3::Y } else { Vec3::Z };
        let camera = format!(
            "[camera]\ntype = \"perspective\"\nposition = [0, 0, 0]\ntarget = {:?}\nup = {:?}\nfov_degrees = 110\n\
             resolution = [96, 64]\n",
            ahead.to_array(),
            up.to_array()
        );
        let shown = agreement(&make(&camera));
        // Pixels at the edges of colours show either.
        assert!(shown > 0.95, "{name}, towards {ahead}: {shown} of the pixels show what is there");
    }
}

const THING: &str = "[materials.grey]\ntype = \"lambert\"\nalbedo = 0.5\n[[objects]]\nshape = \"sphere\"\n\
                     centre = [0, -2, 0]\nradius = 0.1\nmaterial = \"grey\"\n";

fn toml(folder: &Path, text: &str) -> Scene {
    load_text(&folder.join("scene.toml"), text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}")).scene
}

#[test]
fn a_panorama_is_the_right_way_round() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    write_lat_long(&path.join("south.png"), 256, Vec3::Z);
    write_lat_long(&path.join("east.png"), 256, Vec3::X);
    let sky = |rest: &str| format!("[[lights]]\ntype = \"environment\"\n{rest}\n");
    let own = |rest: &str| {
        let sky = sky(rest);
        move |camera: &str| format!("format = 1\n{camera}{THING}{sky}")
    };
    let south = own("radiance = { image = \"south.png\" }");
    views("TOML", |camera| toml(path, &south(camera)));
    // East is a quarter of a turn from south, counter-clockwise seen from above.
    let turned = own("radiance = { image = \"east.png\" }\nrotation_degrees = 90");
    views("TOML, turned", |camera| toml(path, &turned(camera)));
    let placed = own("radiance = { image = \"east.png\" }\ncentre = [2, 1, 0]\nup = [0, 3, 0]");
    views("TOML, placed", |camera| toml(path, &placed(camera)));
    // The letters' ink is everywhere the same.
    let other = own("radiance = { image = \"south.png\" }\nrotation_degrees = 180");
    let south = "[camera]\ntype = \"perspective\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nfov_degrees = 60\n\
                 resolution = [32, 32]\n";
    let shown = agreement(&toml(path, &other(south)));
    assert!(shown < 0.5, "{shown} of the pixels show south, which is behind");

    std::fs::write(path.join("thing.glb"), Gltf::triangle().glb()).expect("written");
    let gltf = sky("radiance = { image = \"south.png\" }");
    views("glTF in TOML", |camera| toml(path, &format!("format = 1\ninclude = \"thing.glb\"\n{camera}{gltf}")));

    // pbrt's world is left-handed, its x our −x. The light's +z is up after a turn by −90° about x: (x, y, z) → (x, z, −y).
    write_octahedral(&path.join("octahedral.png"), 512, |l| Vec3::new(-l.x, l.z, -l.y));
    let text = "LookAt 0 0 0  0 0 1  0 1 0\nCamera \"perspective\" \"float fov\" 60\nWorldBegin\n\
                AttributeBegin\nRotate -90 1 0 0\nLightSource \"infinite\" \"string filename\" \"octahedral.png\"\n\
                AttributeEnd\nTranslate 0 -2 0\nShape \"sphere\" \"float radius\" 0.1\n";
    std::fs::write(path.join("scene.pbrt"), text).expect("written");
    views("pbrt in TOML", |camera| toml(path, &format!("format = 1\ninclude = \"scene.pbrt\"\n{camera}")));
    let alone = load(&path.join("scene.pbrt"), &[]).unwrap_or_else(|problems| panic!("{problems}")).scene;
    // pbrt looks along +z, its x to the right: along our +z, to the south, west to the right.
    let camera = Camera::new(&alone.camera).expect("a camera");
    let [width, height] = alone.camera.resolution.map(f64::from);
    let ahead = camera.ray(Point2::new(0.5 * width, 0.5 * height), Vec2::ZERO).direction;
    let right = camera.ray(Point2::new(width, 0.5 * height), Vec2::ZERO).direction;
    assert!(ahead.dot(Vec3::Z) > 0.999 && right.dot(Vec3::NEG_X) > 0.3, "{ahead:?}, {right:?}");
    assert!(agreement(&alone) > 0.95);
}

/// The quartet on a grid whose values differ by six decades, with dark cells, uneven rows and a single bright one.
#[test]
fn a_piecewise_density_is_a_quartet() {
    let rows = [0.0, 0.03, 0.2, 0.5, 0.55, 1.0];
    let values: Vec<f32> =
        (0..35).map(|i| [1.0, 0.9, 0.0, 1e-3, 30.0, 0.2, 2.0, 0.0, 0.7, 1000.0, 0.5][i * i % 11]).collect();
    let grid = Grid { columns: 7, rows: &rows, values: &values };
    let map = PiecewiseConstant::new(&grid).expect("not black");
    let total: f64 = (0..35).map(|i| f64::from(values[i]) * (rows[i / 7 + 1] - rows[i / 7]) / 7.0).sum();
    let mut stream = Stream::new(SEED, Purpose::Test, 0, 0);
    let mut observed = vec![0u64; 35];
    let mut expected = vec![0.0; 35];
    const DRAWS: usize = 100_000;
    for _ in 0..DRAWS {
        let x = map.sample(stream.uniform2()).x;
        let row = rows.partition_point(|edge| *edge <= x[1]).clamp(1, 5) - 1;
        observed[row * 7 + ((7.0 * x[0]) as usize).min(6)] += 1;
    }
    for i in 0..35 {
        let middle = [((i % 7) as f64 + 0.5) / 7.0, 0.5 * (rows[i / 7] + rows[i / 7 + 1])];
        let value = f64::from(values[i]);
        let pdf = map.pdf(middle);
        // No value is more than a quarter above its rectangle's mean.
        let exact = value / total;
        assert!(1.25 * pdf >= exact * (1.0 - 1e-9), "cell {i}: {pdf}, not {exact}");
        expected[i] = pdf * (rows[i / 7 + 1] - rows[i / 7]) / 7.0 * DRAWS as f64;
    }
    assert!((expected.iter().sum::<f64>() / DRAWS as f64 - 1.0).abs() < 1e-12, "the density is normalised");
    assert_plausible(chi2_test(&observed, &expected), 1, format!("cells, seed {SEED}"));
    for _ in 0..500 {
        let u = stream.uniform2();
        let drawn = map.sample(u);
        assert!((drawn.pdf * drawn.stretch[0] * drawn.stretch[1] - 1.0).abs() < 1e-12);
        assert!((map.pdf(drawn.x) / drawn.pdf - 1.0).abs() < 1e-9, "at {u:?}");
        let back = map.inverse(drawn.x).expect("its own sample");
        for k in 0..2 {
            assert!((back[k] - u[k]).abs() < 1e-12 * (1.0 + 1.0 / drawn.stretch[k]), "at {u:?}: {back:?}");
            let at = |t: f64| {
                let x = map.sample(with(u, k, t)).x;
                Vec3::new(x[0], x[1], 0.0)
            };
            let h = 1e-4;
            // Only where no cut is near.
            if u[k] < h
                || u[k] > 1.0 - h
                || map.sample(with(u, k, u[k] - h)).stretch != drawn.stretch
                || map.sample(with(u, k, u[k] + h)).stretch != drawn.stretch
            {
                continue;
            }
            let (slope, bound) = difference(at, u[k], 1.0);
            assert!((slope.length() - drawn.stretch[k]).abs() <= bound, "at {u:?}: {slope}, not {drawn:?}");
        }
    }
}

/// A grid of one value is one rectangle, which changes nothing; one of zeros is none.
#[test]
fn an_even_grid_is_the_identity() {
    let rows = [0.0, 0.5, 1.0];
    let grid = |values| Grid { columns: 2, rows: &rows, values };
    let map = PiecewiseConstant::new(&grid(&[0.3; 4])).expect("not black");
    assert_eq!((map.rectangles(), map.sample([0.3, 0.7]).x, map.pdf([0.9, 0.1])), (1, [0.3, 0.7], 1.0));
    assert!(PiecewiseConstant::new(&grid(&[0.0; 4])).is_none());
}

/// A white image is the even environment: the same radiance and density everywhere, the same power; its octahedral map sends
/// the very same rays the other way.
#[test]
fn a_white_image_is_the_even_environment() {
    let even = EnvironmentLight { radiance: Radiance(COLOUR), scene: SCENE };
    let mut stream = Stream::new(SEED, Purpose::Test, 1, 0);
    let close = |a: Spectrum, b: Spectrum| (a.luminance() / b.luminance() - 1.0).abs() < 1e-12;
    for (projection, size) in [(Projection::LatLong, [6, 3]), (Projection::Octahedral, [4, 4])] {
        let white = light(upright(image(size[0], size[1], |_, _| 1.0), projection));
        assert!(close(white.power().0, even.power().0));
        for _ in 0..100 {
            let (u, v) = (stream.uniform2(), stream.uniform2());
            let wi = even.sample_li(Point3::ORIGIN, u).expect("everywhere").wi;
            assert!(close(white.environment_radiance(wi).0, COLOUR), "{projection:?}");
            assert!((white.environment_pdf(wi).get() * 4.0 * PI - 1.0).abs() < 1e-12);
            let found = white.sample_li(Point3::ORIGIN, u).expect("everywhere");
            assert!(close(found.weight.0, COLOUR * (4.0 * PI)));
            if projection == Projection::Octahedral {
                let (a, b) = ([v[0], v[1], u[0], u[1]], Aim::Everywhere);
                let [one, other] = [white.emit(a, &b), even.emit(a, &b)].map(|e| e.expect("lit"));
                assert_eq!(one.direction.to_array(), (-other.direction).to_array());
                assert!(close(one.flux.0, other.flux.0));
            }
        }
    }
}

/// One bright texel of a lat-long image, from θ₀ to θ₁ below the pole and ∆φ wide: a plate that faces the pole receives
/// L ∆φ (sin²θ₁ − sin²θ₀)/2. The cosine is linear in the coordinates that samples are even in, so the midpoint rule is exact.
#[test]
fn one_bright_texel_lights_a_plate_by_its_closed_form() {
    const N: usize = 16;
    for row in 0..4 {
        let bright =
            light(upright(image(16, 8, |x, y| if (x, y) == (5, row) { 7.0 } else { 0.0 }), Projection::LatLong));
        let middle = |i: usize| (i as f64 + 0.5) / N as f64;
        let received = |i: usize| {
            let found = bright.sample_li(Point3::ORIGIN, [middle(i % N), middle(i / N)]).expect("bright");
            let seen = bright.environment_radiance(found.wi).0.luminance();
            let claimed = bright.environment_pdf(found.wi).get() * found.weight.0.luminance();
            assert!((claimed / seen - 1.0).abs() < 1e-9, "weight times density is the radiance: {claimed}, {seen}");
            found.weight.0.luminance() * found.wi.z
        };
        let mean = (0..N * N).map(received).sum::<f64>() / (N * N) as f64;
        let [from, to] = [row, row + 1].map(|edge| (PI * edge as f64 / 8.0).sin().powi(2));
        let exact = 7.0 * COLOUR.luminance() * (PI / 8.0) * (to - from) / 2.0;
        assert!((mean / exact - 1.0).abs() < 1e-12, "row {row}: {mean}, not {exact}");
    }
}

/// A sun is a light of its own, and nothing is lost or counted twice between it and its sky.
#[test]
fn a_sun_parts_from_its_sky() {
    let sky = image(64, 32, |x, y| if (x, y) == (20, 9) { 5e4 } else { 0.5 + 0.01 * x as f32 });
    let all = upright(sky, Projection::LatLong);
    let parts = all.clone().into_lights();
    let [sun, rest] = &parts[..] else { panic!("two parts, not {}", parts.len()) };
    assert!(matches!((sun.part, rest.part), (Part::Above(_), Part::UpTo(_))));
    let lights = [light(all), light(sun.clone()), light(rest.clone())];
    let [whole, one, two] = lights.each_ref().map(|light| light.power().0.luminance());
    assert!(((one + two) / whole - 1.0).abs() < 1e-12 && one > 0.2 * whole, "{one} + {two}, not {whole}");
    assert!(lights[1].is_collimated() && !lights[2].is_collimated());
    let mut stream = Stream::new(SEED, Purpose::Test, 2, 0);
    for light in [0, 0, 1, 2] {
        let wi = lights[light].sample_li(Point3::ORIGIN, stream.uniform2()).expect("lit").wi;
        let [whole, one, two] = lights.each_ref().map(|light| light.environment_radiance(wi).0.luminance());
        assert!((one + two - whole).abs() <= 1e-12 * whole && one.min(two) == 0.0);
    }
    let even = upright(image(8, 4, |x, _| 1.0 + x as f32), Projection::LatLong);
    assert_eq!(even.clone().into_lights(), [even]);
}

fn problems(folder: &Path, light: &str) -> String {
    let camera = "[camera]\ntype = \"perspective\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nfov_degrees = 60\n\
                  resolution = [8, 8]\n";
    let text = format!("format = 1\n{camera}{THING}[[lights]]\ntype = \"environment\"\n{light}\n");
    match load_text(&folder.join("scene.toml"), &text, &[]) {
        Ok(_) => String::new(),
        Err(problems) => problems.to_string(),
    }
}

#[test]
fn what_is_wrong_with_a_panorama_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    image::RgbImage::new(4, 2).save(path.join("black.png")).expect("written");
    write_lat_long(&path.join("south.png"), 8, Vec3::Z);
    for (light, message) in [
        ("radiance = { image = \"none.exr\" }", "none.exr"),
        ("radiance = { image = \"black.png\" }", "the image is black"),
        ("radiance = { image = \"south.png\", factor = 0 }", "`radiance.factor` is"),
        ("radiance = { image = \"south.png\" }\ncentre = [0, 2, 0]", "`up` and `centre` are parallel"),
        ("radiance = { image = \"south.png\", wrap = \"clamp\" }", "wrap"),
        ("radiance = 1\nup = [0, 0, 1]", "up"),
    ] {
        let said = problems(path, light);
        assert!(said.contains(message), "{light}: {said:?}");
    }
    for (light, message) in [
        ("\"string filename\" \"south.png\"", "no square"),
        ("\"string filename\" \"square.png\" \"float illuminance\" 3", "illuminance"),
        ("\"point3 portal\" [0 0 0 1 0 0 1 1 0 0 1 0]", "portal"),
    ] {
        write_octahedral(&path.join("square.png"), 4, |w| w);
        let text = format!(
            "Camera \"perspective\"\nWorldBegin\nScale 1 2 1\nLightSource \"infinite\" {light}\n\
                            Shape \"sphere\"\n"
        );
        std::fs::write(path.join("scene.pbrt"), text).expect("written");
        let said = load(&path.join("scene.pbrt"), &[]).map(|_| ()).expect_err("refused").to_string();
        assert!(said.contains(message), "{light}: {said:?}");
    }
    let text = "Camera \"perspective\"\nWorldBegin\nScale 1 2 1\nLightSource \"infinite\" \"string filename\" \"square.png\"\n\
                Shape \"sphere\"\n";
    std::fs::write(path.join("scene.pbrt"), text).expect("written");
    let said = load(&path.join("scene.pbrt"), &[]).map(|_| ()).expect_err("refused").to_string();
    assert!(said.contains("scaled unevenly"), "{said}");
}

/// Both parts of an image of a sun are environments of the scene.
#[test]
fn a_scenes_panorama_is_assembled_in_parts() {
    let folder = tempfile::tempdir().expect("a folder");
    let pixel = |x: u32, y: u32| image::Rgb(if (x, y) == (20, 9) { [9e4f32; 3] } else { [0.5; 3] });
    image::Rgb32FImage::from_fn(64, 32, pixel).save(folder.path().join("sun.hdr")).expect("written");
    let camera = "[camera]\ntype = \"perspective\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nfov_degrees = 60\n\
                  resolution = [8, 8]\n";
    let sky = "[[lights]]\ntype = \"environment\"\nradiance = { image = \"sun.hdr\", factor = [2, 1, 1] }\n";
    let scene = toml(folder.path(), &format!("format = 1\n{camera}{THING}{sky}"));
    assert!(matches!(&scene.lights[..], [LightSource::Panorama(_), LightSource::Panorama(_)]));
    let again = toml(folder.path(), &format!("format = 1\n{camera}{THING}{sky}rotation_degrees = 1\n"));
    assert_ne!(scene.hash, again.hash, "where it is is part of the scene");
    assert_eq!(Lights::new(&scene).expect("lights").environments().count(), 2);

    let lamp = "photons = 7\ngroup = \"sky\"\n[[lights]]\ntype = \"point\"\nposition = [0, 3, 0]\nintensity = 1\n";
    let render = "[render]\nlayers = [\"direct_sky\"]\n";
    let scene = toml(folder.path(), &format!("format = 1\n{camera}{render}{THING}{sky}{lamp}"));
    let groups = [0, 1, 2].map(|light| scene.light_groups.of(LightId(light)).index());
    assert_eq!(groups, [1, 1, 0], "both parts are in the image's group, and the lamp is not");
    let photons = [0, 1, 2].map(|light| scene.light_photons.of(LightId(light)));
    assert_eq!(photons, [PhotonChoice::Count(4), PhotonChoice::Count(4), PhotonChoice::Auto]);
}
