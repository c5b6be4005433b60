//! Which pairs of leaf elements the links of a solution cover, and how often.

use std::f64::consts::PI;

use glam::DVec3;
use lightshaft::hierarchy::{Hierarchy, TOLERANCE};
use lightshaft::math::{Plane, Polygon};
use lightshaft::radiosity::{Forest, Link, Solution};

/// A leaf element with its geometry.
pub(crate) struct Leaf {
    pub(crate) polygon: Polygon,
    pub(crate) plane: Plane,
    pub(crate) facet: u32,
}

impl Leaf {
    /// Whether a part of `other` lies in front of this leaf, by more than rounding.
    fn has_in_front(&self, other: &Leaf) -> bool {
        other.polygon.vertices().iter().any(|&v| self.plane.distance(v) > TOLERANCE)
    }

    /// Whether light could pass between the two if nothing stood between them.
    pub(crate) fn faces(&self, other: &Leaf) -> bool {
        self.facet != other.facet && self.has_in_front(other) && other.has_in_front(self)
    }

    /// What passes between a point of this leaf and one of the other, standing for all their points,
    /// when nothing is in between: area × form factor, local areas.
    pub(crate) fn exchange(&self, own: DVec3, other: &Leaf, point: DVec3) -> f64 {
        let heights = self.plane.distance(point).max(0.0) * other.plane.distance(own).max(0.0);
        heights * self.polygon.area() * other.polygon.area() / (PI * own.distance_squared(point).powi(2))
    }

    /// Whether light could pass between a point of this leaf and one of the other. None does within a plane,
    /// by the rule of the solver: but for rounding there is no cosine. Elements end where walls stand, so
    /// their borders often lie in the planes of these.
    pub(crate) fn exchanges(&self, own: DVec3, other: &Leaf, point: DVec3) -> bool {
        self.plane.distance(point) > TOLERANCE && other.plane.distance(own) > TOLERANCE
    }
}

/// How many links cover each ordered pair of leaf elements.
pub(crate) struct CoveredPairs {
    /// In the order of their ids.
    pub(crate) leaves: Vec<Leaf>,
    /// Exitance of each leaf, largest channel.
    pub(crate) exitance: Vec<f64>,
    counts: Vec<u8>,
}

impl CoveredPairs {
    pub(crate) fn of(hierarchy: &Hierarchy, solution: &Solution, links: &[Link]) -> CoveredPairs {
        let forest = &solution.forest;
        let mut leaves: Vec<Option<Leaf>> = (0..forest.len()).map(|_| None).collect();
        forest.for_each_element(hierarchy, |piece| {
            if forest.second[piece.id as usize] == 0 {
                let (polygon, plane, facet) = (piece.polygon, piece.plane, piece.side.facet);
                leaves[piece.id as usize] = Some(Leaf { polygon, plane, facet });
            }
        });
        // Leaves before each element, in the order of ids.
        let mut before = vec![0];
        before.extend(leaves.iter().scan(0, |sum, leaf| {
            *sum += usize::from(leaf.is_some());
            Some(*sum)
        }));
        let is_leaf = |e: &usize| leaves[*e].is_some();
        let exitance = (0..forest.len())
            .filter(is_leaf)
            .map(|e| solution.light.exitance[e].max_element() as f64)
            .collect();
        let leaves: Vec<Leaf> = leaves.into_iter().flatten().collect();
        let count = leaves.len();
        let mut counts = vec![0u8; count * count];
        for link in links {
            let [receivers, sources] = [link.receiver, link.source].map(|id| {
                let elements = elements_below(hierarchy, forest, id);
                before[elements.start]..before[elements.end]
            });
            for receiver in receivers {
                for times in &mut counts[receiver * count..][sources.clone()] {
                    *times = times.saturating_add(1);
                }
            }
        }
        CoveredPairs { leaves, exitance, counts }
    }

    pub(crate) fn times(&self, receiver: usize, source: usize) -> u8 {
        self.counts[receiver * self.leaves.len() + source]
    }

    /// Pairs of leaves that face each other, receiver and source.
    pub(crate) fn facing(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let all = 0..self.leaves.len();
        all.clone()
            .flat_map(move |r| all.clone().map(move |s| (r, s)))
            .filter(|&(r, s)| self.leaves[r].faces(&self.leaves[s]))
    }
}

/// Ids of the elements below a node, an element itself included.
fn elements_below(hierarchy: &Hierarchy, forest: &Forest, id: u32) -> std::ops::Range<usize> {
    match (id as usize).checked_sub(hierarchy.nodes.len()) {
        Some(element) => {
            let mut last = element;
            while forest.second[last] != 0 {
                last = forest.second[last] as usize;
            }
            element..last + 1
        }
        None => {
            let node = &hierarchy.nodes[id as usize];
            let first_side = forest.sides_of(node.first).start;
            let end_side = forest.sides_of(node.end - 1).end;
            forest.first_element[first_side] as usize..forest.first_element[end_side] as usize
        }
    }
}
