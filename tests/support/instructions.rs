//! Instructions that each phase of a render takes: callgrind's files read, and counts held against a table.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// How far from the table a count may be, as a share of it, either way: where less is done the table is due, too.
pub const TOLERANCE: f64 = 0.03;

/// Instructions of one phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Count {
    /// In the program itself, with the Rust libraries compiled into it.
    pub own: u64,
    /// With the ray library and the C library.
    pub all: u64,
}

/// What counts depend on beside our own code.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Environment {
    /// The folder of the build: `debug` has our own code optimised and the libraries of the tests.
    pub build: String,
    pub rustc: String,
    pub target: String,
    /// The estimate's instruction set, found at run time.
    pub vectors: String,
    pub rays: String,
    pub system: String,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Row {
    pub scene: String,
    pub phase: String,
    #[serde(flatten)]
    pub count: Count,
}

/// Counts of one environment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Table {
    pub environment: Environment,
    pub rows: Vec<Row>,
}

/// Why a callgrind file says nothing.
#[derive(Debug, PartialEq, Eq)]
pub struct Unread(pub String);

/// The sums of one callgrind file: what was spent in the object `program`, and everywhere.
pub fn read_callgrind(text: &str, program: &str) -> Result<Count, Unread> {
    let (mut count, mut objects) = (Count::default(), BTreeMap::new());
    let (mut in_program, mut after_call, mut totals) = (false, false, None);
    for line in text.lines() {
        let unread = || Unread(line.to_owned());
        if let Some(object) = line.strip_prefix("ob=") {
            in_program = name_of(object, &mut objects).ok_or_else(unread)? == program;
        } else if let Some(object) = line.strip_prefix("cob=") {
            name_of(object, &mut objects).ok_or_else(unread)?;
        } else if line.starts_with("calls=") {
            after_call = true;
        } else if let Some(sum) = line.strip_prefix("totals: ") {
            totals = Some(sum.trim().parse::<u64>().map_err(|_| unread())?);
        } else if line.starts_with(|c: char| c.is_ascii_digit() || "+-*".contains(c)) {
            // The line below `calls=` has the cost of the functions called, which is in their own lines, too.
            if !std::mem::take(&mut after_call) {
                let cost = line.split_whitespace().nth(1).map_or(Ok(0), str::parse::<u64>).map_err(|_| unread())?;
                count.all += cost;
                count.own += if in_program { cost } else { 0 };
            }
        }
    }
    if totals == Some(count.all) { Ok(count) } else { Err(Unread(format!("{totals:?} in all, not {}", count.all))) }
}

/// The name that `(7) name` gives to number 7, or that `(7)` alone stands for.
fn name_of(text: &str, names: &mut BTreeMap<String, String>) -> Option<String> {
    let (number, name) = text.strip_prefix('(')?.split_once(')')?;
    if !name.is_empty() {
        names.insert(number.to_owned(), name.trim().to_owned());
    }
    names.get(number).cloned()
}

/// Differences of two counts, as shares of the first.
fn changes(before: Count, now: Count) -> [f64; 2] {
    [(before.own, now.own), (before.all, now.all)].map(|(before, now)| now as f64 / before as f64 - 1.0)
}

/// What comes of holding counts against a table.
pub struct Verdict {
    /// A line for every phase, and what it means.
    pub text: String,
    /// Whether the counts are as they were, or cannot be compared.
    pub passed: bool,
}

/// Holds `now` against `before`.
pub fn judge(before: &Table, now: &Table) -> Verdict {
    let head = |what| format!("{what:>15} {:>8}", "change");
    let mut lines = vec![format!("{:<10} {:<10} {} {}", "scene", "phase", head("own code"), head("all code"))];
    let mut far = Vec::new();
    for row in &now.rows {
        let known = before.rows.iter().find(|known| (&known.scene, &known.phase) == (&row.scene, &row.phase));
        let [own, all] = known.map_or([f64::INFINITY; 2], |known| changes(known.count, row.count));
        let mark = if own.abs().max(all.abs()) <= TOLERANCE { "" } else { "  <" };
        lines.push(format!(
            "{:<10} {:<10} {:>15} {:>+7.2}% {:>15} {:>+7.2}%{mark}",
            row.scene,
            row.phase,
            grouped(row.count.own),
            100.0 * own,
            grouped(row.count.all),
            100.0 * all,
        ));
        if !mark.is_empty() {
            far.push(format!("{} {}", row.scene, row.phase));
        }
    }
    let gone = |row: &&Row| !now.rows.iter().any(|new| (&new.scene, &new.phase) == (&row.scene, &row.phase));
    far.extend(before.rows.iter().filter(gone).map(|row| format!("{} {} (gone)", row.scene, row.phase)));
    let same = before.environment == now.environment;
    let limit = 100.0 * TOLERANCE;
    if !same {
        lines.push(format!(
            "not judged: the table is of another environment\n  table: {}\n  here:  {}",
            before.environment, now.environment
        ));
    } else if far.is_empty() {
        lines.push(format!("all within {limit} % of the table"));
    } else {
        lines.push(format!("further than {limit} % from the table: {}", far.join(", ")));
        lines.push("where that is meant, .ci/instructions --write renews the table".to_owned());
    }
    Verdict { text: lines.join("\n"), passed: !same || far.is_empty() }
}

impl std::fmt::Display for Environment {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Environment { build, rustc, target, vectors, rays, system } = self;
        write!(f, "{build} build, rustc {rustc}, {target}, vectors {vectors}, {rays}, {system}")
    }
}

/// 12 345 678
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> = digits.as_bytes().rchunks(3).rev().filter_map(|group| str::from_utf8(group).ok()).collect();
    groups.join(" ")
}
