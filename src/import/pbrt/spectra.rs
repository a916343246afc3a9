//! Colours of pbrt as linear Rec.709 triples: RGB, black bodies, spectra that are named or written out.
//!
//! Wavelengths in nm. Tristimulus values by the fits of `[Wyman13]`, whose error is below 2 % of the curves' peaks; to Rec.709
//! by the matrix of `[IEC61966]`.

use std::path::Path;

use super::parameters::{Parameter, Values, number, shortened};
use crate::import::read_text;
use crate::scene::error::{Problem, Source};
use crate::scene::metal::Metal;
use crate::scene::spelling::nearest;

/// Bytes of a file with a spectrum.
const MAX_FILE: u64 = 1 << 20;
/// The sodium line for which indices of glass are given.
const SODIUM: f64 = 587.56;
/// What lights a surface whose reflectance is a spectrum, K: the colour temperature of D65.
const DAYLIGHT: f64 = 6504.0;
/// Visible light.
const BAND: std::ops::Range<u32> = 380..780;

/// Pairs of wavelength and value, wavelengths rising.
pub(super) type Pairs = Vec<[f64; 2]>;

/// What a parameter says.
enum Spectrum {
    Rgb([f64; 3]),
    /// K.
    BlackBody(f64),
    Pairs(Pairs),
    Named(String),
}

fn read(parameter: &Parameter, folder: &Path) -> Result<Spectrum, Problem> {
    match (parameter.kind, &parameter.values) {
        ("rgb", _) => match parameter.tuples::<3>(&["rgb"])? {
            [rgb] if rgb.iter().all(|c| *c >= 0.0) => Ok(Spectrum::Rgb(*rgb)),
            [rgb] => Err(parameter.problem(format!("`{}` is {rgb:?}", parameter.name), "no part may be below 0")),
            _ => Err(parameter.problem(format!("`{}` is no colour", parameter.name), "give three numbers")),
        },
        ("blackbody", _) => match parameter.number(&["blackbody"])? {
            kelvin if (100.0..=1e6).contains(&kelvin) => Ok(Spectrum::BlackBody(kelvin)),
            kelvin => Err(parameter.problem(format!("a black body of {kelvin} K"), "give 100 to 1000000 K")),
        },
        ("spectrum", Values::Texts(names)) => match &names[..] {
            [name] if is_file(name) => read_file(&folder.join(name)).map(Spectrum::Pairs),
            [name] => Ok(Spectrum::Named(name.clone())),
            _ => Err(parameter.problem(format!("`{}` is no spectrum", parameter.name), "give one name")),
        },
        ("spectrum", _) => {
            let pairs = parameter.tuples::<2>(&["spectrum"])?.to_vec();
            sound(pairs).map_err(|what| parameter.problem(format!("`{}` {what}", parameter.name), PAIRS))
        }
        (kind, _) => {
            let message = format!("`{}` is of type {kind}, which is no colour", parameter.name);
            Err(parameter.problem(message, "write \"rgb\", \"spectrum\" or \"blackbody\" before its name"))
        }
    }
}

const PAIRS: &str = "give wavelengths in nm, each with its value and larger than the one before";

fn sound(pairs: Pairs) -> Result<Spectrum, &'static str> {
    if pairs.is_empty() || pairs.iter().any(|[wavelength, value]| *wavelength <= 0.0 || *value < 0.0) {
        return Err("is empty or has a number below 0");
    }
    if !pairs.is_sorted_by(|a, b| a[0] < b[0]) {
        return Err("has wavelengths that do not rise");
    }
    Ok(Spectrum::Pairs(pairs))
}

/// Names of spectra have no dot.
fn is_file(name: &str) -> bool {
    name.contains('.')
}

/// A file of wavelengths and values.
fn read_file(path: &Path) -> Result<Pairs, Problem> {
    let text = read_text(path, MAX_FILE)?;
    let source = Source::file(path);
    let mut numbers = Vec::new();
    for (line, content) in (1..).zip(text.lines()) {
        let content = content.split('#').next().unwrap_or("");
        for word in content.split_whitespace() {
            numbers.push(number(word, &source.at_line(line))?);
        }
    }
    let (pairs, rest) = numbers.as_chunks::<2>();
    let refuse = |what| Problem::new(format!("the spectrum {what}")).help(PAIRS).at(&source);
    if !rest.is_empty() {
        return Err(refuse("has a wavelength without a value"));
    }
    match sound(pairs.to_vec()).map_err(refuse)? {
        Spectrum::Pairs(pairs) => Ok(pairs),
        _ => Err(refuse("is none")),
    }
}

/// The share of light that a surface reflects: a spectrum as it looks in daylight.
pub(super) fn reflectance(parameter: &Parameter, folder: &Path) -> Result<[f64; 3], Problem> {
    let shares = match read(parameter, folder)? {
        Spectrum::Rgb(rgb) => rgb,
        Spectrum::Pairs(pairs) => {
            let white = rgb_of(|w| planck(w, DAYLIGHT));
            let seen = rgb_of(|w| planck(w, DAYLIGHT) * at(&pairs, w));
            std::array::from_fn(|c| (seen[c] / white[c]).max(0.0))
        }
        Spectrum::BlackBody(_) => {
            let message = format!("`{}` is a black body, which only lights are", parameter.name);
            return Err(parameter.problem(message, "give \"rgb\" or \"spectrum\""));
        }
        Spectrum::Named(name) => return Err(unnamed(parameter, &name, &[])),
    };
    if shares.iter().any(|c| *c > 1.0 + 1e-9) {
        let message = format!("`{}` reflects {shares:?} of the light", parameter.name);
        return Err(parameter.problem(message, "no share may be above 1"));
    }
    Ok(shares.map(|c| c.min(1.0)))
}

/// The colour of a light. RGB is taken as it is; of everything else pbrt only takes the colour and sets the luminance to 1.
pub(super) fn light(parameter: &Parameter, folder: &Path) -> Result<[f64; 3], Problem> {
    const NAMES: [(&str, [f64; 2]); 4] = [
        // Chromaticities of the CIE's illuminants and of the ACES white.
        ("stdillum-A", [0.44758, 0.40745]),
        ("stdillum-D50", [0.34567, 0.35850]),
        ("stdillum-D65", [0.31271, 0.32902]),
        ("illum-acesD60", [0.32168, 0.33767]),
    ];
    let rgb = match read(parameter, folder)? {
        Spectrum::Rgb(rgb) => return Ok(rgb),
        Spectrum::BlackBody(kelvin) => black_body(kelvin),
        Spectrum::Pairs(pairs) => with_unit_luminance(xyz_of(|w| at(&pairs, w))),
        Spectrum::Named(name) => match NAMES.iter().find(|(known, _)| *known == name) {
            Some((_, [x, y])) => with_unit_luminance([*x, *y, 1.0 - x - y]),
            None => return Err(unnamed(parameter, &name, &NAMES.map(|(name, _)| name))),
        },
    };
    rgb.ok_or_else(|| parameter.problem(format!("`{}` has no visible light", parameter.name), "is it all 0?"))
}

/// A medium's coefficient: RGB is taken as it is, of pairs the means over the thirds of the visible band.
pub(super) fn coefficient(parameter: &Parameter, folder: &Path) -> Result<[f64; 3], Problem> {
    if parameter.kind == "rgb" { light(parameter, folder) } else { metal_index(parameter, folder) }
}

/// η or k of a metal in each third of the visible band, as `scene::metal` takes them.
pub(super) fn metal_index(parameter: &Parameter, folder: &Path) -> Result<[f64; 3], Problem> {
    const NAMES: [(&str, Metal, bool); 8] = [
        ("metal-Ag-eta", Metal::Silver, true),
        ("metal-Ag-k", Metal::Silver, false),
        ("metal-Al-eta", Metal::Aluminium, true),
        ("metal-Al-k", Metal::Aluminium, false),
        ("metal-Au-eta", Metal::Gold, true),
        ("metal-Au-k", Metal::Gold, false),
        ("metal-Cu-eta", Metal::Copper, true),
        ("metal-Cu-k", Metal::Copper, false),
    ];
    match read(parameter, folder)? {
        Spectrum::Rgb(rgb) => Ok(rgb),
        Spectrum::Pairs(pairs) => Ok([600, 500, 400].map(|first| mean(&pairs, first))),
        Spectrum::BlackBody(_) => Err(parameter.problem("a metal's index is no black body", "give \"spectrum\"")),
        Spectrum::Named(name) => match NAMES.iter().find(|(known, ..)| *known == name) {
            Some((_, metal, true)) => Ok(metal.index().eta),
            Some((_, metal, false)) => Ok(metal.index().k),
            None => Err(unnamed(parameter, &name, &NAMES.map(|(name, ..)| name))),
        },
    }
}

/// The index of a glass at the sodium line, and whether it changes with the wavelength.
pub(super) fn glass_index(parameter: &Parameter, folder: &Path) -> Result<(f64, bool), Problem> {
    // n_d of Schott's catalogue.
    const NAMES: [(&str, f64); 7] = [
        ("glass-BK7", 1.5168),
        ("glass-BAF10", 1.6700),
        ("glass-FK51A", 1.4866),
        ("glass-LASF9", 1.8503),
        ("glass-F5", 1.6727),
        ("glass-F10", 1.7283),
        ("glass-F11", 1.7847),
    ];
    if parameter.kind == "float" {
        return Ok((parameter.number(&["float"])?, false));
    }
    match read(parameter, folder)? {
        Spectrum::Pairs(pairs) => Ok((at(&pairs, SODIUM), pairs.iter().any(|[_, n]| *n != pairs[0][1]))),
        Spectrum::Named(name) => match NAMES.iter().find(|(known, _)| *known == name) {
            Some((_, index)) => Ok((*index, true)),
            None => Err(unnamed(parameter, &name, &NAMES.map(|(name, _)| name))),
        },
        Spectrum::Rgb(_) | Spectrum::BlackBody(_) => {
            Err(parameter.problem("an index of refraction is no colour", "give \"float\" or \"spectrum\""))
        }
    }
}

fn unnamed(parameter: &Parameter, name: &str, known: &[&str]) -> Problem {
    let help = match nearest(name, known) {
        Some(near) => format!("did you mean \"{near}\"?"),
        None if known.is_empty() => "write it out as wavelengths and values, or as \"rgb\"".to_owned(),
        None => format!("known here are {}; others can be written out as wavelengths and values", known.join(", ")),
    };
    parameter.problem(format!("there is no spectrum \"{}\" for `{}`", shortened(name), parameter.name), help)
}

/// Straight lines between the pairs, constant beyond.
fn at(pairs: &[[f64; 2]], wavelength: f64) -> f64 {
    let after = pairs.partition_point(|[w, _]| *w <= wavelength);
    match (after.checked_sub(1).and_then(|i| pairs.get(i)), pairs.get(after)) {
        (Some([w0, v0]), Some([w1, v1])) => v0 + (v1 - v0) * (wavelength - w0) / (w1 - w0),
        (Some([_, v]), None) | (None, Some([_, v])) => *v,
        (None, None) => 0.0,
    }
}

/// Over 100 nm.
fn mean(pairs: &[[f64; 2]], first: u32) -> f64 {
    (first..first + 100).map(|w| at(pairs, f64::from(w) + 0.5)).sum::<f64>() / 100.0
}

/// Planck's law, in units of its own: colours are ratios.
fn planck(wavelength: f64, kelvin: f64) -> f64 {
    // hc/k in nm K; over the visible band nothing overflows from 100 K on.
    const SECOND_CONSTANT: f64 = 1.438_776_877e7;
    (555.0 / wavelength).powi(5) / (SECOND_CONSTANT / (wavelength * kelvin)).exp_m1()
}

/// A black body's colour with luminance 1.
fn black_body(kelvin: f64) -> Option<[f64; 3]> {
    with_unit_luminance(xyz_of(|w| planck(w, kelvin)))
}

/// Parts below 0, of colours outside the gamut, become 0.
fn with_unit_luminance(xyz: [f64; 3]) -> Option<[f64; 3]> {
    let [x, y, z] = xyz.map(|c| c / xyz[1]);
    let rgb = rec709([x, y, z]).map(|c| c.max(0.0));
    rgb.iter().all(|c| c.is_finite()).then_some(rgb)
}

fn rgb_of(spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
    rec709(xyz_of(spectrum))
}

fn xyz_of(spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
    let mut xyz = [0.0; 3];
    for w in BAND {
        let wavelength = f64::from(w) + 0.5;
        let (value, seen) = (spectrum(wavelength), matching(wavelength));
        xyz = std::array::from_fn(|c| xyz[c] + value * seen[c]);
    }
    xyz
}

/// x̄, ȳ, z̄ [Wyman13 table 1].
fn matching(wavelength: f64) -> [f64; 3] {
    let lobe = |height: f64, centre: f64, below: f64, above: f64| {
        let t = (wavelength - centre) / if wavelength < centre { below } else { above };
        height * (-0.5 * t * t).exp()
    };
    [
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    ]
}

fn rec709([x, y, z]: [f64; 3]) -> [f64; 3] {
    [3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z, 0.0557 * x - 0.2040 * y + 1.0570 * z]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chromaticities of black bodies, CIE 15: 2856 K (illuminant A) and 6504 K.
    #[test]
    fn black_bodies_have_the_published_chromaticities() {
        for (kelvin, [x, y]) in [(2856.0, [0.4476, 0.4074]), (6504.0, [0.3135, 0.3237])] {
            let xyz = xyz_of(|w| planck(w, kelvin));
            let sum: f64 = xyz.iter().sum();
            assert!((xyz[0] / sum - x).abs() < 0.004 && (xyz[1] / sum - y).abs() < 0.004, "{kelvin}: {xyz:?}");
        }
        let white = with_unit_luminance([0.31271, 0.32902, 0.35827]).expect("visible");
        assert!(white.iter().all(|c| (c - 1.0).abs() < 2e-3), "{white:?}");
    }

    #[test]
    fn spectra_are_straight_between_their_pairs() {
        let pairs = [[500.0, 1.0], [600.0, 3.0]];
        assert_eq!([400.0, 500.0, 550.0, 600.0, 700.0].map(|w| at(&pairs, w)), [1.0, 1.0, 2.0, 3.0, 3.0]);
        for (first, expected) in [(600, 3.0), (500, 2.0), (400, 1.0)] {
            assert!((mean(&pairs, first) - expected).abs() < 1e-14, "{first}");
        }
    }
}
