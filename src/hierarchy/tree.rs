//! The tree above the facets, in depth-first order.

use super::cells::Enclosure;
use super::rooms::Rooms;
use super::surfaces::Surfaces;
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

    /// Whether its box is no further than `distance`, local length, from both other bounds and a plane.
    pub fn is_near(&self, bounds: Aabb, plane: &Plane, distance: f64) -> bool {
        let (low, high) = plane.distance_range(&self.bounds);
        self.bounds.overlaps(bounds, distance as f32) && low <= distance && high >= -distance
    }
}

struct Bounded(Aabb);

impl obvhs::Boundable for Bounded {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        obvhs::aabb::Aabb::new(self.0.min.into(), self.0.max.into())
    }
}

/// Builds the tree above facets (one at least): rooms at the top, neighbours gathered within each. Facets that reach
/// from one room into another are cut.
pub(super) fn build(surfaces: &mut Surfaces<'_>) -> Tree {
    let count = surfaces.facets.len();
    let mut tree = Tree {
        nodes: Vec::with_capacity(2 * count),
        order: Vec::with_capacity(count),
        enclosures: Vec::new(),
    };
    tree.part(&mut Rooms::of(surfaces), &(0..count as u32).collect::<Vec<_>>(), &mut Vec::new());
    let nodes = &mut tree.nodes;
    for index in (0..nodes.len()).rev() {
        let node: Node = nodes[index];
        if !node.is_leaf() {
            let [a, b] = node.children(index as u32).map(|c| nodes[c as usize]);
            nodes[index].bounds = a.bounds.union(b.bounds);
            nodes[index].end = b.end;
        }
    }
    tree
}

/// The tree as it grows; boxes and ends of clusters are still open.
pub(super) struct Tree {
    /// In depth-first order.
    pub(super) nodes: Vec<Node>,
    /// For each new id of a facet, the old one.
    pub(super) order: Vec<u32>,
    /// Ascending by node.
    pub(super) enclosures: Vec<Enclosure>,
}

impl Tree {
    /// Adds rooms, and what is in them. In front of the planes `around` are others.
    fn part(&mut self, rooms: &mut Rooms<'_, '_>, facets: &[u32], around: &mut Vec<Plane>) {
        let Some((wall, [front, back])) = rooms.part(facets) else {
            let planes = rooms.enclosure(facets, around);
            if !planes.is_empty() {
                self.enclosures.push(Enclosure { node: self.nodes.len() as u32, planes });
            }
            return self.gather(rooms, facets);
        };
        let cluster = self.push(Aabb::EMPTY);
        around.push(wall.flipped());
        self.part(rooms, &front, around);
        self.nodes[cluster].second = self.nodes.len() as u32;
        *around.last_mut().expect("pushed above") = wall;
        self.part(rooms, &back, around);
        around.pop();
    }

    /// Adds a tree of neighbours.
    fn gather(&mut self, rooms: &Rooms<'_, '_>, facets: &[u32]) {
        let boxes: Vec<Bounded> = facets.iter().map(|&facet| Bounded(rooms.boxes[facet as usize])).collect();
        let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::Medium,
            &boxes,
            (0..boxes.len() as u32).collect(),
            SortPrecision::U64,
            0,
        );
        ReinsertionOptimizer::default().run(&mut bvh, 0.05, None);

        // (node of the builder, index of the parent that waits to learn its second child)
        let mut stack = vec![(0usize, None)];
        while let Some((old, parent)) = stack.pop() {
            if let Some(parent) = parent {
                let second = self.nodes.len() as u32;
                let parent: &mut Node = &mut self.nodes[parent];
                parent.second = second;
            }
            let node = &bvh.nodes[old];
            if node.is_leaf() {
                debug_assert_eq!(node.prim_count, 1);
                let facet = facets[bvh.primitive_indices[node.first_index as usize] as usize];
                self.push(rooms.boxes[facet as usize]);
                self.order.push(facet);
            } else {
                let index = self.push(Aabb::EMPTY);
                stack.push((node.first_index as usize + 1, Some(index)));
                stack.push((node.first_index as usize, None));
            }
        }
    }

    /// Adds a node, a leaf for now.
    fn push(&mut self, bounds: Aabb) -> usize {
        let first = self.order.len() as u32;
        self.nodes.push(Node { bounds, first, end: first + 1, second: 0, area: 0.0, center: Vec3::ZERO });
        self.nodes.len() - 1
    }
}
