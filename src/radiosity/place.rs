//! Where things are, for people.

use super::forest::Forest;
use crate::hierarchy::Hierarchy;

/// Where an element or a cluster is: its middle in scene units, and what it is. Nodes have the ids that links use.
pub fn place(hierarchy: &Hierarchy, forest: &Forest, node: u32) -> String {
    match node.checked_sub(hierarchy.nodes.len() as u32) {
        Some(element) => {
            let piece = forest.piece(hierarchy, element);
            let center = hierarchy.frame.scene_from_local(piece.polygon.center());
            let material = &hierarchy.material(piece.side.facet).name;
            let side = if piece.side.back { ", back" } else { "" };
            format!("({:.4} {:.4} {:.4}), material {material}{side}", center.x, center.y, center.z)
        }
        None => {
            let node = &hierarchy.nodes[node as usize];
            let center = hierarchy.frame.scene_from_local(node.center.as_dvec3());
            let facets = node.end - node.first;
            format!("({:.4} {:.4} {:.4}), cluster of {facets}", center.x, center.y, center.z)
        }
    }
}
