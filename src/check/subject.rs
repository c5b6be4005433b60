//! What is checked, and who lies in what: the nodes above every element, and points of nodes.

use crate::hierarchy::Hierarchy;
use crate::math::{Plane, hash_pair};
use crate::radiosity::{Link, Piece, Solution, place};
use crate::tracer::Tracer;
use glam::{DVec3, Vec3};

/// A solution with the scene it belongs to. Nodes have the ids that links use: clusters, then elements.
pub(super) struct Subject<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) tracer: &'a dyn Tracer,
    pub(super) solution: &'a Solution,
    /// Elements that are not split, in the order of their ids.
    pub(super) leaves: Vec<u32>,
    /// The node that each element is a part of.
    parents: Vec<u32>,
}

impl<'a> Subject<'a> {
    pub(super) fn new(
        hierarchy: &'a Hierarchy,
        tracer: &'a dyn Tracer,
        solution: &'a Solution,
    ) -> Subject<'a> {
        let forest = &solution.forest;
        let clusters = hierarchy.nodes.len() as u32;
        let mut parents = vec![0; forest.len()];
        for side in 0..forest.side_count() {
            parents[forest.first_element[side] as usize] = hierarchy.leaf(forest.side(side).facet);
        }
        for (element, &second) in (0..).zip(&forest.second) {
            if second != 0 {
                parents[element as usize + 1] = clusters + element;
                parents[second as usize] = clusters + element;
            }
        }
        let leaves = forest.leaves().map(|element| element as u32).collect();
        Subject { hierarchy, tracer, solution, leaves, parents }
    }

    /// The element that a node is, or `None` for a cluster.
    pub(super) fn element(&self, node: u32) -> Option<u32> {
        node.checked_sub(self.hierarchy.nodes.len() as u32)
    }

    /// The node that an element is.
    pub(super) fn node(&self, element: u32) -> u32 {
        self.hierarchy.nodes.len() as u32 + element
    }

    /// A node and all nodes that it is a part of, upwards.
    pub(super) fn lineage(&self, node: u32) -> impl Iterator<Item = u32> + Clone + '_ {
        std::iter::successors(Some(node), |&node| match self.element(node) {
            Some(element) => Some(self.parents[element as usize]),
            None => self.hierarchy.parent(node),
        })
    }

    /// The links that cover a pair of elements: those from a node that holds the source to one that
    /// holds the receiver.
    pub(super) fn links_between(&self, receiver: u32, source: u32) -> impl Iterator<Item = &'a Link> + '_ {
        let sources = self.lineage(self.node(source));
        let links = &self.solution.links;
        self.lineage(self.node(receiver)).filter(|&r| !links.of(r).is_empty()).flat_map(move |r| {
            let of = links.of(r);
            sources.clone().flat_map(move |s| {
                let first = of.partition_point(|link| link.source < s);
                of[first..].iter().take_while(move |link| link.source == s)
            })
        })
    }

    /// A node as an area to pick points of.
    pub(super) fn area_of(&self, node: u32) -> Area {
        Area { node, piece: self.element(node).map(|element| self.piece(element)) }
    }

    /// A point of an area. All are equally likely, for both sides of a cluster together, with numbers in [0, 1) at random:
    /// `at` picks a side, `(u, v)` the point on it.
    pub(super) fn spot(&self, area: &Area, at: f64, (u, v): (f64, f64)) -> Spot {
        let forest = &self.solution.forest;
        let root;
        let piece = match &area.piece {
            Some(piece) => piece,
            None => {
                root = forest.root(self.hierarchy, self.side_below(area.node, at));
                &root
            }
        };
        let point = piece.polygon.point_at(u, v);
        let leaf = forest.element_in(piece, point, |_| false);
        Spot { point, plane: piece.plane, facet: piece.side.facet, leaf }
    }

    /// The number of the side below a cluster that `at`, in [0, 1), points to when all its area is laid in a row.
    fn side_below(&self, cluster: u32, at: f64) -> usize {
        let (facet, left) = self.hierarchy.facet_at(cluster, at);
        let sides = self.solution.forest.sides_of(facet);
        (sides.start + (left * sides.len() as f64) as usize).min(sides.end - 1)
    }

    /// What an element shines by itself, W/m², and its reflectance.
    pub(super) fn surface_of(&self, element: u32) -> (Vec3, Vec3) {
        let forest = &self.solution.forest;
        let side = forest.side_of(element);
        (self.hierarchy.emitted(forest.side(side)), forest.reflectance(self.hierarchy, side).of(element))
    }

    /// Area of an element, local units.
    pub(super) fn area(&self, element: u32) -> f64 {
        self.solution.forest.area[element as usize] as f64
    }

    pub(super) fn piece(&self, element: u32) -> Piece {
        self.solution.forest.piece(self.hierarchy, element)
    }

    /// Where an element is, for people: the middle of it in scene units, and its material.
    pub(super) fn place(&self, element: u32) -> String {
        place(self.hierarchy, &self.solution.forest, self.node(element))
    }

    /// The two ends of a link, for people.
    pub(super) fn places(&self, link: &Link) -> String {
        let [receiver, source] =
            [link.receiver, link.source].map(|node| place(self.hierarchy, &self.solution.forest, node));
        format!("to {receiver} from {source}")
    }
}

/// Where points are picked.
pub(super) struct Area {
    node: u32,
    /// None of a cluster.
    piece: Option<Piece>,
}

/// A point of a surface.
pub(super) struct Spot {
    pub(super) point: DVec3,
    /// Of the side it lies on.
    pub(super) plane: Plane,
    pub(super) facet: u32,
    /// The leaf element it lies on.
    pub(super) leaf: u32,
}

/// Leaf elements, to be picked with a probability proportional to a weight.
pub(super) struct Lottery<'a> {
    leaves: &'a [u32],
    /// Sum of the weights up to and with each leaf.
    sums: Vec<f64>,
    pub(super) total: f64,
}

impl<'a> Lottery<'a> {
    /// Weights that are not positive numbers count as 0.
    pub(super) fn new(leaves: &'a [u32], weight: impl Fn(u32) -> f64) -> Lottery<'a> {
        let mut total = 0.0;
        let sums = leaves
            .iter()
            .map(|&leaf| {
                let weight = weight(leaf);
                total += if weight > 0.0 && weight.is_finite() { weight } else { 0.0 };
                total
            })
            .collect();
        Lottery { leaves, sums, total }
    }

    /// The leaf that `at`, in [0, 1), points to when all weights are laid in a row.
    pub(super) fn pick(&self, at: f64) -> u32 {
        let target = at * self.total;
        self.leaves[self.sums.partition_point(|&sum| sum <= target).min(self.leaves.len() - 1)]
    }
}

/// Salts from here on pick sides of nodes: smaller ones make the sequences of points on them.
pub(super) const SIDES: u64 = 16;

/// A number in [0, 1) that looks random and depends on both.
pub(super) fn fraction(seed: u64, salt: u64) -> f64 {
    (hash_pair(seed, salt) >> 11) as f64 / (1u64 << 53) as f64
}
