//! The numbers of an experiment as a table; every cell carries its exact value beside the rounded text.

use maud::{Markup, html};

use crate::study::results::{ExperimentResult, Mean, Row};

/// A number with its standard error, `None` as a dash.
fn mean(value: Option<Mean>, digits: usize) -> Markup {
    match value {
        None => html! { td { "–" } },
        Some(m) => html! {
            td data-value=(m.value) {
                (significant(m.value, digits))
                @if let Some(error) = m.standard_error { small { " ± " (significant(error, 1)) } }
            }
        },
    }
}

fn plain(value: Option<f64>, text: impl Fn(f64) -> String) -> Markup {
    match value {
        None => html! { td { "–" } },
        Some(v) => html! { td data-value=(v) { (text(v)) } },
    }
}

/// `digits` significant digits.
pub(super) fn significant(v: f64, digits: usize) -> String {
    if v == 0.0 || !v.is_finite() {
        return format!("{v}");
    }
    // The exponent after rounding: 0.00996 has one digit as 0.01.
    let rounded = format!("{v:.*e}", digits.saturating_sub(1));
    let exponent = rounded.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0);
    let decimals = digits as i32 - 1 - exponent;
    if decimals > 7 { rounded } else { format!("{v:.*}", decimals.max(0) as usize) }
}

/// A count with thin spaces between the thousands.
pub(super) fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let chunks: Vec<&str> = digits.as_bytes().rchunks(3).rev().filter_map(|c| std::str::from_utf8(c).ok()).collect();
    chunks.join("\u{202f}")
}

/// The bandwidth as text that stays on one line: `k = 280`.
pub(super) fn bandwidth(row: &Row) -> String {
    row.bandwidth
        .as_ref()
        .map_or_else(|| "–".to_owned(), |b| format!("{}\u{a0}=\u{a0}{}", b.name, significant(b.value, 3)))
}

pub(super) fn rows(experiment: &ExperimentResult) -> Markup {
    let ratio = experiment.rows.iter().any(|row| row.rmse_ratio.is_some());
    let name = names(experiment);
    html! {
        @if let Some(seeds) = experiment.rows.first().map(|row| row.cells.len()).filter(|&seeds| seeds > 1) {
            p { "Means over " (seeds) " seeds ± their standard errors." }
        }
        div.wide {
            table.rows {
                thead {
                    tr {
                        th { "method" }
                        th { "photons" }
                        th { "passes" }
                        th { "bandwidth" }
                        th { "best for" }
                        th { "RMSE" }
                        th { "SSIM" }
                        th { "relMSE" }
                        th { "MAE" }
                        th { "FLIP" }
                        th { "HDR FLIP" }
                        th { "seconds" }
                        @if ratio { th { "RMSE / baseline" } }
                    }
                }
                tbody { @for row in &experiment.rows { (line(row, &name(row), ratio)) } }
            }
        }
    }
}

/// How a table calls a row: by the method, and by the scene where there are several.
fn names(experiment: &ExperimentResult) -> impl Fn(&Row) -> String {
    let first = experiment.rows.first().map(|row| row.scene.clone());
    let several = experiment.rows.iter().any(|row| Some(&row.scene) != first.as_ref());
    move |row| if several { format!("{}: {}", row.scene, row.method) } else { row.method.clone() }
}

fn photons(row: &Row) -> Markup {
    plain(row.photons.map(|n| n as f64), |n| grouped(n as u64))
}

fn line(row: &Row, name: &str, ratio: bool) -> Markup {
    html! {
        tr {
            th scope="row" {
                (name)
                @if let Some((emitted, stored)) = row.photons_emitted.zip(row.photons_stored) {
                    br; small { (grouped(emitted)) " emitted, " (grouped(stored)) " stored" }
                }
            }
            (photons(row))
            (plain(Some(row.passes.into()), |n| n.to_string()))
            (match &row.bandwidth {
                Some(b) => html! { td data-value=(b.value) { (bandwidth(row)) } },
                None => html! { td { "–" } },
            })
            td { (row.chosen_for) }
            (mean(row.mean(|m| Some(m.rmse)), 3))
            (mean(row.mean(|m| m.ssim), 4))
            (mean(row.mean(|m| Some(m.rel_mse)), 3))
            (mean(row.mean(|m| Some(m.mae)), 3))
            (mean(row.mean(|m| m.flip), 3))
            (mean(row.mean(|m| m.flip_hdr), 3))
            (plain(Some(row.seconds()), |s| significant(s, 3)))
            @if ratio { (mean(row.rmse_ratio, 3)) }
        }
    }
}

/// Published values beside ours at the bandwidth that is best for each, and beside the ratios between methods.
pub(super) fn published(experiment: &ExperimentResult) -> Markup {
    let name = names(experiment);
    let same = |a: &Row, b: &Row| (&a.scene, &a.method, a.photons) == (&b.scene, &b.method, b.photons);
    let rows: Vec<&Row> = experiment.rows.iter().filter(|row| !row.published.is_empty()).collect();
    let firsts: Vec<&Row> = rows
        .iter()
        .enumerate()
        .filter(|&(i, row)| !rows[..i].iter().any(|r| same(r, row)))
        .map(|(_, &row)| row)
        .collect();
    let best = |of: &Row, metric: &str, value: &dyn Fn(&Row) -> Option<Mean>, sign: f64| {
        let mine = rows.iter().filter(|row| same(row, of));
        let found = mine.filter_map(|&row| Some((*row.published.get(metric)?, value(row)?, row)));
        found.min_by(|a, b| (sign * a.1.value).total_cmp(&(sign * b.1.value)))
    };
    let rmse = |row: &Row| best(row, "rmse", &|row| row.mean(|m| Some(m.rmse)), 1.0);
    let ssim = |row: &Row| best(row, "ssim", &|row| row.mean(|m| m.ssim), -1.0);
    // The baseline is the row that is its own measure.
    let is_baseline = |row: &Row| row.rmse_ratio.is_some_and(|ratio| ratio.value == 1.0);
    let baseline =
        |of: &Row| rows.iter().find(|row| row.scene == of.scene && is_baseline(row))?.published.get("rmse").copied();
    let ratio = firsts.iter().any(|row| baseline(row).is_some());
    html! {
        @if !firsts.is_empty() {
            h3 { "Published values and those found here" }
            div.wide {
                table.published {
                    thead {
                        tr {
                            th rowspan="2" { "method" }
                            th rowspan="2" { "photons" }
                            th colspan="2" { "RMSE" }
                            th colspan="2" { "SSIM" }
                            @if ratio { th colspan="2" { "RMSE / baseline" } }
                        }
                        tr { @for _ in 0..if ratio { 3 } else { 2 } { th { "published" } th { "here" } } }
                    }
                    tbody {
                        @for row in &firsts {
                            @let (rmse, ssim) = (rmse(row), ssim(row));
                            tr {
                                th scope="row" { (name(row)) }
                                (photons(row))
                                (plain(rmse.map(|r| r.0), |v| v.to_string()))
                                (mean(rmse.map(|r| r.1), 3))
                                (plain(ssim.map(|s| s.0), |v| v.to_string()))
                                (mean(ssim.map(|s| s.1), 4))
                                @if ratio {
                                    (plain(rmse.and_then(|r| Some(r.0 / baseline(row)?)), |v| significant(v, 3)))
                                    (mean(rmse.and_then(|r| r.2.rmse_ratio), 3))
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

pub(super) fn slopes(experiment: &ExperimentResult) -> Markup {
    html! {
        @if !experiment.slopes.is_empty() {
            h3 { "Order of convergence" }
            div.wide {
                table.slopes {
                    thead { tr { th { "method" } th { "over" } th { "slope" } th { "95 % ±" } } }
                    tbody {
                        @for slope in &experiment.slopes {
                            tr {
                                th scope="row" { (slope.method) }
                                td { (slope.over) }
                                (plain(Some(slope.slope), |v| format!("{v:.3}")))
                                (plain(slope.half_width, |v| format!("{v:.3}")))
                            }
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_as_many_digits_as_they_say() {
        assert_eq!(significant(0.068_61, 3), "0.0686");
        assert_eq!(significant(1234.5, 2), "1234");
        assert_eq!(significant(1.0, 3), "1.00");
        assert_eq!(significant(0.009_96, 1), "0.01");
        assert_eq!(significant(3.2e-9, 2), "3.2e-9");
        assert_eq!(grouped(1_000_000), "1\u{202f}000\u{202f}000");
        assert_eq!(grouped(70), "70");
    }
}
