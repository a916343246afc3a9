//! `pdembree compare A.exr B.exr`

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::str::FromStr;

use pdembree::film::Image;
use pdembree::output::exr;
use pdembree::study::{Comparison, Options, SsimDomain, compare};

use super::console::{print, print_json};
use super::failure::{Failure, code};
use super::number::finite;

/// Compare a picture with its reference: RMSE, relMSE, SSIM, FLIP
///
/// Like cmp, it exits with 0 if the pictures are the same, 1 if they differ, 2 if they cannot be compared (a missing
/// file, other sizes, NaN). With --fail they count as the same while every given bound holds.
#[derive(clap::Args)]
pub struct Args {
    /// The picture that is judged (EXR)
    picture: PathBuf,
    /// The reference (EXR)
    reference: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Bound that must hold: mae, rmse, rmse_shown, rel_mse, rel_mse_trimmed, max_error, bias (its size), flip and flip_hdr at most, ssim at least
    #[arg(long, value_name = "METRIC=BOUND")]
    fail: Vec<Bound>,
    /// Compare this layer, for example `caustic` [default: the beauty, R G B]
    #[arg(long, default_value = "", hide_default_value = true)]
    layer: String,
    /// Multiply both pictures by 2^STOPS for rmse_shown, SSIM and FLIP
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = finite, allow_negative_numbers = true)]
    exposure: f64,
    /// Values that SSIM sees, clamped to [0, 1]: sRGB-encoded or linear
    #[arg(long, value_name = "DOMAIN", default_value = "srgb", value_parser = ["srgb", "linear"])]
    ssim_on: String,
}

#[derive(Clone, Copy, Debug)]
enum Metric {
    Mae,
    Rmse,
    RmseShown,
    RelMse,
    RelMseTrimmed,
    MaxError,
    Bias,
    Ssim,
    Flip,
    FlipHdr,
}

const METRICS: [(&str, Metric); 10] = [
    ("mae", Metric::Mae),
    ("rmse", Metric::Rmse),
    ("rmse_shown", Metric::RmseShown),
    ("rel_mse", Metric::RelMse),
    ("rel_mse_trimmed", Metric::RelMseTrimmed),
    ("max_error", Metric::MaxError),
    ("bias", Metric::Bias),
    ("ssim", Metric::Ssim),
    ("flip", Metric::Flip),
    ("flip_hdr", Metric::FlipHdr),
];

#[derive(Clone, Copy, Debug)]
struct Bound {
    metric: Metric,
    bound: f64,
}

impl FromStr for Bound {
    type Err = String;
    fn from_str(text: &str) -> Result<Bound, String> {
        let known = || METRICS.map(|(name, _)| name).join(", ");
        let (name, bound) = text.split_once('=').ok_or("write METRIC=BOUND, as rmse=0.01")?;
        let metric = METRICS.iter().find(|(n, _)| *n == name).ok_or_else(|| format!("the metrics are {}", known()))?.1;
        Ok(Bound { metric, bound: finite(bound)? })
    }
}

impl Bound {
    /// A metric that does not exist for these pictures holds no bound.
    fn holds(self, found: &Comparison) -> bool {
        match self.metric {
            Metric::Mae => found.mae <= self.bound,
            Metric::Rmse => found.rmse <= self.bound,
            Metric::RmseShown => found.rmse_shown <= self.bound,
            Metric::RelMse => found.rel_mse <= self.bound,
            Metric::RelMseTrimmed => found.rel_mse_trimmed <= self.bound,
            Metric::MaxError => found.max_error <= self.bound,
            Metric::Bias => found.bias.abs() <= self.bound,
            Metric::Ssim => found.ssim.is_some_and(|ssim| ssim >= self.bound),
            Metric::Flip => found.flip.is_some_and(|flip| flip <= self.bound),
            Metric::FlipHdr => found.flip_hdr.is_some_and(|flip| flip <= self.bound),
        }
    }
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let (picture, reference) = (read(&args.picture)?, read(&args.reference)?);
    let options = Options {
        layer: args.layer.clone(),
        exposure: args.exposure,
        ssim_domain: if args.ssim_on == "linear" { SsimDomain::Linear } else { SsimDomain::Srgb },
        no_flip: false,
    };
    let found = compare(&picture, &reference, &options).map_err(|error| {
        let names = format!("{} and {}", args.picture.display(), args.reference.display());
        Failure::new(code::USAGE, format!("{names}: {error}"))
    })?;
    if args.json {
        print_json(&found)?
    } else {
        print(&table(&found))?
    }
    let same = match args.fail.as_slice() {
        [] => found.max_error == 0.0,
        bounds => bounds.iter().all(|bound| bound.holds(&found)),
    };
    Ok(if same { ExitCode::SUCCESS } else { ExitCode::from(code::FAILED) })
}

/// As with cmp, every trouble is 2.
fn read(path: &Path) -> Result<Image, Failure> {
    exr::read_file(path).map(|file| file.image).map_err(|error| Failure::new(code::USAGE, error.to_string()))
}

fn table(found: &Comparison) -> String {
    let [x, y] = found.max_error_at;
    let [r, g, b] = found.bias_rgb;
    let ssim = found.ssim.map_or_else(|| "none: smaller than its window of 11 x 11".to_owned(), |v| format!("{v:.6}"));
    let [flip, flip_hdr] = [found.flip, found.flip_hdr]
        .map(|v| v.map_or_else(|| "none: this binary was built without it".to_owned(), |v| format!("{v:.6}")));
    let lines = [
        ("size", format!("{} x {}", found.width, found.height)),
        ("mae", format!("{:.6e}", found.mae)),
        ("rmse", format!("{:.6e}", found.rmse)),
        ("rmse_shown", format!("{:.6e}", found.rmse_shown)),
        ("rel_mse", format!("{:.6e}", found.rel_mse)),
        ("rel_mse_trimmed", format!("{:.6e}", found.rel_mse_trimmed)),
        ("max_error", format!("{:.6e} in pixel ({x}, {y})", found.max_error)),
        ("bias", format!("{:.6e} (R {r:.3e}, G {g:.3e}, B {b:.3e})", found.bias)),
        ("ssim", ssim),
        ("flip", flip),
        ("flip_hdr", flip_hdr),
    ];
    lines.map(|(name, value)| format!("{name:<16}{value}\n")).concat()
}
