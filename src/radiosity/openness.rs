//! How open surfaces lie in the clusters that hold them: of light that comes to a cluster from outside and is partly
//! kept off, by whatever, those sides get more that nothing in the cluster shades, and those that it hides get none.
//!
//! Shares are never negative and do not depend on the light. What comes to a cluster of which next to nothing lies open
//! is lost in part ([`MOST`]).

use super::forest::Forest;
use super::links::{Link, LinkClass, LinkSet};
use super::transport::{Light, direction};
use crate::hierarchy::Hierarchy;
use crate::math::{CosineLobes, PairSequence, axial_parts, cosine_direction};
use crate::progress::{Progress, Work};
use crate::tracer::{Departure, PACKET, Ray, Tracer, departing_hits};
use glam::Vec3;
use rayon::prelude::*;

/// Rays from each side; the same for all, so that what they get wrong differs little between neighbours.
const RAYS: usize = PACKET;

/// Where less than one part in this many of a cluster lies open, it does not receive more than that many times as much.
const MOST: f32 = 8.0;

/// Rays of one side that end in one cluster.
#[derive(Clone, Copy, Debug)]
pub struct Kept {
    /// The smallest cluster that holds both ends of the rays.
    pub node: u32,
    /// Their share of all rays of the side.
    pub share: f32,
}

/// How the sides in one cluster lie.
#[derive(Clone, Copy, Debug, Default)]
struct Inside {
    /// Area that its sides turn towards each direction, local units.
    area: CosineLobes<f32>,
    /// As much of it as lies open, along each axis.
    open: [f32; 6],
}

/// What rays from all sides met.
#[derive(Clone, Debug, Default)]
pub struct Openness {
    /// First of the `kept` of each side, with their number at the end.
    first: Vec<u32>,
    kept: Vec<Kept>,
    /// By [place](Hierarchy::cluster_place) of the cluster.
    inside: Vec<Inside>,
}

/// Light that comes to a cluster over its links.
#[derive(Clone, Copy, Debug, Default)]
pub struct Arriving {
    /// Falls on all sides alike that face it.
    even: CosineLobes,
    /// Falls on sides as they lie open, along each axis.
    uneven: [Vec3; 6],
}

impl Openness {
    /// Nothing is known, and no light on its way.
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
        progress.start("openness", forest.side_count() as u64);
        let working = || Work::begin(progress, "openness");
        let kept: Vec<Box<[Kept]>> = (0..forest.side_count())
            .into_par_iter()
            .with_min_len(64)
            .map_init(working, |_, side| {
                progress.advance(1);
                kept_of(hierarchy, forest, tracer, side)
            })
            .collect();
        progress.finish();
        Openness::from_kept(hierarchy, forest, kept.iter().map(AsRef::as_ref))
    }

    /// From where the rays of each side ended: one slice for each.
    pub fn from_kept<'a>(
        hierarchy: &Hierarchy,
        forest: &Forest,
        kept: impl Iterator<Item = &'a [Kept]>,
    ) -> Openness {
        let mut openness = Openness { first: vec![0], ..Openness::default() };
        openness.inside = vec![Inside::default(); hierarchy.cluster_count()];
        for (index, kept) in kept.enumerate() {
            let side = forest.side(index);
            let area = hierarchy.nodes[hierarchy.leaf(side.facet) as usize].area;
            let parts = axial_parts(hierarchy.side_normal(side).as_vec3());
            for Kept { node, share } in kept {
                let inside = &mut openness.inside[hierarchy.cluster_place(*node)];
                inside.open.iter_mut().zip(parts).for_each(|(sum, part)| *sum -= area * part * share);
            }
            openness.kept.extend_from_slice(kept);
            openness.first.push(openness.kept.len() as u32);
        }
        let of_facet = |facet| Inside::of_facet(hierarchy, forest, facet);
        hierarchy.sum_up(&mut openness.inside, of_facet, Inside::merge);
        openness
    }

    /// Bytes of all of it, and of the light that is on its way.
    pub(super) fn bytes(&self) -> u64 {
        let cluster = size_of::<Inside>() + size_of::<Arriving>();
        (size_of_val(&self.first[..]) + size_of_val(&self.kept[..]) + self.inside.len() * cluster) as u64
    }

    /// The area that the sides in each cluster turn towards each direction, local units.
    pub fn area(&self, hierarchy: &Hierarchy, cluster: u32) -> &CosineLobes<f32> {
        &self.inside[hierarchy.cluster_place(cluster)].area
    }

    /// What comes to each cluster and to those above it over `links`, by [place](Hierarchy::cluster_place).
    pub fn arriving(
        &self,
        hierarchy: &Hierarchy,
        forest: &Forest,
        links: &LinkSet,
        light: &Light,
    ) -> Vec<Arriving> {
        let clusters: Vec<u32> = hierarchy.clusters().collect();
        let mut arriving: Vec<Arriving> = clusters
            .par_iter()
            .with_min_len(256)
            .map(|&cluster| {
                let inside = &self.inside[hierarchy.cluster_place(cluster)];
                let mut arriving = Arriving::default();
                for link in links.of(cluster) {
                    let carried = light.carried(hierarchy, forest, link);
                    arriving.add(inside, link, direction(hierarchy, forest, link), carried);
                }
                arriving
            })
            .collect();
        for cluster in clusters {
            if let Some(above) = hierarchy.parent(cluster) {
                let from_above = arriving[hierarchy.cluster_place(above)];
                arriving[hierarchy.cluster_place(cluster)].merge(&from_above);
            }
        }
        arriving
    }

    /// What falls on a side from all clusters it lies in; `arriving` is what came to each and to those above it.
    pub fn irradiance(
        &self,
        hierarchy: &Hierarchy,
        forest: &Forest,
        side: usize,
        arriving: &[Arriving],
    ) -> Vec3 {
        let named = forest.side(side);
        let normal = hierarchy.side_normal(named).as_vec3();
        // Without a cluster there is nothing that light could come from.
        let Some(cluster) = hierarchy.parent(hierarchy.leaf(named.facet)) else { return Vec3::ZERO };
        let all = &arriving[hierarchy.cluster_place(cluster)];
        let mut uneven = all.uneven_on(normal);
        for kept in self.kept_of(side) {
            uneven -= arriving[hierarchy.cluster_place(kept.node)].uneven_on(normal) * kept.share;
        }
        // Less than nothing is rounding here.
        all.even.evaluate(normal) + uneven.max(Vec3::ZERO)
    }

    /// Where the rays of a side ended, but those that left the scene.
    pub fn kept_of(&self, side: usize) -> &[Kept] {
        match self.first.get(side..) {
            Some([first, end, ..]) => &self.kept[*first as usize..*end as usize],
            _ => &[],
        }
    }
}

impl Inside {
    /// How the sides of one facet lie, with nothing before them.
    fn of_facet(hierarchy: &Hierarchy, forest: &Forest, facet: u32) -> Inside {
        let mut inside = Inside::default();
        let area = hierarchy.nodes[hierarchy.leaf(facet) as usize].area;
        for side in forest.sides_of(facet) {
            let normal = hierarchy.side_normal(forest.side(side)).as_vec3();
            inside.area.add(normal, area);
            inside.open.iter_mut().zip(axial_parts(normal)).for_each(|(sum, part)| *sum += area * part);
        }
        inside
    }

    /// Adds how the sides of a node in the cluster lie.
    fn merge(&mut self, below: &Inside) {
        self.area.merge(&below.area);
        self.open.iter_mut().zip(below.open).for_each(|(sum, open)| *sum += open);
    }
}

impl Arriving {
    /// Adds what one link of a cluster brings, across the `direction` it comes from; `inside` is that of the cluster.
    fn add(&mut self, inside: &Inside, link: &Link, direction: Vec3, carried: Vec3) {
        // What rays did not find kept off is not shaded, and light of its own comes from everywhere in the cluster.
        if link.class != LinkClass::Partial || link.source == link.receiver {
            self.even.add(direction, carried);
            return;
        }
        let Inside { area, open } = inside;
        let facing = if direction == Vec3::ZERO { area.mean() } else { area.evaluate(direction) };
        let parts = axial_parts(direction);
        let open: f32 = open.iter().zip(parts).map(|(open, part)| open * part).sum();
        let gain = if open * MOST > facing { facing / open } else { MOST };
        self.uneven.iter_mut().zip(parts).for_each(|(sum, part)| *sum += carried * (gain * part));
    }

    /// Adds what came to the cluster above.
    fn merge(&mut self, above: &Arriving) {
        self.even.merge(&above.even);
        self.uneven.iter_mut().zip(above.uneven).for_each(|(sum, above)| *sum += above);
    }

    /// Light that falls on sides as they lie open, on one that does so wholly.
    fn uneven_on(&self, normal: Vec3) -> Vec3 {
        self.uneven.iter().zip(axial_parts(normal)).fold(Vec3::ZERO, |sum, (light, part)| sum + *light * part)
    }
}

/// Where the rays of one side end, by the smallest clusters that hold both ends.
fn kept_of(hierarchy: &Hierarchy, forest: &Forest, tracer: &dyn Tracer, side: usize) -> Box<[Kept]> {
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
    let mut ends: Vec<u32> = hits
        .iter()
        .flatten()
        .filter_map(|hit| {
            hierarchy.lineage(hierarchy.leaf(facet)).skip(1).find(|&node| holds(node, hit.facet))
        })
        .collect();
    ends.sort_unstable();
    let kept = |run: &[u32]| Kept { node: run[0], share: run.len() as f32 / RAYS as f32 };
    ends.chunk_by(|a, b| a == b).map(kept).collect()
}

/// Where ray `index` goes, for [`cosine_direction`]: in pairs that mirror each other at the normal, one pair in each
/// ring of equal weight at its mean cosine.
fn direction_of(index: usize) -> [f64; 2] {
    let (pair, is_second) = (index / 2, index % 2 == 1);
    let pairs = (RAYS / 2) as f64;
    let turn = 0.5 * (pair as f64 * 0.618_033_988_749_895).fract();
    let upto = |ring: usize| (1.0 - ring as f64 / pairs).powf(1.5);
    let cosine = (upto(pair) - upto(pair + 1)) * pairs / 1.5;
    [turn + if is_second { 0.5 } else { 0.0 }, 1.0 - cosine * cosine]
}
