//! Which layers a film has, and where each stands in a pixel's record of sums: the beauty first, then the layers as they
//! were asked for, then the shares of groups of lights. Layers that are counted and not summed stand elsewhere.

use std::sync::Arc;

use super::layer::BEAUTY;
use super::light::Part;
use super::matte::{Matte, Subject};
use crate::scene::settings::Layer;
use crate::scene::{GroupId, GroupLayer, Scene, light_group};

/// A group's share of a part of the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct GroupShare {
    pub part: Part,
    pub group: GroupId,
}

/// The layers of a film.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    layers: Vec<Layer>,
    group_layers: Vec<GroupLayer>,
    shares: Vec<GroupShare>,
    mattes: Vec<Matte>,
    stride: usize,
}

impl Layout {
    /// Repeated layers are taken once.
    pub fn new(layers: &[Layer]) -> Layout {
        Layout::of(layers, &[])
    }

    /// With the shares of groups.
    pub fn of(layers: &[Layer], group_layers: &[GroupLayer]) -> Layout {
        let mut unique = Vec::with_capacity(layers.len());
        for &layer in layers {
            if !unique.contains(&layer) {
                unique.push(layer);
            }
        }
        let ids = light_group::ids(group_layers);
        // Others than these three are no shares: they would be empty.
        let share =
            |(layer, group): (&GroupLayer, GroupId)| Some(GroupShare { part: Part::of_layer(layer.of)?, group });
        let shares: Vec<GroupShare> = group_layers.iter().zip(ids).filter_map(share).collect();
        let of_layers: usize = unique.iter().map(|layer| layer.channels().len()).sum();
        let stride = BEAUTY.len() + of_layers + 3 * shares.len();
        let mattes =
            unique.iter().filter_map(|&layer| Some(Matte { subject: Subject::of(layer)?, names: Arc::default() }));
        Layout { mattes: mattes.collect(), layers: unique, group_layers: group_layers.to_vec(), shares, stride }
    }

    /// What the settings of a scene ask for, with the names of its objects and materials.
    pub fn of_scene(scene: &Scene) -> Layout {
        let settings = &scene.settings;
        Layout::of(&settings.layers, &settings.group_layers).naming(|subject| match subject {
            Subject::Object => scene.objects.iter().map(|object| object.name.clone()).collect(),
            Subject::Material => scene.material_names.clone(),
        })
    }

    /// With the names of what can be met.
    pub(super) fn naming(mut self, mut names: impl FnMut(Subject) -> Vec<String>) -> Layout {
        for matte in &mut self.mattes {
            matte.names = names(matte.subject).into();
        }
        self
    }

    /// The layers beside the beauty.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// The shares of groups of lights.
    pub fn group_layers(&self) -> &[GroupLayer] {
        &self.group_layers
    }

    /// The names of all layers, as scene files spell them.
    pub fn names(&self) -> Vec<String> {
        let own = self.layers.iter().map(|layer| layer.name().to_owned());
        own.chain(self.group_layers.iter().map(GroupLayer::name)).collect()
    }

    /// The layers that are counted.
    pub fn mattes(&self) -> &[Matte] {
        &self.mattes
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

    /// Each share with the place of its first number.
    pub(super) fn shares(&self) -> impl Iterator<Item = (&GroupShare, usize)> + '_ {
        let first = self.stride - 3 * self.shares.len();
        self.shares.iter().enumerate().map(move |(i, share)| (share, first + 3 * i))
    }

    /// Channel names in the order of the record.
    pub fn channel_names(&self) -> impl Iterator<Item = String> + '_ {
        let own = BEAUTY.into_iter().chain(self.layers.iter().flat_map(|layer| layer.channels().iter().copied()));
        let of_groups =
            self.group_layers.iter().flat_map(|layer| ["R", "G", "B"].map(|c| format!("{}.{c}", layer.name())));
        own.map(str::to_owned).chain(of_groups)
    }
}
