//! Curves as SVG: error over bandwidth, error over photons and over seconds. Titles and legends stand beside the plot, in
//! the page, where they cover no data.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;

use super::ReportError;
use super::table::grouped;
use crate::study::results::{Curve, ExperimentResult, Row, Slope};

const SIZE: (u32, u32) = (440, 270);

/// Colours that are told apart without red and green (Okabe and Ito's); black is the page's own colour of text.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(213, 94, 0),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    BLACK,
    RGBColor(128, 128, 128),
];

/// Shapes differ, too, so that a plot can be read in grey.
const MARKS: [char; 3] = ['●', '▲', '✕'];

/// What the page shows of a plot.
pub(super) struct Plot {
    pub title: String,
    pub svg: String,
    pub legend: Vec<Key>,
}

/// A line of a legend; the colour as a style sheet has it.
pub(super) struct Key {
    pub mark: char,
    pub colour: String,
    pub text: String,
}

/// A line of points.
#[derive(Default)]
struct Series {
    name: String,
    points: Vec<(f64, f64)>,
    /// One of them, and what the legend says of it.
    marked: Option<(usize, String)>,
    /// A straight line in logarithms beside the points: slope and intercept.
    law: Option<(f64, f64)>,
}

/// RMSE over the bandwidth, and SSIM where it exists.
pub(super) fn curves(curve: &Curve) -> Result<Vec<Plot>, ReportError> {
    let photons = curve.photons.map_or_else(String::new, |n| format!(", {} photons", grouped(n)));
    let one = |metric: &str, values: Vec<f64>, best: Option<usize>, bracketed: bool| {
        let points: Vec<(f64, f64)> = curve.points.iter().map(|p| p.bandwidth).zip(values).collect();
        let marked = best.and_then(|i| {
            let &(bandwidth, value) = points.get(i)?;
            let end = if bracketed { "" } else { ", the end of the range" };
            Some((i, format!("best: {} at {} = {}{end}", short(value), curve.parameter, short(bandwidth))))
        });
        let axes = [(curve.parameter.as_str(), true), (metric, false)];
        plot(format!("{}{photons}: {metric}", curve.method), axes, &[Series { points, marked, ..Series::default() }])
    };
    let rmse = curve.points.iter().map(|p| p.rmse).collect();
    let mut all = vec![one("RMSE", rmse, Some(curve.best_rmse), curve.rmse_bracketed)?];
    let ssim: Option<Vec<f64>> = curve.points.iter().map(|p| p.ssim).collect();
    if let Some(ssim) = ssim {
        all.push(one("SSIM", ssim, curve.best_ssim, curve.ssim_bracketed)?);
    }
    Ok(all)
}

/// Error of all methods over photons and over seconds, for one scene of an experiment with fitted slopes.
pub(super) fn convergence(experiment: &ExperimentResult, scene: &str) -> Result<Vec<Plot>, ReportError> {
    let over = |what: &str, x: &dyn Fn(&Row) -> Option<f64>| {
        let of = |slope: &&Slope| slope.scene == scene && slope.over == what;
        let lines = experiment.slopes.iter().filter(of).map(|slope| {
            let rows = experiment.rows.iter().filter(|r| r.scene == scene && r.method == slope.method);
            let rows = rows.filter(|r| r.chosen_for != "ssim");
            let point = |row: &Row| Some((x(row)?, row.mean(|m| Some(m.rmse_linear))?.value));
            let mut points: Vec<(f64, f64)> = rows.filter_map(point).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let interval = slope.half_width.map_or_else(String::new, |w| format!(" ± {w:.2}"));
            let name = format!("{}: slope {:.2}{interval}", slope.method, slope.slope);
            Series { name, points, law: Some((slope.slope, slope.intercept)), ..Series::default() }
        });
        let lines: Vec<Series> = lines.collect();
        let axes = [(what, true), ("linear RMSE", true)];
        if lines.is_empty() { Ok(None) } else { plot(format!("Linear RMSE over {what}"), axes, &lines).map(Some) }
    };
    let plots = [over("photons", &|row| row.photons.map(|n| n as f64))?, over("seconds", &|row| Some(row.seconds()))?];
    Ok(plots.into_iter().flatten().collect())
}

/// An axis with its ticks and their labels.
#[derive(Clone)]
struct Axis {
    name: String,
    logarithmic: bool,
    range: Range<f64>,
    ticks: Vec<f64>,
    /// Thinner lines between the ticks.
    between: Vec<f64>,
}

impl Axis {
    /// Around `values`, with some room.
    fn new((name, logarithmic): (&str, bool), values: impl Iterator<Item = f64>) -> Axis {
        let place = |v: f64| if logarithmic { v.log10() } else { v };
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        values.map(place).filter(|v| v.is_finite()).for_each(|v| (low, high) = (low.min(v), high.max(v)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let margin = (0.06 * (high - low)).max(0.02 * high.abs()).max(1e-9);
        let range = low - margin..high + margin;
        let name = name.to_owned();
        if logarithmic {
            let (ticks, between) = decades(&range);
            let range = 10f64.powf(range.start)..10f64.powf(range.end);
            return Axis { name, logarithmic, range, ticks, between };
        }
        Axis { name, logarithmic, ticks: even(&range), range, between: Vec::new() }
    }

    fn holds(&self, v: f64) -> bool {
        v.is_finite() && (!self.logarithmic || v > 0.0)
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, v: &f64, (from, to): (i32, i32)) -> i32 {
        let place = |v: f64| if self.logarithmic { v.log10() } else { v };
        let (low, high) = (place(self.range.start), place(self.range.end));
        from + (f64::from(to - from) * (place(*v) - low) / (high - low)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { self.between.clone() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Axis {
    fn format(v: &f64) -> String {
        short(*v)
    }
}

/// Steps of 1, 2 or 5 times a power of ten, up to six in `range`.
fn even(range: &Range<f64>) -> Vec<f64> {
    let least = (range.end - range.start) / 6.0;
    let power = 10f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|&s| s >= least).unwrap_or(least);
    let (first, last) = ((range.start / step).ceil() as i64, (range.end / step).floor() as i64);
    (first..=last).map(|i| i as f64 * step).collect()
}

/// Ticks for a range of logarithms: the fewest of 1, 2, 5, … times powers of ten that are three or more; and all nine a
/// decade.
fn decades(range: &Range<f64>) -> (Vec<f64>, Vec<f64>) {
    let powers = range.start.floor() as i32..=range.end.ceil() as i32;
    let of = |mantissas: &[f64]| -> Vec<f64> {
        let all = powers.clone().flat_map(|k| mantissas.iter().map(move |m| m * 10f64.powi(k)));
        all.filter(|v| range.contains(&v.log10())).collect()
    };
    let nine = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
    let sets: [&[f64]; 4] = [&[1.0], &[1.0, 3.0], &[1.0, 2.0, 5.0], &nine];
    let ticks = sets.map(of).into_iter().find(|ticks| ticks.len() > 2);
    (ticks.unwrap_or_else(|| even(&(10f64.powf(range.start)..10f64.powf(range.end)))), of(&nine))
}

fn plot(title: String, [x, y]: [(&str, bool); 2], series: &[Series]) -> Result<Plot, ReportError> {
    let points = || series.iter().flat_map(|s| s.points.iter());
    let x = Axis::new(x, points().map(|p| p.0));
    let y = Axis::new(y, points().map(|p| p.1));
    let mut svg = String::new();
    let drawn = draw(&mut svg, &x, &y, series);
    drawn.map_err(|e| ReportError::Plot { what: title.clone(), reason: e.to_string() })?;
    // Black on white is white on black in a dark window.
    let svg = svg.replace("#000000", "currentColor");
    Ok(Plot { title, svg, legend: legend(series) })
}

fn legend(series: &[Series]) -> Vec<Key> {
    let key = |mark, i: usize, text: &str| {
        let RGBColor(r, g, b) = COLOURS[i % COLOURS.len()];
        let colour = if (r, g, b) == (0, 0, 0) { "currentColor".to_owned() } else { format!("rgb({r} {g} {b})") };
        Key { mark, colour, text: text.to_owned() }
    };
    let named = series.iter().enumerate().filter(|(_, s)| !s.name.is_empty());
    let lines = named.map(|(i, s)| key(MARKS[i % MARKS.len()], i, &s.name));
    lines.chain(series.iter().filter_map(|s| Some(key('◯', RING, &s.marked.as_ref()?.1)))).collect()
}

/// Place among the colours of the ring around a marked point.
const RING: usize = 3;

fn draw(svg: &mut String, x: &Axis, y: &Axis, series: &[Series]) -> Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    let mut builder = ChartBuilder::on(&area);
    builder.margin(6).margin_right(14).x_label_area_size(40).y_label_area_size(66);
    let mut chart = builder.build_cartesian_2d(x.clone(), y.clone())?;
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(&x.name).y_desc(&y.name);
    mesh.label_style(("sans-serif", 13)).axis_desc_style(("sans-serif", 14));
    mesh.light_line_style(BLACK.mix(0.07)).bold_line_style(BLACK.mix(0.18)).draw()?;
    for (i, line) in series.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        let held = |p: &(f64, f64)| x.holds(p.0) && y.holds(p.1);
        let seen: Vec<(f64, f64)> = line.points.iter().copied().filter(held).collect();
        if let Some((slope, intercept)) = line.law {
            let ends = [seen.first(), seen.last()].into_iter().flatten();
            let ends = ends.map(|p| (p.0, (intercept + slope * p.0.ln()).exp()));
            chart.draw_series(LineSeries::new(ends, colour.mix(0.6)))?;
        } else {
            chart.draw_series(LineSeries::new(seen.iter().copied(), colour))?;
        }
        match i % MARKS.len() {
            0 => chart.draw_series(seen.iter().map(|&p| Circle::new(p, 4, colour.filled())))?,
            1 => chart.draw_series(seen.iter().map(|&p| TriangleMarker::new(p, 6, colour.filled())))?,
            _ => chart.draw_series(seen.iter().map(|&p| Cross::new(p, 4, colour.stroke_width(2))))?,
        };
        if let Some(&best) = line.marked.as_ref().and_then(|(best, _)| line.points.get(*best)).filter(|p| held(p)) {
            chart.draw_series([Circle::new(best, 8, COLOURS[RING].stroke_width(2))])?;
        }
    }
    area.present()?;
    Ok(())
}

/// Three digits, powers of ten where they are shorter.
fn short(v: f64) -> String {
    match v.abs() {
        a if a == 0.0 || (1e-3..1e5).contains(&a) => {
            let digits = (2 - a.max(1e-3).log10().floor() as i32).max(0) as usize;
            let text = format!("{v:.digits$}");
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
        }
        _ => format!("{v:.1e}").replace(".0e", "e"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let numbers = [(0.0, "0"), (0.0421, "0.0421"), (70.0, "70"), (333.4, "333"), (1e5, "1e5"), (2.1e-4, "2.1e-4")];
        for (v, text) in numbers {
            assert_eq!(short(v), text);
        }
    }

    #[test]
    fn every_axis_has_ticks() {
        for values in [[0.002, 30.0], [0.04, 0.1], [7.1, 7.3], [5.0, 5.0]] {
            for logarithmic in [true, false] {
                let axis = Axis::new(("x", logarithmic), values.into_iter());
                let inside = axis.ticks.iter().all(|tick| axis.range.contains(tick));
                assert!(inside && (3..9).contains(&axis.ticks.len()), "{values:?}: {:?}", axis.ticks);
            }
        }
        assert_eq!(Axis::new(("x", true), [0.002, 30.0].into_iter()).ticks.len(), 4);
        let ticks = Axis::new(("x", true), [0.02, 0.3].into_iter()).ticks;
        assert_eq!(ticks.iter().map(|&v| short(v)).collect::<Vec<_>>(), ["0.03", "0.1", "0.3"]);
    }

    #[test]
    fn a_plot_of_nothing_is_still_a_plot() {
        let none = Series { marked: Some((3, String::new())), ..Series::default() };
        assert!(plot("nothing".to_owned(), [("x", true); 2], &[none]).expect("a plot").svg.starts_with("<svg"));
    }
}
