//! Where a buffer or an image is: beside the file, or in the address itself (RFC 2397, RFC 3986 2.1).

use std::path::{Path, PathBuf};

use base64::Engine;

pub(super) enum Resource {
    Embedded(Vec<u8>),
    File(PathBuf),
}

/// What `uri` names, relative names being those of files in `folder`.
pub(super) fn resolve(uri: &str, folder: &Path) -> Result<Resource, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
        let encoded = encoded.ok_or("embedded data must be base64")?;
        let decoded = base64::engine::general_purpose::STANDARD.decode(encoded);
        return decoded.map(Resource::Embedded).map_err(|error| format!("broken base64: {error}"));
    }
    if uri.contains("://") {
        return Err(format!("`{}` is no file beside this one", shortened(uri)));
    }
    let name = percent_decoded(uri).ok_or_else(|| format!("`{}` is no name of a file", shortened(uri)))?;
    Ok(Resource::File(folder.join(name)))
}

fn shortened(uri: &str) -> String {
    uri.chars().take(100).collect()
}

/// `None` for a % without two hexadecimal digits, or bytes that are no UTF-8.
fn percent_decoded(text: &str) -> Option<String> {
    let mut parts = text.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        let (digits, rest) = part.split_at_checked(2)?;
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        bytes.extend_from_slice(rest.as_bytes());
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_decoded_and_other_places_refused() {
        let folder = Path::new("f");
        let file = |uri| match resolve(uri, folder) {
            Ok(Resource::File(path)) => Some(path.to_string_lossy().into_owned()),
            _ => None,
        };
        assert_eq!(file("a%20b.png").as_deref(), Some("f/a b.png"));
        assert_eq!(file("%C3%A9.bin").as_deref(), Some("f/é.bin"));
        assert_eq!(file("a%2"), None);
        assert_eq!(file("a%zz"), None);
        assert_eq!(file("https://example.org/a.bin"), None);
        let Ok(Resource::Embedded(bytes)) = resolve("data:application/octet-stream;base64,AQID", folder) else {
            panic!("embedded")
        };
        assert_eq!(bytes, [1, 2, 3]);
        assert!(resolve("data:text/plain,abc", folder).is_err());
        assert!(resolve("data:;base64,A", folder).is_err());
    }
}
