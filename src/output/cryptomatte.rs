//! What tells compositing programs that channels are mattes, and which name each id stands for `[Friedman15]`.

use super::channel_names::ChannelNames;
use super::exr::Attributes;
use crate::film::Layout;
use crate::film::matte::{self, Matte};

/// The attributes of all of a film's mattes, with their full names.
pub fn attributes(layout: &Layout, names: ChannelNames) -> Attributes {
    let mut all: Attributes = layout.mattes().iter().flat_map(|matte| of_matte(matte, names)).collect();
    all.sort();
    all
}

fn of_matte(matte: &Matte, names: ChannelNames) -> [(String, String); 4] {
    let name = names.of_layer(matte.subject.name());
    // The first seven digits of the layer's own id.
    let key = format!("{:08x}", matte::murmur3(name.as_bytes()))[..7].to_owned();
    let attribute = |what: &str, value: String| (format!("cryptomatte/{key}/{what}"), value);
    [
        attribute("name", name),
        attribute("hash", "MurmurHash3_32".to_owned()),
        attribute("conversion", "uint32_to_float32".to_owned()),
        attribute("manifest", manifest(&matte.names)),
    ]
}

/// A JSON object from names to ids of eight hexadecimal digits, in ASCII: headers hold Latin-1.
fn manifest(names: &[String]) -> String {
    let ids = names.iter().map(|name| (name.clone(), format!("{:08x}", matte::id(name)).into()));
    let json = serde_json::Value::Object(ids.collect()).to_string();
    let escaped = |c: char| match c.is_ascii() {
        true => c.to_string(),
        false => c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")).collect(),
    };
    json.chars().map(escaped).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_manifest_is_ascii_json_that_keeps_names() {
        let names = ["a \"b\"".to_owned(), "Glas für 水 🝆".to_owned()];
        let text = manifest(&names);
        assert!(text.is_ascii(), "{text}");
        let read: std::collections::BTreeMap<String, String> = serde_json::from_str(&text).expect("JSON");
        for name in names {
            assert_eq!(read[&name], format!("{:08x}", matte::id(&name)));
        }
    }
}
