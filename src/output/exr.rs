//! OpenEXR: one flat part, scan lines, ZIP, 32-bit floats, linear Rec.709 said in `chromaticities`.
//!
//! Channels keep their names: `R G B A` in no layer, `caustic.R` in the layer `caustic`. Many programs read only the first part
//! of a file, so there is one.

use std::io::Cursor;
use std::path::Path;

use exr::image::read::read;
use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Layer};
use exr::meta::attribute::{AttributeValue, Chromaticities, IntegerBounds, LineOrder, Text};
use exr::meta::header::LayerAttributes;
use exr::prelude::{Compression, ReadChannels, ReadLayers, SmallVec, Vec2};

use super::atomic;
use super::channel_names::ChannelNames;
use super::error::{ReadError, WriteError};
use crate::film::{Channel, Image};

/// Text attributes of a file, name and value, in the order of their names.
pub type Attributes = Vec<(String, String)>;

/// Rec.709 primaries and the D65 white, CIE 1931 x and y `[BT709]`.
const REC709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

/// Where the pixels of a file lie in the whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Of the top left pixel, from the picture's corner.
    pub origin: [u32; 2],
    /// Width and height of the whole picture.
    pub whole: [u32; 2],
}

/// Writes `image` with `attributes` (their names get the prefix `pdembree/`), whole or not at all.
pub fn write(path: &Path, image: &Image, attributes: &[(String, String)]) -> Result<(), WriteError> {
    write_window(path, image, Window { origin: [0, 0], whole: [image.width, image.height] }, attributes)
}

/// Writes a part of a picture: the data window is the part, the display window the whole, so that tools that assemble
/// pictures know its place.
pub fn write_window(
    path: &Path,
    image: &Image,
    window: Window,
    attributes: &[(String, String)],
) -> Result<(), WriteError> {
    write_named(path, image, window, attributes, (ChannelNames::Own, &[]))
}

/// The same with other names of the channels, and with attributes that keep their names.
pub fn write_named(
    path: &Path,
    image: &Image,
    window: Window,
    attributes: &[(String, String)],
    (names, verbatim): (ChannelNames, &[(String, String)]),
) -> Result<(), WriteError> {
    let unfit = |reason: String| WriteError::Unfit { path: path.to_owned(), reason };
    let own = attributes.iter().map(|(name, value)| (format!("pdembree/{name}"), value.clone()));
    let attributes: Attributes = own.chain(verbatim.iter().cloned()).collect();
    let bytes = encode(image, names, window, &attributes).map_err(unfit)?;
    atomic::write(path, &bytes)
}

fn encode(
    image: &Image,
    names: ChannelNames,
    window: Window,
    attributes: &[(String, String)],
) -> Result<Vec<u8>, String> {
    let text = |s: &str| Text::new_or_none(s).ok_or_else(|| format!("{s:?} is no Latin-1 text"));
    let far = |_| "the picture has more pixels than 31 bits can count".to_owned();
    let mut channels = SmallVec::new();
    for Channel { name, samples } in &image.channels {
        if samples.len() != image.pixels() {
            return Err(format!("channel {name} has {} samples for {} pixels", samples.len(), image.pixels()));
        }
        channels.push(AnyChannel::new(text(&names.of_channel(name))?, FlatSamples::F32(samples.clone())));
    }
    let [x, y] = window.origin.map(|v| i32::try_from(v).map_err(far));
    let mut own = LayerAttributes { layer_position: Vec2(x?, y?), ..LayerAttributes::default() };
    // Other programs spell this name with a capital, unlike the crate's own field.
    let software = concat!("pdembree ", env!("CARGO_PKG_VERSION"));
    own.other.insert(text("Software")?, AttributeValue::Text(text(software)?));
    for (name, value) in attributes {
        // A path in a command line may hold any letter; the header's Latin-1 gets an escape for it.
        let value = Text::new_or_none(value).map_or_else(|| text(&value.escape_unicode().to_string()), Ok)?;
        own.other.insert(text(name)?, AttributeValue::Text(value));
    }
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let size = Vec2(image.width as usize, image.height as usize);
    let layer = Layer::new(size, own, encoding, AnyChannels::sort(channels));
    let mut file = exr::image::Image::from_layer(layer);
    let [width, height] = window.whole.map(|side| side as usize);
    file.attributes.display_window = IntegerBounds::from_dimensions(Vec2(width, height));
    file.attributes.chromaticities = Some(REC709);
    let mut bytes = Cursor::new(Vec::new());
    file.write().to_buffered(&mut bytes).map_err(|e| e.to_string())?;
    let bytes = bytes.into_inner();
    Ok(with_sorted_header(&bytes).unwrap_or(bytes))
}

/// The same file with its header's attributes in the order of their names. The crate writes them in the random order
/// of a hash map, and equal pictures shall be equal files. `None`: the bytes are no EXR of one part.
///
/// A header is a run of attributes (name, 0, type, 0, length as little-endian `i32`, value) ended by a 0 `[OpenEXR-layout]`; it
/// keeps its length, so the offsets after it stay right.
fn with_sorted_header(bytes: &[u8]) -> Option<Vec<u8>> {
    /// Magic number and version.
    const START: usize = 8;
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut rest = bytes.get(START..)?;
    while *rest.first()? != 0 {
        let name = rest.iter().position(|&b| b == 0)? + 1;
        let kind = rest.get(name..)?.iter().position(|&b| b == 0)? + 1;
        let value = rest.get(name + kind..)?;
        let length = i32::from_le_bytes(*value.first_chunk()?);
        let (attribute, after) = rest.split_at_checked(name + kind + 4 + usize::try_from(length).ok()?)?;
        attributes.push(attribute);
        rest = after;
    }
    attributes.sort();
    Some([&bytes[..START], &attributes.concat(), rest].concat())
}

/// A file's picture and its text attributes (`Software`, `pdembree/…`, with their full names).
#[derive(Clone, Debug, PartialEq)]
pub struct ExrFile {
    pub image: Image,
    pub attributes: Attributes,
}

/// Reads any EXR of one flat part without subsampled channels; half floats and integers become `f32`.
pub fn read_file(path: &Path) -> Result<ExrFile, ReadError> {
    let malformed = |reason: String| ReadError::Malformed { path: path.to_owned(), reason };
    let unsupported = |reason: &str| ReadError::Unsupported { path: path.to_owned(), reason: reason.to_owned() };
    let bytes = std::fs::read(path).map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound => ReadError::Missing { path: path.to_owned() },
        _ => ReadError::Io { path: path.to_owned(), source },
    })?;
    let meta =
        exr::meta::MetaData::read_from_buffered(bytes.as_slice(), false).map_err(|e| malformed(e.to_string()))?;
    let [header] = meta.headers.as_slice() else {
        return Err(unsupported("the file has more than one part"));
    };
    if header.deep {
        return Err(unsupported("the file holds deep pixels"));
    }
    if header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        return Err(unsupported("the file has subsampled channels"));
    }
    let file = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| malformed(e.to_string()))?;
    let Vec2(width, height) = file.layer_data.size;
    let too_large = |_| unsupported("the picture has more pixels than 32 bits can count");
    let (width, height) = (u32::try_from(width).map_err(too_large)?, u32::try_from(height).map_err(too_large)?);
    let channels = file.layer_data.channel_data.list.into_iter().map(|channel| Channel {
        name: channel.name.to_string(),
        samples: channel.sample_data.values_as_f32().collect(),
    });
    let image = Image { width, height, channels: channels.collect() };
    Ok(ExrFile { image, attributes: texts(&file.layer_data.attributes) })
}

fn texts(own: &LayerAttributes) -> Attributes {
    let software = own.software_name.iter().map(|text| ("Software".to_owned(), text.to_string()));
    let others = own.other.iter().filter_map(|(name, value)| match value {
        AttributeValue::Text(text) => Some((name.to_string(), text.to_string())),
        _ => None,
    });
    let mut all: Attributes = software.chain(others).collect();
    all.sort();
    all
}
