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
    let decimals = digits as i32 - 1 - v.abs().log10().floor() as i32;
    if decimals > 7 {
        format!("{v:.*e}", digits.saturating_sub(1))
    } else {
        format!("{v:.*}", decimals.max(0) as usize)
    }
}

/// A count with thin spaces between the thousands.
pub(super) fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let chunks: Vec<&str> = digits.as_bytes().rchunks(3).rev().filter_map(|c| std::str::from_utf8(c).ok()).collect();
    chunks.join("\u{202f}")
}

/// The bandwidth as text: `k = 280`.
pub(super) fn bandwidth(row: &Row) -> String {
    row.bandwidth.as_ref().map_or_else(|| "–".to_owned(), |b| format!("{} = {}", b.name, significant(b.value, 3)))
}

pub(super) fn rows(experiment: &ExperimentResult) -> Markup {
    let published = experiment.rows.iter().any(|row| !row.published.is_empty());
    let ratio = experiment.rows.iter().any(|row| row.rmse_ratio.is_some());
    html! {
        div.wide {
            table {
                thead {
                    tr {
                        th { "method" }
                        th { "photons" }
                        th { "passes" }
                        th { "bandwidth" }
                        th { "best for" }
                        @if published { th { "RMSE published" } }
                        th { "RMSE" }
                        @if published { th { "SSIM published" } }
                        th { "SSIM" }
                        th { "relMSE" }
                        th { "MAE" }
                        th { "FLIP" }
                        th { "HDR FLIP" }
                        th { "seconds" }
                        @if ratio { th { "RMSE / baseline" } }
                    }
                }
                tbody { @for row in &experiment.rows { (line(row, published, ratio)) } }
            }
        }
    }
}

fn line(row: &Row, published: bool, ratio: bool) -> Markup {
    let said = |name: &str| row.published.get(name).copied();
    html! {
        tr {
            th scope="row" { (row.method) @if row.cells.len() > 1 { small { " " (row.cells.len()) " seeds" } } }
            (plain(row.photons.map(|n| n as f64), |n| grouped(n as u64)))
            (plain(Some(row.passes.into()), |n| n.to_string()))
            (match &row.bandwidth {
                Some(b) => html! { td data-value=(b.value) { (bandwidth(row)) } },
                None => html! { td { "–" } },
            })
            td { (row.chosen_for) }
            @if published { (plain(said("rmse"), |v| format!("{v}"))) }
            (mean(row.mean(|m| Some(m.rmse)), 3))
            @if published { (plain(said("ssim"), |v| format!("{v}"))) }
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

pub(super) fn slopes(experiment: &ExperimentResult) -> Markup {
    html! {
        @if !experiment.slopes.is_empty() {
            table {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_as_many_digits_as_they_say() {
        assert_eq!(significant(0.068_61, 3), "0.0686");
        assert_eq!(significant(1234.5, 2), "1234");
        assert_eq!(significant(1.0, 3), "1.00");
        assert_eq!(significant(3.2e-9, 2), "3.2e-9");
        assert_eq!(grouped(1_000_000), "1\u{202f}000\u{202f}000");
        assert_eq!(grouped(70), "70");
    }
}
