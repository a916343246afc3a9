//! Kinds of values: what a key expects, and the conversion of a TOML value to it.

use std::ops::Range;

use toml::Spanned;
use toml::de::DeValue;

use crate::scene::spelling::nearest;

/// Why a value is not of its kind: what was found there.
pub(crate) struct Mismatch {
    pub found: String,
    pub span: Range<usize>,
}

impl Mismatch {
    fn of(value: &Spanned<DeValue<'_>>) -> Mismatch {
        Mismatch { found: found(value.get_ref()), span: value.span() }
    }
}

/// A kind of value.
pub(crate) trait Convert {
    type Output;
    /// Completes "must be …".
    fn expects(&self) -> String;
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<Self::Output, Mismatch>;
    /// What to do about a value that is not of this kind, where `expects` does not say it.
    fn help(&self) -> Option<String> {
        None
    }
}

/// A value as messages show it.
pub(crate) fn found(value: &DeValue<'_>) -> String {
    const SHOWN: usize = 40;
    match value {
        DeValue::String(s) if s.chars().count() > SHOWN => {
            format!("the text \"{}…\"", s.chars().take(SHOWN).collect::<String>())
        }
        DeValue::String(s) => format!("the text \"{s}\""),
        DeValue::Integer(i) => i.to_string(),
        DeValue::Float(f) => f.as_str().to_owned(),
        DeValue::Boolean(b) => b.to_string(),
        DeValue::Datetime(d) => format!("the date {d}"),
        DeValue::Array(a) => match a.len() {
            1 => "an array of 1 value".to_owned(),
            n => format!("an array of {n} values"),
        },
        DeValue::Table(_) => "a table".to_owned(),
    }
}

/// A finite number within bounds.
#[derive(Clone, Copy)]
pub(crate) struct Number {
    /// Lower bound and whether it is itself allowed.
    min: (f64, bool),
    max: (f64, bool),
}

pub(crate) const ANY: Number = Number { min: (f64::NEG_INFINITY, false), max: (f64::INFINITY, false) };
pub(crate) const POSITIVE: Number = Number { min: (0.0, false), ..ANY };
pub(crate) const NON_NEGATIVE: Number = Number { min: (0.0, true), ..ANY };
pub(crate) const FRACTION: Number = Number { min: (0.0, true), max: (1.0, true) };

impl Number {
    /// min < x < max
    pub const fn between(min: f64, max: f64) -> Number {
        Number { min: (min, false), max: (max, false) }
    }
    /// min < x ≤ max
    pub const fn above_up_to(min: f64, max: f64) -> Number {
        Number { min: (min, false), max: (max, true) }
    }
    /// min ≤ x ≤ max
    pub const fn from_up_to(min: f64, max: f64) -> Number {
        Number { min: (min, true), max: (max, true) }
    }
    fn bounds(&self) -> String {
        let sign = |equal| if equal { "≥" } else { ">" };
        match (self.min, self.max) {
            ((f64::NEG_INFINITY, _), (f64::INFINITY, _)) => String::new(),
            ((min, equal), (f64::INFINITY, _)) => format!(" {} {min}", sign(equal)),
            ((f64::NEG_INFINITY, _), (max, _)) => format!(" up to {max}"),
            ((min, true), (max, true)) => format!(" from {min} to {max}"),
            ((min, equal), (max, max_equal)) => {
                format!(" {} {min} and {} {max}", sign(equal), if max_equal { "≤" } else { "<" })
            }
        }
    }
    fn contains(&self, x: f64) -> bool {
        let above = if self.min.1 { x >= self.min.0 } else { x > self.min.0 };
        let below = if self.max.1 { x <= self.max.0 } else { x < self.max.0 };
        x.is_finite() && above && below
    }
}

impl Convert for Number {
    type Output = f64;
    fn expects(&self) -> String {
        format!("a finite number{}", self.bounds())
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<f64, Mismatch> {
        let number = match value.get_ref() {
            DeValue::Integer(i) => i128::from_str_radix(i.as_str(), i.radix()).ok().map(|i| i as f64),
            DeValue::Float(f) => f.as_str().parse().ok(),
            _ => None,
        };
        number.filter(|&x| self.contains(x)).ok_or_else(|| Mismatch::of(value))
    }
}

/// An integer from `min` to `max`.
#[derive(Clone, Copy)]
pub(crate) struct Integer {
    pub min: u64,
    pub max: u64,
    pub help: Option<&'static str>,
}

impl Integer {
    pub const fn within(min: u64, max: u64) -> Integer {
        Integer { min, max, help: None }
    }
}

impl Convert for Integer {
    type Output = u64;
    fn expects(&self) -> String {
        format!("an integer from {} to {}", self.min, self.max)
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<u64, Mismatch> {
        let DeValue::Integer(i) = value.get_ref() else { return Err(Mismatch::of(value)) };
        let number = u64::from_str_radix(i.as_str(), i.radix()).ok();
        number.filter(|n| (self.min..=self.max).contains(n)).ok_or_else(|| Mismatch::of(value))
    }
    fn help(&self) -> Option<String> {
        self.help.map(str::to_owned)
    }
}

/// `N` numbers of one kind.
#[derive(Clone, Copy)]
pub(crate) struct Array<K, const N: usize>(pub K);

impl<K: Convert<Output: Copy + Default>, const N: usize> Convert for Array<K, N> {
    type Output = [K::Output; N];
    fn expects(&self) -> String {
        format!("an array of {N}, each {}", self.0.expects())
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<Self::Output, Mismatch> {
        let DeValue::Array(items) = value.get_ref() else { return Err(Mismatch::of(value)) };
        if items.len() != N {
            return Err(Mismatch::of(value));
        }
        let mut converted = [K::Output::default(); N];
        for (slot, item) in converted.iter_mut().zip(items.iter()) {
            *slot = self.0.convert(item)?;
        }
        Ok(converted)
    }
    fn help(&self) -> Option<String> {
        self.0.help()
    }
}

/// A position: three numbers.
pub(crate) const POINT: Array<Number, 3> = Array(ANY);

/// Three numbers, not all zero.
#[derive(Clone, Copy)]
pub(crate) struct Direction;

impl Convert for Direction {
    type Output = [f64; 3];
    fn expects(&self) -> String {
        "an array of 3 finite numbers that are not all 0".to_owned()
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<[f64; 3], Mismatch> {
        let v = POINT.convert(value)?;
        if v == [0.0; 3] {
            return Err(Mismatch { found: "[0, 0, 0]".to_owned(), span: value.span() });
        }
        Ok(v)
    }
}

/// One number (grey) or three (linear Rec.709).
#[derive(Clone, Copy)]
pub(crate) struct Colour(pub Number);

impl Convert for Colour {
    type Output = [f64; 3];
    fn expects(&self) -> String {
        format!("a number or [r, g, b], each {}", self.0.expects())
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<[f64; 3], Mismatch> {
        match value.get_ref() {
            DeValue::Array(_) => Array::<Number, 3>(self.0).convert(value),
            _ => self.0.convert(value).map(|grey| [grey; 3]),
        }
    }
}

/// A factor: one number for all axes, or three.
#[derive(Clone, Copy)]
pub(crate) struct ScaleFactors;

impl Convert for ScaleFactors {
    type Output = [f64; 3];
    fn expects(&self) -> String {
        "a number or [x, y, z], none of them 0".to_owned()
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<[f64; 3], Mismatch> {
        let factors = Colour(ANY).convert(value)?;
        if factors.contains(&0.0) { Err(Mismatch::of(value)) } else { Ok(factors) }
    }
}

/// An array of any length but 0.
#[derive(Clone, Copy)]
pub(crate) struct List<K>(pub K);

impl<K: Convert> Convert for List<K> {
    type Output = Vec<K::Output>;
    fn expects(&self) -> String {
        format!("an array, each element {}", self.0.expects())
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<Vec<K::Output>, Mismatch> {
        match value.get_ref() {
            DeValue::Array(items) if !items.is_empty() => items.iter().map(|item| self.0.convert(item)).collect(),
            _ => Err(Mismatch::of(value)),
        }
    }
}

/// Any text.
#[derive(Clone, Copy)]
pub(crate) struct Text;

impl Convert for Text {
    type Output = String;
    fn expects(&self) -> String {
        "a text in quotes".to_owned()
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<String, Mismatch> {
        match value.get_ref() {
            DeValue::String(s) => Ok(s.clone().into_owned()),
            _ => Err(Mismatch::of(value)),
        }
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Boolean;

impl Convert for Boolean {
    type Output = bool;
    fn expects(&self) -> String {
        "true or false".to_owned()
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<bool, Mismatch> {
        match value.get_ref() {
            DeValue::Boolean(b) => Ok(*b),
            _ => Err(Mismatch::of(value)),
        }
    }
}

/// One of a list of words.
#[derive(Clone, Copy)]
pub(crate) struct Choice<'n, T> {
    pub names: &'n [&'n str],
    pub from_name: fn(&str) -> Option<T>,
}

impl<T> Convert for Choice<'_, T> {
    type Output = T;
    fn expects(&self) -> String {
        let quoted: Vec<String> = self.names.iter().map(|n| format!("\"{n}\"")).collect();
        format!("one of {}", quoted.join(", "))
    }
    fn convert(&self, value: &Spanned<DeValue<'_>>) -> Result<T, Mismatch> {
        let DeValue::String(s) = value.get_ref() else { return Err(Mismatch::of(value)) };
        (self.from_name)(s).ok_or_else(|| Mismatch {
            found: match nearest(s, self.names) {
                Some(near) => format!("\"{s}\"; did you mean \"{near}\"?"),
                None => format!("\"{s}\""),
            },
            span: value.span(),
        })
    }
}
