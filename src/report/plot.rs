//! Curves as SVG: error over bandwidth, error over photons and over seconds.

use std::ops::Range;

use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;

use super::ReportError;
use crate::study::results::{Curve, ExperimentResult, Row};

const SIZE: (u32, u32) = (560, 340);

/// Colours that are told apart without red and green (Okabe and Ito's).
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(213, 94, 0),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(120, 120, 120),
];

/// A line of points, with some of them marked.
struct Series {
    name: String,
    points: Vec<(f64, f64)>,
    marked: Option<usize>,
    /// A straight line in logarithms beside the points: slope and intercept.
    law: Option<(f64, f64)>,
}

/// RMSE over the bandwidth, and SSIM where it exists.
pub(super) fn curves(curve: &Curve) -> Result<Vec<String>, ReportError> {
    let photons = curve.photons.map_or_else(String::new, |n| format!(", {n} photons"));
    let title = |metric: &str| format!("{}{photons}: {metric}", curve.method);
    let series =
        |metric: &str, points: Vec<(f64, f64)>, marked| Series { name: metric.to_owned(), points, marked, law: None };
    let rmse = curve.points.iter().map(|p| (p.bandwidth, p.rmse)).collect();
    let mut all = vec![plot(&title("RMSE"), &curve.parameter, &[series("RMSE", rmse, Some(curve.best_rmse))], false)?];
    let ssim: Option<Vec<(f64, f64)>> = curve.points.iter().map(|p| Some((p.bandwidth, p.ssim?))).collect();
    if let Some(ssim) = ssim {
        all.push(plot(&title("SSIM"), &curve.parameter, &[series("SSIM", ssim, curve.best_ssim)], false)?);
    }
    Ok(all)
}

/// Error of all methods over photons and over seconds, for one scene of an experiment with fitted slopes.
pub(super) fn convergence(experiment: &ExperimentResult, scene: &str) -> Result<Vec<String>, ReportError> {
    let over = |what: &str, x: &dyn Fn(&Row) -> Option<f64>| {
        let of = |slope: &&crate::study::results::Slope| slope.scene == scene && slope.over == what;
        let lines = experiment.slopes.iter().filter(of).map(|slope| {
            let rows = experiment.rows.iter().filter(|r| r.scene == scene && r.method == slope.method);
            let rows = rows.filter(|r| r.chosen_for != "ssim");
            let point = |row: &Row| Some((x(row)?, row.mean(|m| Some(m.rmse_linear))?.value));
            let mut points: Vec<(f64, f64)> = rows.filter_map(point).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let interval = slope.half_width.map_or_else(String::new, |w| format!(" ± {w:.2}"));
            let name = format!("{} {:.2}{interval}", slope.method, slope.slope);
            Series { name, points, marked: None, law: Some((slope.slope, slope.intercept)) }
        });
        let lines: Vec<Series> = lines.collect();
        if lines.is_empty() { Ok(None) } else { plot(&format!("RMSE over {what}"), what, &lines, true).map(Some) }
    };
    let plots = [over("photons", &|row| row.photons.map(|n| n as f64))?, over("seconds", &|row| Some(row.seconds()))?];
    Ok(plots.into_iter().flatten().collect())
}

/// The span of finite values, a little wider.
fn span(values: impl Iterator<Item = f64>, logarithmic: bool) -> Range<f64> {
    let fits = |v: &f64| v.is_finite() && (!logarithmic || *v > 0.0);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    values.filter(fits).for_each(|v| (low, high) = (low.min(v), high.max(v)));
    if low > high {
        return 1.0..2.0;
    }
    if logarithmic {
        return low / 1.15..high * 1.15;
    }
    let margin = (0.06 * (high - low)).max(1e-9 * high.abs()).max(1e-12);
    low - margin..high + margin
}

/// A plot over a logarithmic axis; `log_y` makes the other one logarithmic, too.
fn plot(title: &str, x_name: &str, series: &[Series], log_y: bool) -> Result<String, ReportError> {
    let failed = |reason: String| ReportError::Plot { what: title.to_owned(), reason };
    let points = || series.iter().flat_map(|s| s.points.iter());
    let x = span(points().map(|p| p.0), true);
    let y = span(points().map(|p| p.1), log_y);
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let mut builder = ChartBuilder::on(&area);
        builder.margin(10).caption(title, ("sans-serif", 15)).x_label_area_size(34).y_label_area_size(58);
        if log_y {
            let chart = builder.build_cartesian_2d(x.clone().log_scale(), y.log_scale());
            draw(chart.map_err(|e| failed(e.to_string()))?, x_name, series, &x).map_err(failed)?;
        } else {
            let chart = builder.build_cartesian_2d(x.clone().log_scale(), y);
            draw(chart.map_err(|e| failed(e.to_string()))?, x_name, series, &x).map_err(failed)?;
        }
        area.present().map_err(|e| failed(e.to_string()))?;
    }
    Ok(svg)
}

type Chart<'a, X, Y> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>;

fn draw<'a, X, Y>(mut chart: Chart<'a, X, Y>, x_name: &str, series: &[Series], x: &Range<f64>) -> Result<(), String>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64> + 'a,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64> + 'a,
{
    let text = |e: &dyn std::fmt::Display| e.to_string();
    let label = |v: &f64| short(*v);
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(x_name).x_labels(8).y_labels(7).x_label_formatter(&label).y_label_formatter(&label);
    mesh.light_line_style(BLACK.mix(0.05)).bold_line_style(BLACK.mix(0.15)).draw().map_err(|e| text(&e))?;
    for (i, line) in series.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        if let Some((slope, intercept)) = line.law {
            let ends = [x.start, x.end].map(|x| (x, (intercept + slope * x.ln()).exp()));
            chart.draw_series(LineSeries::new(ends, colour.mix(0.5))).map_err(|e| text(&e))?;
        } else {
            chart.draw_series(LineSeries::new(line.points.iter().copied(), colour)).map_err(|e| text(&e))?;
        }
        // Shapes differ, too, so that the plot can be read in grey.
        let drawn = match i % 3 {
            0 => chart.draw_series(line.points.iter().map(|&p| Circle::new(p, 4, colour.filled()))),
            1 => chart.draw_series(line.points.iter().map(|&p| TriangleMarker::new(p, 6, colour.filled()))),
            _ => chart.draw_series(line.points.iter().map(|&p| Cross::new(p, 4, colour.stroke_width(2)))),
        };
        let drawn = drawn.map_err(|e| text(&e))?;
        if series.len() > 1 || line.law.is_some() {
            drawn.label(&line.name).legend(move |(x, y)| Rectangle::new([(x, y - 4), (x + 8, y + 4)], colour.filled()));
        }
        if let Some(&best) = line.marked.and_then(|best| line.points.get(best)) {
            let ring = Circle::new(best, 8, COLOURS[3].stroke_width(2));
            chart.draw_series([ring]).map_err(|e| text(&e))?;
            let place = format!("best: {} at {}", short(best.1), short(best.0));
            let style = ("sans-serif", 12).into_text_style(chart.plotting_area());
            chart
                .plotting_area()
                .draw(&(EmptyElement::at(best) + Text::new(place, (-40, -22), style)))
                .map_err(|e| text(&e))?;
        }
    }
    if series.iter().any(|s| s.law.is_some()) {
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::LowerLeft).background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.3));
        labels.draw().map_err(|e| text(&e))?;
    }
    Ok(())
}

/// Three digits, powers of ten where they are shorter.
fn short(v: f64) -> String {
    match v.abs() {
        a if a == 0.0 || (1e-3..1e4).contains(&a) => {
            let digits = (2 - a.max(1e-3).log10().floor() as i32).max(0) as usize;
            let text = format!("{v:.digits$}");
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
        }
        _ => format!("{v:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let numbers = [(0.0, "0"), (0.0421, "0.0421"), (70.0, "70"), (333.4, "333"), (1e5, "1.0e5"), (2e-4, "2.0e-4")];
        for (v, text) in numbers {
            assert_eq!(short(v), text);
        }
    }

    #[test]
    fn a_plot_of_nothing_is_still_a_plot() {
        let none = Series { name: String::new(), points: vec![], marked: Some(3), law: None };
        assert!(plot("nothing", "x", &[none], true).expect("a plot").starts_with("<svg"));
    }
}
