//! Groups of lights, whose shares of the picture have layers of their own.

use super::ids::LightId;
use super::settings::Layer;

/// The group of lights that name none.
pub const DEFAULT: &str = "default";
/// In the name of a layer, every group.
pub const EVERY: &str = "*";

/// One group's share of a layer, `caustic_key`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct GroupLayer {
    /// One of [`GroupLayer::OF`].
    pub of: Layer,
    pub group: String,
}

impl GroupLayer {
    /// Layers that are shared out to groups: they add up to the beauty.
    pub const OF: [Layer; 3] = [Layer::Direct, Layer::Caustic, Layer::Indirect];

    pub fn name(&self) -> String {
        format!("{}_{}", self.of.name(), self.group)
    }

    pub fn from_name(text: &str) -> Option<GroupLayer> {
        GroupLayer::OF.into_iter().find_map(|of| {
            let group = text.strip_prefix(of.name())?.strip_prefix('_')?;
            let fits = group == EVERY || is_name(group);
            fits.then(|| GroupLayer { of, group: group.to_owned() })
        })
    }
}

/// Whether a group may be called so: letters, digits and `_`, as names of EXR layers that every program reads.
pub fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// A group whose light is kept apart; 0 is everything else.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct GroupId(u16);

impl GroupId {
    /// Light that no layer asks for by its group.
    pub const REST: GroupId = GroupId(0);

    pub fn index(self) -> usize {
        usize::from(self.0)
    }

    /// All there can be, in order.
    pub fn all() -> impl Iterator<Item = GroupId> {
        (0..=u16::MAX).map(GroupId)
    }
}

/// The groups that layers ask for, and which of them each light belongs to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightGroups {
    of_light: Vec<GroupId>,
    count: usize,
}

impl LightGroups {
    /// `of_light` are the names of the lights' groups.
    pub fn new<'a>(layers: &[GroupLayer], of_light: impl Iterator<Item = &'a str>) -> LightGroups {
        let names = asked(layers);
        let id = |group: &str| names.iter().position(|name| *name == group).map_or(GroupId::REST, id_of);
        LightGroups { of_light: of_light.map(id).collect(), count: names.len() }
    }

    pub fn of(&self, light: LightId) -> GroupId {
        self.of_light.get(light.index()).copied().unwrap_or_default()
    }

    /// How many ids there are, that of the rest among them.
    pub fn ids(&self) -> usize {
        self.count + 1
    }
}

fn id_of(place: usize) -> GroupId {
    GroupId(u16::try_from(place + 1).unwrap_or(0))
}

/// The groups that layers name, each once; group i of them has the [`GroupId`] i + 1.
fn asked(layers: &[GroupLayer]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for layer in layers {
        if !names.contains(&layer.group.as_str()) {
            names.push(&layer.group);
        }
    }
    names
}

/// Which group each layer holds.
pub fn ids(layers: &[GroupLayer]) -> Vec<GroupId> {
    let names = asked(layers);
    layers.iter().map(|layer| names.iter().position(|name| *name == layer.group).map_or(GroupId::REST, id_of)).collect()
}
