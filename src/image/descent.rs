//! What nodes have, handed down to all that is in them.

use crate::hierarchy::Hierarchy;
use crate::radiosity::Forest;

/// Gives every node, by its id as links have it, what it has itself and what all nodes above it have.
pub(super) fn handed_down<T: Copy>(
    hierarchy: &Hierarchy,
    forest: &Forest,
    mut own: Vec<T>,
    add: impl Fn(&mut T, T),
) -> Vec<T> {
    let clusters = hierarchy.nodes.len();
    let pass = |values: &mut Vec<T>, from: usize, to: usize| {
        let above = values[from];
        add(&mut values[to], above);
    };
    for (index, node) in hierarchy.nodes.iter().enumerate() {
        if node.is_leaf() {
            for side in forest.sides_of(node.first) {
                pass(&mut own, index, clusters + forest.first_element[side] as usize);
            }
        } else {
            for child in node.children(index as u32) {
                pass(&mut own, index, child as usize);
            }
        }
    }
    for element in 0..forest.len() {
        let second = forest.second[element] as usize;
        if second != 0 {
            pass(&mut own, clusters + element, clusters + element + 1);
            pass(&mut own, clusters + element, clusters + second);
        }
    }
    own
}
