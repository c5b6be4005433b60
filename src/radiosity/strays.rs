//! Stray light: what no link carries, because the few rays of a pair saw no way through. Each such pair
//! brings next to nothing, but there are very many of them. Rays over whole groups of surfaces find how
//! much reflected light they bring together; the surfaces of a group then receive that much more than their
//! links bring. Emission is left out: few rays meet a lamp, so what they found would be noise.

use super::forest::{Forest, Piece};
use super::links::{LinkClass, LinkSet};
use super::transport::Light;
use crate::hierarchy::{Hierarchy, NodeKind, Side};
use crate::math::{PairSequence, cosine_direction, hash_pair};
use crate::tracer::{Departure, PACKET, Ray, Tracer, departing_hits};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A group of surfaces has about this share of the area of a wall.
const GROUP: f64 = 1.0 / 16.0;

/// Fewest rays for a group.
const FEWEST: u32 = 32;

/// A large surface is a group by itself, with at most this many times the rays.
const LARGEST: f64 = 4.0;

/// No group receives more than this times what its links bring.
const MOST: f64 = 4.0;

/// A group never sends back more than this share of what it receives over links.
const MOST_RETURNED: f64 = 0.99;

/// Gains are rounded to this part of 1.
const STEPS: f64 = 1024.0;

/// What each element receives, over what its links bring.
#[derive(Clone, Debug)]
pub struct Strays(Vec<f32>);

impl Strays {
    /// None, for `elements` elements.
    pub(super) fn none(elements: usize) -> Strays {
        Strays(vec![1.0; elements])
    }

    /// What `element` receives, over what its links bring.
    #[inline]
    pub fn gain(&self, element: u32) -> f32 {
        self.0[element as usize]
    }

    /// Looks for stray light in groups of about `wall_area` / 16, with up to `rays` rays each.
    pub(super) fn found(
        scene: &Watched<'_>,
        wall_area: f64,
        rays: u32,
        before: &Strays,
        advance: &(dyn Fn(u64) + Sync),
    ) -> Strays {
        let group_area = GROUP * wall_area;
        let groups = scene.groups(group_area);
        // One array of marks for each of a few long runs of groups: they are as large as the scene.
        let run = groups.len().div_ceil(4 * rayon::current_num_threads()).max(1);
        let gains: Vec<f32> = groups
            .par_chunks(run)
            .flat_map_iter(|groups| {
                let marks = vec![0; scene.hierarchy.nodes.len() + scene.forest.len()];
                let mut covered = Covered { stamp: 0, marks };
                let gain = move |group: &Group| {
                    let count = rays as f64 * (group.area / group_area).min(LARGEST);
                    let count = (count as u32).max(FEWEST).next_multiple_of(PACKET as u32);
                    advance(1);
                    scene.gain(group, count, before, &mut covered)
                };
                groups.iter().map(gain)
            })
            .collect();
        let mut strays = Strays::none(scene.forest.len());
        for (group, gain) in groups.iter().zip(gains) {
            for cell in &group.cells {
                let first = cell.element as usize;
                let elements = scene.forest.cell[first..].iter().take_while(|&&c| c == cell.element).count();
                strays.0[first..first + elements].fill(gain);
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

/// A side, or the part of it between the lines it is cut along.
struct Cell {
    /// Its first element.
    element: u32,
    side: u32,
    /// The nodes above it that lie within its group.
    chain: Vec<u32>,
}

/// Surfaces that are looked at together. Groups hold whole cells, so that it does not matter how finely
/// these are divided.
struct Group {
    cells: Vec<Cell>,
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
        let area = node.area as f64 * self.hierarchy.sides() as f64;
        if area <= most {
            let mut group = Group { cells: Vec::new(), above: above.clone(), area };
            self.collect(index, &mut Vec::new(), &mut group.cells);
            groups.push(group);
            return;
        }
        match node.kind(index) {
            NodeKind::Cluster(children) => {
                above.push(index);
                children.into_iter().for_each(|child| self.groups_of(child, most, above, groups));
                above.pop();
            }
            NodeKind::Leaf(_) => {
                let mut cells = Vec::new();
                self.collect(index, &mut Vec::new(), &mut cells);
                groups.extend(cells.into_iter().map(|cell| {
                    let area = self.forest.area[cell.element as usize] as f64;
                    Group { cells: vec![cell], above: above.clone(), area }
                }));
            }
        }
    }

    fn collect(&self, index: u32, chain: &mut Vec<u32>, cells: &mut Vec<Cell>) {
        chain.push(index);
        match self.hierarchy.nodes[index as usize].kind(index) {
            NodeKind::Cluster(children) => children.into_iter().for_each(|c| self.collect(c, chain, cells)),
            NodeKind::Leaf(facet) => {
                for side in self.forest.sides_of(facet) {
                    self.collect_cells(self.forest.root(self.hierarchy, side), side as u32, chain, cells);
                }
            }
        }
        chain.pop();
    }

    fn collect_cells(&self, piece: Piece<'_>, side: u32, chain: &mut Vec<u32>, cells: &mut Vec<Cell>) {
        if piece.is_cell() {
            cells.push(Cell { element: piece.id(), side, chain: chain.clone() });
            return;
        }
        chain.push(self.node_of(piece.id()));
        piece.halves(self.forest).into_iter().for_each(|half| self.collect_cells(half, side, chain, cells));
        chain.pop();
    }

    fn node_of(&self, element: u32) -> u32 {
        self.hierarchy.nodes.len() as u32 + element
    }

    /// What a group receives over what its links bring.
    fn gain(&self, group: &Group, count: u32, before: &Strays, covered: &mut Covered) -> f32 {
        let area = |cell: &Cell| self.forest.area[cell.element as usize] as f64;
        let linked: f64 = group
            .cells
            .iter()
            .map(|cell| {
                let irradiance = self.light.irradiance[cell.element as usize].element_sum();
                (irradiance / before.gain(cell.element)) as f64 * area(cell)
            })
            .sum();
        if linked <= 0.0 {
            return 1.0;
        }
        let mut sum = 0.0;
        let sums: Vec<f64> = group
            .cells
            .iter()
            .map(|cell| {
                sum += area(cell);
                sum
            })
            .collect();
        covered.begin();
        group.above.iter().for_each(|&node| covered.mark(self.links, node));
        let common = covered.stamp;
        let (mut marked, mut own) = (usize::MAX, common);
        let first_cell = group.cells.first().map_or(0, |cell| cell.side as u64);
        let sequence = PairSequence::new(hash_pair(first_cell, 0x57_72_61_79));
        let (mut stray, mut linked_rays) = (0.0, 0);
        for first in (0..count).step_by(PACKET) {
            let owners: [usize; PACKET] = std::array::from_fn(|i| {
                let at = (f64::from(first + i as u32) + 0.5) / f64::from(count) * sum;
                sums.partition_point(|&s| s <= at).min(sums.len() - 1)
            });
            let mut known = (owners[0], self.forest.piece(self.hierarchy, group.cells[owners[0]].element));
            let departures: [Departure; PACKET] = std::array::from_fn(|i| {
                let [u, v, s, t] = sequence.point(first + i as u32);
                if known.0 != owners[i] {
                    let piece = self.forest.piece(self.hierarchy, group.cells[owners[i]].element);
                    known = (owners[i], piece);
                }
                let piece = &known.1;
                Departure {
                    point: piece.polygon.point_at(u, v),
                    normal: piece.plane.normal,
                    facet: piece.side.facet,
                    direction: cosine_direction(piece.plane.normal, s, t),
                }
            });
            let mut rays = [Ray { origin: Vec3::ZERO, direction: Vec3::Z }; PACKET];
            let mut hits = [None; PACKET];
            departing_hits(self.tracer, &departures, &mut rays, &mut hits);
            for i in 0..PACKET {
                let Some(hit) = hits[i] else { continue };
                let plane = self.hierarchy.facets[hit.facet as usize].plane;
                let back = plane.normal.dot(rays[i].direction.as_dvec3()) > 0.0;
                let side = Side { facet: hit.facet, back };
                let point = (rays[i].origin + rays[i].direction * hit.t).as_dvec3();
                let Some(source) = self.forest.leaf_at(self.hierarchy, side, point) else { continue };
                let reflectance = Vec3::from(self.hierarchy.material(hit.facet).reflectance);
                let irradiance = self.light.irradiance[source.id() as usize];
                let brought = (irradiance * reflectance).element_sum() as f64;
                if brought <= 0.0 {
                    linked_rays += 1;
                    continue;
                }
                if marked != owners[i] {
                    marked = owners[i];
                    covered.next();
                    own = covered.stamp;
                    group.cells[marked].chain.iter().for_each(|&node| covered.mark(self.links, node));
                }
                covered.next();
                self.mark_elements(&group.cells[marked], departures[i].point, covered);
                if covered.holds(self, side, source.id(), [common, own]) {
                    linked_rays += 1;
                } else {
                    stray += brought / f64::from(count);
                }
            }
        }
        // What comes back over the links, that much more of it, must not grow from bounce to bounce.
        let reflectances = group.cells.iter().map(|cell| {
            let facet = self.forest.side(cell.side as usize).facet;
            Vec3::from(self.hierarchy.material(facet).reflectance).max_element()
        });
        let returned =
            f64::from(reflectances.fold(0.0, f32::max)) * f64::from(linked_rays) / f64::from(count);
        let most = MOST.min((MOST_RETURNED / returned.max(f64::MIN_POSITIVE)).max(1.0));
        // Rounded, so that what differs by rounding stays the same.
        let gain = ((linked + stray * sum) / linked).min(most);
        ((gain * STEPS).round() / STEPS) as f32
    }

    /// Marks what covers sources for a point of a cell, from the cell down to the leaf element.
    fn mark_elements(&self, cell: &Cell, point: DVec3, covered: &mut Covered) {
        let mut piece = self.forest.piece(self.hierarchy, cell.element);
        let normal = piece.plane.normal;
        loop {
            covered.mark(self.links, self.node_of(piece.id()));
            if self.forest.second[piece.id() as usize] == 0 {
                return;
            }
            let is_first = piece.division(self.forest).is_in_first(point, normal);
            let [a, b] = piece.halves(self.forest);
            piece = if is_first { a } else { b };
        }
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

    /// Marks that follow are told from those before, and take their place.
    fn next(&mut self) {
        self.stamp += 1;
    }

    fn mark(&mut self, links: &LinkSet, receiver: u32) {
        for link in links.of(receiver).iter().filter(|link| link.class != LinkClass::Untested) {
            self.marks[link.source as usize] = self.stamp;
        }
    }

    /// Whether a link covers the leaf element on this side: one made to it or to a node above it, marked now
    /// or with one of the `older` stamps.
    fn holds(&self, scene: &Watched<'_>, side: Side, leaf: u32, older: [u32; 2]) -> bool {
        let is_marked = |node: u32| {
            let mark = self.marks[node as usize];
            mark == self.stamp || older.contains(&mark)
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
