//! glTF files put together by hand.

use base64::Engine;
use serde_json::{Value, json};

/// A document with one buffer; what is added first has the first index.
pub struct Gltf {
    pub json: Value,
    pub bytes: Vec<u8>,
}

/// The codes of component types.
pub const U8: u32 = 5121;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

pub fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Indices of the given component type.
pub fn indices(kind: u32, values: &[u32]) -> Vec<u8> {
    let width = match kind {
        U8 => 1,
        U16 => 2,
        _ => 4,
    };
    values.iter().flat_map(|i| i.to_le_bytes()[..width].to_vec()).collect()
}

impl Gltf {
    pub fn new() -> Gltf {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [], "accessors": [], "bufferViews": [],
        });
        Gltf { json, bytes: Vec::new() }
    }

    /// The triangle (0, 0, 0), (1, 0, 0), (0, 1, 0), which faces +z, with texture coordinates (x, y).
    pub fn triangle() -> Gltf {
        let mut file = Gltf::new();
        let positions = file.accessor("VEC3", F32, 3, &floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
        let uvs = file.accessor("VEC2", F32, 3, &floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]));
        file.push("meshes", json!({"primitives": [{"attributes": {"POSITION": positions, "TEXCOORD_0": uvs}}]}));
        file
    }

    pub fn push(&mut self, list: &str, item: Value) -> usize {
        let items = &mut self.json[list];
        if items.is_null() {
            *items = json!([]);
        }
        let items = items.as_array_mut().expect("a list");
        items.push(item);
        items.len() - 1
    }

    pub fn view(&mut self, data: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(data);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": data.len()}))
    }

    pub fn accessor(&mut self, dimensions: &str, component: u32, count: usize, data: &[u8]) -> usize {
        let view = self.view(data);
        let accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": dimensions});
        self.push("accessors", accessor)
    }

    /// The value at a JSON pointer, made where it is not.
    pub fn set(mut self, pointer: &str, value: Value) -> Gltf {
        let mut place = &mut self.json;
        for key in pointer.split('/').skip(1) {
            place = match key.parse::<usize>() {
                Ok(index) => &mut place[index],
                Err(_) => &mut place[key],
            };
        }
        *place = value;
        self
    }

    /// As text, the buffer at `uri`.
    pub fn text_with(&self, uri: &str) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"].is_null() {
            json["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        }
        json.to_string().into_bytes()
    }

    /// As text, the buffer within.
    pub fn text(&self) -> Vec<u8> {
        let encoded = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
        self.text_with(&format!("data:application/octet-stream;base64,{encoded}"))
    }

    /// As a binary container.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + text.len() + 8 + self.bytes.len();
        let mut file = b"glTF".to_vec();
        for word in [2, length as u32, text.len() as u32] {
            file.extend(word.to_le_bytes());
        }
        file.extend(b"JSON");
        file.extend(&text);
        file.extend((self.bytes.len() as u32).to_le_bytes());
        file.extend(b"BIN\0");
        file.extend(&self.bytes);
        file
    }
}
