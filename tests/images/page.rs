//! The page of a study, as a browser shows it: its numbers, its slider, its width on screens and on paper.

use std::path::Path;

use pdembree::study::results::{ExperimentResult, Mean, Results, Row};
use serde_json::{Value, json};

use crate::support::browser::Browser;
use crate::support::study::{folder, results, run};

/// A4 without the margins of the style sheet (10 mm at the sides), in CSS pixels of 1/96 inch.
const PAPER: f64 = (210.0 - 20.0) / 25.4 * 96.0;

#[test]
fn the_page_of_a_study_works_in_a_browser() {
    let mut browser = Browser::start();
    let folder = folder();
    let (code, err) = run(folder.path());
    assert_eq!(code, 0, "{err}");
    browser.resize(1280, 900, "screen");
    browser.open(&folder.path().join("report/index.html"));

    pictures_are_there(&mut browser);
    the_slider_slides(&mut browser);
    the_tables_hold(&results(folder.path()), &mut browser);
    for width in [1280, 400] {
        it_fits(&mut browser, width);
    }
    it_prints(&mut browser);
    it_is_quiet(&browser.events, folder.path());
}

fn pictures_are_there(browser: &mut Browser) {
    let widths = browser.evaluate(
        "Promise.all([...document.images].map(i => i.decode().then(() => i.naturalWidth, e => `${i.alt}: ${e}`)))",
    );
    let widths = widths.as_array().expect("a list");
    // 4 and 7 pictures, the reference among them, with errors below the others; two in each slider.
    assert!(widths.len() > 20 && widths.iter().all(|w| *w == 24), "{widths:?}");
}

fn the_slider_slides(browser: &mut Browser) {
    let states = browser.evaluate(
        r#"[...document.querySelectorAll(".slider")].map(slider => {
            const find = what => slider.querySelector(what);
            const state = () => [find(".over").style.clipPath, find(".over").src, find(".under").src];
            const set = (control, value) => {
                find(control).value = value;
                find(control).dispatchEvent(new Event("input", { bubbles: true }));
                return state();
            };
            return [slider.hidden, state(), set("input", 20), set(".left", 2), set(".right", 1)];
        })"#,
    );
    let sliders = states.as_array().expect("a list");
    assert_eq!(sliders.len(), 2);
    for slider in sliders {
        let [hidden, start, moved, left, right] = &slider.as_array().expect("states")[..] else { panic!("{slider}") };
        assert_eq!(*hidden, json!(false));
        assert_eq!([&start[0], &moved[0]], [&json!("inset(0px 50% 0px 0px)"), &json!("inset(0px 80% 0px 0px)")]);
        assert!(start[1] == moved[1] && moved[1] != left[1] && left[2] == moved[2], "the left choice");
        assert!(right[1] == left[1] && right[2] != left[2] && right[2] == start[1], "the right choice");
    }
}

/// The number and the text of a cell with an exact value, or nothing for a dash.
type Cells = Vec<Vec<Option<(f64, String)>>>;

/// The cells below the headings of a table of an experiment: those of a row in order.
fn cells(browser: &mut Browser, table: &str) -> Cells {
    let found = browser.evaluate(&format!(
        r#"[...document.querySelectorAll("{table} tbody tr")].map(tr => [...tr.querySelectorAll("td")].map(td =>
            td.dataset.value === undefined ? null : [Number(td.dataset.value), td.firstChild.textContent]))"#
    ));
    serde_json::from_value(found).expect("cells")
}

/// Whether `text` is `value` rounded to the digits that it shows; its last number counts, as in `k = 70`.
fn is_rounded(text: &str, value: f64) -> bool {
    let text = text.replace('\u{202f}', "");
    let text = text.rsplit(char::is_whitespace).next().unwrap_or_default();
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, d)| d.len() as i32);
    let unit = 10f64.powi(exponent.parse::<i32>().expect("an exponent") - decimals);
    (text.parse::<f64>().expect("a number") - value).abs() <= 0.500_001 * unit
}

fn same(found: &Cells, expected: &[Vec<Option<f64>>], table: &str) {
    let values: Vec<Vec<Option<f64>>> =
        found.iter().map(|row| row.iter().map(|cell| cell.as_ref().map(|c| c.0)).collect()).collect();
    assert_eq!(values, expected, "{table}");
    for (value, text) in found.iter().flatten().flatten() {
        assert!(is_rounded(text, *value), "{table}: {value} is shown as {text}");
    }
}

fn the_tables_hold(results: &Results, browser: &mut Browser) {
    let value = |mean: Option<Mean>| mean.map(|m| m.value);
    for (i, experiment) in results.experiments.iter().enumerate() {
        let ratio = experiment.rows.iter().any(|row| row.rmse_ratio.is_some());
        let line = |row: &Row| {
            let mut line = vec![
                row.photons.map(|n| n as f64),
                Some(f64::from(row.passes)),
                row.bandwidth.as_ref().map(|b| b.value),
                None,
                value(row.mean(|m| Some(m.rmse))),
                value(row.mean(|m| m.ssim)),
                value(row.mean(|m| Some(m.rel_mse))),
                value(row.mean(|m| Some(m.mae))),
                value(row.mean(|m| m.flip)),
                value(row.mean(|m| m.flip_hdr)),
                Some(row.seconds()),
            ];
            line.extend(ratio.then_some(value(row.rmse_ratio)));
            line
        };
        let table = format!("#e{i} table.rows");
        same(&cells(browser, &table), &experiment.rows.iter().map(line).collect::<Vec<_>>(), &table);
        let table = format!("#e{i} table.slopes");
        let slopes: Vec<_> = experiment.slopes.iter().map(|s| vec![None, Some(s.slope), s.half_width]).collect();
        same(&cells(browser, &table), &slopes, &table);
    }
    published_stands_beside_ours(&results.experiments[0], browser);
}

/// The study gives 0.07 and 0.8 of knn, its baseline, and 0.05 of pd-lattice, which has two bandwidths here.
fn published_stands_beside_ours(experiment: &ExperimentResult, browser: &mut Browser) {
    let of = |method: &str| experiment.rows.iter().filter(move |row| row.method == method).collect::<Vec<_>>();
    let rmse = |row: &Row| row.mean(|m| Some(m.rmse)).expect("a mean").value;
    let ssim = |row: &Row| row.mean(|m| m.ssim).expect("a mean").value;
    let knn = of("knn");
    let best = knn.iter().map(|row| rmse(row)).fold(f64::INFINITY, f64::min);
    let similar = knn.iter().map(|row| ssim(row)).fold(0.0, f64::max);
    let lattice = of("pd-lattice").into_iter().min_by(|a, b| rmse(a).total_cmp(&rmse(b))).expect("a row");
    let expected = [
        vec![Some(500.0), Some(0.07), Some(best), Some(0.8), Some(similar), Some(1.0), Some(1.0)],
        vec![
            Some(500.0),
            Some(0.05),
            Some(rmse(lattice)),
            None,
            None,
            Some(0.05 / 0.07),
            Some(lattice.rmse_ratio.expect("a baseline").value),
        ],
    ];
    same(&cells(browser, "table.published"), &expected, "published");
}

/// What sticks out of `width` pixels, beside pictures that are cut to a window on purpose.
fn sticking_out(browser: &mut Browser, width: f64) -> Value {
    browser.evaluate(&format!(
        r#"[...document.body.querySelectorAll("*")]
            .filter(e => !e.closest(".window, .stack, script") && e.getBoundingClientRect().right > {width} + 0.5)
            .map(e => `${{e.tagName}}.${{e.className}} ${{e.getBoundingClientRect().right}}`)"#
    ))
}

fn it_fits(browser: &mut Browser, width: u32) {
    browser.resize(width, 900, "screen");
    assert_eq!(browser.evaluate("document.documentElement.scrollWidth"), json!(width), "the page scrolls sideways");
    // What is wider than the window is within something that scrolls; with all of that away nothing is left.
    let scrolled = browser.evaluate(
        r#"[...document.querySelectorAll(".wide")].map(wide => {
            wide.scrollLeft = 1e6;
            return [wide.scrollWidth - wide.clientWidth, wide.scrollLeft];
        })"#,
    );
    let scrolled: Vec<[f64; 2]> = serde_json::from_value(scrolled).expect("pairs");
    assert!(scrolled.iter().all(|[room, left]| (room - left).abs() <= 1.0), "{scrolled:?}");
    if width < 500 {
        assert!(scrolled.iter().any(|[room, _]| *room > 100.0), "no table is wide: the check checks nothing");
    }
    browser.evaluate(r#"document.querySelectorAll(".wide").forEach(wide => { wide.style.display = "none"; })"#);
    assert_eq!(sticking_out(browser, f64::from(width)), json!([]));
    browser.evaluate(r#"document.querySelectorAll(".wide").forEach(wide => { wide.style.display = ""; })"#);
}

fn it_prints(browser: &mut Browser) {
    browser.resize(PAPER as u32, 1000, "print");
    assert_eq!(sticking_out(browser, PAPER), json!([]), "cut off on paper");
    let pdf = browser.print();
    let text = String::from_utf8_lossy(&pdf);
    let boxes: Vec<Vec<f64>> = text
        .split("/MediaBox")
        .skip(1)
        .map(|rest| {
            let inside = rest.trim_start().trim_start_matches('[').split(']').next().unwrap_or_default();
            inside.split_whitespace().map(|v| v.parse().expect("a number")).collect()
        })
        .collect();
    assert!(!boxes.is_empty(), "no pages");
    for page in &boxes {
        let a4 = [0.0, 0.0, 595.276, 841.89];
        assert!(page.len() == 4 && page.iter().zip(a4).all(|(a, b)| (a - b).abs() < 1.0), "{page:?} is not A4");
    }
}

/// No error, no exception, and nothing loaded but the page and what it carries itself.
fn it_is_quiet(events: &[Value], folder: &Path) {
    for event in events {
        let (method, about) = (event["method"].as_str().unwrap_or_default(), &event["params"]);
        let error = method == "Runtime.exceptionThrown"
            || method == "Runtime.consoleAPICalled" && about["type"] == "error"
            || method == "Log.entryAdded" && about["entry"]["level"] == "error";
        assert!(!error, "{event}");
        if method == "Network.requestWillBeSent" {
            let url = about["request"]["url"].as_str().expect("an address");
            let page = url.starts_with(&format!("file://{}", folder.display())) && url.ends_with("report/index.html");
            assert!(page || url.starts_with("data:"), "{url}");
        }
    }
    assert!(events.iter().any(|e| e["method"] == "Network.requestWillBeSent"), "requests are not seen");
}
