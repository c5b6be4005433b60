//! The tree of nodes: where each mesh and camera stands.

use std::path::Path;

use glam::{DMat4, DQuat, DVec3, DVec4};
use gltf_json::Root;
use gltf_json::scene::Node;

use super::super::error::{SceneError, quoted};

/// A node of the scene that is shown, and where it stands.
pub(super) struct Placed {
    pub(super) node: usize,
    pub(super) world: DMat4,
}

/// All nodes of the default scene, parents before children; of the first scene where none is the default, and of all nodes
/// without parents where there is no scene.
///
/// # Errors
/// [`SceneError::Parse`] where the nodes are no trees or a transformation makes no sense.
pub(super) fn placed(path: &Path, root: &Root) -> Result<Vec<Placed>, SceneError> {
    let scene = root
        .scene
        .map(|scene| scene.value())
        .and_then(|scene| root.scenes.get(scene))
        .or(root.scenes.first());
    let tops: Vec<usize> = match scene {
        Some(scene) => scene.nodes.iter().map(|node| node.value()).collect(),
        None => orphans(root),
    };
    let fault = |index: usize, what: &str| {
        let name = quoted(root.nodes[index].name.as_deref().unwrap_or_default());
        SceneError::parse(path, None, format!("node {index} {name}: {what}; export it again"))
    };
    // Each is checked before it waits: a list that names one node many times takes no memory.
    let mut is_reached = vec![false; root.nodes.len()];
    let mut reach = |node: usize| match std::mem::replace(&mut is_reached[node], true) {
        true => Err(fault(node, "has two parents or is its own ancestor")),
        false => Ok(()),
    };
    let mut waiting = Vec::new();
    for &node in tops.iter().rev() {
        reach(node)?;
        waiting.push(Placed { node, world: DMat4::IDENTITY });
    }
    let mut placed = Vec::new();
    while let Some(Placed { node: index, world: parent }) = waiting.pop() {
        let node = &root.nodes[index];
        let world = match local(node) {
            Some(local) => parent * local,
            None => return Err(fault(index, "its rotation is zero")),
        };
        if !world.is_finite() {
            return Err(fault(index, "its transformation is not finite or too large"));
        }
        for child in node.children.iter().flatten().rev() {
            reach(child.value())?;
            waiting.push(Placed { node: child.value(), world });
        }
        placed.push(Placed { node: index, world });
    }
    Ok(placed)
}

/// Nodes that are no children.
fn orphans(root: &Root) -> Vec<usize> {
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        is_child[child.value()] = true;
    }
    (0..root.nodes.len()).filter(|&node| !is_child[node]).collect()
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
