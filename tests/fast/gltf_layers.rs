//! `KHR_materials_specular`, `KHR_materials_clearcoat` and `KHR_materials_dispersion` of glTF files.

use std::path::Path;

use serde_json::{Value, json};

use pdembree::import::gltf::parse;
use pdembree::import::imported::Imported;
use pdembree::scene::description::{CoatDescription, MaterialModel, Parameter, SpecularDescription};
use pdembree::scene::error::Problems;

use crate::support::gltf::Gltf;

/// One pixel: red 255, green 51, blue 0, alpha 102.
fn pixel() -> Value {
    use base64::Engine;
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(1, 1, image::Rgba([255, 51, 0, 102]))
        .write_to(&mut png, image::ImageFormat::Png)
        .expect("a picture");
    let code = base64::engine::general_purpose::STANDARD.encode(png.into_inner());
    json!({"uri": format!("data:image/png;base64,{code}")})
}

fn with(extensions: &Value) -> Result<Imported, Problems> {
    let used: Vec<&String> = extensions.as_object().expect("extensions").keys().collect();
    let mut file = Gltf::triangle()
        .set("/extensionsUsed", json!(used))
        .set("/materials", json!([{"extensions": extensions}]))
        .set("/meshes/0/primitives/0/material", json!(0));
    file.push("textures", json!({"source": 0}));
    file.push("images", pixel());
    parse(Path::new("t.gltf"), &file.text())
}

fn layers(extensions: &Value) -> (Option<SpecularDescription>, Option<CoatDescription>, Imported) {
    let scene = with(extensions).unwrap_or_else(|problems| panic!("{problems}"));
    let MaterialModel::Principled { specular, coat, .. } = scene.materials[0].model else { panic!("another model") };
    (specular, coat, scene)
}

#[test]
fn specular_and_clearcoat_are_layers_of_the_principled_material() {
    let (specular, coat, scene) = layers(&json!({
        "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [2.0, 1.0, 0.25]},
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.75, "clearcoatRoughnessFactor": 0.25},
    }));
    let colour = Parameter::Constant([2.0, 1.0, 0.25]);
    assert_eq!(specular, Some(SpecularDescription { weight: Parameter::Constant(0.5), colour }));
    let (weight, roughness) = (Parameter::Constant(0.75), Parameter::Constant(0.25));
    assert_eq!(coat, Some(CoatDescription { weight, roughness, ior: 1.5 }));
    assert!(!scene.warnings.iter().any(|w| w.to_string().contains("KHR_")), "{:?}", scene.warnings);
    // What says nothing changes nothing.
    let (specular, coat, _) =
        layers(&json!({"KHR_materials_specular": {}, "KHR_materials_clearcoat": {"clearcoatRoughnessFactor": 0.5}}));
    assert_eq!((specular, coat), (None, None));
}

/// Strength of the reflectance in alpha, of the coat in red, its roughness in green.
#[test]
fn their_images_are_read_from_the_formats_channels() {
    let (specular, coat, scene) = layers(&json!({
        "KHR_materials_specular": {"specularTexture": {"index": 0}},
        "KHR_materials_clearcoat": {
            "clearcoatFactor": 0.5, "clearcoatTexture": {"index": 0},
            "clearcoatRoughnessFactor": 1.0, "clearcoatRoughnessTexture": {"index": 0},
            "clearcoatNormalTexture": {"index": 0},
        },
    }));
    let (specular, coat) = (specular.expect("specular"), coat.expect("a coat"));
    for (parameter, factor, texel) in [(specular.weight, 1.0, 0.4), (coat.weight, 0.5, 1.0), (coat.roughness, 1.0, 0.2)]
    {
        let Parameter::Image { texture, factor: found } = parameter else { panic!("{parameter:?}") };
        assert_eq!(found, factor);
        let [red, ..] = scene.textures[texture].image.texels.texel(0);
        assert!((red - texel).abs() < 1e-6, "{red}, not {texel}");
    }
    let warning = scene.warnings[0].to_string();
    assert!(warning.contains("clearcoatNormalTexture"), "{warning}");
}

#[test]
fn an_image_that_is_not_there_is_an_error_and_dispersion_of_glass_is_listed() {
    let coat = json!({"KHR_materials_clearcoat": {"clearcoatFactor": 1.0, "clearcoatTexture": {"index": 7}}});
    let said = with(&coat).map(drop).expect_err("no such texture").to_string();
    assert!(said.contains("names the texture 7"), "{said}");
    let glass = |dispersion: f64| {
        let (_, _, scene) = layers(&json!({
            "KHR_materials_transmission": {"transmissionFactor": 1.0},
            "KHR_materials_dispersion": {"dispersion": dispersion},
        }));
        scene.warnings.iter().map(ToString::to_string).collect::<String>()
    };
    assert!(glass(0.5).contains("KHR_materials_dispersion (read, but one index for all colours)"));
    assert!(!glass(0.0).contains("KHR_materials_dispersion"));
}
