//! Grids of numbers: NumPy's `.npy` files and bare numbers, as simulations write densities.
//!
//! An array of shape (z, y, x) in C order has x change fastest, as here. The header of an `.npy` file is a Python literal of
//! known form (NEP 1). Sizes are checked against the file's length, so that nothing is allocated for numbers that are not
//! there.

use std::path::Path;

use super::read_bytes;
use crate::scene::error::{Problem, Source};

/// Bytes of a volume file.
const MAX_FILE: u64 = 8 << 30;

/// Samples on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Along x, y and z.
    pub counts: [usize; 3],
    /// Finite and ≥ 0; x changes fastest.
    pub samples: Vec<f32>,
}

/// How a number is stored, least significant byte first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberFormat {
    Unsigned8,
    Unsigned16,
    Single,
    Double,
}

impl NumberFormat {
    pub const NAMES: &'static [&'static str] = &["u8", "u16", "f32", "f64"];

    pub fn from_name(name: &str) -> Option<NumberFormat> {
        match name {
            "u8" => Some(NumberFormat::Unsigned8),
            "u16" => Some(NumberFormat::Unsigned16),
            "f32" => Some(NumberFormat::Single),
            "f64" => Some(NumberFormat::Double),
            _ => None,
        }
    }

    /// By NumPy's name.
    fn from_descr(descr: &str) -> Option<NumberFormat> {
        match descr {
            "|u1" => Some(NumberFormat::Unsigned8),
            "<u2" => Some(NumberFormat::Unsigned16),
            "<f4" => Some(NumberFormat::Single),
            "<f8" => Some(NumberFormat::Double),
            _ => None,
        }
    }

    fn size(self) -> usize {
        match self {
            NumberFormat::Unsigned8 => 1,
            NumberFormat::Unsigned16 => 2,
            NumberFormat::Single => 4,
            NumberFormat::Double => 8,
        }
    }

    fn decode(self, bytes: &[u8]) -> Vec<f32> {
        fn all<const N: usize>(bytes: &[u8], number: impl Fn([u8; N]) -> f32) -> Vec<f32> {
            bytes.as_chunks::<N>().0.iter().map(|b| number(*b)).collect()
        }
        match self {
            NumberFormat::Unsigned8 => bytes.iter().map(|&b| b.into()).collect(),
            NumberFormat::Unsigned16 => all(bytes, |b| u16::from_le_bytes(b).into()),
            NumberFormat::Single => all(bytes, f32::from_le_bytes),
            NumberFormat::Double => all(bytes, |b| f64::from_le_bytes(b) as f32),
        }
    }
}

/// Reads an `.npy` file, or with the `raw` counts and numbers a file of nothing but these.
///
/// # Errors
/// A file that cannot be read, is no such array, is too short or too long, or has a number that is negative or not finite.
pub fn read(path: &Path, raw: Option<([usize; 3], NumberFormat)>) -> Result<Volume, Problem> {
    let bytes = read_bytes(path, MAX_FILE)?;
    let read = match raw {
        Some((counts, format)) => from_raw(&bytes, counts, format),
        None => from_npy(&bytes),
    };
    read.map_err(|(what, help)| Problem::new(format!("`{}` {what}", path.display())).help(help).at(&Source::file(path)))
}

/// What is wrong, and what to do about it.
type Unusable = (String, &'static str);

const WRITE_NPY: &str = "write it by numpy.save of an array of float32 with the shape (z, y, x)";

/// The content of an `.npy` file.
///
/// # Errors
/// As [`read`]: what is wrong, and what to do about it.
pub fn from_npy(bytes: &[u8]) -> Result<Volume, Unusable> {
    let broken = || ("is no .npy file that can be read".to_owned(), WRITE_NPY);
    let after_magic = bytes.strip_prefix(b"\x93NUMPY").ok_or_else(broken)?;
    let (length, rest) = match after_magic {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        _ => return Err(broken()),
    };
    let (header, numbers) = rest.split_at_checked(length).ok_or_else(broken)?;
    let header = std::str::from_utf8(header).map_err(|_| broken())?;
    let descr = text_of(header, "descr").ok_or_else(broken)?;
    let Some(format) = NumberFormat::from_descr(descr) else {
        return Err((format!("holds numbers of the type `{descr}`"), "use float32, float64, uint8 or uint16"));
    };
    let counts = shape(header).ok_or_else(broken)?;
    if after(header, "fortran_order").ok_or_else(broken)?.starts_with("True") {
        // (x, y, z) with the first index fastest is the same as (z, y, x) with the last one.
        return from_raw(numbers, counts, format);
    }
    let [z, y, x] = counts;
    from_raw(numbers, [x, y, z], format)
}

/// What follows a key of the header's dictionary.
fn after<'h>(header: &'h str, key: &str) -> Option<&'h str> {
    let at = header.find(&format!("'{key}'"))? + key.len() + 2;
    Some(header[at..].trim_start().strip_prefix(':')?.trim_start())
}

fn text_of<'h>(header: &'h str, key: &str) -> Option<&'h str> {
    after(header, key)?.strip_prefix('\'')?.split('\'').next()
}

/// Three counts.
fn shape(header: &str) -> Option<[usize; 3]> {
    let inside = after(header, "shape")?.strip_prefix('(')?.split(')').next()?;
    let counts: Option<Vec<usize>> =
        inside.split(',').map(str::trim).filter(|n| !n.is_empty()).map(|n| n.parse().ok()).collect();
    counts?.try_into().ok()
}

/// Numbers and nothing else.
fn from_raw(bytes: &[u8], counts: [usize; 3], format: NumberFormat) -> Result<Volume, Unusable> {
    let [x, y, z] = counts;
    let wanted = x.checked_mul(y).and_then(|n| n.checked_mul(z)).and_then(|n| n.checked_mul(format.size()));
    if wanted != Some(bytes.len()) || bytes.is_empty() {
        let message = format!("has {} bytes of numbers, which are not those of {x} × {y} × {z} samples", bytes.len());
        return Err((message, "check the counts along x, y and z and the kind of numbers"));
    }
    let samples = format.decode(bytes);
    match samples.iter().position(|s| !(*s >= 0.0 && s.is_finite())) {
        Some(i) => {
            let cell = [i % x, i / x % y, i / (x * y)];
            Err((format!("has the density {} at cell {cell:?}", samples[i]), "densities are finite numbers ≥ 0"))
        }
        None => Ok(Volume { counts, samples }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(header: &str, numbers: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(numbers);
        bytes
    }

    #[test]
    fn arrays_are_read_in_every_order_and_kind_of_numbers() {
        let numbers: Vec<f32> = (0..6).map(|i| i as f32).collect();
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        // As numpy 1.24 writes it.
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 3), }          \n";
        let volume = Volume { counts: [3, 2, 1], samples: numbers };
        assert_eq!(from_npy(&npy(header, &bytes)), Ok(volume.clone()));
        let fortran = "{'descr': '<f4', 'fortran_order': True, 'shape': (3, 2, 1), }\n";
        assert_eq!(from_npy(&npy(fortran, &bytes)), Ok(volume.clone()));
        let small = "{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2, 3), }\n";
        assert_eq!(from_npy(&npy(small, &[0, 1, 2, 3, 4, 5])), Ok(volume.clone()));
        let double: Vec<u8> = volume.samples.iter().flat_map(|n| f64::from(*n).to_le_bytes()).collect();
        let header = header.replace("<f4", "<f8");
        assert_eq!(from_npy(&npy(&header, &double)), Ok(volume));
    }

    #[test]
    fn what_is_no_such_array_is_refused() {
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 1, 2), }\n";
        let numbers = |a: f32, b: f32| [a, b].map(f32::to_le_bytes).concat();
        let refused = |bytes: &[u8]| from_npy(bytes).expect_err("refused").0;
        assert!(refused(&npy(header, &numbers(1.0, -1.0))).contains("the density -1 at cell [1, 0, 0]"));
        assert!(refused(&npy(header, &numbers(f32::NAN, 1.0))).contains("NaN"));
        assert!(refused(&npy(header, &[0; 7])).contains("7 bytes"));
        assert!(refused(&npy(&header.replace("<f4", "<c8"), &[0; 8])).contains("`<c8`"));
        let huge = header.replace("(1, 1, 2)", "(99999999999, 99999999999, 99999999999)");
        assert!(refused(&npy(&huge, &[0; 8])).contains("8 bytes"));
        for bytes in [&b""[..], b"\x93NUMPY", b"\x93NUMPY\x01\x00\xff\xff{", b"P5 3 3"] {
            assert!(refused(bytes).contains("no .npy file"));
        }
        for shape in ["(2,)", "(1, 2)", "(-1, 1, 2)", "1"] {
            assert!(refused(&npy(&header.replace("(1, 1, 2)", shape), &[0; 8])).contains("no .npy file"), "{shape}");
        }
    }
}
