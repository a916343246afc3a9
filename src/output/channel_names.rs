//! What an EXR's channels are called: as here, or as other programs look for them.

/// Who reads the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChannelNames {
    /// Our own: `film::layer` lists them.
    #[default]
    Own,
    /// pbrt's `imgtool`: `Albedo.R`, `Ns.X`.
    Pbrt,
    /// Blender's multi-layer files: `ViewLayer.Combined.R`, `ViewLayer.Depth.Z`.
    Blender,
}

/// Blender's name of the layer around all passes.
const VIEW_LAYER: &str = "ViewLayer";

impl ChannelNames {
    pub const NAMES: [&'static str; 3] = ["own", "pbrt", "blender"];

    pub fn from_name(text: &str) -> Option<ChannelNames> {
        match text {
            "own" => Some(ChannelNames::Own),
            "pbrt" => Some(ChannelNames::Pbrt),
            "blender" => Some(ChannelNames::Blender),
            _ => None,
        }
    }

    /// A channel of ours.
    pub fn of_channel(self, own: &str) -> String {
        match (self, own.rsplit_once('.')) {
            (ChannelNames::Own, _) => own.to_owned(),
            (_, Some((layer, component))) => format!("{}.{component}", self.of_layer(layer)),
            (ChannelNames::Pbrt, None) => own.to_owned(),
            (ChannelNames::Blender, None) if own == "Z" => format!("{VIEW_LAYER}.Depth.Z"),
            (ChannelNames::Blender, None) => format!("{VIEW_LAYER}.Combined.{own}"),
        }
    }

    /// A layer of ours whose channels have components.
    pub fn of_layer(self, own: &str) -> String {
        match (self, own) {
            (ChannelNames::Pbrt, "albedo") => "Albedo".to_owned(),
            // The shading normal; its `N` is the geometric one.
            (ChannelNames::Pbrt, "N") => "Ns".to_owned(),
            (ChannelNames::Own | ChannelNames::Pbrt, _) => own.to_owned(),
            (ChannelNames::Blender, "N") => format!("{VIEW_LAYER}.Normal"),
            (ChannelNames::Blender, "P") => format!("{VIEW_LAYER}.Position"),
            (ChannelNames::Blender, "albedo") => format!("{VIEW_LAYER}.Denoising Albedo"),
            (ChannelNames::Blender, _) => format!("{VIEW_LAYER}.{own}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_have_the_names_that_others_look_for() {
        let expected = [
            ("R", "R", "ViewLayer.Combined.R"),
            ("A", "A", "ViewLayer.Combined.A"),
            ("Z", "Z", "ViewLayer.Depth.Z"),
            ("N.X", "Ns.X", "ViewLayer.Normal.X"),
            ("P.Z", "P.Z", "ViewLayer.Position.Z"),
            ("albedo.G", "Albedo.G", "ViewLayer.Denoising Albedo.G"),
            ("caustic_key.B", "caustic_key.B", "ViewLayer.caustic_key.B"),
            ("CryptoObject00.R", "CryptoObject00.R", "ViewLayer.CryptoObject00.R"),
        ];
        for (own, pbrt, blender) in expected {
            assert_eq!(ChannelNames::Own.of_channel(own), own);
            assert_eq!(ChannelNames::Pbrt.of_channel(own), pbrt);
            assert_eq!(ChannelNames::Blender.of_channel(own), blender);
        }
    }
}
