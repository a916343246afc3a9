//! A finished picture: named channels of `f32`, as files hold them.

/// One named channel, row by row from the top left pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    pub name: String,
    pub samples: Vec<f32>,
}

/// A picture of `width` × `height` pixels; every channel has `width · height` samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    pub width: u32,
    pub height: u32,
    pub channels: Vec<Channel>,
}

impl Image {
    /// A picture of the channels `R G B` from interleaved values, row by row.
    pub fn from_rgb(width: u32, height: u32, rgb: &[[f32; 3]]) -> Image {
        assert_eq!(rgb.len(), width as usize * height as usize, "one colour a pixel");
        let channels = ["R", "G", "B"]
            .into_iter()
            .enumerate()
            .map(|(c, name)| Channel { name: name.to_owned(), samples: rgb.iter().map(|pixel| pixel[c]).collect() });
        Image { width, height, channels: channels.collect() }
    }

    /// BLAKE3 over size, names and samples, 64 hexadecimal digits.
    pub fn digest(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.width.to_le_bytes());
        hasher.update(&self.height.to_le_bytes());
        for Channel { name, samples } in &self.channels {
            hasher.update(&(name.len() as u64).to_le_bytes());
            hasher.update(name.as_bytes());
            let bytes: Vec<u8> = samples.iter().flat_map(|v| v.to_le_bytes()).collect();
            hasher.update(&bytes);
        }
        hasher.finalize().to_hex().to_string()
    }

    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The samples of the channel of that name.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|channel| channel.name == name).map(|channel| channel.samples.as_slice())
    }

    /// A layer's colour: channels `layer.R`, `layer.G`, `layer.B`, or `R G B` when `layer` is empty. A grey picture
    /// (`Y` alone) counts as three equal channels.
    pub fn rgb(&self, layer: &str) -> Option<[&[f32]; 3]> {
        let name = |c: &str| if layer.is_empty() { c.to_owned() } else { format!("{layer}.{c}") };
        let colour = || Some([self.channel(&name("R"))?, self.channel(&name("G"))?, self.channel(&name("B"))?]);
        colour().or_else(|| self.channel(&name("Y")).map(|y| [y; 3]))
    }
}
