//! How open surfaces lie in the clusters that hold them: of light that comes to a cluster from outside and is partly
//! kept off, by whatever, those get more that nothing in the cluster shades, and those that it hides get none.

use super::forest::Forest;
use super::links::{Link, LinkClass};
use crate::hierarchy::Hierarchy;
use crate::math::{CosineLobes, HemispherePart, LobeWeights, PairSequence, cosine_direction};
use crate::progress::Progress;
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
    /// Where they go.
    part: HemispherePart,
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
    pub(super) fn found(
        hierarchy: &Hierarchy,
        forest: &Forest,
        tracer: &dyn Tracer,
        progress: &dyn Progress,
    ) -> Openness {
        let mut parents = vec![NONE; hierarchy.nodes.len()];
        for (index, node) in hierarchy.nodes.iter().enumerate().filter(|(_, node)| !node.is_leaf()) {
            node.children(index as u32).into_iter().for_each(|child| parents[child as usize] = index as u32);
        }
        progress.start("openness", forest.side_count() as u64);
        let kept: Vec<Box<[Kept]>> = (0..forest.side_count())
            .into_par_iter()
            .with_min_len(64)
            .map(|side| {
                progress.advance(1);
                kept_of(hierarchy, forest, tracer, &parents, side)
            })
            .collect();
        progress.finish();
        let mut openness = Openness { first: vec![0], ..Openness::default() };
        openness.areas = vec![CosineLobes::default(); hierarchy.nodes.len()];
        for (index, kept) in kept.into_iter().enumerate() {
            let side = forest.side(index);
            let leaf = hierarchy.leaf(side.facet) as usize;
            let area = hierarchy.nodes[leaf].area;
            let whole = LobeWeights::toward(hierarchy.side_normal(side).as_vec3());
            openness.areas[leaf].add_part(&whole, Vec3::new(area, area, 0.0));
            for Kept { node, part } in &kept {
                openness.areas[*node as usize].add_part(&part.weights(&whole), Vec3::new(0.0, -area, 0.0));
            }
            openness.kept.extend(kept);
            openness.first.push(openness.kept.len() as u32);
        }
        for (index, &parent) in parents.iter().enumerate().skip(1).rev() {
            let own = openness.areas[index];
            openness.areas[parent as usize].merge(&own);
        }
        openness
    }

    /// Bytes of all of it.
    pub(super) fn bytes(&self) -> u64 {
        (size_of_val(&self.first[..]) + size_of_val(&self.kept[..]) + size_of_val(&self.areas[..])) as u64
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
                uneven -= arriving[kept.node as usize].uneven.evaluate_with(&kept.part.weights(&weights));
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

/// Where the rays of one side end, by the smallest clusters that hold both ends, but the whole scene: all light is
/// from inside of it.
fn kept_of(
    hierarchy: &Hierarchy,
    forest: &Forest,
    tracer: &dyn Tracer,
    parents: &[u32],
    side: usize,
) -> Box<[Kept]> {
    let sequence = PairSequence::new(0);
    let piece = forest.root(hierarchy, side);
    let (normal, facet) = (piece.plane.normal, piece.side.facet);
    let departures: [Departure; RAYS] = std::array::from_fn(|i| {
        let [u, v, ..] = sequence.point(i as u32);
        let [s, t] = direction_of(i);
        let (point, direction) = (piece.polygon.point_at(u, v), cosine_direction(normal, s, t));
        Departure { point, normal, facet, direction }
    });
    let mut rays = [Ray { origin: Vec3::ZERO, direction: Vec3::Z }; RAYS];
    let mut hits = [None; RAYS];
    departing_hits(tracer, &departures, &mut rays, &mut hits);
    let holds = |node: u32, facet: u32| {
        let node = &hierarchy.nodes[node as usize];
        (node.first..node.end).contains(&facet)
    };
    let parent = |node: &u32| Some(parents[*node as usize]).filter(|&parent| parent != NONE);
    let mut ends: [(u32, Vec3); RAYS] = std::array::from_fn(|i| {
        let mut lineage = std::iter::successors(Some(hierarchy.leaf(facet)), parent);
        let node = hits[i].and_then(|hit| lineage.find(|&node| holds(node, hit.facet))).unwrap_or(0);
        (node, departures[i].direction)
    });
    ends.sort_by_key(|(node, _)| *node);
    let runs = ends.chunk_by(|(a, _), (b, _)| a == b).filter(|run| run[0].0 != 0);
    runs.map(|run| {
        let directions = run.iter().map(|(_, direction)| *direction);
        Kept { node: run[0].0, part: HemispherePart::of(directions, RAYS) }
    })
    .collect()
}

/// Where ray `index` goes, for [`cosine_direction`]: in pairs that mirror each other at the normal, one pair in each
/// ring of equal weight at its mean cosine, so that all of them together weigh light from anywhere as the cosine does,
/// up to the first order.
fn direction_of(index: usize) -> [f64; 2] {
    let (pair, is_second) = (index / 2, index % 2 == 1);
    let pairs = (RAYS / 2) as f64;
    let turn = 0.5 * (pair as f64 * 0.618_033_988_749_895).fract();
    let upto = |ring: usize| (1.0 - ring as f64 / pairs).powf(1.5);
    let cosine = (upto(pair) - upto(pair + 1)) * pairs / 1.5;
    [turn + if is_second { 0.5 } else { 0.0 }, 1.0 - cosine * cosine]
}
