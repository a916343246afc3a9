//! Packets of tev's protocol: a picture as one `CreateImage` and as many `UpdateImage` as its size asks for.
//!
//! A packet is its length in bytes (`u32`, itself included), its kind (`u8`) and that kind's fields. Numbers are
//! little-endian, a text ends with a zero byte. `CreateImage` makes a black picture, or replaces the one of that name;
//! `UpdateImage` fills a rectangle of it. The viewer answers nothing.

use crate::film::Image;

/// Bytes of one packet, header included. Versions of tev before 2021 take no more than 1 MiB; small packets also let
/// the sender see soon that nobody waits for it any more.
const MAX_PACKET: usize = 1 << 19;

const CREATE_IMAGE: u8 = 4;
/// The third version of the packet: several channels, each with its own offset and stride.
const UPDATE_IMAGE: u8 = 6;

/// What the viewer must know of a picture before its pixels. The protocol's integers are signed, so sides and number of
/// channels are below 2³¹.
#[derive(PartialEq, Eq)]
pub(super) struct Layout {
    width: u32,
    height: u32,
    channels: Vec<String>,
}

impl Layout {
    /// # Errors
    /// The picture has no pixels, more than the protocol can say, or other numbers of them than it says itself.
    pub fn of(image: &Image) -> Result<Layout, String> {
        let Image { width, height, channels } = image;
        if image.pixels() == 0 || channels.is_empty() {
            return Err("it has no pixels".to_owned());
        }
        if i32::try_from(*width).and(i32::try_from(*height)).and(i32::try_from(channels.len())).is_err() {
            return Err(format!("it is too large: {width} × {height} pixels, {} channels", channels.len()));
        }
        if let Some(channel) = channels.iter().find(|channel| channel.samples.len() != image.pixels()) {
            let (name, samples) = (&channel.name, channel.samples.len());
            return Err(format!("channel {name} has {samples} samples, not {width} × {height}"));
        }
        let names = channels.iter().map(|channel| channel.name.clone()).collect();
        Ok(Layout { width: *width, height: *height, channels: names })
    }

    /// Rectangles that cover the picture, of whole rows if these are short enough; each fits a packet with `header`
    /// bytes before its samples.
    fn tiles(&self, header: usize) -> impl Iterator<Item = Tile> + use<> {
        let (width, height) = (self.width, self.height);
        let pixels = MAX_PACKET.saturating_sub(header) / (size_of::<f32>() * self.channels.len());
        let pixels = u32::try_from(pixels).unwrap_or(u32::MAX).max(1);
        let columns = width.min(pixels);
        let rows = pixels / columns;
        let lefts = move || (0..width).step_by(columns as usize);
        (0..height).step_by(rows as usize).flat_map(move |y| {
            lefts().map(move |x| Tile { x, y, width: columns.min(width - x), height: rows.min(height - y) })
        })
    }
}

/// A rectangle of a picture, in pixels from its top left corner.
#[derive(Clone, Copy, Default)]
struct Tile {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

/// The packets that make the viewer show `image` under `name`, in their order. `create`: the viewer holds no picture of
/// that layout.
pub(super) fn packets(name: &str, image: &Image, layout: &Layout, create: bool) -> impl Iterator<Item = Vec<u8>> {
    let header = update_image(name, image, layout, Tile::default()).len();
    let updates = layout.tiles(header).map(move |tile| update_image(name, image, layout, tile));
    create.then(|| create_image(name, layout)).into_iter().chain(updates)
}

fn create_image(name: &str, layout: &Layout) -> Vec<u8> {
    // Only here does the viewer turn to the picture: whoever looks at another one meanwhile is left in peace.
    let mut packet = Packet::new(CREATE_IMAGE, true, name);
    packet.int(layout.width);
    packet.int(layout.height);
    packet.channels(&layout.channels);
    packet.finish()
}

/// The pixels of one tile, channel after channel.
fn update_image(name: &str, image: &Image, layout: &Layout, tile: Tile) -> Vec<u8> {
    let mut packet = Packet::new(UPDATE_IMAGE, false, name);
    packet.channels(&layout.channels);
    for side in [tile.x, tile.y, tile.width, tile.height] {
        packet.int(side);
    }
    let pixels = u64::from(tile.width) * u64::from(tile.height);
    // Offsets and strides count samples, not bytes.
    for channel in 0..layout.channels.len() as u64 {
        packet.long(channel * pixels);
    }
    for _ in &layout.channels {
        packet.long(1);
    }
    for channel in &image.channels {
        for y in tile.y..tile.y + tile.height {
            let left = y as usize * image.width as usize + tile.x as usize;
            packet.samples(&channel.samples[left..left + tile.width as usize]);
        }
    }
    packet.finish()
}

/// A packet being written.
struct Packet(Vec<u8>);

impl Packet {
    fn new(kind: u8, grab_focus: bool, name: &str) -> Packet {
        // The length comes last.
        let mut packet = Packet(vec![0, 0, 0, 0, kind, grab_focus.into()]);
        packet.text(name);
        packet
    }

    fn int(&mut self, value: u32) {
        self.0.extend(value.to_le_bytes());
    }

    fn long(&mut self, value: u64) {
        self.0.extend(value.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        // A zero inside would end the text early and shift everything behind it.
        self.0.extend(text.bytes().filter(|&byte| byte != 0));
        self.0.push(0);
    }

    fn channels(&mut self, names: &[String]) {
        self.int(names.len() as u32);
        for name in names {
            self.text(name);
        }
    }

    fn samples(&mut self, samples: &[f32]) {
        self.0.reserve(size_of_val(samples));
        for sample in samples {
            self.0.extend_from_slice(&sample.to_le_bytes());
        }
    }

    fn finish(mut self) -> Vec<u8> {
        let length = self.0.len() as u32;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}
