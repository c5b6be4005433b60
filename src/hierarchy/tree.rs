//! The tree above the facets, in depth-first order.

use super::TOLERANCE;
use crate::math::{Aabb, Plane};
use glam::Vec3;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// A cluster, or a leaf that holds one facet.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Box around everything below.
    pub bounds: Aabb,
    /// First facet below.
    pub first: u32,
    /// One past the last facet below.
    pub end: u32,
    /// Second child; the first child is the next node. 0 in a leaf.
    second: u32,
    /// Area of one side of all facets below, local units.
    pub area: f32,
    /// Centroid of all facets below.
    pub center: Vec3,
}

/// What a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeKind {
    /// Holds two nodes.
    Cluster([u32; 2]),
    /// Holds one facet.
    Leaf(u32),
}

impl Node {
    /// Whether the node holds a single facet.
    #[inline]
    pub fn is_leaf(&self) -> bool {
        self.second == 0
    }

    /// Both children of a cluster with index `index`.
    #[inline]
    pub fn children(&self, index: u32) -> [u32; 2] {
        debug_assert!(!self.is_leaf());
        [index + 1, self.second]
    }

    /// The node's kind, given its index.
    #[inline]
    pub fn kind(&self, index: u32) -> NodeKind {
        if self.is_leaf() { NodeKind::Leaf(self.first) } else { NodeKind::Cluster([index + 1, self.second]) }
    }

    /// Whether its box touches both other bounds and a plane.
    pub fn touches(&self, bounds: Aabb, plane: &Plane) -> bool {
        let (low, high) = plane.distance_range(&self.bounds);
        self.bounds.overlaps(bounds, TOLERANCE as f32) && low <= TOLERANCE && high >= -TOLERANCE
    }
}

struct Bounded(Aabb);

impl obvhs::Boundable for Bounded {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        obvhs::aabb::Aabb::new(self.0.min.into(), self.0.max.into())
    }
}

/// Builds the tree over `boxes` (not empty); returns the nodes in depth-first order and, for each
/// new id, the index of its box.
pub(super) fn build(boxes: &[Aabb]) -> (Vec<Node>, Vec<u32>) {
    let bounded: Vec<Bounded> = boxes.iter().map(|&b| Bounded(b)).collect();
    let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        &bounded,
        (0..boxes.len() as u32).collect(),
        SortPrecision::U64,
        0,
    );
    ReinsertionOptimizer::default().run(&mut bvh, 0.05, None);

    let mut nodes = Vec::with_capacity(2 * boxes.len());
    let mut order = Vec::with_capacity(boxes.len());
    // (node of the builder, index of the parent that waits to learn its second child)
    let mut stack = vec![(0usize, None)];
    while let Some((old, parent)) = stack.pop() {
        let index = nodes.len() as u32;
        if let Some(parent) = parent {
            let parent: &mut Node = &mut nodes[parent as usize];
            parent.second = index;
        }
        let node = &bvh.nodes[old];
        let first = order.len() as u32;
        nodes.push(Node {
            bounds: Aabb::EMPTY,
            first,
            end: first + 1,
            second: 0,
            area: 0.0,
            center: Vec3::ZERO,
        });
        if node.is_leaf() {
            debug_assert_eq!(node.prim_count, 1);
            let facet = bvh.primitive_indices[node.first_index as usize];
            nodes[index as usize].bounds = boxes[facet as usize];
            order.push(facet);
        } else {
            stack.push((node.first_index as usize + 1, Some(index)));
            stack.push((node.first_index as usize, None));
        }
    }
    for index in (0..nodes.len()).rev() {
        let node: Node = nodes[index];
        if !node.is_leaf() {
            let [a, b] = node.children(index as u32).map(|c| nodes[c as usize]);
            nodes[index].bounds = a.bounds.union(b.bounds);
            nodes[index].end = b.end;
        }
    }
    (nodes, order)
}
