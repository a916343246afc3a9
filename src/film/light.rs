//! How light is told apart: by the part of the picture that it belongs to, and by how it has reached what the eye sees.

use crate::scene::GroupId;
use crate::scene::settings::Layer;

/// What artists handle apart. The three parts add up to the beauty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Direct,
    Caustic,
    Indirect,
}

/// How light has come to the first surface of class D that the eye sees, over mirrors, through glass or past glossy
/// surfaces: the classes of `render::partition`. The five add up to the beauty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// No surface has scattered it, L S* E.
    Emission,
    /// L D
    Straight,
    /// L S⁺ D
    Focused,
    /// L … D S⁺ D
    SentBack,
    /// L … D D
    Scattered,
}

/// Both of them for one path's light, and whose light it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightKind {
    pub part: Part,
    pub arrival: Arrival,
    pub group: GroupId,
}

impl Part {
    pub(super) const COUNT: usize = 3;

    /// The part that a layer holds, if it holds one.
    pub(super) fn of_layer(layer: Layer) -> Option<Part> {
        [Part::Direct, Part::Caustic, Part::Indirect].into_iter().find(|part| part.layer() == layer)
    }

    pub(super) const fn layer(self) -> Layer {
        match self {
            Part::Direct => Layer::Direct,
            Part::Caustic => Layer::Caustic,
            Part::Indirect => Layer::Indirect,
        }
    }
}

impl Arrival {
    pub(super) const COUNT: usize = 5;

    pub(super) const fn layer(self) -> Layer {
        match self {
            Arrival::Emission => Layer::Emission,
            Arrival::Straight => Layer::Straight,
            Arrival::Focused => Layer::Focused,
            Arrival::SentBack => Layer::SentBack,
            Arrival::Scattered => Layer::Scattered,
        }
    }
}

impl LightKind {
    /// The layers that hold such light, beside the beauty.
    pub(super) fn layers(self) -> [Layer; 2] {
        [self.part.layer(), self.arrival.layer()]
    }
}
