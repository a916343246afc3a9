//! Numbers as one types them.

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
        assert!(small_count("5G").is_err());
        assert!(finite("1e400").is_err() && finite("nan").is_err() && finite("-2.5") == Ok(-2.5));
    }
}
