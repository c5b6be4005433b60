//! How open surfaces lie in the clusters that hold them: of light that comes to a cluster from outside and is partly
//! kept off, by whatever, those get more that nothing in the cluster shades, and those that it hides get none.

use super::forest::Forest;
use super::links::{Link, LinkClass};
use crate::hierarchy::Hierarchy;
use crate::math::{CosineLobes, LobeWeights, PairSequence, cosine_direction};
use crate::tracer::{Departure, PACKET, Ray, Tracer, departing_hits};
use glam::Vec3;
use rayon::prelude::*;

/// Rays from each side; the same for all, so that what they get wrong differs little between neighbours.
const RAYS: usize = PACKET;

/// Where less than one part in this many of a cluster lies open, it does not receive more than that many times as much.
const MOST: f32 = 8.0;

/// No node.
const NONE: u32 = u32::MAX;

/// Rays of one side that end in one cluster.
#[derive(Clone, Copy, Debug)]
struct Kept {
    /// The smallest cluster that holds both ends of the rays.
    node: u32,
    /// How many of all rays of the side they are, as a share.
    share: f32,
}

/// What rays from all sides met.
#[derive(Clone, Debug, Default)]
pub struct Openness {
    /// First of the `kept` of each side, with their number at the end; empty when nothing is known.
    first: Vec<u32>,
    kept: Vec<Kept>,
    /// For each cluster the area that its sides turn towards each direction (x), and as much of it as lies open (y).
    areas: Vec<CosineLobes>,
}

/// Light that comes to a cluster over its links.
#[derive(Clone, Copy, Debug, Default)]
pub struct Arriving {
    /// Falls on all sides alike that face it.
    even: CosineLobes,
    /// Falls on sides as they lie open.
    uneven: CosineLobes,
}

impl Openness {
    /// Nothing is known: light falls on all sides alike.
    pub(super) fn unknown() -> Openness {
        Openness::default()
    }

    /// Casts rays from all sides.
    pub(super) fn found(hierarchy: &Hierarchy, forest: &Forest, tracer: &dyn Tracer) -> Openness {
        let mut parents = vec![NONE; hierarchy.nodes.len()];
        for (index, node) in hierarchy.nodes.iter().enumerate().filter(|(_, node)| !node.is_leaf()) {
            node.children(index as u32).into_iter().for_each(|child| parents[child as usize] = index as u32);
        }
        let ends: Vec<[u32; RAYS]> = (0..forest.side_count())
            .into_par_iter()
            .map(|side| ends_of_rays(hierarchy, forest, tracer, &parents, side))
            .collect();
        let mut openness = Openness { first: vec![0], ..Openness::default() };
        openness.areas = vec![CosineLobes::default(); hierarchy.nodes.len()];
        for (index, ends) in ends.iter().enumerate() {
            let side = forest.side(index);
            let normal = hierarchy.side_normal(side).as_vec3();
            let area = hierarchy.nodes[hierarchy.leaf(side.facet) as usize].area;
            openness.areas[hierarchy.leaf(side.facet) as usize].add(normal, Vec3::new(area, area, 0.0));
            // All light is from inside the whole scene.
            for run in ends.chunk_by(|a, b| a == b).filter(|run| ![NONE, 0].contains(&run[0])) {
                let share = run.len() as f32 / RAYS as f32;
                openness.areas[run[0] as usize].add(normal, Vec3::new(0.0, -share * area, 0.0));
                openness.kept.push(Kept { node: run[0], share });
            }
            openness.first.push(openness.kept.len() as u32);
        }
        for (index, &parent) in parents.iter().enumerate().skip(1).rev() {
            let own = openness.areas[index];
            openness.areas[parent as usize].merge(&own);
        }
        openness
    }

    /// Adds what one link of a cluster brings, across the `direction` it comes from, to what arrives there.
    pub fn add(&self, arriving: &mut Arriving, link: &Link, direction: Vec3, carried: Vec3) {
        // What rays did not find kept off is not shaded, and light of its own comes from everywhere in the cluster.
        if link.class != LinkClass::Partial || link.source == link.receiver || self.areas.is_empty() {
            arriving.even.add(direction, carried);
            return;
        }
        let lobes = &self.areas[link.receiver as usize];
        let areas = if direction == Vec3::ZERO { lobes.mean() } else { lobes.evaluate(direction) };
        let gain = if areas.y * MOST > areas.x { areas.x / areas.y } else { MOST };
        arriving.uneven.add(direction, carried * gain);
    }

    /// What falls on a side from all clusters it lies in; `arriving` is what came to each and to those above it.
    pub fn irradiance(
        &self,
        hierarchy: &Hierarchy,
        side: usize,
        forest: &Forest,
        arriving: &[Arriving],
    ) -> Vec3 {
        let named = forest.side(side);
        let weights = LobeWeights::toward(hierarchy.side_normal(named).as_vec3());
        let all = &arriving[hierarchy.leaf(named.facet) as usize];
        let mut uneven = all.uneven.evaluate_with(&weights);
        if let Some([first, end, ..]) = self.first.get(side..) {
            for kept in &self.kept[*first as usize..*end as usize] {
                uneven -= arriving[kept.node as usize].uneven.evaluate_with(&weights) * kept.share;
            }
        }
        all.even.evaluate_with(&weights).max(Vec3::ZERO) + uneven.max(Vec3::ZERO)
    }
}

impl Arriving {
    /// Adds to what came to each cluster what came to those above it.
    pub fn hand_down(hierarchy: &Hierarchy, arriving: &mut [Arriving]) {
        for (index, node) in hierarchy.nodes.iter().enumerate().filter(|(_, node)| !node.is_leaf()) {
            let from_above = arriving[index];
            for child in node.children(index as u32) {
                arriving[child as usize].even.merge(&from_above.even);
                arriving[child as usize].uneven.merge(&from_above.uneven);
            }
        }
    }
}

/// For rays from one side the smallest clusters that hold both ends, or [`NONE`]; in order.
fn ends_of_rays(
    hierarchy: &Hierarchy,
    forest: &Forest,
    tracer: &dyn Tracer,
    parents: &[u32],
    side: usize,
) -> [u32; RAYS] {
    let sequence = PairSequence::new(5);
    let piece = forest.root(hierarchy, side);
    let (normal, facet) = (piece.plane.normal, piece.side.facet);
    let departures: [Departure; RAYS] = std::array::from_fn(|i| {
        let [u, v, s, t] = sequence.point(i as u32);
        let (point, direction) = (piece.polygon.point_at(u, v), cosine_direction(normal, s, t));
        Departure { point, normal, facet, direction }
    });
    let mut rays = [Ray { origin: Vec3::ZERO, direction: Vec3::Z }; RAYS];
    let mut hits = [None; RAYS];
    departing_hits(tracer, &departures, &mut rays, &mut hits);
    let leaf = hierarchy.leaf(facet);
    let mut ends = hits.map(|hit| {
        let holds = |node: u32, facet: u32| {
            let node = &hierarchy.nodes[node as usize];
            (node.first..node.end).contains(&facet)
        };
        let mut above =
            std::iter::successors(Some(leaf), |&node| Some(parents[node as usize]).filter(|&p| p != NONE));
        hit.and_then(|hit| above.find(|&node| holds(node, hit.facet))).unwrap_or(NONE)
    });
    ends.sort_unstable();
    ends
}
