//! Numbers as one types them.

use std::time::Duration;

/// A finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{text}` is no number")),
    }
}

/// A count of at least 1, with a suffix K, M or G for thousands, millions or milliards: `200000`, `200K`, `1.5M`.
pub fn count(text: &str) -> Result<u64, String> {
    let wrong = || format!("`{text}` is no count; write 200000, 200K, 2M or 1G");
    let split = text.len() - usize::from(text.ends_with(|c: char| c.is_ascii_alphabetic()));
    let (digits, suffix) = text.split_at(split);
    let (unit, places) = match suffix {
        "" => (1, 0),
        "k" | "K" => (1_000, 3),
        "m" | "M" => (1_000_000, 6),
        "g" | "G" => (1_000_000_000, 9),
        _ => return Err(wrong()),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let all_digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
    if whole.is_empty() || fraction.len() > places || !all_digits(whole) || !all_digits(fraction) {
        return Err(wrong());
    }
    let below = format!("{fraction:0<places$}").parse::<u64>().unwrap_or(0);
    match whole.parse::<u64>().ok().and_then(|n| n.checked_mul(unit)?.checked_add(below)) {
        Some(0) => Err("0 is too few".to_owned()),
        Some(count) => Ok(count),
        None => Err(format!("`{text}` is too many")),
    }
}

/// A count from 1 to 2³² − 1, with the suffixes of [`count`].
pub fn small_count(text: &str) -> Result<u32, String> {
    u32::try_from(count(text)?).map_err(|_| format!("`{text}` is too many"))
}

/// A number above 0 and below 1.
pub fn fraction(text: &str) -> Result<f64, String> {
    match finite(text)? {
        x if x > 0.0 && x < 1.0 => Ok(x),
        _ => Err("write a number between 0 and 1, for example 0.02".to_owned()),
    }
}

/// Bytes, with a suffix K, M, G or T (KiB and so on are understood too): `2G`, `512MiB`, `100000`.
pub fn bytes(text: &str) -> Result<u64, String> {
    let wrong = || format!("`{text}` is no size; write 512M, 2G or a number of bytes");
    let digits = text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.').len();
    let (number, suffix) = text.split_at(digits);
    let power = match suffix.to_ascii_lowercase().trim_end_matches('b').trim_end_matches('i') {
        "" => 0,
        "k" => 1,
        "m" => 2,
        "g" => 3,
        "t" => 4,
        _ => return Err(wrong()),
    };
    let value = finite(number).map_err(|_| wrong())? * 1024f64.powi(power);
    if value < 1.0 || value > u64::MAX as f64 { Err(wrong()) } else { Ok(value as u64) }
}

/// A length of time above 0: `90`, `90s`, `10m`, `1.5h`.
pub fn length_of_time(text: &str) -> Result<Duration, String> {
    let wrong = || format!("`{text}` is no length of time; write 90s, 10m or 1.5h");
    let unit = match text.chars().last() {
        Some('s') => 1.0,
        Some('m') => 60.0,
        Some('h') => 3600.0,
        Some(c) if c.is_ascii_digit() => 1.0,
        _ => return Err(wrong()),
    };
    let number = text.trim_end_matches(['s', 'm', 'h']);
    if number.len() + 1 < text.len() {
        return Err(wrong());
    }
    let seconds = finite(number).map_err(|_| wrong())? * unit;
    match Duration::try_from_secs_f64(seconds) {
        Ok(time) if !time.is_zero() && seconds < 1e9 => Ok(time),
        _ => Err(wrong()),
    }
}

/// `A..B`, A below B.
pub fn range(text: &str) -> Result<(u32, u32), String> {
    let wrong = || format!("`{text}` is no range of passes; write 0..4 for the passes 0, 1, 2 and 3");
    let (first, end) = text.split_once("..").ok_or_else(wrong)?;
    match (first.parse(), end.parse()) {
        (Ok(first), Ok(end)) if first < end => Ok((first, end)),
        _ => Err(wrong()),
    }
}

/// `J/M`, J below M.
pub fn tile(text: &str) -> Result<(u32, u32), String> {
    let wrong = || format!("`{text}` is no tile; write 0/4 to 3/4 for the four quarters");
    let (j, m) = text.split_once('/').ok_or_else(wrong)?;
    match (j.parse(), m.parse()) {
        (Ok(j), Ok(m)) if j < m => Ok((j, m)),
        _ => Err(wrong()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_take_suffixes_and_refuse_everything_else() {
        let good = [("1", 1), ("200K", 200_000), ("1.5M", 1_500_000), ("2g", 2_000_000_000), ("0.001k", 1)];
        for (text, value) in good {
            assert_eq!(count(text), Ok(value), "{text}");
        }
        for text in ["", "0", "-1", "K", "1.5", "1e6", "2T", "0.0001K", "1_000", "99999999999G", " 1", "٣", "１K"] {
            assert!(count(text).is_err(), "{text}");
        }
        assert_eq!(length_of_time("1.5h"), Ok(Duration::from_secs(5400)));
        assert_eq!(length_of_time("10m"), Ok(Duration::from_secs(600)));
        assert_eq!(length_of_time("0.5"), Ok(Duration::from_millis(500)));
        for text in ["", "s", "-1s", "0", "1d", "10 m", "1ms", "1e300h", "nan"] {
            assert!(length_of_time(text).is_err(), "{text}");
        }
        assert_eq!((bytes("2G"), bytes("1.5KiB"), bytes("7")), (Ok(2 << 30), Ok(1536), Ok(7)));
        for text in ["", "G", "0", "-1G", "2X", "1e3", "nan"] {
            assert!(bytes(text).is_err(), "{text}");
        }
        assert_eq!((range("0..4"), tile("3/4")), (Ok((0, 4)), Ok((3, 4))));
        for text in ["", "..", "4..4", "1..", "5..4", "-1..2", "1...3"] {
            assert!(range(text).is_err(), "{text}");
        }
        for text in ["", "4/4", "1/0", "a/b", "-1/2"] {
            assert!(tile(text).is_err(), "{text}");
        }
        assert!(fraction("0.02").is_ok() && fraction("1").is_err() && fraction("0").is_err());
        assert!(small_count("5G").is_err());
        assert!(finite("1e400").is_err() && finite("nan").is_err() && finite("-2.5") == Ok(-2.5));
    }
}
