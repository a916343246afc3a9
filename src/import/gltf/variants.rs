//! `KHR_materials_variants`: other materials for the same meshes, by the name of a variant.

use gltf::{Document, Material, Primitive};

use crate::import::imported::find;
use crate::scene::description::Reference;
use crate::scene::error::{Problem, Source};

/// The number of the variant that is wanted.
///
/// # Errors
/// The file has none of that name.
pub(super) fn wanted(document: &Document, name: Option<&Reference>, source: &Source) -> Result<Option<u32>, Problem> {
    let names = || document.variants().into_iter().flatten().map(|variant| variant.name()).collect::<Vec<_>>();
    name.map(|name| find("variant", name, &names(), source).map(|place| place as u32)).transpose()
}

/// The material of a primitive; what a variant leaves out is as without it.
pub(super) fn material<'a>(primitive: &Primitive<'a>, variant: Option<u32>) -> Material<'a> {
    let mapped = variant.and_then(|variant| primitive.mappings().find(|mapping| mapping.variants().contains(&variant)));
    mapped.map_or_else(|| primitive.material(), |mapping| mapping.material())
}
