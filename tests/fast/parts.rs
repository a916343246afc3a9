//! Renders cut into passes, tiles and pieces, saved, damaged, mixed up and put together again.

use std::path::{Path, PathBuf};

use pdembree::film::Film;
use pdembree::output::{PartError, part};
use pdembree::render::store::{self, Assignment, StoreError};
use pdembree::render::{Ended, RenderState, tiling};
use pdembree::world::World;
use proptest::prelude::*;

use crate::support::renders::{ball, go_on_for, info, passes, whole};

const METHODS: [(&str, &str); 4] = [("photon_map", "pd"), ("photon_map", "knn"), ("path", "pd"), ("light", "pd")];

fn world_of((method, estimator): (&str, &str)) -> World {
    ball(&[("render.method", method), ("render.estimator", estimator)])
}

/// Films are equal to the bit, and so is all that was counted; times are not.
fn assert_same(a: &RenderState, b: &RenderState, what: &str) {
    assert!(a.film == b.film, "{what}: the films differ");
    assert_eq!(a.report.photons, b.report.photons, "{what}");
}

fn saved(folder: &Path, name: &str, world: &World, wanted: u32, state: &RenderState) -> PathBuf {
    let path = folder.join(name);
    store::save(&path, &info(world, wanted), state).expect("a file");
    path
}

#[test]
fn passes_in_any_split_and_order_are_the_whole_to_the_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    for method in METHODS {
        let world = world_of(method);
        let expected = passes(&world, whole(&world), 0, 5);
        for cuts in [vec![0, 2, 5], vec![0, 1, 2, 3, 4, 5], vec![0, 4, 5]] {
            let part = |w: &[u32]| {
                let state = passes(&world, whole(&world), w[0], w[1]);
                saved(folder.path(), &format!("{}.pdpart", w[0]), &world, 5, &state)
            };
            let mut parts: Vec<PathBuf> = cuts.windows(2).map(part).collect();
            parts.reverse();
            let merged = store::merge(&parts, false).expect("they belong together");
            assert_same(&merged.state, &expected, &format!("{method:?} cut at {cuts:?}"));
        }
    }
}

#[test]
fn tiles_are_crops_of_the_whole_and_make_it_up() {
    let folder = tempfile::tempdir().expect("a folder");
    for method in METHODS {
        let world = world_of(method);
        let expected = passes(&world, whole(&world), 0, 2);
        let picture = expected.film.resolve();
        for m in [1, 2, 3, 6] {
            let mut parts = Vec::new();
            for j in 0..m {
                let pixels = tiling::tile(world.scene.camera.resolution, j, m).expect("a tile");
                // Some in one go, some pass by pass.
                let state = passes(&world, pixels, 0, 2);
                let tile = state.film.resolve();
                for (mine, all) in tile.channels.iter().zip(&picture.channels) {
                    let rows = (pixels.y0..pixels.y1).map(|y| (y * picture.width) as usize);
                    let crop = rows.flat_map(|row| &all.samples[row + pixels.x0 as usize..row + pixels.x1 as usize]);
                    let same = mine.samples.iter().zip(crop).all(|(a, b)| a.to_bits() == b.to_bits());
                    assert!(same, "{method:?}, tile {j}/{m}, {}", mine.name);
                }
                parts.push(saved(folder.path(), &format!("{j}.pdpart"), &world, 2, &state));
            }
            let merged = store::merge(&parts, false).expect("they belong together");
            assert_same(&merged.state, &expected, &format!("{method:?} in {m} tiles"));
        }
    }
}

/// Stopped after every possible number of units, saved, read and continued: the same bits.
#[test]
fn a_render_resumed_anywhere_is_the_uninterrupted_one() {
    let folder = tempfile::tempdir().expect("a folder");
    for method in METHODS {
        let world = world_of(method);
        let expected = passes(&world, whole(&world), 0, 2);
        let assignment = Assignment { pixels: whole(&world), passes: 0..2 };
        let mut stops = 0;
        for units in 0.. {
            let mut state = RenderState::new(&world, whole(&world), 0);
            let ended = go_on_for(&world, &mut state, 2, units);
            let path = saved(folder.path(), "c.pdpart", &world, 2, &state);
            let mut state = store::resume(&path, &info(&world, 2), &assignment).expect("its own checkpoint");
            assert_eq!(go_on_for(&world, &mut state, 2, usize::MAX), Ended::Done);
            assert_same(&state, &expected, &format!("{method:?} stopped after {units} units"));
            if ended == Ended::Done {
                break;
            }
            stops += 1;
        }
        assert!(stops > 6, "{method:?}: stopped {stops} times only");
    }
}

/// A checkpoint is read whole or not at all: cut at every length, changed in any byte.
#[test]
fn a_damaged_part_is_refused_whatever_happened_to_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = ball(&[("camera.resolution", "[3, 2]"), ("render.photons", "500"), ("render.layers", "[]")]);
    let state = passes(&world, whole(&world), 0, 1);
    let path = saved(folder.path(), "whole.pdpart", &world, 1, &state);
    let bytes = std::fs::read(&path).expect("the part");
    assert!(part::decode(&bytes, &path).is_ok());
    for length in 0..bytes.len() {
        match part::decode(&bytes[..length], &path) {
            Err(PartError::Damaged { .. }) => {}
            other => panic!("cut to {length} of {} bytes: {other:?}", bytes.len()),
        }
    }
    for place in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[place] ^= 0x10;
        assert!(part::decode(&changed, &path).is_err(), "byte {place} changed");
    }
    let longer = [bytes.clone(), vec![0]].concat();
    assert!(matches!(part::decode(&longer, &path), Err(PartError::Damaged { .. })));
    let newer = String::from_utf8_lossy(part::MAGIC).replace('1', "2").into_bytes();
    let newer = [&newer, &bytes[part::MAGIC.len()..]].concat();
    assert!(matches!(part::decode(&newer, &path), Err(PartError::OtherLayout { .. })));
    assert!(matches!(part::decode(b"v/1\x01 an EXR", &path), Err(PartError::NotAPart { .. })));
    assert!(matches!(part::read(&folder.path().join("none")), Err(PartError::Missing { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whoever makes up a file with a right digest gets an error, not a panic or all memory.
    #[test]
    fn made_up_parts_are_refused(header in ".{0,80}", sums in prop::collection::vec(any::<u8>(), 0..64), claim in any::<u64>()) {
        for length in [header.len() as u64, claim] {
            let mut bytes = part::MAGIC.to_vec();
            bytes.extend(length.to_le_bytes());
            bytes.extend(header.as_bytes());
            bytes.extend(&sums);
            bytes.extend(blake3::hash(&bytes).as_bytes());
            prop_assert!(part::decode(&bytes, "made up".as_ref()).is_err());
        }
    }
}

fn refusal(parts: &[&PathBuf]) -> String {
    let parts: Vec<PathBuf> = parts.iter().map(|path| (*path).clone()).collect();
    store::merge(&parts, false).map(|_| ()).expect_err("they do not belong together").to_string()
}

#[test]
fn parts_that_do_not_belong_together_are_refused_and_the_reason_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = ball(&[]);
    let part = |name: &str, world: &World, first, end| {
        saved(folder.path(), name, world, 4, &passes(world, whole(world), first, end))
    };
    let (a, b, d) = (part("a", &world, 0, 2), part("b", &world, 2, 3), part("d", &world, 3, 4));
    assert!(store::merge(&[d.clone(), a.clone(), b.clone()], false).is_ok());

    let gap = refusal(&[&a, &d]);
    assert!(gap.contains("passes 2..3 are missing"), "{gap}");
    let end = refusal(&[&a, &b]);
    assert!(end.contains("passes 3..4 are missing"), "{end}");
    let twice = refusal(&[&a, &b, &d, &part("b2", &world, 1, 3)]);
    assert!(twice.contains("b2") && twice.contains("pass 1 of the same pixels"), "{twice}");
    let partial = store::merge(&[a.clone(), d.clone()], true).expect("a partial picture was asked for");
    assert_eq!((partial.state.film.passes(), partial.missing.as_deref()), (3, Some("passes 2..3 are missing")));

    let others = [
        (("render.seed", "9"), "seed: 9 and 0"),
        (("render.photons", "20001"), "photons: 20001 and 20000"),
        (("render.layers", "[\"caustic\"]"), "layers: "),
        (("camera.resolution", "[40, 25]"), "resolution: 40 x 25 and 40 x 24"),
        (("materials.glass.ior", "1.51"), "scene contents: "),
        (("render.backend", "brute"), "backend: "),
    ];
    for (setting, reason) in others {
        let other = part("other", &ball(&[setting]), 2, 4);
        let refused = refusal(&[&a, &other]);
        assert!(refused.contains("other: belongs to another render") && refused.contains(reason), "{refused}");
    }

    let mut unfinished = RenderState::new(&world, whole(&world), 2);
    while unfinished.film.is_between_passes() {
        go_on_for(&world, &mut unfinished, 4, 8);
    }
    let unfinished = saved(folder.path(), "unfinished", &world, 4, &unfinished);
    assert!(matches!(store::merge(&[a, unfinished], false), Err(StoreError::PassUnderWay { .. })));
}

#[test]
fn tiles_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = ball(&[]);
    let tile = |j: u32, m: u32, passes_end: u32| {
        let pixels = tiling::tile(world.scene.camera.resolution, j, m).expect("a tile");
        let name = format!("{j}of{m}to{passes_end}");
        saved(folder.path(), &name, &world, 2, &passes(&world, pixels, 0, passes_end))
    };
    let missing = refusal(&[&tile(0, 2, 2)]);
    assert!(missing.contains("tiles with") && missing.contains("of 960 pixels are missing"), "{missing}");
    let uneven = refusal(&[&tile(0, 2, 2), &tile(1, 2, 1)]);
    assert!(uneven.contains("different passes (0..2 and 0..1)"), "{uneven}");
    let cut_twice = refusal(&[&tile(0, 2, 2), &tile(0, 3, 2)]);
    assert!(cut_twice.contains("cut the picture in one way"), "{cut_twice}");
}

#[test]
fn a_checkpoint_of_another_task_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = ball(&[]);
    let path = saved(folder.path(), "c", &world, 2, &passes(&world, whole(&world), 0, 1));
    let resume = |world: &World, assignment| store::resume(&path, &info(world, 2), &assignment);
    let mine = Assignment { pixels: whole(&world), passes: 0..2 };
    assert!(resume(&world, mine.clone()).is_ok());
    // A picture of more passes than are wanted is another picture.
    let two = saved(folder.path(), "two", &world, 2, &passes(&world, whole(&world), 0, 2));
    let fewer = store::resume(&two, &info(&world, 1), &Assignment { passes: 0..1, ..mine.clone() });
    let refused = fewer.map(|_| ()).expect_err("too many passes").to_string();
    assert!(refused.contains("holds passes 0..2, not passes 0..1"), "{refused}");
    let later = resume(&world, Assignment { passes: 1..2, ..mine.clone() });
    assert!(matches!(later, Err(StoreError::OtherAssignment { .. })));
    let pixels = tiling::tile(world.scene.camera.resolution, 0, 2).expect("a tile");
    assert!(matches!(resume(&world, Assignment { pixels, ..mine.clone() }), Err(StoreError::OtherAssignment { .. })));
    let refused = resume(&ball(&[("render.spp", "3")]), mine).map(|_| ()).expect_err("another spp").to_string();
    assert!(refused.contains("spp: 2 and 3"), "{refused}");
}

/// The variance of the mean is that of the passes' own pictures.
#[test]
fn the_error_of_the_mean_is_that_of_the_passes() {
    let world = ball(&[]);
    let n = 6;
    let all = passes(&world, whole(&world), 0, n);
    let luminance = |film: &Film| {
        let image = film.resolve();
        let [r, g, b] = image.rgb("").expect("beauty").map(<[f32]>::to_vec);
        (0..r.len())
            .map(|i| pdembree::radiometry::Spectrum::rgb(r[i].into(), g[i].into(), b[i].into()).luminance())
            .collect::<Vec<f64>>()
    };
    let each: Vec<Vec<f64>> = (0..n).map(|i| luminance(&passes(&world, whole(&world), i, i + 1).film)).collect();
    let found = all.film.mean_errors().expect("six passes");
    for (pixel, known) in found.iter().enumerate() {
        let values: Vec<f64> = each.iter().map(|pass| pass[pixel]).collect();
        let mean = values.iter().sum::<f64>() / f64::from(n);
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / f64::from(n - 1);
        let error = (variance / f64::from(n)).sqrt();
        // The passes' pictures are f32.
        assert!((known.mean - mean).abs() < 1e-6 * (1.0 + mean), "pixel {pixel}: {known:?}, {mean}");
        assert!((known.standard_error - error).abs() < 1e-6 * (1.0 + mean), "pixel {pixel}: {known:?}, {error}");
    }
    assert!(found.iter().any(|known| known.standard_error > 1e-3), "there is noise to measure");
    assert!(passes(&world, whole(&world), 0, 1).film.mean_errors().is_none());
    let image = all.film.resolve();
    let variance = image.channel("variance.Y").expect("asked for");
    assert!(found.iter().zip(variance).all(|(known, &v)| known.standard_error.powi(2) as f32 == v));
}
