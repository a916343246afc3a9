//! One line a render: every row of every experiment with each of its seeds.

use crate::study::results::{ExperimentResult, Results, Row};

const HEAD: &str = "experiment,scene,method,photons,passes,parameter,bandwidth,chosen_for,seed,seconds,\
                    rmse,rmse_linear,rel_mse,mae,ssim,flip,flip_hdr\n";

pub(super) fn table(results: &Results) -> String {
    let of = |experiment: &ExperimentResult| -> String {
        experiment.rows.iter().map(|row| lines(&experiment.name, row)).collect()
    };
    HEAD.to_owned() + &results.experiments.iter().map(of).collect::<String>()
}

fn lines(experiment: &str, row: &Row) -> String {
    let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
    let (parameter, bandwidth) = match &row.bandwidth {
        Some(bandwidth) => (bandwidth.name.as_str(), bandwidth.value.to_string()),
        None => ("", String::new()),
    };
    let photons = row.photons.map_or_else(String::new, |n| n.to_string());
    let line = |cell: &crate::study::results::Cell| {
        let m = &cell.metrics;
        let fields = [
            quoted(experiment),
            quoted(&row.scene),
            quoted(&row.method),
            photons.clone(),
            cell.passes.to_string(),
            parameter.to_owned(),
            bandwidth.clone(),
            quoted(&row.chosen_for),
            cell.seed.to_string(),
            cell.seconds.to_string(),
            m.rmse.to_string(),
            m.rmse_linear.to_string(),
            m.rel_mse.to_string(),
            m.mae.to_string(),
            number(m.ssim),
            number(m.flip),
            number(m.flip_hdr),
        ];
        fields.join(",") + "\n"
    };
    row.cells.iter().map(line).collect()
}

/// A text as RFC 4180 has it.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}
