//! Studies: their file, references that are kept and refused, a run from the command line and its page.

use std::path::Path;

use pdembree::output::exr;
use pdembree::render::progress::Silent;
use pdembree::study::StudyError;
use pdembree::study::file;
use pdembree::study::plan::{BandwidthPlan, Budget, Study};
use pdembree::study::reference::{Reference, Shelf, reference};
use pdembree::study::results::Results;

use crate::support::data::root;
use crate::support::study::{SCENE, STUDY, folder, results, run};

fn study(text: &str, folder: &Path) -> Study {
    file::read_text(&folder.join("study.toml"), text).unwrap_or_else(|problems| panic!("{problems}"))
}

#[test]
fn a_study_file_is_read_as_it_is_written() {
    let folder = folder();
    let study = study(STUDY, folder.path());
    assert_eq!((study.title.as_str(), study.scenes.len(), study.experiments.len()), ("A mirror's light", 1, 2));
    let [first, second] = &study.experiments[..] else { panic!("two experiments") };
    assert_eq!(study.methods[first.methods[0].method].name, "knn");
    assert_eq!(first.methods[0].bandwidth, BandwidthPlan::Best { low: 5.0, high: 40.0 });
    assert_eq!(first.methods[1].bandwidth, BandwidthPlan::Each(vec![1.5, 4.0]));
    assert_eq!(first.published[0].rmse, Some(0.07));
    assert_eq!(second.budgets, [200, 800, 3200].map(Budget::Photons));
    assert_eq!(second.methods[1].bandwidth, BandwidthPlan::AsSet);
    assert_eq!(second.region, Some([4, 2, 20, 14]));
}

#[test]
fn the_studies_of_scenes_are_read() {
    let studies =
        ["refraction/bandwidth_study", "refraction/study", "reflection/study", "ring/study", "ring/floor_study"];
    for name in studies.map(|name| format!("{name}.toml")) {
        let path = root().join("scenes").join(name);
        let study = file::read(&path).unwrap_or_else(|problems| panic!("{problems}"));
        for scene in &study.scenes {
            let file = study.folder.join(&scene.file);
            pdembree::import::load(&file, &scene.overrides).unwrap_or_else(|problems| panic!("{problems}"));
        }
    }
}

/// Every mistake is told with its place, all at once.
#[test]
fn what_is_wrong_with_a_study_is_told_with_its_place() {
    let folder = folder();
    let wrong = [
        ("methods = [\"knn\", \"pd-lattice\"]", "methods = [\"knm\"]", "did you mean \"knn\"?"),
        ("photons = [500]", "photons = 500", "`photons` must be an array"),
        ("photons = [500]\n", "", "needs the key `photons`"),
        ("crop = [2, 2, 20, 14]", "crop = [20, 2, 2, 14]", "`crop` has no pixels"),
        ("knn = { from = 5, to = 40 }", "knn = 5", "the bandwidth of knn"),
        ("white = 0.4", "whit = 0.4", "did you mean `white`?"),
        ("white = 0.4", "exact = \"wave\"", "has two references"),
        ("format = 1", "format = 2", "version 1"),
        ("photons = [500]", "photons = [500]\nstored = [500]", "two kinds of work"),
        ("set = [\"render.method=light\", \"render.photons=4000\"]", "set = [\"light\"]", "is not an override"),
        ("title = \"A mirror's light\"", "", "needs the key `title`"),
        ("seeds = [1, 2]", "seeds = []", "`seeds` must be an array"),
    ];
    for (right, mistake, message) in wrong {
        let text = STUDY.replacen(right, mistake, 1);
        let problems = file::read_text(&folder.path().join("study.toml"), &text).expect_err(mistake).to_string();
        assert!(problems.contains(message) && problems.contains("study.toml"), "{mistake}: {problems}");
    }
    let missing = file::read(&folder.path().join("none.toml")).expect_err("no file");
    assert!(missing.only_missing_inputs());
}

fn reference_of(study: &Study, own: &Path, published: &Path) -> Result<Reference, StudyError> {
    reference(&study.scenes[0], &study.folder, &Shelf { published, own }, &Silent)
}

fn kept(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path());
    let mut found: Vec<_> = entries.filter(|p| p.extension().is_some_and(|e| e == "exr")).collect();
    found.sort();
    found
}

/// A reference is found again, continued to the same picture that all passes at once give, and carries its variance.
#[test]
fn references_are_kept_and_continued() {
    let (folder, own, other) = (folder(), folder(), folder());
    let (own, other) = (own.path().join("own"), other.path().join("other"));
    let four = study(STUDY, folder.path());
    let eight = study(&STUDY.replace("passes = 4", "passes = 8"), folder.path());
    let first = reference_of(&four, &own, &other).expect("a reference");
    assert_eq!(kept(&own).len(), 1);
    let again = reference_of(&four, &own, &other).expect("the same");
    assert_eq!(first.image, again.image);
    assert!(again.seconds < first.seconds, "found, not rendered");
    let continued = reference_of(&eight, &own, &other).expect("more of it");
    assert_eq!(kept(&own).len(), 1, "the same file");
    let straight = reference_of(&eight, &other, &own.join("none")).expect("all at once");
    let worst = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let [a, b] = [&continued, &straight].map(|r| r.image.rgb("").expect("a picture")[1]);
    // The file between the passes is of f32.
    assert!(worst(a, b) < 1e-5, "{}", worst(a, b));
    let mean_error = |r: &Reference| r.error.iter().map(|e| e[1] * e[1]).sum::<f64>();
    let ratio = mean_error(&first) / mean_error(&continued);
    // Twice the passes, half the variance of the mean; both variances are estimates of few passes in 384 pixels.
    assert!((1.4..3.0).contains(&ratio), "{ratio}");
}

/// Whoever changes the scene gets a new reference and a word on the old one; a file of another scene under the name of
/// this one's is refused, and so is one without its variance.
#[test]
fn references_of_another_scene_are_refused() {
    let (folder, own) = (folder(), folder());
    let own = own.path().join("own");
    let plan = study(STUDY, folder.path());
    assert!(reference_of(&plan, &own, &own).expect("a reference").notes.is_empty());
    std::fs::write(folder.path().join("mirror.toml"), SCENE.replace("albedo = 0.5", "albedo = 0.6")).expect("scene");
    let changed = reference_of(&plan, &own, &own).expect("a new reference");
    assert!(changed.notes[0].contains("another scene"), "{:?}", changed.notes);
    let [a, b] = &kept(&own)[..] else { panic!("two references") };
    std::fs::copy(a, own.join("kept")).expect("a copy");
    std::fs::copy(b, a).expect("a copy");
    std::fs::copy(own.join("kept"), b).expect("a copy");
    assert!(matches!(reference_of(&plan, &own, &own), Err(StudyError::ReferenceRefused { .. })));
    let attributes = exr::read_file(a).expect("a file").attributes.into_iter();
    // Writing puts the prefix back.
    let bare = |(name, value): (String, String)| Some((name.strip_prefix("pdembree/")?.to_owned(), value));
    let hash: Vec<(String, String)> = attributes.filter_map(bare).collect();
    let mut bare = exr::read_file(b).expect("a file").image;
    bare.channels.truncate(3);
    for path in [a, b] {
        exr::write(path, &bare, &hash).expect("a file");
    }
    assert!(matches!(reference_of(&plan, &own, &own), Err(StudyError::ReferenceRefused { .. })));
}

/// Light paths cannot show what the mirror reflects: its pixels are not compared, those of the floor are.
#[test]
fn pixels_that_show_a_mirror_are_masked() {
    let (folder, own) = (folder(), folder());
    // From the side, so that the mirror is seen.
    let side = SCENE.replace("position = [0, 1, 0]", "position = [1, 1, 0]");
    std::fs::write(folder.path().join("mirror.toml"), side).expect("scene");
    let own = own.path().join("own");
    let mask = reference_of(&study(STUDY, folder.path()), &own, &own).expect("a reference").mask.expect("a mask");
    let held = mask.iter().filter(|&&m| m).count();
    assert!(held > 24 * 16 / 4 && held < 24 * 16, "{held}");
}

/// The whole command: rows, curves, slopes, files; what is there is not rendered again; the page holds the numbers.
#[test]
fn a_study_runs_and_goes_on_where_it_was() {
    let folder = folder();
    let (code, err) = run(folder.path());
    assert_eq!(code, 0, "{err}");
    let first = results(folder.path());
    let [bandwidth, convergence] = &first.experiments[..] else { panic!("two experiments") };
    assert_eq!(bandwidth.curves.len(), 1);
    let knn = &bandwidth.rows[0];
    assert!(knn.chosen_for.starts_with("rmse") && knn.published["rmse"] == 0.07, "{knn:?}");
    assert!((knn.rmse_ratio.expect("a baseline").value - 1.0).abs() < 1e-12);
    let best = bandwidth.curves[0].points.iter().map(|p| p.rmse).fold(f64::INFINITY, f64::min);
    assert!((knn.mean(|m| Some(m.rmse)).expect("a mean").value - best).abs() < 1e-12);
    assert_eq!(convergence.rows.len(), 6);
    assert_eq!(convergence.slopes.len(), 4);
    for row in first.experiments.iter().flat_map(|e| &e.rows) {
        for ending in ["exr", "png"] {
            let path = folder.path().join("report").join(&row.image).with_extension(ending);
            assert!(path.exists(), "{}", path.display());
        }
    }
    let csv = std::fs::read_to_string(folder.path().join("report/results.csv")).expect("a table");
    let cells: usize = first.experiments.iter().flat_map(|e| &e.rows).map(|row| row.cells.len()).sum();
    assert_eq!(csv.lines().count(), cells + 1);
    page_holds_the_numbers(&folder.path().join("report/index.html"), &first);

    // One render is lost, as if the study had been stopped in the middle of it: the others stay what they are.
    let lost = folder.path().join("report").join(&knn.image).with_extension("json");
    std::fs::remove_file(lost).expect("the record");
    assert_eq!(run(folder.path()).0, 0);
    let second = results(folder.path());
    let seconds = |r: &Results, e: usize| -> Vec<f64> {
        r.experiments[e].rows.iter().flat_map(|row| row.cells.iter().map(|cell| cell.seconds)).collect()
    };
    assert_eq!(seconds(&first, 1), seconds(&second, 1), "rendered again");
    let errors = |r: &Results| -> Vec<f64> {
        r.experiments.iter().flat_map(|e| &e.rows).flat_map(|row| row.cells.iter().map(|c| c.metrics.rmse)).collect()
    };
    assert_eq!(errors(&first), errors(&second));
}

/// Every number of a table stands in results.json, and nothing is loaded from elsewhere.
fn page_holds_the_numbers(page: &Path, results: &Results) {
    let html = std::fs::read_to_string(page).expect("a page");
    let foreign = html.replace("http://www.w3.org/2000/svg", "");
    assert!(!foreign.contains("http://") && !foreign.contains("https://"), "the page loads from elsewhere");
    let shown: Vec<f64> = html
        .split("data-value=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().expect("a value").parse().expect("a number"))
        .collect();
    for row in results.experiments.iter().flat_map(|e| &e.rows) {
        let means = [row.mean(|m| Some(m.rmse)), row.mean(|m| m.ssim), row.mean(|m| m.flip_hdr)];
        for mean in means.into_iter().flatten() {
            assert!(shown.contains(&mean.value), "{} of {} is not on the page", mean.value, row.method);
        }
    }
}

#[test]
fn studies_that_cannot_run_say_why() {
    let folder = folder();
    let broken = STUDY.replace("file = \"mirror.toml\"", "file = \"none.toml\"");
    std::fs::write(folder.path().join("study.toml"), broken).expect("study");
    let (code, err) = run(folder.path());
    assert!(code == 66 && err.contains("none.toml"), "{code}: {err}");
    let wide = STUDY.replace("region = [4, 2, 20, 14]", "region = [4, 2, 200, 14]");
    std::fs::write(folder.path().join("study.toml"), wide).expect("study");
    let (code, err) = run(folder.path());
    assert!(code == 65 && err.contains("region is not within the picture"), "{code}: {err}");
    let exact = STUDY.replace("[[scenes.reference]]", "exact = \"wave\"\n[[scenes.unused]]");
    std::fs::write(folder.path().join("study.toml"), exact).expect("study");
    assert_eq!(run(folder.path()).0, 65);
}
