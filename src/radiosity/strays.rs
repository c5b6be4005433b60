//! Stray light: what no link carries, because the few rays of a pair saw no way through. Each such pair
//! brings next to nothing, but there are very many of them. Rays over whole groups of surfaces find how
//! much light they bring together; the surfaces of a group then receive that much more than their links
//! bring.

use super::forest::{Forest, Piece};
use super::links::LinkSet;
use super::transport::Light;
use crate::hierarchy::{Hierarchy, NodeKind, Side};
use crate::math::{PairSequence, cosine_direction, hash_pair};
use crate::tracer::{Departure, NO_FACET, PACKET, Ray, Tracer, departing_hits};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A group of surfaces has about this share of the area of a wall.
const GROUP: f64 = 1.0 / 64.0;

/// Fewest rays for a group.
const FEWEST: u32 = 32;

/// No group receives more than this times what its links bring.
const MOST: f32 = 4.0;

/// What each element receives, over what its links bring.
#[derive(Clone, Debug)]
pub(super) struct Strays(Vec<f32>);

impl Strays {
    /// None, for `elements` elements.
    pub(super) fn none(elements: usize) -> Strays {
        Strays(vec![1.0; elements])
    }

    /// What `element` receives, over what its links bring.
    #[inline]
    pub(super) fn gain(&self, element: u32) -> f32 {
        self.0[element as usize]
    }

    /// Looks for stray light in groups of about `wall_area` / 64, with up to `rays` rays each.
    pub(super) fn found(
        scene: &Watched<'_>,
        wall_area: f64,
        rays: u32,
        before: &Strays,
        advance: &(dyn Fn(u64) + Sync),
    ) -> Strays {
        let group_area = GROUP * wall_area;
        let groups = scene.groups(group_area);
        let gains: Vec<f32> = groups
            .par_iter()
            .map_init(
                || Covered { stamp: 0, marks: vec![0; scene.hierarchy.nodes.len() + scene.forest.len()] },
                |covered, group| {
                    let count = (rays as f64 * (group.area / group_area).min(1.0)) as u32;
                    let count = count.max(FEWEST).next_multiple_of(PACKET as u32);
                    let gain = scene.gain(group, count, before, covered);
                    advance(1);
                    gain
                },
            )
            .collect();
        let mut strays = Strays::none(scene.forest.len());
        for (group, gain) in groups.iter().zip(gains) {
            for leaf in &group.leaves {
                strays.0[leaf.element as usize] = gain;
            }
        }
        strays
    }
}

/// Links in place, and the light to look for.
pub(super) struct Watched<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) forest: &'a Forest,
    pub(super) light: &'a Light,
    pub(super) links: &'a LinkSet,
    pub(super) tracer: &'a dyn Tracer,
}

/// A leaf element and the nodes above it that lie within its group.
struct Leaf {
    element: u32,
    side: u32,
    chain: Vec<u32>,
}

/// Surfaces that are looked at together.
struct Group {
    leaves: Vec<Leaf>,
    /// Nodes above all of it.
    above: Vec<u32>,
    area: f64,
}

/// Which sources the links of one receiver and of all nodes above it cover.
struct Covered {
    stamp: u32,
    marks: Vec<u32>,
}

impl Watched<'_> {
    /// All lit surfaces, in groups of at most about this area.
    fn groups(&self, most: f64) -> Vec<Group> {
        let mut groups = Vec::new();
        let mut above = Vec::new();
        self.groups_of(0, most, &mut above, &mut groups);
        groups
    }

    fn groups_of(&self, index: u32, most: f64, above: &mut Vec<u32>, groups: &mut Vec<Group>) {
        let node = &self.hierarchy.nodes[index as usize];
        let sides = self.hierarchy.sides() as f64;
        if node.area as f64 * sides <= most {
            let mut group =
                Group { leaves: Vec::new(), above: above.clone(), area: node.area as f64 * sides };
            self.collect(index, &mut Vec::new(), &mut group);
            groups.push(group);
            return;
        }
        above.push(index);
        match node.kind(index) {
            NodeKind::Cluster(children) => {
                children.into_iter().for_each(|child| self.groups_of(child, most, above, groups));
            }
            NodeKind::Leaf(facet) => {
                for side in self.forest.sides_of(facet) {
                    self.groups_of_element(self.forest.first_element[side], side as u32, most, above, groups);
                }
            }
        }
        above.pop();
    }

    fn groups_of_element(
        &self,
        element: u32,
        side: u32,
        most: f64,
        above: &mut Vec<u32>,
        groups: &mut Vec<Group>,
    ) {
        let (area, second) =
            (self.forest.area[element as usize] as f64, self.forest.second[element as usize]);
        if area <= most || second == 0 {
            let mut group = Group { leaves: Vec::new(), above: above.clone(), area };
            self.collect_elements(element, side, &mut Vec::new(), &mut group);
            groups.push(group);
            return;
        }
        above.push(self.node_of(element));
        for half in [element + 1, second] {
            self.groups_of_element(half, side, most, above, groups);
        }
        above.pop();
    }

    fn collect(&self, index: u32, chain: &mut Vec<u32>, group: &mut Group) {
        chain.push(index);
        match self.hierarchy.nodes[index as usize].kind(index) {
            NodeKind::Cluster(children) => children.into_iter().for_each(|c| self.collect(c, chain, group)),
            NodeKind::Leaf(facet) => {
                for side in self.forest.sides_of(facet) {
                    self.collect_elements(self.forest.first_element[side], side as u32, chain, group);
                }
            }
        }
        chain.pop();
    }

    fn collect_elements(&self, element: u32, side: u32, chain: &mut Vec<u32>, group: &mut Group) {
        chain.push(self.node_of(element));
        match self.forest.second[element as usize] {
            0 => group.leaves.push(Leaf { element, side, chain: chain.clone() }),
            second => {
                [element + 1, second].into_iter().for_each(|e| self.collect_elements(e, side, chain, group))
            }
        }
        chain.pop();
    }

    fn node_of(&self, element: u32) -> u32 {
        self.hierarchy.nodes.len() as u32 + element
    }

    /// What a group receives over what its links bring.
    fn gain(&self, group: &Group, count: u32, before: &Strays, covered: &mut Covered) -> f32 {
        let mut sum = 0.0;
        let sums: Vec<f64> = group
            .leaves
            .iter()
            .map(|leaf| {
                sum += self.forest.area[leaf.element as usize] as f64;
                sum
            })
            .collect();
        let linked: f64 = group
            .leaves
            .iter()
            .map(|leaf| {
                let e = leaf.element as usize;
                let irradiance = self.light.irradiance[e].element_sum() / before.gain(leaf.element);
                (irradiance * self.forest.area[e]) as f64
            })
            .sum();
        if linked <= 0.0 {
            return 1.0;
        }
        let seed = group.leaves.first().map_or(0, |leaf| leaf.element as u64);
        let sequence = PairSequence::new(hash_pair(seed, 0x57_72_61_79));
        covered.begin();
        group.above.iter().for_each(|&node| covered.mark(self.links, node));
        let common = covered.stamp;
        let mut stray = 0.0;
        let mut current: Option<(usize, Piece<'_>)> = None;
        for first in (0..count).step_by(PACKET) {
            let nowhere =
                Departure { point: DVec3::ZERO, normal: DVec3::Z, facet: NO_FACET, direction: Vec3::Z };
            let mut departures = [nowhere; PACKET];
            let mut owners = [0usize; PACKET];
            for i in 0..PACKET {
                let index = first + i as u32;
                let at = (index as f64 + 0.5) / count as f64 * sum;
                let leaf = sums.partition_point(|&s| s <= at).min(sums.len() - 1);
                if current.as_ref().is_none_or(|(known, _)| *known != leaf) {
                    let known = &group.leaves[leaf];
                    current = Some((leaf, self.piece_of(known)));
                }
                let Some((_, piece)) = &current else { continue };
                let [u, v, s, t] = sequence.point(index);
                let normal = piece.plane.normal;
                let (point, direction) = (piece.polygon.point_at(u, v), cosine_direction(normal, s, t));
                departures[i] = Departure { point, normal, facet: piece.side.facet, direction };
                owners[i] = leaf;
            }
            let mut rays = [Ray { origin: Vec3::ZERO, direction: Vec3::Z }; PACKET];
            let mut hits = [None; PACKET];
            departing_hits(self.tracer, &departures, &mut rays, &mut hits);
            let mut marked = usize::MAX;
            for ((ray, hit), &owner) in rays.iter().zip(&hits).zip(&owners) {
                let Some(hit) = hit else { continue };
                let plane = self.hierarchy.facets[hit.facet as usize].plane;
                let back = plane.normal.dot(ray.direction.as_dvec3()) > 0.0;
                let side = Side { facet: hit.facet, back };
                let point = (ray.origin + ray.direction * hit.t).as_dvec3();
                let Some(source) = self.forest.leaf_at(self.hierarchy, side, point) else { continue };
                let id = source.id() as usize;
                let reflectance = Vec3::from(self.hierarchy.material(hit.facet).reflectance);
                let brought = (self.light.irradiance[id] * reflectance).element_sum() as f64;
                if brought <= 0.0 {
                    continue;
                }
                if marked != owner {
                    covered.next();
                    group.leaves[owner].chain.iter().for_each(|&node| covered.mark(self.links, node));
                    marked = owner;
                }
                if !covered.holds(self, side, id as u32, common) {
                    stray += brought / count as f64;
                }
            }
        }
        ((linked + stray * sum) / linked).min(MOST as f64) as f32
    }

    /// The leaf's geometry.
    fn piece_of(&self, leaf: &Leaf) -> Piece<'_> {
        let mut piece = self.forest.root(self.hierarchy, leaf.side as usize);
        while piece.id() != leaf.element {
            let second = self.forest.second[piece.id() as usize];
            let [a, b] = piece.halves(self.forest);
            piece = if leaf.element < second { a } else { b };
        }
        piece
    }
}

impl Covered {
    /// Forgets everything.
    fn begin(&mut self) {
        if self.stamp > u32::MAX / 2 {
            self.marks.fill(0);
            self.stamp = 0;
        }
        self.stamp += 1;
    }

    /// Forgets all but what was marked since the last [`Covered::begin`] and before the first call of this.
    fn next(&mut self) {
        self.stamp += 1;
    }

    fn mark(&mut self, links: &LinkSet, receiver: u32) {
        for link in links.of(receiver) {
            self.marks[link.source as usize] = self.stamp;
        }
    }

    /// Whether a link covers the leaf element on this side: one made to it or to a node above it.
    fn holds(&self, scene: &Watched<'_>, side: Side, leaf: u32, common: u32) -> bool {
        let is_marked = |node: u32| {
            let mark = self.marks[node as usize];
            mark == self.stamp || mark == common
        };
        let mut index = 0u32;
        loop {
            if is_marked(index) {
                return true;
            }
            match scene.hierarchy.nodes[index as usize].kind(index) {
                NodeKind::Leaf(_) => break,
                NodeKind::Cluster([first, second]) => {
                    let is_second = side.facet >= scene.hierarchy.nodes[second as usize].first;
                    index = if is_second { second } else { first };
                }
            }
        }
        let Some(side) = scene.forest.side_index(side) else { return true };
        let mut element = scene.forest.first_element[side];
        loop {
            if is_marked(scene.node_of(element)) {
                return true;
            }
            if element == leaf {
                return false;
            }
            let second = scene.forest.second[element as usize];
            element = if leaf < second { element + 1 } else { second };
        }
    }
}
