//! The film: means, refusals, order of merging.

use pdembree::film::{Arrival, Exposure, EyeSample, Film, Layout, LightKind, Part, PixelBounds, SplatBuffer, Tile};
use pdembree::math::Vec3;
use pdembree::radiometry::Spectrum;
use pdembree::sampling::stream::{Purpose, Stream};
use pdembree::scene::GroupId;
use pdembree::scene::camera::PixelFilter;
use pdembree::scene::settings::Layer;

const ALL: [Layer; 13] = [
    Layer::Caustic,
    Layer::Direct,
    Layer::Indirect,
    Layer::Emission,
    Layer::Straight,
    Layer::Focused,
    Layer::SentBack,
    Layer::Scattered,
    Layer::Normal,
    Layer::Depth,
    Layer::Albedo,
    Layer::Photons,
    Layer::Variance,
];

fn sample(direct: f64, caustic: f64, indirect: f64, depth: Option<f64>) -> EyeSample {
    let mut sample = EyeSample::default();
    sample.depth = depth;
    sample.normal = Vec3::new(0.0, -1.0, 0.5);
    sample.albedo = Spectrum::rgb(0.1, 0.2, 0.3);
    sample.photon_density = 8.0;
    for (part, arrival, light) in [
        (Part::Direct, Arrival::Emission, direct),
        (Part::Caustic, Arrival::Focused, caustic),
        (Part::Indirect, Arrival::SentBack, indirect),
    ] {
        sample.add(LightKind { part, arrival, group: GroupId::REST }, Spectrum::splat(light));
    }
    sample
}

fn new_film(width: u32, height: u32, layers: &[Layer]) -> Film {
    Film::new(PixelBounds::whole([width, height]), 0, Layout::new(layers))
}

/// Every number is exact in binary, so the means are too.
#[test]
fn a_pixel_is_the_mean_of_its_samples_in_every_layer() {
    let mut film = new_film(1, 1, &ALL);
    for (pass, samples) in [[(1.0, Some(2.0)), (3.0, None)], [(0.0, Some(4.0)), (4.0, Some(6.0))]].iter().enumerate() {
        let mut tile = Tile::new(film.layout(), film.bounds(), pass as u32);
        for &(direct, depth) in samples {
            tile.add(0, 0, &sample(direct, 0.5, 0.25, depth));
        }
        film.add_tile(0, &tile);
        film.end_pass();
    }
    let image = film.resolve();
    let names: Vec<&str> = image.channels.iter().map(|c| c.name.as_str()).collect();
    let expected = "R G B A caustic.R caustic.G caustic.B direct.R direct.G direct.B indirect.R indirect.G indirect.B \
                    emission.R emission.G emission.B straight.R straight.G straight.B focused.R focused.G focused.B \
                    sent_back.R sent_back.G sent_back.B scattered.R scattered.G scattered.B \
                    N.X N.Y N.Z Z albedo.R albedo.G albedo.B photons.density variance.Y";
    assert_eq!(names, expected.split(' ').collect::<Vec<_>>());
    let values: Vec<f32> = image.channels.iter().map(|c| c.samples[0]).collect();
    let expected = [
        2.75, 2.75, 2.75, 0.75, 0.5, 0.5, 0.5, 2.0, 2.0, 2.0, 0.25, 0.25, 0.25, 2.0, 2.0, 2.0, 0.0, 0.0, 0.0, 0.5, 0.5,
        0.5, 0.25, 0.25, 0.25, 0.0, 0.0, 0.0, 0.0, -1.0, 0.5, 4.0, 0.1, 0.2, 0.3, 8.0, 0.0,
    ];
    assert_eq!(values, expected);
}

#[test]
fn bad_samples_are_refused_with_their_place_and_the_rest_counts() {
    let mut film = new_film(3, 2, &[Layer::Caustic]);
    film.end_pass();
    let mut tile = Tile::new(film.layout(), PixelBounds { x0: 1, y0: 1, x1: 3, y1: 2 }, film.passes());
    for bad in [f64::NAN, f64::INFINITY, 2e12, -1e-9] {
        tile.add(2, 1, &sample(0.0, bad, 0.0, None));
    }
    tile.add(2, 1, &sample(1.0, 0.5, 0.0, None));
    // Each part is storable, their sum is not.
    tile.add(1, 1, &sample(9e11, 9e11, 0.0, None));
    film.add_tile(0, &tile);
    let refused = film.refused();
    assert_eq!((refused.not_a_number, refused.too_large, refused.negative, refused.total()), (1, 3, 1, 5));
    assert!(refused.first[1..].iter().all(|r| (r.x, r.y, r.pass) == (2, 1, 1)), "{refused:?}");
    let image = film.resolve();
    assert_eq!(image.channel("R").expect("R")[5], 1.5);
    assert_eq!(image.channel("caustic.R").expect("caustic")[5], 0.5);
    assert_eq!(image.channel("R").expect("R")[4], 0.0, "a pixel whose samples were all refused is black");
}

#[test]
fn the_first_refusals_are_remembered_whatever_the_order() {
    let mut film = new_film(8, 8, &[]);
    for bounds in PixelBounds::tiles(8, 8, 4).into_iter().rev() {
        let mut tile = Tile::new(film.layout(), bounds, 0);
        for _ in 0..10 {
            tile.add(bounds.x0, bounds.y0, &sample(f64::NAN, 0.0, 0.0, None));
        }
        film.add_tile(0, &tile);
    }
    assert_eq!(film.refused().not_a_number, 40);
    let places: Vec<(u32, u32)> = film.refused().first.iter().map(|r| (r.x, r.y)).collect();
    assert_eq!(places, [vec![(0, 0); 10], vec![(4, 0); 6]].concat());
}

/// However the picture is cut, every pixel is in one tile, and the samples add up to the same bits.
#[test]
fn tiles_cover_every_pixel_once_and_the_cut_does_not_matter() {
    let (width, height) = (37, 23);
    let picture = |size: u32| {
        let mut film = new_film(width, height, &[Layer::Direct]);
        for pass in 0..2 {
            for bounds in PixelBounds::tiles(width, height, size) {
                let mut tile = Tile::new(film.layout(), bounds, pass);
                for y in bounds.y0..bounds.y1 {
                    for x in bounds.x0..bounds.x1 {
                        let mut stream = Stream::new(7, Purpose::Test, pass, u64::from(y * width + x));
                        (0..3).for_each(|_| tile.add(x, y, &sample(stream.uniform(), 0.0, 0.0, Some(1.0))));
                    }
                }
                film.add_tile(0, &tile);
            }
            film.end_pass();
        }
        film.resolve()
    };
    let reference = picture(64);
    assert!(reference.channel("A").expect("A").iter().all(|&a| a == 1.0));
    for size in [1, 5, 16] {
        assert_eq!(picture(size), reference, "tiles of {size}");
    }
}

#[test]
fn splats_are_the_mean_of_the_passes_and_join_the_eye_samples() {
    let mut film = new_film(2, 2, &[Layer::Caustic, Layer::Direct]);
    for pass in 0..4 {
        let mut tile = Tile::new(film.layout(), film.bounds(), pass);
        tile.add(1, 0, &sample(2.0, 0.0, 0.0, None));
        film.add_tile(0, &tile);
        let mut splats = SplatBuffer::new(film.bounds(), pass, PixelFilter::Box);
        let kind = LightKind { part: Part::Caustic, arrival: Arrival::Focused, group: GroupId::REST };
        splats.add_splat(1.25, 0.75, kind, Spectrum::rgb(f64::from(pass), 0.0, 1.0));
        film.add_splats(Exposure::LightToAll, 0, &splats);
        film.end_pass();
    }
    let image = film.resolve();
    let at = |name: &str| image.channel(name).expect("a channel")[1];
    assert_eq!([at("R"), at("G"), at("B")], [3.5, 2.0, 3.0]);
    assert_eq!([at("caustic.R"), at("direct.R")], [1.5, 2.0]);
    assert_eq!(image.channel("R").expect("R")[0], 0.0);
}
