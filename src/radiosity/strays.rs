//! Stray light: what no link carries, because the few rays of a pair saw no way through. Each such pair
//! brings next to nothing, but there are very many of them. Rays over whole groups of surfaces find how
//! much reflected light they bring together; the surfaces of a group then receive that much more than their
//! links bring, both sides of small ones alike. Emission is left out: few rays meet a lamp, so what they found would be noise.

use super::forest::Forest;
use super::gains::Gains;
use super::links::{LinkClass, LinkSet};
use super::transport::Light;
use crate::hierarchy::{Hierarchy, NodeKind};
use crate::math::{PairSequence, cosine_direction, hash_pair};
use crate::progress::{Progress, Work};
use crate::tracer::{Departure, PACKET, Ray, Tracer, departing_hits};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

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

/// Marks of all groups that are looked at at the same time: at most this many, 256 MiB, or
/// [`FEWEST_RUNS`] times those of the scene.
const MOST_MARKS: usize = 1 << 26;

/// However large the scene, the groups are dealt out in this many runs.
const FEWEST_RUNS: usize = 8;

/// In how many runs the groups are dealt out to the threads: each has an array of marks as large as the
/// scene, so the runs are few, and no more than fit in memory together.
fn runs(threads: usize, nodes: usize) -> usize {
    let most = (MOST_MARKS / nodes.max(1)).max(FEWEST_RUNS);
    if threads <= most { 4 * threads } else { most }
}

/// Links in place, and the light to look for.
pub(super) struct Watched<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) forest: &'a Forest,
    pub(super) light: &'a Light,
    pub(super) links: &'a LinkSet,
    pub(super) tracer: &'a dyn Tracer,
}

/// Surfaces that are looked at together: a cluster, or one cell of a large facet, which is a side or the
/// part of it between the lines it is cut along. So it does not matter how finely a cell is divided.
struct Group {
    /// The node that holds all of it.
    root: u32,
    area: f64,
}

/// Which sources the links of one receiver and of all nodes above it cover.
struct Covered {
    stamp: u32,
    marks: Vec<u32>,
}

impl Watched<'_> {
    /// Looks for stray light in groups of about `wall_area` / 16, with up to `rays` rays each: what elements receive with it
    /// over what links bring. `before` is what they receive over that now.
    pub(super) fn strays(&self, wall_area: f64, rays: u32, before: &Gains, progress: &dyn Progress) -> Gains {
        let group_area = GROUP * wall_area;
        let groups = self.groups(group_area);
        progress.start("stray light", groups.len() as u64);
        let nodes = self.hierarchy.nodes.len() + self.forest.len();
        let run = groups.len().div_ceil(runs(rayon::current_num_threads(), nodes)).max(1);
        let found: Vec<f32> = groups
            .par_chunks(run)
            .flat_map_iter(|groups| {
                let mut covered = Covered { stamp: 0, marks: vec![0; nodes] };
                let gain = move |group: &Group| {
                    let _work = Work::begin(progress, "stray light");
                    let count = rays as f64 * (group.area / group_area).min(LARGEST);
                    let count = (count as u32).max(FEWEST).next_multiple_of(PACKET as u32);
                    progress.advance(1);
                    self.gain(group, count, before, &mut covered)
                };
                groups.iter().map(gain)
            })
            .collect();
        progress.finish();
        let mut factors = vec![1.0; self.forest.len()];
        for (group, gain) in groups.iter().zip(found) {
            factors[self.elements(group)].fill(gain);
        }
        Gains::from_factors(factors)
    }

    /// All lit surfaces, in groups of at most about this area.
    fn groups(&self, most: f64) -> Vec<Group> {
        let mut groups = Vec::new();
        self.groups_of(0, most, &mut groups);
        groups
    }

    fn groups_of(&self, root: u32, most: f64, groups: &mut Vec<Group>) {
        let node = &self.hierarchy.nodes[root as usize];
        let area = node.area as f64 * self.hierarchy.sides() as f64;
        if area <= most {
            groups.push(Group { root, area });
            return;
        }
        match node.kind(root) {
            NodeKind::Cluster(children) => {
                children.into_iter().for_each(|child| self.groups_of(child, most, groups));
            }
            NodeKind::Leaf(_) => groups.extend(self.cells(self.elements_of(root)).map(|cell| {
                let area = self.forest.area[cell as usize] as f64;
                Group { root: self.node_of(cell), area }
            })),
        }
    }

    /// All elements of a group.
    fn elements(&self, group: &Group) -> Range<usize> {
        match group.root.checked_sub(self.node_of(0)) {
            None => self.elements_of(group.root),
            Some(cell) => cell as usize..self.end_of_cell(cell as usize),
        }
    }

    /// All elements of a cluster.
    fn elements_of(&self, cluster: u32) -> Range<usize> {
        let node = &self.hierarchy.nodes[cluster as usize];
        let end = self.forest.sides_of(node.end - 1).end;
        let sides = self.forest.sides_of(node.first).start..end;
        let [start, end] = [sides.start, sides.end].map(|side| self.forest.first_element[side] as usize);
        start..end
    }

    fn end_of_cell(&self, cell: usize) -> usize {
        cell + self.forest.cell[cell..].iter().take_while(|&&c| c as usize == cell).count()
    }

    /// The first elements of all cells among `elements`.
    fn cells(&self, elements: Range<usize>) -> impl Iterator<Item = u32> + '_ {
        let Range { mut start, end } = elements;
        std::iter::from_fn(move || {
            // An element of several cells is none itself: what follows it belongs to the first of them.
            while start < end {
                let first = start;
                start = self.end_of_cell(first);
                if self.forest.second[first] == 0 || start > first + 1 {
                    return Some(first as u32);
                }
            }
            None
        })
    }

    /// The leaf elements of a cell.
    fn leaves_below(&self, cell: u32) -> impl Iterator<Item = usize> + '_ {
        let elements = cell as usize..self.end_of_cell(cell as usize);
        elements.filter(|&element| self.forest.second[element] == 0)
    }

    /// The nodes from `from` down to `to`, which lies in it.
    fn path(&self, from: u32, to: u32) -> impl Iterator<Item = u32> + '_ {
        let clusters = self.node_of(0);
        let side = to.checked_sub(clusters).map(|element| self.forest.side_of(element));
        let facet = match side {
            Some(side) => self.forest.side(side).facet,
            None => self.hierarchy.nodes[to as usize].first,
        };
        std::iter::successors(Some(from), move |&node| {
            if node == to {
                return None;
            }
            if let Some(element) = node.checked_sub(clusters) {
                let second = clusters + self.forest.second[element as usize];
                return Some(if to < second { node + 1 } else { second });
            }
            match self.hierarchy.nodes[node as usize].kind(node) {
                NodeKind::Leaf(_) => side.map(|side| self.node_of(self.forest.first_element[side])),
                NodeKind::Cluster([first, second]) => {
                    let is_second = facet >= self.hierarchy.nodes[second as usize].first;
                    Some(if is_second { second } else { first })
                }
            }
        })
    }

    fn node_of(&self, element: u32) -> u32 {
        self.hierarchy.nodes.len() as u32 + element
    }

    /// What a group receives over what its links bring.
    fn gain(&self, group: &Group, count: u32, before: &Gains, covered: &mut Covered) -> f32 {
        let cells: Vec<u32> = self.cells(self.elements(group)).collect();
        let area = |cell: u32| self.forest.area[cell as usize] as f64;
        let linked: f64 = cells
            .iter()
            .map(|&cell| {
                let leaves = self.leaves_below(cell);
                let power = |leaf: usize| {
                    let irradiance = self.light.irradiance[leaf].element_sum();
                    f64::from(
                        irradiance / before.of(leaf as u32).max(f32::MIN_POSITIVE) * self.forest.area[leaf],
                    )
                };
                leaves.map(power).sum::<f64>()
            })
            .sum();
        if linked <= 0.0 {
            return 1.0;
        }
        let mut sum = 0.0;
        let sums: Vec<f64> = cells
            .iter()
            .map(|&cell| {
                sum += area(cell);
                sum
            })
            .collect();
        covered.begin();
        self.path(0, group.root).for_each(|node| covered.mark(self.links, node));
        let common = covered.stamp;
        let (mut marked, mut own) = (usize::MAX, common);
        let side = cells.first().map_or(0, |&cell| self.forest.side_of(cell));
        let sequence = PairSequence::new(hash_pair(side as u64, 0x57_72_61_79));
        let (mut stray, mut linked_rays) = (0.0, 0);
        for first in (0..count).step_by(PACKET) {
            let owners: [usize; PACKET] = std::array::from_fn(|i| {
                let at = (f64::from(first + i as u32) + 0.5) / f64::from(count) * sum;
                sums.partition_point(|&s| s <= at).min(sums.len() - 1)
            });
            let mut known = (owners[0], self.forest.piece(self.hierarchy, cells[owners[0]]));
            let departures: [Departure; PACKET] = std::array::from_fn(|i| {
                let [u, v, s, t] = sequence.point(first + i as u32);
                if known.0 != owners[i] {
                    let piece = self.forest.piece(self.hierarchy, cells[owners[i]]);
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
                let Some(source) = self.forest.leaf_met(self.hierarchy, &rays[i], &hit) else { continue };
                let reflectance = self.forest.reflectance_of(self.hierarchy, source);
                let irradiance = self.light.irradiance[source.id as usize];
                let brought = (irradiance * reflectance).element_sum() as f64;
                if brought <= 0.0 {
                    linked_rays += 1;
                    continue;
                }
                if marked != owners[i] {
                    marked = owners[i];
                    covered.next();
                    own = covered.stamp;
                    let cell = self.node_of(cells[marked]);
                    self.path(group.root, cell).for_each(|node| covered.mark(self.links, node));
                }
                covered.next();
                self.mark_elements(cells[marked], departures[i].point, covered);
                if covered.holds(self, source.id, [common, own]) {
                    linked_rays += 1;
                } else {
                    stray += brought / f64::from(count);
                }
            }
        }
        // What comes back over the links, that much more of it, must not grow from bounce to bounce.
        let reflectances = cells.iter().map(|&cell| {
            self.forest.reflectance(self.hierarchy, self.forest.side_of(cell)).of(cell).max_element()
        });
        let returned =
            f64::from(reflectances.fold(0.0, f32::max)) * f64::from(linked_rays) / f64::from(count);
        let most = MOST.min((MOST_RETURNED / returned.max(f64::MIN_POSITIVE)).max(1.0));
        // Rounded, so that what differs by rounding stays the same.
        let gain = ((linked + stray * sum) / linked).min(most);
        ((gain * STEPS).round() / STEPS) as f32
    }

    /// Marks what covers sources for a point of a cell, from the cell down to the leaf element.
    fn mark_elements(&self, cell: u32, point: DVec3, covered: &mut Covered) {
        for element in self.forest.elements_below(self.hierarchy, cell, point) {
            covered.mark(self.links, self.node_of(element));
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

    /// Whether a link covers a leaf element: one made to it or to a node above it, marked now or with one
    /// of the `older` stamps.
    fn holds(&self, scene: &Watched<'_>, leaf: u32, older: [u32; 2]) -> bool {
        scene.path(0, scene.node_of(leaf)).any(|node| {
            let mark = self.marks[node as usize];
            mark == self.stamp || older.contains(&mark)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_bounded_whatever_the_number_of_threads() {
        for nodes in [1, 1000, 1 << 20, 10_000_000, usize::MAX / 2] {
            for threads in [1, 2, 8, 64, 1024] {
                let runs = runs(threads, nodes);
                let together = runs.min(threads);
                assert!(runs >= threads.min(FEWEST_RUNS), "{runs} runs leave threads idle");
                assert!(together <= FEWEST_RUNS.max(MOST_MARKS / nodes), "{together} arrays of {nodes}");
            }
        }
    }
}
