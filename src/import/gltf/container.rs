//! The JSON of a glTF file and the binary chunk that a `.glb` carries along.

use gltf::json::validation::{Error as Fault, Validate};
use gltf::json::{self, Root};

use super::references;
use crate::scene::error::{Problem, Problems, Source};

const GLB_MAGIC: &[u8] = b"glTF";
const GLB_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
const JSON_CHUNK: &[u8] = b"JSON";
const BINARY_CHUNK: &[u8] = b"BIN\0";

/// Faults of one file that are reported: the others mostly follow from them.
const MAX_FAULTS: usize = 5;

/// Extensions without which the rest of a file means something else. Those of materials only add to what is there.
const KNOWN_IF_REQUIRED: [&str; 2] = ["KHR_lights_punctual", "KHR_texture_transform"];
const OF_MATERIALS: &str = "KHR_materials_";

/// The parts of a file.
pub(super) struct Container<'b> {
    pub root: Root,
    /// What the first buffer of a `.glb` holds.
    pub blob: Option<&'b [u8]>,
}

/// Reads the JSON and checks that everything it refers to is there.
pub(super) fn open<'b>(bytes: &'b [u8], source: &Source) -> Result<Container<'b>, Problems> {
    let (text, blob, is_text) = match bytes.starts_with(GLB_MAGIC) {
        true => {
            let (text, blob) = chunks(bytes).map_err(|what| not_sound(&what).at(source))?;
            (text, blob, false)
        }
        false => (bytes, None, true),
    };
    let root: Root = json::deserialize::from_slice(text).map_err(|error| broken_json(&error, is_text, source))?;
    if !root.asset.version.starts_with("2.") {
        let problem = Problem::new(format!("this is glTF {}", root.asset.version)).at(source);
        return Err(problem.help("only version 2 of the format can be read").into());
    }
    check(&root, source)?;
    Ok(Container { root, blob })
}

fn not_sound(what: &str) -> Problem {
    Problem::new(format!("not a sound glTF file: {what}"))
}

/// The parser's message with its place, which is one in the file only where that is text.
fn broken_json(error: &json::Error, is_text: bool, source: &Source) -> Problem {
    let message = error.to_string();
    let message = message.split(" at line ").next().unwrap_or(&message);
    let place = if is_text { source.at(error.line() as u32, error.column() as u32) } else { source.clone() };
    not_sound(message).at(&place)
}

/// The JSON and the binary chunk of a `.glb`.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |at: usize| {
        let four = bytes.get(at..at + 4).ok_or("it ends within a header")?;
        Ok::<u32, &str>(u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
    };
    let version = word(4)?;
    if version != 2 {
        return Err(format!("version {version} of the binary container"));
    }
    let chunk = |at: usize| {
        let length = word(at)? as usize;
        let kind = bytes.get(at + 4..at + CHUNK_HEADER).ok_or("it ends within a header")?;
        let start = at + CHUNK_HEADER;
        let content = bytes.get(start..start + length).ok_or_else(|| {
            let there = bytes.len() - start;
            format!("a chunk claims {length} bytes, but only {there} follow; is the file truncated?")
        })?;
        Ok::<_, String>((kind, content))
    };
    let (kind, text) = chunk(GLB_HEADER)?;
    if kind != JSON_CHUNK {
        return Err("its first chunk is not JSON".to_owned());
    }
    let next = GLB_HEADER + CHUNK_HEADER + text.len();
    if bytes.len() < next + CHUNK_HEADER {
        return Ok((text, None));
    }
    let (kind, blob) = chunk(next)?;
    Ok((text, (kind == BINARY_CHUNK).then_some(blob)))
}

/// Indices in range, values of the choices that the format has, required extensions.
fn check(root: &Root, source: &Source) -> Result<(), Problems> {
    references::check(root).map_err(|what| not_sound(&what).at(source))?;
    let mut faults = Vec::new();
    root.validate(root, json::Path::new, &mut |path, fault| {
        // Required extensions are judged below; bounds are computed anyway, and files without them are many.
        let is_bound = || [".min", ".max"].iter().any(|end| path().as_str().ends_with(end));
        if fault != Fault::Unsupported && !(fault == Fault::Missing && is_bound()) {
            faults.push((path(), fault));
        }
    });
    let described = |(path, fault): &(json::Path, Fault)| {
        let what = match fault {
            Fault::IndexOutOfBounds => "names something that is not in the file",
            Fault::Missing => "is missing",
            Fault::Oversize => "is too large",
            Fault::Invalid | Fault::Unsupported => "has a value that the format does not know",
        };
        not_sound(&format!("`{path}` {what}")).at(source)
    };
    let mut problems = Problems(faults.iter().take(MAX_FAULTS).map(described).collect());
    for name in &root.extensions_required {
        if !KNOWN_IF_REQUIRED.contains(&name.as_str()) && !name.starts_with(OF_MATERIALS) {
            let problem = Problem::new(format!("the file requires the extension {name}, which cannot be read here"));
            problems.push(problem.help("export it without this extension").at(source));
        }
    }
    problems.into_result(())
}
