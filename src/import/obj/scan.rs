//! One pass over the lines of an OBJ file that finds what is wrong, and writes what is right in plain form.

use std::fmt::Write;
use std::path::Path;

use super::{Wanted, library_path};
use crate::scene::error::{Problem, Problems, Source};

/// Problems reported from one file.
const MAX_PROBLEMS: usize = 10;

/// What the pass found.
pub(super) struct Scan {
    /// The file as tobj gets it.
    pub clean: String,
    /// The line of the face that each triangle comes from.
    pub triangle_lines: Vec<u32>,
    /// Whether any corner has a texture coordinate of its own.
    pub has_uvs: bool,
    /// Material libraries with the line that names them.
    libraries: Vec<(String, u32)>,
}

/// Elements that corners refer to.
const POSITION: usize = 0;
const UV: usize = 1;
const NORMAL: usize = 2;
const NAMES: [&str; 3] = ["vertex", "texture coordinate", "normal"];

struct State<'a> {
    scan: Scan,
    problems: Problems,
    source: &'a Source,
    wanted: Wanted,
    /// Elements of each kind so far.
    counts: [usize; 3],
    /// The largest index of each kind that a face names, with its line.
    largest: [(usize, u32); 3],
    /// The first line with a corner with a normal, and with one without.
    with_normal: Option<u32>,
    without_normal: Option<u32>,
}

impl Scan {
    pub fn of(text: &str, source: &Source, wanted: Wanted) -> Result<Scan, Problems> {
        let scan = Scan {
            // Number 1 stands for a missing texture coordinate.
            clean: String::from("vt 0 0\n"),
            triangle_lines: Vec::new(),
            has_uvs: false,
            libraries: Vec::new(),
        };
        let mut state = State {
            scan,
            problems: Problems::default(),
            source,
            wanted,
            counts: [0; 3],
            largest: [(0, 0); 3],
            with_normal: None,
            without_normal: None,
        };
        for (number, line) in logical_lines(text) {
            state.line(number, &line);
            if state.problems.len() >= MAX_PROBLEMS {
                break;
            }
        }
        state.finish()
    }

    /// The line that names a material library.
    pub fn library_line(&self, library: &Path) -> u32 {
        let named = self.libraries.iter().find(|(name, _)| library_path(name) == library);
        named.map_or(0, |(_, line)| *line)
    }
}

/// Lines without comments, those that end in a backslash joined with the next, each with the number of its first.
fn logical_lines(text: &str) -> impl Iterator<Item = (u32, String)> {
    let mut physical = text.lines().zip(1_u32..);
    std::iter::from_fn(move || {
        let (line, number) = physical.next()?;
        let mut joined = line.to_owned();
        while joined.ends_with('\\') {
            joined.pop();
            joined.push(' ');
            joined.push_str(physical.next().map_or("", |(next, _)| next));
        }
        if let Some(comment) = joined.find('#') {
            joined.truncate(comment);
        }
        Some((number, joined))
    })
}

impl State<'_> {
    fn refuse(&mut self, line: u32, message: String, help: &str) {
        self.problems.push(Problem::new(message).help(help).at(&self.source.at_line(line)));
    }

    fn line(&mut self, number: u32, line: &str) {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => self.element(POSITION, number, words),
            Some("vt") => self.element(UV, number, words),
            Some("vn") => self.element(NORMAL, number, words),
            Some("f") => self.face(number, words),
            Some(word @ ("mtllib" | "usemtl")) if self.wanted.materials => {
                let name = line.trim().strip_prefix(word).unwrap_or_default().trim().to_owned();
                if name.is_empty() {
                    return self.refuse(number, format!("`{word}` without a name"), "name a material or its library");
                }
                // Writing to a String cannot fail.
                let _ = writeln!(self.scan.clean, "{word} {name}");
                if word == "mtllib" {
                    self.scan.libraries.push((name, number));
                }
            }
            _ => {}
        }
    }

    /// `v x y z [w | r g b]`, `vt u [v [w]]`, `vn x y z`.
    fn element<'w>(&mut self, kind: usize, number: u32, words: impl Iterator<Item = &'w str>) {
        self.counts[kind] += 1;
        let mut values: Vec<f32> = Vec::new();
        for word in words {
            match word.parse::<f32>() {
                Ok(value) if value.is_finite() => values.push(value),
                _ => {
                    let message = format!("a {} has `{word}` for a number", NAMES[kind]);
                    return self.refuse(number, message, "coordinates must be finite numbers below 3e38");
                }
            }
        }
        let needed = if kind == UV { 1 } else { 3 };
        if values.len() < needed {
            let message = format!("a {} has {} numbers", NAMES[kind], values.len());
            return self.refuse(number, message, &format!("it needs {needed}"));
        }
        values.resize(values.len().max(2), 0.0);
        let clean = &mut self.scan.clean;
        match kind {
            POSITION if values.len() == 4 => {
                let [x, y, z] = [values[0], values[1], values[2]].map(|c| c / values[3]);
                if !(x.is_finite() && y.is_finite() && z.is_finite()) {
                    let message = format!("a vertex has the weight {}", values[3]);
                    return self.refuse(number, message, "divided by it, its coordinates must stay finite");
                }
                let _ = writeln!(clean, "v {x} {y} {z}");
            }
            POSITION => {
                let _ = writeln!(clean, "v {} {} {}", values[0], values[1], values[2]);
            }
            UV => {
                let _ = writeln!(clean, "vt {} {}", values[0], values[1]);
            }
            _ if !self.wanted.normals => {}
            _ => {
                let largest = values.iter().fold(0.0_f32, |max, x| max.max(x.abs()));
                if largest == 0.0 {
                    let help = "use `smooth = true` or `smooth = false` instead of the file's normals";
                    return self.refuse(number, "a normal has no length".to_owned(), help);
                }
                // Divided first, so that squares of very long and very short ones can be represented.
                let [x, y, z] = [values[0], values[1], values[2]].map(|c| c / largest);
                let _ = writeln!(clean, "vn {x} {y} {z}");
            }
        }
    }

    fn face<'w>(&mut self, number: u32, words: impl Iterator<Item = &'w str>) {
        let mut corners = 0;
        let start = self.scan.clean.len();
        self.scan.clean.push('f');
        for word in words {
            if let Err(problem) = self.corner(number, word) {
                self.problems.push(problem);
                self.scan.clean.truncate(start);
                return;
            }
            corners += 1;
        }
        if corners < 3 {
            self.scan.clean.truncate(start);
            return self.refuse(number, format!("a face has {corners} corners"), "it needs at least 3");
        }
        self.scan.clean.push('\n');
        self.scan.triangle_lines.extend(std::iter::repeat_n(number, corners - 2));
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&mut self, number: u32, word: &str) -> Result<(), Problem> {
        let mut parts = word.split('/');
        let mut indices = [None; 3];
        for (kind, index) in indices.iter_mut().enumerate() {
            *index = match parts.next() {
                None | Some("") => None,
                Some(part) => Some(self.index(kind, number, part)?),
            };
        }
        let [Some(position), uv, normal] = indices else {
            return Err(self.bad_corner(number, word));
        };
        if parts.next().is_some() {
            return Err(self.bad_corner(number, word));
        }
        self.scan.has_uvs |= uv.is_some();
        // Index 0 of a missing texture coordinate is the stand-in before the file's own.
        let _ = write!(self.scan.clean, " {position}/{}", uv.unwrap_or(0) + 1);
        let first = if normal.is_some() { &mut self.with_normal } else { &mut self.without_normal };
        first.get_or_insert(number);
        if let (Some(normal), true) = (normal, self.wanted.normals) {
            let _ = write!(self.scan.clean, "/{normal}");
        }
        Ok(())
    }

    fn bad_corner(&self, number: u32, word: &str) -> Problem {
        let problem = Problem::new(format!("`{word}` is no corner of a face"));
        problem.help("write v, v/vt, v//vn or v/vt/vn").at(&self.source.at_line(number))
    }

    /// An index counted from 1; negative ones count back from the last element.
    fn index(&mut self, kind: usize, number: u32, part: &str) -> Result<usize, Problem> {
        let count = self.counts[kind];
        let at = self.source.at_line(number);
        let Ok(index) = part.parse::<i64>() else {
            return Err(Problem::new(format!("`{part}` is no index")).help("indices are integers").at(&at));
        };
        let absolute = if index < 0 { count as i64 + 1 + index } else { index };
        if absolute < 1 {
            let message = format!("a face names {} {index}, there are {count} before it", NAMES[kind]);
            return Err(Problem::new(message).help("indices count from 1, or back from -1").at(&at));
        }
        let absolute = usize::try_from(absolute).unwrap_or(usize::MAX);
        if absolute > self.largest[kind].0 {
            self.largest[kind] = (absolute, number);
        }
        Ok(absolute)
    }

    fn finish(mut self) -> Result<Scan, Problems> {
        for kind in [POSITION, UV, NORMAL] {
            let (largest, line) = self.largest[kind];
            let count = self.counts[kind];
            if largest > count && self.problems.len() < MAX_PROBLEMS {
                let message = format!("a face names {} {largest}, the file has {count}", NAMES[kind]);
                self.refuse(line, message, "indices count from 1");
            }
        }
        if let (true, Some(with), Some(without)) = (self.wanted.normals, self.with_normal, self.without_normal) {
            let message = format!("a corner has no normal, but those of line {with} have");
            self.refuse(without, message, "set `smooth = true` or `smooth = false` instead of the file's normals");
        }
        self.problems.into_result(self.scan)
    }
}
