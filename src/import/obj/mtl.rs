//! MTL: what an OBJ's materials mean here. Parsed by `tobj`, after a scan that finds wrong lines, which it cannot name.

use std::io::Cursor;
use std::path::Path;

use crate::import::mesh_file::{MeshMaterial, MeshMaterialModel};
use crate::import::read_bytes;
use crate::scene::error::{Problem, Problems, Source};

/// Bytes of a material library.
const MAX_BYTES: u64 = 16 << 20;
/// Index of refraction of a glass that does not state its own.
const GLASS: f64 = 1.5;
/// Roughness of a metal that does not state its own.
const METAL_ROUGHNESS: f64 = 0.3;

/// Reads a library in tobj's form and in ours, materials in the same order.
///
/// # Errors
/// A library that cannot be read, or what is wrong in it with the line.
pub(super) fn read(path: &Path, used_at: &Source) -> Result<(tobj::MTLLoadResult, Vec<MeshMaterial>), Problems> {
    let bytes = read_bytes(path, MAX_BYTES).map_err(|problem| problem.at_unless_placed(used_at))?;
    parse(path, &String::from_utf8_lossy(&bytes))
}

fn parse(path: &Path, text: &str) -> Result<(tobj::MTLLoadResult, Vec<MeshMaterial>), Problems> {
    let source = Source::file(path);
    let named_at = scan(text, &source)?;
    let (materials, index) = tobj::load_mtl_buf(&mut Cursor::new(text.as_bytes()))
        .map_err(|error| Problem::new(format!("cannot read the materials: {error}")).at(&source))?;
    let described = materials.iter().enumerate().map(|(i, material)| MeshMaterial {
        name: material.name.clone(),
        source: named_at.get(i).map_or(source.clone(), |&line| source.at_line(line)),
        model: model(material),
    });
    let described = described.collect();
    Ok((Ok((materials, index)), described))
}

/// The lines of the `newmtl`s, after checking the numbers of what is read.
fn scan(text: &str, source: &Source) -> Result<Vec<u32>, Problems> {
    let mut problems = Problems::default();
    let mut named_at = Vec::new();
    for (line, number) in text.lines().zip(1_u32..) {
        let mut words = line.split_whitespace();
        let Some(key) = words.next() else { continue };
        let needed = match key {
            "newmtl" => {
                named_at.push(number);
                0
            }
            "Ka" | "Kd" | "Ks" | "Ke" => 3,
            "Ns" | "Ni" | "d" | "Pr" | "Pm" => 1,
            "illum" => 1,
            _ => continue,
        };
        let finite = |word: &&str| word.parse::<f32>().is_ok_and(f32::is_finite);
        let sound = match key {
            "newmtl" => words.next().is_some(),
            "illum" => words.next().is_some_and(|word| word.parse::<u8>().is_ok()),
            _ => words.by_ref().take(needed).filter(finite).count() == needed,
        };
        if !sound {
            let expected = match key {
                "newmtl" => "a name".to_owned(),
                "illum" => "an integer from 0 to 10".to_owned(),
                _ if needed == 1 => "a finite number".to_owned(),
                _ => format!("{needed} finite numbers"),
            };
            let problem = Problem::new(format!("`{key}` needs {expected}"));
            problems.push(problem.at(&source.at_line(number)));
        }
    }
    problems.into_result(named_at)
}

/// See the table in [`crate::doc::scene_format`].
fn model(material: &tobj::Material) -> MeshMaterialModel {
    let colour = |c: Option<[f32; 3]>| c.map(|c| c.map(decimal));
    let parameter = |name: &str| material.unknown_param.get(name).and_then(|text| text.parse::<f64>().ok());
    let diffuse = colour(material.diffuse);
    let roughness = parameter("Pr").map(|r| r.clamp(0.0, 1.0));
    if let Some(4 | 6 | 7 | 9) = material.illumination_model {
        let ior = material.optical_density.map(decimal).filter(|n| *n > 1.0).unwrap_or(GLASS);
        return match roughness {
            Some(roughness) if roughness > 0.0 => MeshMaterialModel::RoughDielectric { ior, roughness },
            _ => MeshMaterialModel::Dielectric { ior },
        };
    }
    if parameter("Pm").is_some_and(|metallic| metallic >= 0.5) {
        let roughness = roughness.filter(|r| *r > 0.0).unwrap_or(METAL_ROUGHNESS);
        return MeshMaterialModel::Metal { reflectance: diffuse.unwrap_or([1.0; 3]), roughness };
    }
    let specular = colour(material.specular).filter(|ks| *ks != [0.0; 3]);
    if let (Some(3 | 5 | 8), Some(reflectance)) = (material.illumination_model, specular) {
        return MeshMaterialModel::Mirror { reflectance };
    }
    // Options of the map, as "-s 2 2 2", stand before the file's name.
    let file = |map: &String| {
        if map.starts_with('-') { map.split_whitespace().last().map(str::to_owned) } else { Some(map.clone()) }
    };
    let image = material.diffuse_texture.as_ref().and_then(file);
    let default = if image.is_some() { [1.0; 3] } else { [0.8; 3] };
    MeshMaterialModel::Lambert { albedo: diffuse.unwrap_or(default), image }
}

/// The number that was written: 0.8 rather than the nearest single-precision number to it.
fn decimal(x: f32) -> f64 {
    x.to_string().parse().unwrap_or_else(|_| f64::from(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn models(text: &str) -> Vec<(String, MeshMaterialModel)> {
        let (_, materials) = parse(Path::new("m.mtl"), text).expect("sound materials");
        materials.into_iter().map(|m| (format!("{}@{}", m.name, m.source.line), m.model)).collect()
    }

    #[test]
    fn each_kind_of_material_finds_its_model() {
        let text = "newmtl glass\nNi 1.33\nillum 7\nKd 1 1 1\n\nnewmtl mirror\nKs 0.9 0.9 0.8\nillum 3\n\
                    newmtl wood\nKd 0.8 0.7 0.6\nmap_Kd -s 1 1 1 wood.png\nnewmtl gold\nKd 1 0.8 0.3\nPm 1\nPr 0.2\n\
                    newmtl grey\nKd 0.5 0.5 0.5\nillum 2\nnewmtl frosted\nillum 4\nPr 0.4\n";
        let expected = [
            ("glass@1", MeshMaterialModel::Dielectric { ior: 1.33 }),
            ("mirror@6", MeshMaterialModel::Mirror { reflectance: [0.9, 0.9, 0.8] }),
            ("wood@9", MeshMaterialModel::Lambert { albedo: [0.8, 0.7, 0.6], image: Some("wood.png".to_owned()) }),
            ("gold@12", MeshMaterialModel::Metal { reflectance: [1.0, 0.8, 0.3], roughness: 0.2 }),
            ("grey@16", MeshMaterialModel::Lambert { albedo: [0.5; 3], image: None }),
            ("frosted@19", MeshMaterialModel::RoughDielectric { ior: 1.5, roughness: 0.4 }),
        ];
        assert_eq!(models(text), expected.map(|(name, model)| (name.to_owned(), model)));
    }

    #[test]
    fn wrong_numbers_name_their_line() {
        let problems = parse(Path::new("m.mtl"), "newmtl a\nKd 1 x 0\nNi nan\nillum glass\n").expect_err("wrong");
        let lines: Vec<String> = problems.iter().map(ToString::to_string).collect();
        let expected = [
            "m.mtl:2: `Kd` needs 3 finite numbers",
            "m.mtl:3: `Ni` needs a finite number",
            "m.mtl:4: `illum` needs an integer from 0 to 10",
        ];
        assert_eq!(lines, expected);
    }
}
