//! The page: how it was made, then each experiment with its table, curves and pictures.

use std::path::Path;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::picture::{WORST, data_uri, gradient, with_ending, write_error_map};
use super::plot::Plot;
use super::table::{bandwidth, grouped, significant};
use super::{ReportError, plot, table};
use crate::study::results::{ExperimentResult, Results, Row, SceneResult};

const STYLE: &str = include_str!("style.css");
const SLIDER: &str = include_str!("slider.js");

pub(super) fn page(folder: &Path, results: &Results) -> Result<String, ReportError> {
    let mut sections = Vec::new();
    for (i, experiment) in results.experiments.iter().enumerate() {
        sections.push(section(folder, results, experiment, i)?);
    }
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (results.title) " – pdembree study" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { (results.title) }
                    p { (results.about) }
                }
                nav {
                    @for (i, experiment) in results.experiments.iter().enumerate() {
                        a href={ "#e" (i) } { (experiment.name) } " "
                    }
                }
                (PreEscaped(sections.into_iter().map(PreEscaped::into_string).collect::<String>()))
                (method_of_measurement(results))
                script { (PreEscaped(SLIDER)) }
            }
        }
    };
    Ok(markup.into_string())
}

fn section(
    folder: &Path,
    results: &Results,
    experiment: &ExperimentResult,
    number: usize,
) -> Result<Markup, ReportError> {
    let scenes = results.scenes.iter().filter(|s| experiment.rows.iter().any(|row| row.scene == s.name));
    let mut parts = Vec::new();
    for scene in scenes {
        parts.push(of_scene(folder, experiment, scene)?);
    }
    Ok(html! {
        section id={ "e" (number) } {
            h2 { (experiment.name) }
            p { (experiment.about) }
            @if let Some([x0, y0, x1, y1]) = experiment.region {
                p { "Errors are measured in the pixels from (" (x0) ", " (y0) ") to (" (x1) ", " (y1) ")." }
            }
            (table::rows(experiment))
            (table::published(experiment))
            (table::slopes(experiment))
            @for part in parts { (part) }
        }
    })
}

fn of_scene(folder: &Path, experiment: &ExperimentResult, scene: &SceneResult) -> Result<Markup, ReportError> {
    let mut plots = plot::convergence(experiment, &scene.name)?;
    for curve in experiment.curves.iter().filter(|curve| curve.scene == scene.name) {
        plots.extend(plot::curves(curve)?);
    }
    let rows: Vec<&Row> = experiment.rows.iter().filter(|row| row.scene == scene.name).collect();
    let reference = folder.join(&scene.reference.image);
    let mut pictures = vec![Picture {
        name: "reference".to_owned(),
        detail: format!("own error {}", significant(scene.reference.standard_error, 2)),
        picture: data_uri(&with_ending(&reference, ".png"))?,
        error: None,
    }];
    for row in rows {
        let image = folder.join(&row.image);
        let error = write_error_map(&image, &reference, scene.white)?;
        pictures.push(Picture {
            name: caption(row),
            detail: detail(row),
            picture: data_uri(&with_ending(&image, ".png"))?,
            error: Some(data_uri(&error)?),
        });
    }
    let size = [scene.width, scene.height];
    Ok(html! {
        h3 { (scene.name) }
        @if !plots.is_empty() { div.plots { @for plot in &plots { (figure(plot)) } } }
        div.pictures {
            @for picture in &pictures { (tile(picture, size, experiment.crop)) }
        }
        p.legend {
            "Below each picture its error as shown, mean over the colours: 0 "
            span.scale style={ "background: " (gradient()) } {}
            " " (WORST) " and more. Blue-grey: not compared."
        }
        (slider(size))
    })
}

fn figure(plot: &Plot) -> Markup {
    html! {
        figure {
            h4 { (plot.title) }
            (PreEscaped(&plot.svg))
            ul { @for key in &plot.legend { li { span style={ "color: " (key.colour) } { (key.mark) } " " (key.text) } } }
        }
    }
}

struct Picture {
    name: String,
    detail: String,
    picture: String,
    error: Option<String>,
}

fn caption(row: &Row) -> String {
    let photons = row.photons.map_or_else(String::new, |n| format!(", {} photons", grouped(n)));
    let setting = row.bandwidth.as_ref().map_or_else(String::new, |_| format!(", {}", bandwidth(row)));
    format!("{}{photons}{setting}", row.method)
}

fn detail(row: &Row) -> String {
    let text = |name: &str, value: Option<crate::study::results::Mean>, digits| {
        value.map_or_else(String::new, |m| format!("{name} {} ", significant(m.value, digits)))
    };
    text("RMSE", row.mean(|m| Some(m.rmse)), 3) + &text("SSIM", row.mean(|m| m.ssim), 4)
}

/// A picture, and its error below it, cut to the crop: the same picture serves the slider whole.
fn tile(picture: &Picture, size: [u32; 2], crop: Option<[u32; 4]>) -> Markup {
    let [x0, y0, x1, y1] = crop.unwrap_or([0, 0, size[0], size[1]]).map(f64::from);
    let width = f64::from(size[0]);
    let (w, h) = (x1 - x0, y1 - y0);
    let window = format!("aspect-ratio: {w} / {h}");
    let place =
        format!("width: {:.3}%; left: {:.3}%; top: {:.3}%", 100.0 * width / w, -100.0 * x0 / w, -100.0 * y0 / h);
    html! {
        figure.tile {
            div.window style=(window) { img.whole src=(picture.picture) alt=(picture.name) style=(place); }
            @if let Some(error) = &picture.error {
                div.window style=(window) { img src=(error) alt={ "error of " (picture.name) } style=(place); }
            }
            figcaption { (picture.name) br; small { (picture.detail) } }
        }
    }
}

/// Two pictures one over the other; the script fills it with those of the tiles before it.
fn slider(size: [u32; 2]) -> Markup {
    html! {
        div.slider hidden {
            div.choice {
                label { "left " select.left {} }
                label { "right " select.right {} }
            }
            div.stack style={ "aspect-ratio: " (size[0]) " / " (size[1]) } {
                img.under alt="right picture";
                img.over alt="left picture";
            }
            input type="range" min="0" max="100" value="50" aria-label="where the left picture ends";
        }
    }
}

fn method_of_measurement(results: &Results) -> Markup {
    html! {
        section id="how" {
            h2 { "How it was measured" }
            p {
                (results.program) ", " (results.backend) ", " (results.threads) " threads. Files: results.json, results.csv, "
                "and of every picture an EXR and a PNG."
            }
            div.wide {
                table {
                    thead { tr { th { "scene" } th { "pixels" } th { "layer" } th { "white" } th { "reference" } th { "its error" } th { "compared" } } }
                    tbody {
                        @for scene in &results.scenes {
                            tr {
                                th scope="row" { (scene.name) br; small { (scene.file.display()) } }
                                td { (scene.width) " × " (scene.height) }
                                td { @if scene.layer.is_empty() { "beauty" } @else { (scene.layer) } }
                                td data-value=(scene.white) { (significant(scene.white, 4)) }
                                td.text { (scene.reference.about) }
                                td data-value=(scene.reference.standard_error) { (significant(scene.reference.standard_error, 2)) }
                                td data-value=(scene.reference.pixels_compared) { (grouped(scene.reference.pixels_compared)) }
                            }
                        }
                    }
                }
            }
            dl {
                dt { "Shown values" } dd { "clamp(v / white, 0, 1), linear; pictures on this page are sRGB-encoded." }
                dt { "RMSE" } dd { "root mean square difference of shown values over pixels and colours; ± standard error over the seeds." }
                dt { "SSIM" }
                dd {
                    "mean over R, G, B of shown values, "
                    @for scene in &results.scenes { (scene.name) ": " (scene.ssim_domain) "; " }
                    "Gaussian window of 11 × 11 pixels, σ = 1.5, K₁ = 0.01, K₂ = 0.03, L = 1, population covariances."
                }
                dt { "relMSE" } dd { "mean of (v − r)² / (r² + 0.01), v and r in units of white." }
                dt { "MAE" } dd { "mean absolute difference in units of white, unclamped." }
                dt { "FLIP" } dd { "mean LDR FLIP of the 8-bit sRGB pictures at 67 pixels per degree." }
                dt { "HDR FLIP" } dd { "mean over pixels of the largest LDR FLIP over all exposures, tone-mapped (ACES)." }
                dt { "Its error" } dd { "root mean square over the pixels of the reference's own standard error; of a closed form, of the error of its quadrature." }
                dt { "Slopes" } dd { "of ln error (linear RMSE) over ln photons or ln seconds, least squares, with 95 % intervals." }
                dt { "Best bandwidth" } dd { "by a bracketed search over its logarithm; the curves show all points that were looked at, means over the seeds." }
                dt { "Seconds" } dd { "wall clock of one render, mean over the seeds." }
            }
        }
    }
}
