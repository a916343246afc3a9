//! The node tree, flattened: every node with its map to the world.

use gltf::scene::Transform;
use gltf::{Document, Node};

use crate::scene::description::TransformMap;
use glam::{DMat4, DQuat, DVec3};

/// A node in its place.
pub(super) struct Placed<'a> {
    pub node: Node<'a>,
    pub to_world: DMat4,
}

/// The nodes of the file's scene, parents before children: its default scene or first one; if it has none, all trees.
///
/// # Errors
/// Nodes that are no tree.
pub(super) fn placed(document: &Document) -> Result<Vec<Placed<'_>>, String> {
    let mut waiting: Vec<(Node<'_>, DMat4)> = match document.default_scene().or_else(|| document.scenes().next()) {
        Some(scene) => scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect(),
        None => roots(document).into_iter().map(|node| (node, DMat4::IDENTITY)).collect(),
    };
    // Taken from the end, so that the first comes first.
    waiting.reverse();
    let mut seen = vec![false; document.nodes().len()];
    let mut placed = Vec::new();
    while let Some((node, parent)) = waiting.pop() {
        let index = node.index();
        if std::mem::replace(&mut seen[index], true) {
            return Err(format!("nodes[{index}] has two parents, or is its own ancestor"));
        }
        let to_world = parent * local(&node);
        let children: Vec<_> = node.children().map(|child| (child, to_world)).collect();
        waiting.extend(children.into_iter().rev());
        placed.push(Placed { node, to_world });
    }
    Ok(placed)
}

/// Nodes that are no child of any.
fn roots(document: &Document) -> Vec<Node<'_>> {
    let mut is_child = vec![false; document.nodes().len()];
    document.nodes().flat_map(|node| node.children()).for_each(|child| is_child[child.index()] = true);
    document.nodes().filter(|node| !is_child[node.index()]).collect()
}

/// T R S, or the matrix that is given.
fn local(node: &Node<'_>) -> DMat4 {
    match node.transform() {
        Transform::Matrix { matrix } => DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from))),
        Transform::Decomposed { translation, rotation, scale } => {
            let rotation = DQuat::from_array(rotation.map(f64::from));
            // A turn by a quaternion of any length but zero.
            let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
            let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
            DMat4::from_scale_rotation_translation(vector(scale), rotation, vector(translation))
        }
    }
}

/// Rows of [M | t], `None` for the identity.
pub(super) fn transform_map(to_world: &DMat4) -> Option<TransformMap> {
    let rows = to_world.transpose().to_cols_array_2d();
    (*to_world != DMat4::IDENTITY).then_some(TransformMap::Matrix([rows[0], rows[1], rows[2]]))
}

/// Whether nothing can be seen of what is placed so: nodes are hidden by scaling them to nothing.
pub(super) fn is_flat(to_world: &DMat4) -> bool {
    let [x, y, z] = [to_world.x_axis, to_world.y_axis, to_world.z_axis].map(|axis| axis.truncate());
    let volume = x.dot(y.cross(z)).abs();
    volume <= 1e-12 * x.length() * y.length() * z.length()
}

/// The direction of an axis of the node's own frame in the world; the axis itself where it has been scaled to nothing.
pub(super) fn direction(to_world: &DMat4, axis: DVec3) -> DVec3 {
    to_world.transform_vector3(axis).try_normalize().unwrap_or(axis)
}
