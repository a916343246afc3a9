//! PLY: ASCII and both byte orders, vertices with normals and texture coordinates, polygons cut into fans.

use std::path::Path;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::ScalarType;
use ply_rs_bw::ply::{ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType};

use super::mesh_file::MeshFile;
use super::{MAX_MESH_BYTES, read_bytes};
use crate::scene::error::{Problem, Problems, Source};
use crate::scene::mesh::TriangleMesh;

/// Names of the scalar properties of a vertex that are read, with other programs' names for the last two.
const SCALARS: [&[&str]; 8] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["s", "u", "texture_u", "texture_s"],
    &["t", "v", "texture_v", "texture_t"],
];
const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Elements that are held at once as the parser gives them, several times as large as what is kept.
const ROWS_AT_ONCE: usize = 1 << 16;

/// Reads a PLY file; without `normals` those of the file are left out.
///
/// # Errors
/// A file that cannot be read or is no PLY; claims of more elements than its bytes can hold; vertices that are not
/// finite; indices out of range. The line is named in ASCII files, the byte or element in binary ones.
pub fn read(path: &Path, normals: bool) -> Result<MeshFile, Problems> {
    let bytes = read_bytes(path, MAX_MESH_BYTES)?;
    parse(path, &bytes, normals)
}

/// Like [`read`] with the content of the file at hand.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, bytes: &[u8], normals: bool) -> Result<MeshFile, Problems> {
    let file = PlyFile { source: Source::file(path), bytes };
    let mut reader = Reader::new(bytes);
    let parser = Parser::<Row>::new();
    let header = parser.read_header(&mut reader).map_err(|error| file.broken(&error, true, &reader))?;
    file.check_claims(&header, reader.get_ref().len())?;

    let missing = |name: &str| Problem::new(format!("the file has no element `{name}`")).at(&file.source);
    let vertices = header.elements.get("vertex").ok_or_else(|| missing("vertex"))?;
    if !header.elements.contains_key("face") {
        return Err(missing("face").help("point clouds and strips cannot be rendered").into());
    }
    let mut building = Building::new(vertices, normals, &file.source)?;
    let ascii = header.encoding == Encoding::Ascii;
    for (name, element) in &header.elements {
        for first in (0..element.count).step_by(ROWS_AT_ONCE) {
            let some = ElementDef { count: ROWS_AT_ONCE.min(element.count - first), ..element.clone() };
            let first_line = ascii.then_some(reader.line());
            let rows = parser
                .read_payload_for_element(&mut reader, &some, &header)
                .map_err(|error| file.broken(&error, ascii, &reader))?;
            let rows = Rows { rows, first, first_line, source: &file.source };
            match name.as_str() {
                "vertex" => building.add_vertices(&rows)?,
                "face" => building.add_triangles(&rows)?,
                _ => {}
            }
        }
    }
    let Building { mesh, triangle_lines, .. } = building;
    let triangle_materials = vec![None; mesh.triangles.len()];
    Ok(MeshFile { source: file.source, mesh, triangle_lines, triangle_materials, materials: Vec::new() })
}

struct PlyFile<'b> {
    source: Source,
    bytes: &'b [u8],
}

impl PlyFile<'_> {
    /// The parser's error as a problem: with its line in text, with the byte in binary data.
    fn broken(&self, error: &ParseError, text: bool, reader: &Reader<&[u8]>) -> Problem {
        const LONGEST: usize = 200;
        let message = error.to_string();
        let message = match message.split_once(": ") {
            Some((place, rest)) if place.starts_with("Line ") => rest,
            _ => &message,
        };
        let message: String = message.split_whitespace().collect::<Vec<_>>().join(" ").chars().take(LONGEST).collect();
        match error.line() {
            Some(line) if text => {
                Problem::new(format!("not a sound PLY file: {message}")).at(&self.source.at_line(line as u32))
            }
            _ => {
                let byte = self.bytes.len() - reader.get_ref().len();
                Problem::new(format!("not a sound PLY file: {message} (at byte {byte})")).at(&self.source)
            }
        }
    }

    /// The header must not claim more than the file can hold, before anything is allocated for it.
    fn check_claims(&self, header: &Header, available: usize) -> Result<(), Problem> {
        let mut needed: u128 = 0;
        for element in header.elements.values().filter(|e| e.count > 0) {
            if element.properties.is_empty() {
                let message = format!("the element `{}` has no property", element.name);
                return Err(Problem::new(message).at(&self.source));
            }
            needed += element.count as u128 * least_bytes(element, header.encoding);
            // The last line of a text needs no line break.
            if needed > available as u128 + 1 {
                let message = format!(
                    "the header claims {} elements `{}`, which need at least {needed} bytes, but only {available} follow",
                    element.count, element.name
                );
                return Err(Problem::new(message).help("is the file truncated?").at(&self.source));
            }
        }
        Ok(())
    }
}

/// Bytes that one element takes at least: in text a digit and a separator a value, in binary data its fixed part.
fn least_bytes(element: &ElementDef, encoding: Encoding) -> u128 {
    let size = |property: &PropertyType| match property {
        PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => match scalar {
            ScalarType::Char | ScalarType::UChar => 1,
            ScalarType::Short | ScalarType::UShort => 2,
            ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
            ScalarType::Double => 8,
        },
    };
    match encoding {
        Encoding::Ascii => 2 * element.properties.len() as u128,
        _ => element.properties.values().map(|p| size(&p.data_type)).sum(),
    }
}

/// What is kept of one element of any kind.
struct Row {
    scalars: [f64; 8],
    indices: Vec<i64>,
}

impl PropertyAccess for Row {
    fn new() -> Row {
        Row { scalars: [0.0; 8], indices: Vec::new() }
    }
    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let scalar = match property {
            Property::Char(x) => f64::from(x),
            Property::UChar(x) => f64::from(x),
            Property::Short(x) => f64::from(x),
            Property::UShort(x) => f64::from(x),
            Property::Int(x) => f64::from(x),
            Property::UInt(x) => f64::from(x),
            Property::Float(x) => f64::from(x),
            Property::Double(x) => x,
            list => return self.set_list(name, list),
        };
        match SCALARS.iter().position(|names| names.contains(&name)) {
            Some(slot) => {
                self.scalars[slot] = scalar;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::Ignored,
        }
    }
}

impl Row {
    fn set_list(&mut self, name: &str, list: Property) -> PropertyAccessResult {
        if !INDICES.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.indices = match list {
            Property::ListChar(l) => l.into_iter().map(i64::from).collect(),
            Property::ListUChar(l) => l.into_iter().map(i64::from).collect(),
            Property::ListShort(l) => l.into_iter().map(i64::from).collect(),
            Property::ListUShort(l) => l.into_iter().map(i64::from).collect(),
            Property::ListInt(l) => l.into_iter().map(i64::from).collect(),
            Property::ListUInt(l) => l.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// Some elements of one kind.
struct Rows<'s> {
    rows: Vec<Row>,
    /// Number of the first one in the file.
    first: usize,
    /// Its line, in text files.
    first_line: Option<usize>,
    source: &'s Source,
}

impl Rows<'_> {
    fn line(&self, index: usize) -> Option<u32> {
        self.first_line.map(|first| (first + index) as u32)
    }
    fn source(&self, index: usize) -> Source {
        self.line(index).map_or(self.source.clone(), |line| self.source.at_line(line))
    }
    /// Each with its number in the file.
    fn numbered(&self) -> impl Iterator<Item = (usize, usize, &Row)> {
        self.rows.iter().enumerate().map(|(index, row)| (index, self.first + index, row))
    }
}

/// The mesh as far as it has been read.
struct Building {
    mesh: TriangleMesh,
    triangle_lines: Vec<u32>,
    vertices: i64,
    has_normals: bool,
    has_uvs: bool,
}

impl Building {
    fn new(vertices: &ElementDef, normals: bool, source: &Source) -> Result<Building, Problem> {
        let is_scalar = |name: &&str| {
            vertices.properties.get(*name).is_some_and(|p| matches!(p.data_type, PropertyType::Scalar(_)))
        };
        let has = |slots: std::ops::Range<usize>| SCALARS[slots].iter().all(|names| names.iter().any(is_scalar));
        if !has(0..3) {
            return Err(Problem::new("the vertices have no x, y, z").at(source));
        }
        let (has_normals, has_uvs, vertices) = (normals && has(3..6), has(6..8), vertices.count as i64);
        Ok(Building { mesh: TriangleMesh::default(), triangle_lines: Vec::new(), vertices, has_normals, has_uvs })
    }

    fn add_vertices(&mut self, rows: &Rows) -> Result<(), Problem> {
        let mesh = &mut self.mesh;
        for (index, number, row) in rows.numbered() {
            let refuse = |what: &str, help: &str| {
                Err(Problem::new(format!("vertex {number} has {what}")).help(help.to_owned()).at(&rows.source(index)))
            };
            let [x, y, z, nx, ny, nz, u, v] = row.scalars;
            let position = [x, y, z].map(|c| c as f32);
            if !position.iter().all(|c| c.is_finite()) {
                return refuse("a coordinate that is not finite", "coordinates must be finite numbers below 3e38");
            }
            mesh.positions.push(position);
            if self.has_normals {
                let length = (nx * nx + ny * ny + nz * nz).sqrt();
                if !(length > 0.0 && length.is_finite()) {
                    return refuse("a normal without length", "use `smooth = true` or `smooth = false` instead");
                }
                mesh.normals.push([nx, ny, nz].map(|c| (c / length) as f32));
            }
            if self.has_uvs {
                if !(u as f32).is_finite() || !(v as f32).is_finite() {
                    return refuse("a texture coordinate that is not finite", "it must be a finite number");
                }
                mesh.uvs.push([u as f32, v as f32]);
            }
        }
        Ok(())
    }

    /// Cuts the faces into triangles.
    fn add_triangles(&mut self, rows: &Rows) -> Result<(), Problem> {
        for (index, number, row) in rows.numbered() {
            if let Some(vertex) = row.indices.iter().find(|vertex| !(0..self.vertices).contains(*vertex)) {
                let message = format!("face {number} names vertex {vertex}, the file has {}", self.vertices);
                return Err(Problem::new(message).help("vertices count from 0").at(&rows.source(index)));
            }
            if row.indices.len() < 3 {
                let message = format!("face {number} has {} corners", row.indices.len());
                return Err(Problem::new(message).help("a face needs at least 3").at(&rows.source(index)));
            }
            let [first, rest @ ..] = &row.indices[..] else { continue };
            for pair in rest.windows(2) {
                self.mesh.triangles.push([*first, pair[0], pair[1]].map(|vertex| vertex as u32));
                self.triangle_lines.extend(rows.line(index));
            }
        }
        Ok(())
    }
}
