//! The layers of a picture: what each one means, its EXR channels, and the eye sample that fills them.
//!
//! Units: radiance layers in W/(m²·sr), linear Rec.709; `Z` in metres; `photons.density` in photons per m², `variance` in (W/(m²·sr))²; `N` and
//! `albedo` have none. Frame: `N` in world space, `Z` along the camera's view axis.
//!
//! | layer | channels | meaning |
//! | --- | --- | --- |
//! | beauty, always there | `R G B A` | all light; A is the share of eye samples that hit something |
//! | `direct` | `direct.R G B` | emitters and background seen by the eye, and their light over one bounce (LE, LDE), also behind specular chains from the eye |
//! | `caustic` | `caustic.R G B` | light whose first events were specular or glossy and that then reached a surface that scatters (L S⁺ D …) |
//! | `indirect` | `indirect.R G B` | everything else; direct + caustic + indirect = beauty |
//! | `emission` | `emission.R G B` | light that no surface has scattered, L S* E; this layer and the next four are another way to share the beauty out, by how light has reached the first surface that scatters |
//! | `straight` | `straight.R G B` | straight from a light, L D |
//! | `focused` | `focused.R G B` | over mirrors, glass and glossy surfaces only, L S⁺ D |
//! | `sent_back` | `sent_back.R G B` | over these, but scattered before, L … D S⁺ D |
//! | `scattered` | `scattered.R G B` | straight from another surface that scatters, L … D D |
//! | `N` | `N.X Y Z` | shading normal at the first vertex that is not specular, so that a denoiser sees the floor behind the glass; 0 where there is none |
//! | `Z` | `Z` | depth of the first hit, mean of the samples that hit; 0 where A = 0 |
//! | `albedo` | `albedo.R G B` | reflectance at the vertex where `N` is taken |
//! | `photons` | `photons.density` | Σ K/A over the photons whose footprints cover that vertex: the photon density that the estimate saw |
//! | `variance` | `variance.Y` | variance of the mean luminance, from how much the passes differ; 0 with one pass |

use super::light::{Arrival, LightKind, Part};
use crate::math::Vec3;
use crate::radiometry::Spectrum;
use crate::scene::settings::Layer;

impl Layer {
    /// The EXR channels that this layer fills, in the order of [`EyeSample`]'s components.
    pub const fn channels(self) -> &'static [&'static str] {
        match self {
            Layer::Caustic => &["caustic.R", "caustic.G", "caustic.B"],
            Layer::Direct => &["direct.R", "direct.G", "direct.B"],
            Layer::Indirect => &["indirect.R", "indirect.G", "indirect.B"],
            Layer::Emission => &["emission.R", "emission.G", "emission.B"],
            Layer::Straight => &["straight.R", "straight.G", "straight.B"],
            Layer::Focused => &["focused.R", "focused.G", "focused.B"],
            Layer::SentBack => &["sent_back.R", "sent_back.G", "sent_back.B"],
            Layer::Scattered => &["scattered.R", "scattered.G", "scattered.B"],
            Layer::Normal => &["N.X", "N.Y", "N.Z"],
            Layer::Depth => &["Z"],
            Layer::Albedo => &["albedo.R", "albedo.G", "albedo.B"],
            Layer::Photons => &["photons.density"],
            Layer::Variance => &["variance.Y"],
        }
    }
}

/// The beauty's channels; their place is the start of every pixel's record.
pub(super) const BEAUTY: [&str; 4] = ["R", "G", "B", "A"];

/// What one path from the eye brought back. [`EyeSample::add`] shares its light out to parts and arrivals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EyeSample {
    /// W/(m²·sr)
    pub(super) direct: Spectrum,
    /// W/(m²·sr)
    pub(super) caustic: Spectrum,
    /// W/(m²·sr)
    pub(super) indirect: Spectrum,
    /// The same light by its [`Arrival`], in the enum's order.
    pub(super) arrived: [Spectrum; Arrival::COUNT],
    /// Metres along the view axis to the first hit; `None`: the ray left the scene.
    pub depth: Option<f64>,
    /// World-space shading normal at the first vertex that is not specular; zero if there is none.
    pub normal: Vec3,
    /// Reflectance at that vertex.
    pub albedo: Spectrum,
    /// Photons per m² at that vertex.
    pub photon_density: f64,
}

impl EyeSample {
    /// Adds light, W/(m²·sr).
    pub fn add(&mut self, kind: LightKind, light: Spectrum) {
        let part = match kind.part {
            Part::Direct => &mut self.direct,
            Part::Caustic => &mut self.caustic,
            Part::Indirect => &mut self.indirect,
        };
        *part += light;
        self.arrived[kind.arrival as usize] += light;
    }

    /// All light of the sample, W/(m²·sr).
    pub fn radiance(&self) -> Spectrum {
        self.direct + self.caustic + self.indirect
    }

    fn arrived(&self, arrival: Arrival) -> [f64; 3] {
        self.arrived[arrival as usize].to_array()
    }

    /// Values of `layer` in the order of its channels; the unused ones are 0.
    pub(super) fn values(&self, layer: Layer) -> [f64; 3] {
        match layer {
            Layer::Caustic => self.caustic.to_array(),
            Layer::Direct => self.direct.to_array(),
            Layer::Indirect => self.indirect.to_array(),
            Layer::Emission => self.arrived(Arrival::Emission),
            Layer::Straight => self.arrived(Arrival::Straight),
            Layer::Focused => self.arrived(Arrival::Focused),
            Layer::SentBack => self.arrived(Arrival::SentBack),
            Layer::Scattered => self.arrived(Arrival::Scattered),
            Layer::Normal => self.normal.to_array(),
            Layer::Depth => [self.depth.unwrap_or(0.0), 0.0, 0.0],
            Layer::Albedo => self.albedo.to_array(),
            Layer::Photons => [self.photon_density, 0.0, 0.0],
            // Known of passes, not of samples.
            Layer::Variance => [0.0; 3],
        }
    }
}

/// Where each layer stands in a pixel's record of `f64` sums: the beauty first, then the layers as they were asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    layers: Vec<Layer>,
    stride: usize,
}

impl Layout {
    /// Repeated layers are taken once.
    pub fn new(layers: &[Layer]) -> Layout {
        let mut unique = Vec::with_capacity(layers.len());
        for &layer in layers {
            if !unique.contains(&layer) {
                unique.push(layer);
            }
        }
        let stride = BEAUTY.len() + unique.iter().map(|layer| layer.channels().len()).sum::<usize>();
        Layout { layers: unique, stride }
    }

    /// The layers beside the beauty.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Numbers in a pixel's record.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Whether `layer` is recorded; renderers may skip the work for those that are not.
    pub fn has(&self, layer: Layer) -> bool {
        self.layers.contains(&layer)
    }

    /// Each layer with the place of its first number.
    pub(super) fn offsets(&self) -> impl Iterator<Item = (Layer, usize)> + '_ {
        self.layers.iter().scan(BEAUTY.len(), |next, &layer| {
            let offset = *next;
            *next += layer.channels().len();
            Some((layer, offset))
        })
    }

    /// Channel names in the order of the record.
    pub fn channel_names(&self) -> impl Iterator<Item = &'static str> + '_ {
        BEAUTY.into_iter().chain(self.layers.iter().flat_map(|layer| layer.channels().iter().copied()))
    }
}
