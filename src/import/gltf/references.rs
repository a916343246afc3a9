//! What the crate's own validation takes for granted, and panics without: checked before it.

use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;
use gltf::json::{Root, image, mesh};

/// The first place that refers to something which is not there, and what is wrong with it.
pub(super) fn check(root: &Root) -> Result<(), String> {
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            if !positions_are_there(primitive, root) {
                return Err(missing(&format!("meshes[{m}].primitives[{p}].attributes.POSITION")));
            }
        }
    }
    if let Some(i) = root.textures.iter().position(|texture| texture.source.value() >= root.images.len()) {
        return Err(missing(&format!("textures[{i}].source")));
    }
    let lights = root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()).map_or(0, |e| e.lights.len());
    let light = |i: usize| root.nodes[i].extensions.as_ref()?.khr_lights_punctual.as_ref().map(|e| e.light.value());
    if let Some(i) = (0..root.nodes.len()).find(|i| light(*i).is_some_and(|light| light >= lights)) {
        return Err(missing(&format!("nodes[{i}].extensions.KHR_lights_punctual.light")));
    }
    match root.images.iter().position(|image| !is_complete(image)) {
        Some(i) => Err(format!("`images[{i}]` needs a `uri`, or a `bufferView` with its `mimeType`")),
        None => Ok(()),
    }
}

fn missing(place: &str) -> String {
    format!("`{place}` names something that is not in the file")
}

/// Primitives without positions are found later.
fn positions_are_there(primitive: &mesh::Primitive, root: &Root) -> bool {
    let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
    positions.is_none_or(|index| index.value() < root.accessors.len())
}

fn is_complete(image: &image::Image) -> bool {
    if image.buffer_view.is_some() { image.mime_type.is_some() } else { image.uri.is_some() }
}
