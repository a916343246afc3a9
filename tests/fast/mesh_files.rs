//! OBJ, PLY and image files: what is read from them, in every form that they come in.

use std::path::Path;

use ply_rs_bw::ply::{
    Addable, DefaultElement, ElementDef, Encoding, Ply, Property, PropertyDef, PropertyType, ScalarType,
};
use ply_rs_bw::writer::Writer;

use pdembree::import::image::{self, ColourSpace};
use pdembree::import::mesh_file::MeshFile;
use pdembree::import::obj::{self, Wanted};
use pdembree::import::{load_text, ply};
use pdembree::scene::texture::{TextureMemory, Wrap};
use pdembree::scene::{Material, TriangleMesh};

use crate::support::data::{root, shared};

const ALL: Wanted = Wanted { normals: true, materials: true };

fn read_obj(text: &str) -> MeshFile {
    obj::parse(Path::new("m.obj"), text, ALL).expect("a sound OBJ")
}

fn obj_problems(text: &str, wanted: Wanted) -> Vec<String> {
    obj::parse(Path::new("m.obj"), text, wanted).expect_err("a wrong OBJ").iter().map(ToString::to_string).collect()
}

#[test]
fn obj_polygons_become_fans_with_their_lines() {
    let file = read_obj("v 0 0 0\nv 1 0 0\nv 1 1 0 # a corner\nv 0 1 0\nv -1 0.5 0\nf 1 2 3 4 5\nf -5 -4 -3\nl 1 2\n");
    assert_eq!(file.mesh.triangles.len(), 4);
    assert_eq!(file.triangle_lines, [6, 6, 6, 7]);
    assert_eq!(file.mesh.corners(2).map(|p| p.x), [0.0, 0.0, -1.0]);
    assert_eq!(file.mesh.corners(3).map(|p| (p.x, p.y)), [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]);
    assert!(file.mesh.normals.is_empty() && file.mesh.uvs.is_empty());
}

#[test]
fn obj_corners_share_vertices_only_with_all_their_parts() {
    let text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0.25 0.5\nvn 0 0 2\nvn 0 3 0\nf 1/1/1 2//1 3//1\nf 2//2 4//2 3//2\n";
    let file = read_obj(text);
    assert_eq!(file.mesh.positions.len(), 6, "two normals at vertices 2 and 3");
    assert_eq!(file.mesh.normals.len(), 6);
    assert_eq!(file.mesh.normals[0], [0.0, 0.0, 1.0]);
    assert_eq!(file.mesh.normals[5], [0.0, 1.0, 0.0]);
    assert_eq!(file.mesh.uvs[0], [0.25, 0.5]);
    assert_eq!(file.mesh.uvs[1], [0.0, 0.0], "no coordinate of its own");
}

#[test]
fn wrong_obj_lines_are_all_named() {
    let text = "v 0 0 0\nv nan 0 0\nv 0 1\nv 0 0 1e39\nf 1 2\nf 1 2 x\nf 0 1 2\nf 1 2 9\nf -8 1 2\nf 1/2/3/4 1 2\n";
    let expected = [
        "m.obj:2: a vertex has `nan` for a number (coordinates must be finite numbers below 3e38)",
        "m.obj:3: a vertex has 2 numbers (it needs 3)",
        "m.obj:4: a vertex has `1e39` for a number (coordinates must be finite numbers below 3e38)",
        "m.obj:5: a face has 2 corners (it needs at least 3)",
        "m.obj:6: `x` is no index (indices are integers)",
        "m.obj:7: a face names vertex 0, there are 4 before it (indices count from 1, or back from -1)",
        "m.obj:9: a face names vertex -8, there are 4 before it (indices count from 1, or back from -1)",
        "m.obj:10: `1/2/3/4` is no corner of a face (write v, v/vt, v//vn or v/vt/vn)",
        "m.obj:8: a face names vertex 9, the file has 4 (indices count from 1)",
        "m.obj:10: a face names texture coordinate 2, the file has 0 (indices count from 1)",
    ];
    assert_eq!(obj_problems(text, ALL)[..expected.len()], expected);
}

#[test]
fn normals_on_some_corners_only_are_refused_unless_they_are_not_wanted() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\nf 1 3 2\n";
    let problems = obj_problems(text, ALL);
    assert!(problems[0].starts_with("m.obj:6: a corner has no normal, but those of line 5 have"), "{problems:?}");
    let without = obj::parse(Path::new("m.obj"), text, Wanted { normals: false, ..ALL }).expect("not wanted");
    assert_eq!(without.mesh.triangles.len(), 2);
}

/// A unit cube of six quads, every corner once.
const CUBE: [[f32; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];
const CUBE_FACES: [[i32; 4]; 6] = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [2, 3, 7, 6], [0, 4, 7, 3], [1, 2, 6, 5]];

/// The cube through ply-rs's own writer, with normals along the diagonals and a property that nobody reads.
fn cube_ply(encoding: Encoding) -> Vec<u8> {
    let scalar = |name: &str, kind| PropertyDef::new(name.to_owned(), PropertyType::Scalar(kind));
    let mut ply = Ply::<DefaultElement>::new();
    ply.header.encoding = encoding;
    let mut vertex = ElementDef::new("vertex".to_owned());
    for name in ["x", "y", "z", "nx", "ny", "nz", "s", "t"] {
        vertex.properties.add(scalar(name, ScalarType::Float));
    }
    vertex.properties.add(scalar("quality", ScalarType::UChar));
    ply.header.elements.add(vertex);
    let mut face = ElementDef::new("face".to_owned());
    let list = PropertyType::List(ScalarType::UChar, ScalarType::Int);
    face.properties.add(PropertyDef::new("vertex_indices".to_owned(), list));
    ply.header.elements.add(face);
    let vertices = CUBE.iter().enumerate().map(|(i, p)| {
        let mut element = DefaultElement::new();
        let values = [p[0], p[1], p[2], p[0] - 0.5, p[1] - 0.5, p[2] - 0.5, p[0] * 0.1, i as f32 / 7.0];
        for (name, value) in ["x", "y", "z", "nx", "ny", "nz", "s", "t"].into_iter().zip(values) {
            element.insert(name.to_owned(), Property::Float(value));
        }
        element.insert("quality".to_owned(), Property::UChar(i as u8));
        element
    });
    ply.payload.insert("vertex".to_owned(), vertices.collect());
    let faces = CUBE_FACES.iter().map(|face| {
        let mut element = DefaultElement::new();
        element.insert("vertex_indices".to_owned(), Property::ListInt(face.to_vec()));
        element
    });
    ply.payload.insert("face".to_owned(), faces.collect());
    let mut bytes = Vec::new();
    Writer::new().write_ply(&mut bytes, &mut ply).expect("a consistent PLY");
    bytes
}

#[test]
fn the_three_encodings_of_ply_give_the_same_mesh() {
    let read = |encoding| ply::parse(Path::new("cube.ply"), &cube_ply(encoding), true).expect("a sound PLY");
    let ascii = read(Encoding::Ascii);
    assert_eq!(ascii.mesh.positions, CUBE);
    assert_eq!(ascii.mesh.triangles.len(), 12);
    assert_eq!(ascii.mesh.triangles[..2], [[0, 3, 2], [0, 2, 1]]);
    let third = 1.0 / 3.0_f64.sqrt();
    assert!(ascii.mesh.normals[0].iter().all(|c| (f64::from(*c) + third).abs() < 1e-7));
    assert_eq!(ascii.mesh.uvs[7], [0.0, 1.0]);
    assert_eq!(ascii.mesh, read(Encoding::BinaryLittleEndian).mesh);
    assert_eq!(ascii.mesh, read(Encoding::BinaryBigEndian).mesh);
    // 15 lines of header, 8 of vertices; two triangles a face.
    assert_eq!(ascii.triangle_lines[..3], [24, 24, 25]);
}

#[test]
fn a_ply_that_claims_more_than_it_holds_is_refused_before_anything_is_allocated() {
    for (format, count) in [("ascii", "1000000000000"), ("binary_little_endian", "1000000000000")] {
        let text = format!(
            "ply\nformat {format} 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n"
        );
        let problems = ply::parse(Path::new("big.ply"), text.as_bytes(), true).expect_err("a lie");
        let message = problems.to_string();
        assert!(
            message.starts_with("big.ply: the header claims 1000000000000 elements `vertex`, which need"),
            "{message}"
        );
    }
}

#[test]
fn wrong_plys_name_line_or_byte() {
    let ascii = String::from_utf8(cube_ply(Encoding::Ascii)).expect("text");
    let problem = |bytes: &[u8]| ply::parse(Path::new("m.ply"), bytes, true).expect_err("a wrong PLY").to_string();
    let found = problem(ascii.replacen("4 0 3 2 1", "4 0 3 2 8", 1).as_bytes());
    assert!(found.starts_with("m.ply:24: face 0 names vertex 8, the file has 8"), "{found}");
    let found = problem(ascii.replacen("4 0 3 2 1", "4 0 3 x 1", 1).as_bytes());
    assert!(found.starts_with("m.ply:24: not a sound PLY file"), "{found}");
    let mut binary = cube_ply(Encoding::BinaryLittleEndian);
    binary.truncate(binary.len() - 5);
    let found = problem(&binary);
    assert!(found.starts_with("m.ply: ") && found.contains("at byte"), "{found}");
    let mut binary = cube_ply(Encoding::BinaryLittleEndian);
    // The last face takes 17 bytes, the six of them 102; the last vertex's 33 bytes stand before them, x first.
    let x = binary.len() - 102 - 33;
    binary[x..x + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    let found = problem(&binary);
    assert!(found.starts_with("m.ply: vertex 7 has a coordinate that is not finite"), "{found}");
    let found = problem(b"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n");
    assert!(found.contains("no element `face`"), "{found}");
}

/// A wavy sheet of 2·`side`² triangles as OBJ and as PLY: more rows than are read at a time.
fn sheet(side: u32) -> (String, String) {
    use std::fmt::Write as _;
    let at = |i: u32, j: u32| (i as f32 / side as f32, j as f32 / side as f32, (0.37 * (i * 7 + j * 3) as f32).sin());
    let corners = |i: u32, j: u32| [i, i + 1].map(|i| [j, j + 1].map(|j| i * (side + 1) + j));
    let (mut obj, mut rows) = (String::new(), String::new());
    for (i, j) in (0..=side).flat_map(|i| (0..=side).map(move |j| (i, j))) {
        let (x, y, z) = at(i, j);
        writeln!(obj, "v {x} {y} {z}").expect("text");
        writeln!(rows, "{x} {y} {z}").expect("text");
    }
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        let [[a, b], [d, c]] = corners(i, j);
        for [a, b, c] in [[a, b, c], [a, c, d]] {
            writeln!(obj, "f {} {} {}", a + 1, b + 1, c + 1).expect("text");
            writeln!(rows, "3 {a} {b} {c}").expect("text");
        }
    }
    let (vertices, faces) = ((side + 1).pow(2), 2 * side.pow(2));
    let header = format!(
        "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    );
    (obj, header + &rows)
}

#[test]
fn a_ply_of_many_rows_is_the_obj_of_as_many_lines() {
    let side = 300;
    let (obj, rows) = sheet(side);
    let vertices = (side + 1).pow(2) as usize;
    let expected = read_obj(&obj);
    let file = ply::parse(Path::new("sheet.ply"), rows.as_bytes(), true).expect("a sound PLY");
    // An OBJ's vertices come in the order of their first use.
    let corners = |mesh: &TriangleMesh| -> Vec<_> { (0..2 * side.pow(2)).map(|i| mesh.corners(i)).collect() };
    assert_eq!(file.mesh.positions.len(), vertices);
    assert_eq!(file.mesh.triangles.len(), expected.mesh.triangles.len());
    assert_eq!(corners(&file.mesh), corners(&expected.mesh));
    let lines: Vec<u32> = expected.triangle_lines.iter().map(|line| line + 9).collect();
    assert_eq!(file.triangle_lines, lines, "nine lines of header before them");

    // What is wrong far down is found where it stands.
    let wrong = |line: usize, with: &str| {
        let mut lines: Vec<&str> = rows.lines().collect();
        lines[line - 1] = with;
        let text = lines.join("\n") + "\n";
        ply::parse(Path::new("sheet.ply"), text.as_bytes(), true).expect_err("a wrong PLY").to_string()
    };
    let last = 9 + vertices + 2 * side.pow(2) as usize;
    assert_eq!(rows.lines().count(), last);
    let found = wrong(last, "3 0 1 900000");
    let face = 2 * side.pow(2) - 1;
    assert!(found.starts_with(&format!("sheet.ply:{last}: face {face} names vertex 900000")), "{found}");
    let found = wrong(9 + 80_000, "0 0 x");
    assert!(found.starts_with(&format!("sheet.ply:{}: not a sound PLY file", 9 + 80_000)), "{found}");
}

/// A scene of one mesh.
fn scene_of(file: &str, more: &str) -> String {
    format!(
        "format = 1\n[camera]\ntype = \"perspective\"\nposition = [0, 1, 5]\ntarget = [0, 0, 0]\nfov_degrees = 40\n\
         resolution = [8, 8]\n[materials.glass]\ntype = \"dielectric\"\nior = 1.5\n[[objects]]\nshape = \"mesh\"\n\
         file = \"{file}\"\n{more}\n[[lights]]\ntype = \"point\"\nposition = [0, 9, 0]\nintensity = 1\n"
    )
}

#[test]
fn angle_weighted_normals_do_not_depend_on_how_faces_are_cut() {
    let cube = read_obj(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
         f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n",
    );
    let third = 1.0 / 3.0_f64.sqrt();
    let mesh: &TriangleMesh = &cube.mesh;
    for (normal, position) in mesh.angle_weighted_normals().iter().zip(&mesh.positions) {
        for (n, p) in normal.iter().zip(position) {
            assert!((f64::from(*n) - (2.0 * f64::from(*p) - 1.0) * third).abs() < 1e-7, "{normal:?} at {position:?}");
        }
    }
    assert!((mesh.signed_volume() - 1.0).abs() < 1e-15);
    assert!((mesh.area() - 6.0).abs() < 1e-15);
}

#[test]
fn a_sheet_seen_from_both_sides_keeps_a_normal() {
    let sheet = read_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n");
    assert_eq!(sheet.mesh.angle_weighted_normals(), [[0.0, 0.0, 1.0]; 3]);
}

#[test]
fn an_obj_brings_its_materials_along() {
    let folder = root().join("tests/corpus/valid");
    let path = folder.join("materials.toml");
    let loaded = load_text(&path, &scene_of("two_materials.obj", ""), &[]).unwrap_or_else(|p| panic!("{p}"));
    let scene = loaded.scene;
    assert_eq!(scene.objects.len(), 2);
    let material = |i: usize| &scene.materials[scene.objects[i].material.index()];
    assert_eq!(*material(0), Material::Dielectric { ior: 1.33, exterior: 1.0, fresnel: true });
    assert!(matches!(material(1), Material::Lambert { .. }), "{:?}", material(1));
    assert_eq!(scene.objects[0].name, "object 0/two_materials.obj:water");
    assert_eq!(scene.meshes[1].triangles.len(), 2);
    // With a material of its own the object is one mesh again.
    let whole = load_text(&path, &scene_of("two_materials.obj", "material = \"glass\""), &[]).expect("sound").scene;
    assert_eq!(whole.objects.len(), 1);
    assert_eq!(whole.meshes[0].triangles.len(), 14);
}

#[test]
fn open_and_inverted_glass_is_warned_about() {
    let folder = root().join("tests/corpus/valid");
    let warnings = |file: &str| -> Vec<String> {
        let text = scene_of(file, "name = \"it\"\nmaterial = \"glass\"");
        let loaded = load_text(&folder.join("s.toml"), &text, &[]).unwrap_or_else(|p| panic!("{p}"));
        loaded.warnings.iter().map(ToString::to_string).collect()
    };
    assert_eq!(warnings("cube.obj"), Vec::<String>::new());
    let open = warnings("open_cube.obj");
    assert!(open.len() == 1 && open[0].contains("the dielectric `it` is not closed: 4 edges"), "{open:?}");
    let inverted = warnings("inverted_cube.ply");
    assert!(inverted.len() == 1 && inverted[0].contains("is inside out"), "{inverted:?}");
    let degenerate = warnings("degenerate_cube.obj");
    let expected = "1 degenerate triangle without area is left out, the first is triangle 12";
    assert!(degenerate[0].contains(expected) && degenerate[0].contains("degenerate_cube.obj:16"), "{degenerate:?}");
}

#[test]
fn images_are_decoded_to_linear_light() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let memory = TextureMemory::default();
    let png = dir.path().join("a.png");
    ::image::RgbImage::from_fn(2, 1, |x, _| ::image::Rgb([255 * x as u8, 128, 0])).save(&png).expect("written");
    let srgb = image::read(&png, None, Wrap::Repeat, &memory).expect("a PNG");
    assert_eq!((srgb.texels.width(), srgb.texels.height()), (2, 1));
    // 128/255 on the sRGB curve.
    assert!((srgb.texels.texel(1)[1] - 0.215_860_5).abs() < 1e-6, "{:?}", srgb.texels);
    assert_eq!((srgb.texels.texel(0)[0], srgb.texels.texel(1)[0]), (0.0, 1.0));
    let linear = image::read(&png, Some(ColourSpace::Linear), Wrap::Repeat, &memory).expect("a PNG");
    assert_eq!(linear.texels.texel(1)[1], 128.0 / 255.0);

    let exr = dir.path().join("a.exr");
    exr::prelude::write_rgb_file(&exr, 3, 2, |x, y| (x as f32, y as f32, 0.25)).expect("written");
    let read = image::read(&exr, None, Wrap::Clamp, &memory).expect("an EXR");
    assert_eq!((read.texels.width(), read.texels.height()), (3, 2));
    assert_eq!(read.texels.texel(3 + 2), [2.0, 1.0, 0.25]);

    for file in [&png, &exr] {
        let bytes = std::fs::read(file).expect("read");
        std::fs::write(file, &bytes[..bytes.len() / 2]).expect("written");
        let problem = image::read(file, None, Wrap::Repeat, &memory).expect_err("truncated").to_string();
        assert!(problem.contains(&format!("{}: cannot use the image", file.display())), "{problem}");
    }
}

#[test]
fn the_shared_meshes_load() {
    // Vertices and triangles as counted with grep in the files.
    for name in ["fandisk", "rocker-arm", "spot", "stanford-bunny", "suzanne", "teapot"] {
        let Some(path) = shared(&format!("meshes/{name}.obj")) else { return };
        let text = std::fs::read_to_string(&path).expect("readable");
        let corners = |line: &str| line.split_whitespace().count() - 1;
        let triangles: usize = text.lines().filter(|l| l.starts_with("f ")).map(|l| corners(l) - 2).sum();
        let file = obj::read(&path, ALL).unwrap_or_else(|p| panic!("{name}: {p}"));
        assert_eq!(file.mesh.triangles.len(), triangles, "{name}");
        assert_eq!(file.triangle_lines.len(), triangles, "{name}");
        assert!(file.mesh.area() > 0.0);
    }
}
