//! The layers of a picture: what each one means, its EXR channels, and the eye sample that fills them.
//!
//! Units: radiance layers in W/(m²·sr), linear Rec.709; `Z` and `P` in metres; `photons.density` in photons per m², `variance` in (W/(m²·sr))²; `N` and
//! `albedo` have none. Frame: `N` and `P` in world space, `Z` along the camera's view axis.
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
//! | `direct_G`, `caustic_G`, `indirect_G` | `caustic_G.R G B` | the share that the lights of group `G` have in that layer; those of all groups add up to it |
//! | `P` | `P.X Y Z` | where the eye's ray first hit, mean of the samples that hit; 0 where A = 0 |
//! | `Z` | `Z` | depth of the first hit, mean of the samples that hit; 0 where A = 0 |
//! | `albedo` | `albedo.R G B` | reflectance at the vertex where `N` is taken |
//! | `photons` | `photons.density` | Σ K/A over the photons whose footprints cover that vertex: the photon density that the estimate saw |
//! | `crypto_object`, `crypto_material` | `CryptoObject00.R` … | Cryptomatte: which objects, or materials, the samples hit first ([`super::matte`]) |
//! | `variance` | `variance.Y` | variance of the mean luminance, from how much the passes differ; 0 with one pass |

use super::layout::GroupShare;
use super::light::{Arrival, LightKind, Part};
use crate::math::Vec3;
use crate::radiometry::Spectrum;
use crate::scene::settings::Layer;
use crate::scene::{LightGroups, MaterialId, ObjectId};

impl Layer {
    /// Whether its mean is that of the samples that hit something.
    pub(super) const fn is_of_hits(self) -> bool {
        matches!(self, Layer::Depth | Layer::Position)
    }

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
            Layer::Position => &["P.X", "P.Y", "P.Z"],
            Layer::Albedo => &["albedo.R", "albedo.G", "albedo.B"],
            Layer::Photons => &["photons.density"],
            Layer::Variance => &["variance.Y"],
            // Counted, not summed.
            Layer::CryptoObject | Layer::CryptoMaterial => &[],
        }
    }
}

/// The beauty's channels; their place is the start of every pixel's record.
pub(super) const BEAUTY: [&str; 4] = ["R", "G", "B", "A"];

/// What the eye's ray met first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Met {
    pub object: ObjectId,
    pub material: MaterialId,
}

/// What one path from the eye brought back. [`EyeSample::add`] shares its light out to parts, arrivals and groups.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EyeSample {
    /// W/(m²·sr)
    pub(super) direct: Spectrum,
    /// W/(m²·sr)
    pub(super) caustic: Spectrum,
    /// W/(m²·sr)
    pub(super) indirect: Spectrum,
    /// The same light by its [`Arrival`], in the enum's order.
    pub(super) arrived: [Spectrum; Arrival::COUNT],
    /// The parts, in the enum's order, of each group of lights; empty where none is kept apart.
    pub(super) by_group: Vec<[Spectrum; Part::COUNT]>,
    /// The first surface, if it is one and no medium.
    pub met: Option<Met>,
    /// World-space place of the first hit.
    pub position: Vec3,
    /// Metres along the view axis to the first hit; `None`: the ray left the scene.
    pub depth: Option<f64>,
    /// World-space shading normal at the first vertex that is not specular; zero if there is none.
    pub normal: Vec3,
    /// Reflectance at that vertex.
    pub albedo: Spectrum,
    /// Photons per m² at that vertex.
    pub photon_density: f64,
    /// Whether caustics are left out, as that vertex's object says.
    pub without_caustics: bool,
}

impl EyeSample {
    /// Without light. It tells apart what `groups` say.
    pub fn of(groups: &LightGroups) -> EyeSample {
        let kept = if groups.ids() > 1 { groups.ids() } else { 0 };
        EyeSample { by_group: vec![Default::default(); kept], ..EyeSample::default() }
    }

    /// Adds light, W/(m²·sr), but for what is left out.
    pub fn add(&mut self, kind: LightKind, light: Spectrum) {
        if self.without_caustics && kind.part == Part::Caustic {
            return;
        }
        let part = match kind.part {
            Part::Direct => &mut self.direct,
            Part::Caustic => &mut self.caustic,
            Part::Indirect => &mut self.indirect,
        };
        *part += light;
        self.arrived[kind.arrival as usize] += light;
        if let Some(parts) = self.by_group.get_mut(kind.group.index()) {
            parts[kind.part as usize] += light;
        }
    }

    /// A group's share of a part.
    pub(super) fn of_group(&self, GroupShare { part, group, .. }: &GroupShare) -> Spectrum {
        self.by_group.get(group.index()).map_or(Spectrum::BLACK, |parts| parts[*part as usize])
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
            Layer::Position => self.position.to_array(),
            Layer::Albedo => self.albedo.to_array(),
            Layer::Photons => [self.photon_density, 0.0, 0.0],
            // Known of passes, not of samples.
            Layer::Variance | Layer::CryptoObject | Layer::CryptoMaterial => [0.0; 3],
        }
    }
}
