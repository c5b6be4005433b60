//! The tree of nodes: where each mesh and camera stands.

use std::borrow::Cow;
use std::path::Path;

use glam::{DMat4, DQuat, DVec3, DVec4};
use gltf_json::scene::Node;
use gltf_json::{Index, Root};

use super::super::error::{SceneError, quoted};

/// A node of the scene that is shown, and where it stands.
pub(super) struct Placed {
    pub(super) node: usize,
    pub(super) world: DMat4,
}

/// Visits all nodes of the default scene, parents before children; of the first scene where none is the default, and of all
/// nodes without parents where there is no scene. What is remembered are the nodes above the one that is visited.
///
/// # Errors
/// [`SceneError::Parse`] where the nodes are no trees or a transformation makes no sense; those of `visit`.
pub(super) fn visit(
    path: &Path,
    root: &Root,
    mut visit: impl FnMut(Placed) -> Result<(), SceneError>,
) -> Result<(), SceneError> {
    let scene = root
        .scene
        .map(|scene| scene.value())
        .and_then(|scene| root.scenes.get(scene))
        .or(root.scenes.first());
    let tops = scene.map_or_else(|| Cow::Owned(orphans(root)), |scene| Cow::Borrowed(&scene.nodes[..]));
    let fault = |index: usize, what: &str| {
        let name = quoted(root.nodes[index].name.as_deref().unwrap_or_default());
        SceneError::parse(path, None, format!("node {index} {name}: {what}; export it again"))
    };
    let mut is_reached = vec![false; root.nodes.len()];
    // Nodes that are still to be visited on each level, and where their parent stands.
    let mut levels = vec![(tops.iter(), DMat4::IDENTITY)];
    while let Some((left, parent)) = levels.last_mut() {
        let (next, parent) = (left.next(), *parent);
        // A level without more of them is left at once, so that a chain takes no room.
        if left.len() == 0 {
            levels.pop();
        }
        let Some(index) = next.map(|index| index.value()) else { continue };
        if std::mem::replace(&mut is_reached[index], true) {
            return Err(fault(index, "has two parents or is its own ancestor"));
        }
        let node = &root.nodes[index];
        let world = match local(node) {
            Some(local) => parent * local,
            None => return Err(fault(index, "its rotation is zero")),
        };
        if !world.is_finite() {
            return Err(fault(index, "its transformation is not finite or too large"));
        }
        visit(Placed { node: index, world })?;
        if let Some(children) = &node.children {
            levels.push((children.iter(), world));
        }
    }
    Ok(())
}

/// Whether there is nothing that says where meshes stand.
pub(super) fn is_without_scene(root: &Root) -> bool {
    root.nodes.is_empty() && root.scenes.is_empty()
}

/// Nodes that are no children.
fn orphans(root: &Root) -> Vec<Index<Node>> {
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        is_child[child.value()] = true;
    }
    (0..root.nodes.len()).filter(|&node| !is_child[node]).map(|node| Index::new(node as u32)).collect()
}

/// The transformation of a node in its parent; none when its rotation is zero.
fn local(node: &Node) -> Option<DMat4> {
    if let Some(matrix) = node.matrix {
        let mut columns = [DVec4::ZERO; 4];
        for (column, four) in columns.iter_mut().zip(matrix.as_chunks::<4>().0) {
            *column = DVec4::from_array(four.map(f64::from));
        }
        return Some(DMat4::from_cols(columns[0], columns[1], columns[2], columns[3]));
    }
    let vector = |values: Option<[f32; 3]>, default| {
        values.map_or(default, |values| DVec3::from_array(values.map(f64::from)))
    };
    let rotation = DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from));
    let length = rotation.length();
    let rotation = if length > 0.0 { rotation / length } else { return None };
    let (scale, translation) = (vector(node.scale, DVec3::ONE), vector(node.translation, DVec3::ZERO));
    Some(DMat4::from_scale_rotation_translation(scale, rotation, translation))
}
