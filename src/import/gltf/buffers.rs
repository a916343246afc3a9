//! The bytes that accessors and images lie in.

use std::borrow::Cow;
use std::path::Path;

use gltf::{Buffer, Document, buffer};

use super::uri::{Resource, resolve};
use crate::import::{MAX_MESH_BYTES, read_bytes};
use crate::scene::error::{Problem, Source};

/// All buffers of a file, each at least as long as the file says.
pub(super) struct Buffers<'b>(Vec<Cow<'b, [u8]>>);

impl<'b> Buffers<'b> {
    pub fn load(
        document: &Document,
        blob: Option<&'b [u8]>,
        folder: &Path,
        source: &Source,
    ) -> Result<Buffers<'b>, Problem> {
        let load = |buffer: Buffer<'_>| {
            let bytes = content(&buffer, blob, folder).map_err(|problem| {
                let message = format!("buffers[{}]: {}", buffer.index(), problem.message);
                Problem { message, ..problem }.at_unless_placed(source)
            })?;
            if bytes.len() < buffer.length() {
                let (index, length, there) = (buffer.index(), buffer.length(), bytes.len());
                let message = format!("buffers[{index}] should have {length} bytes, but there are {there}");
                return Err(Problem::new(message).help("is its file truncated?").at(source));
            }
            Ok(bytes)
        };
        document.buffers().map(load).collect::<Result<_, _>>().map(Buffers)
    }

    pub fn of(&self, buffer: &Buffer<'_>) -> Option<&[u8]> {
        self.0.get(buffer.index()).map(AsRef::as_ref)
    }

    /// The bytes of a view, `None` if it reaches out of its buffer.
    pub fn view(&self, view: &buffer::View<'_>) -> Option<&[u8]> {
        let end = view.offset().checked_add(view.length())?;
        self.of(&view.buffer())?.get(view.offset()..end)
    }

    /// Of all buffers together.
    pub fn total_bytes(&self) -> usize {
        self.0.iter().map(|bytes| bytes.len()).sum()
    }
}

fn content<'b>(buffer: &Buffer<'_>, blob: Option<&'b [u8]>, folder: &Path) -> Result<Cow<'b, [u8]>, Problem> {
    match buffer.source() {
        buffer::Source::Bin => match blob {
            Some(blob) if buffer.index() == 0 => Ok(Cow::Borrowed(blob)),
            _ => Err(Problem::new("it has no `uri`, and the file no binary chunk for it")),
        },
        buffer::Source::Uri(uri) => match resolve(uri, folder).map_err(Problem::new)? {
            Resource::Embedded(bytes) => Ok(Cow::Owned(bytes)),
            Resource::File(path) => read_bytes(&path, MAX_MESH_BYTES).map(Cow::Owned),
        },
    }
}
