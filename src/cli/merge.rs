//! `pdembree merge PART... -o out.exr`

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use pdembree::output::{BirthCertificate, exr, part};
use pdembree::render::progress::Silent;
use pdembree::render::store::{self, Merged};

use super::certificate::{Circumstances, certificate};
use super::console::{Verbosity, note};
use super::failure::Failure;
use super::outputs::{OutputArgs, Outputs, rescued};

/// Put the parts of a render together
///
/// The parts are what `render --pass-range`, `render --tile` or `render --checkpoint` left, in any order. Sums are exact,
/// so the picture is the one that a single machine would have rendered, bit for bit. Parts that do not belong together,
/// overlap, or are not the whole are refused. Nothing is done if the picture of these very parts is there already.
#[derive(clap::Args)]
pub struct Args {
    /// Parts (.pdpart)
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Make a picture of what there is, though passes or tiles are missing
    #[arg(long)]
    partial: bool,
    #[command(flatten)]
    output: OutputArgs,
}

pub fn run(args: &Args, verbosity: Verbosity) -> Result<ExitCode, Failure> {
    let start = Instant::now();
    Outputs::check_names(&args.output)?;
    let outputs = Outputs::check(&args.output, false)?;
    let path = &args.output.output;
    let parts = digest_of(&args.parts);
    if outputs.exist() && is_of(path, &parts) {
        note(verbosity, "done", &format!("{} was there already", path.display()));
        return Ok(ExitCode::SUCCESS);
    }
    let Merged { info, state, missing } = store::merge(&args.parts, args.partial)?;
    let (picture, told) = args.output.finished(state.film.resolve());
    let warnings: Vec<String> = missing.into_iter().chain(told).collect();
    warnings.iter().for_each(|warning| note(verbosity, "warning", warning));
    let seconds = start.elapsed().as_secs_f64();
    let circumstances = Circumstances { threads: 1, seconds, phases: Vec::new(), warnings, textures: None };
    let certificate = BirthCertificate { parts: Some(parts), ..certificate(&info, &state, &picture, circumstances) };
    outputs.write(&info, &state, &picture, &certificate, &Silent).map_err(|error| rescued(error, &info, &state))?;
    let passes = state.film.passes();
    note(verbosity, "done", &format!("{} of {} parts, {passes} passes", path.display(), args.parts.len()));
    Ok(ExitCode::SUCCESS)
}

/// A digest of the parts, whatever their order and names.
fn digest_of(parts: &[PathBuf]) -> String {
    let mut digests: Vec<Option<[u8; 32]>> = parts.iter().map(|path| part::digest(path)).collect();
    digests.sort_unstable();
    let bytes: Vec<u8> = digests.into_iter().flat_map(Option::unwrap_or_default).collect();
    blake3::hash(&bytes).to_hex().to_string()
}

/// Whether `picture` is whole and was made of these parts.
fn is_of(picture: &Path, parts: &str) -> bool {
    let known = || {
        let text = std::fs::read(BirthCertificate::path_beside(picture)).ok()?;
        let certificate: serde_json::Value = serde_json::from_slice(&text).ok()?;
        Some(certificate.get("parts")?.as_str()? == parts)
    };
    let readable = picture.extension().is_none_or(|ending| ending != "exr") || exr::read_file(picture).is_ok();
    known().unwrap_or(false) && readable
}
