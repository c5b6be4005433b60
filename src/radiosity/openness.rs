//! How open surfaces lie: of light that comes to a cluster from outside and is partly kept off, by whatever, those leaf
//! elements get more that nothing in the cluster shades, and those that it hides get none. So it is with light that
//! comes to an element and is kept off some of it: of its leaves those get none on which something stands.
//!
//! Shares are never negative and do not depend on the light. Of what comes to a cluster of which next to nothing lies
//! open a part is lost ([`MOST`]); of what comes to such an element that part falls on all of its leaves alike.

use super::forest::{Forest, Piece, Way};
use super::links::{Link, LinkClass, LinkSet};
use super::transport::{Light, direction};
use crate::hierarchy::Hierarchy;
use crate::math::{CosineLobes, PairSequence, axial_parts, cosine_direction, golden_fraction};
use crate::progress::{Progress, Work};
use crate::tracer::{Departure, PACKET, Ray, Tracer, departing_hits};
use glam::Vec3;
use rayon::prelude::*;

/// Rays from each leaf element; the same for all, so that what they get wrong differs little between neighbours.
const RAYS: usize = PACKET;

/// What is nearer to an element than this times its width can keep light off a part of it.
const REACH: f32 = 0.5;

/// Of pairs of rays that end beside an element, those at most of its parts first, so many count as its rays: none where
/// at least two thirds of them go further, all where none does.
const RAYS_OF_PAIRS: [u8; RAYS / 2] = [0, 0, 1, 3, 3, 3, 3, 3];

/// No element that there was before.
const NEW: u32 = u32::MAX;

/// Where less than one part in this many of a cluster or an element lies open, it does not receive more than that many
/// times as much.
const MOST: f32 = 8.0;

/// Rays of one leaf element that go no further than what it is a part of. There may be several for each element, so they
/// are packed.
#[derive(Clone, Copy, Debug)]
#[repr(Rust, packed)]
pub struct Kept {
    /// The smallest cluster that holds both ends of the rays; or, plus the number of nodes of the hierarchy, the number of
    /// elements, from the undivided side down, that are so wide that the rays end beside them.
    pub node: u32,
    /// How many rays count as ended there, of [16](Kept::RAYS).
    pub rays: u8,
}

impl Kept {
    /// All rays of an element.
    pub const RAYS: u8 = RAYS as u8;

    /// Share of all rays of the element.
    fn share(self) -> f32 {
        f32::from(self.rays) / f32::from(Kept::RAYS)
    }
}

/// How the sides in one cluster lie.
#[derive(Clone, Copy, Debug, Default)]
struct Inside {
    /// Area that its sides turn towards each direction, local units.
    area: CosineLobes<f32>,
    /// As much of it as lies open, along each axis.
    open: [f32; 6],
}

/// What rays from all leaf elements met.
#[derive(Clone, Debug, Default)]
pub struct Openness {
    kept: KeptRays,
    /// By [place](Hierarchy::cluster_place) of the cluster.
    inside: Vec<Inside>,
    /// Share of each inner element that does not lie hidden beside it.
    open: Vec<f32>,
}

/// Where the rays of all leaf elements ended.
#[derive(Clone, Debug, Default)]
struct KeptRays {
    /// First of the lists of each element, with their number at the end; inner elements have none.
    first: Vec<u32>,
    all: Vec<Kept>,
}

impl KeptRays {
    fn of(&self, element: u32) -> &[Kept] {
        match self.first.get(element as usize..) {
            Some([first, end, ..]) => &self.all[*first as usize..*end as usize],
            _ => &[],
        }
    }
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

    /// Casts rays from all leaf elements.
    pub(super) fn found(
        hierarchy: &Hierarchy,
        forest: &Forest,
        tracer: &dyn Tracer,
        progress: &dyn Progress,
    ) -> Openness {
        Openness::unknown().refined(hierarchy, forest, &[], tracer, progress)
    }

    /// The same where elements have been divided since: `new_from_old` has the new id of each element that there was.
    pub(super) fn refined(
        self,
        hierarchy: &Hierarchy,
        forest: &Forest,
        new_from_old: &[u32],
        tracer: &dyn Tracer,
        progress: &dyn Progress,
    ) -> Openness {
        // What else was known is made anew, and freed before.
        let Openness { kept: kept_before, inside, open } = self;
        drop((inside, open));
        // Those that have been divided are no leaves any more.
        let there_before = kept_before.first.len().saturating_sub(1);
        let mut before = vec![NEW; forest.len()];
        for (old, &new) in (0..).zip(new_from_old).take(there_before) {
            before[new as usize] = old;
        }
        let leaves: Vec<u32> = forest.leaves().map(|leaf| leaf as u32).collect();
        progress.start("openness", leaves.len() as u64);
        let working = || (Work::begin(progress, "openness"), Way::new(hierarchy, forest));
        // Of new leaves: one list for many, with the end of each.
        let fresh: Vec<(Vec<Kept>, Vec<u32>)> = leaves
            .par_chunks(256)
            .map_init(working, |(_, way), leaves| {
                let (mut kept, mut ends) = (Vec::new(), Vec::new());
                for &leaf in leaves.iter().filter(|&&leaf| before[leaf as usize] == NEW) {
                    add_kept(hierarchy, forest, tracer, way.to(leaf), &mut kept);
                    ends.push(kept.len() as u32);
                }
                progress.advance(leaves.len() as u64);
                kept.shrink_to_fit();
                (kept, ends)
            })
            .collect();
        progress.finish();
        let mut fresh = fresh.iter().flat_map(|(kept, ends)| {
            let begins = std::iter::once(0).chain(ends.iter().copied());
            begins.zip(ends).map(|(begin, &end)| &kept[begin as usize..end as usize])
        });
        let of_leaves = leaves.iter().map(|&leaf| match before[leaf as usize] {
            NEW => fresh.next().unwrap_or_default(),
            old => kept_before.of(old),
        });
        Openness::from_kept(hierarchy, forest, of_leaves)
    }

    /// From where the rays of each leaf element ended: one slice for each.
    pub fn from_kept<'a>(
        hierarchy: &Hierarchy,
        forest: &Forest,
        mut kept_of_leaves: impl Iterator<Item = &'a [Kept]>,
    ) -> Openness {
        let mut openness = Openness {
            kept: KeptRays { first: vec![0], all: Vec::new() },
            inside: vec![Inside::default(); hierarchy.cluster_count()],
            open: vec![0.0; forest.len()],
        };
        let mut sums = SideSums::default();
        for side in 0..forest.side_count() {
            let elements = forest.elements_of(side);
            sums.begin(elements.len());
            for element in elements.clone() {
                if forest.second[element] == 0 {
                    let kept = kept_of_leaves.next().unwrap_or_default();
                    sums.add_leaf(hierarchy, forest, elements.start as u32, element as u32, kept);
                    openness.kept.all.extend_from_slice(kept);
                }
                openness.kept.first.push(openness.kept.all.len() as u32);
            }
            for (open, [area, hidden]) in openness.open[elements].iter_mut().zip(&sums.below) {
                *open = (1.0 - hidden / area.max(f64::MIN_POSITIVE)) as f32;
            }
            let parts = axial_parts(hierarchy.side_normal(forest.side(side)).as_vec3());
            for &(cluster, area) in &sums.in_clusters {
                let open = &mut openness.inside[hierarchy.cluster_place(cluster)].open;
                open.iter_mut().zip(parts).for_each(|(sum, part)| *sum -= area as f32 * part);
            }
        }
        openness.kept.all.shrink_to_fit();
        let of_facet = |facet| Inside::of_facet(hierarchy, forest, facet);
        hierarchy.sum_up(&mut openness.inside, of_facet, Inside::merge);
        openness
    }

    /// Bytes of all of it, and of the light that is on its way.
    pub(super) fn bytes(&self) -> u64 {
        let cluster = size_of::<Inside>() + size_of::<Arriving>();
        let KeptRays { first, all } = &self.kept;
        let elements = size_of_val(&first[..]) + size_of_val(&all[..]) + size_of_val(&self.open[..]);
        (elements + self.inside.len() * cluster) as u64
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

    /// Sends light down to the leaf elements of a side, from the clusters it lies in and from what is above each element.
    /// `arriving` is what came to each cluster and to those above it; `even` and `uneven` are what the elements of the side
    /// [gathered](Light::gathered). In the place of what is uneven leaves get all that falls on them.
    pub fn push(
        &self,
        hierarchy: &Hierarchy,
        forest: &Forest,
        side: usize,
        arriving: &[Arriving],
        (even, uneven): (&[Vec3], &mut [Vec3]),
    ) {
        let named = forest.side(side);
        let normal = hierarchy.side_normal(named).as_vec3();
        let cluster = hierarchy.parent(hierarchy.leaf(named.facet));
        // Without a cluster there is nothing that light could come from.
        let all =
            cluster.map_or_else(Arriving::default, |cluster| arriving[hierarchy.cluster_place(cluster)]);
        let mut pushing = Pushing {
            openness: self,
            hierarchy,
            forest,
            first: forest.first_element[side],
            normal,
            arriving,
            uneven_of_clusters: all.uneven_on(normal),
            even,
            uneven,
            from_above: vec![Vec3::ZERO],
        };
        pushing.push(forest.first_element[side], all.even.evaluate(normal));
    }

    /// Where the rays of a leaf element ended, but those that went further than everything it is a part of.
    pub fn kept_of(&self, element: u32) -> &[Kept] {
        self.kept.of(element)
    }
}

/// Light on its way down to the leaf elements of one side.
struct Pushing<'a> {
    openness: &'a Openness,
    hierarchy: &'a Hierarchy,
    forest: &'a Forest,
    /// First element of the side.
    first: u32,
    normal: Vec3,
    arriving: &'a [Arriving],
    /// Uneven light of all clusters that hold the side.
    uneven_of_clusters: Vec3,
    even: &'a [Vec3],
    uneven: &'a mut [Vec3],
    /// Uneven light of so many elements above, from the undivided side down, on a part of them that lies open.
    from_above: Vec<Vec3>,
}

impl Pushing<'_> {
    fn push(&mut self, element: u32, from_above: Vec3) {
        let own = (element - self.first) as usize;
        let second = self.forest.second[element as usize];
        let mut even = from_above + self.even[own];
        if second == 0 {
            self.uneven[own] = even + self.on_leaf(element).max(Vec3::ZERO);
            return;
        }
        let open = self.openness.open.get(element as usize).map_or(1.0, |open| *open);
        let uneven = self.uneven[own];
        let most = if open * MOST > 1.0 { open.recip() } else { MOST };
        even += uneven * (1.0 - most * open);
        let above = self.from_above[self.from_above.len() - 1];
        self.from_above.push(above + uneven * most);
        self.push(element + 1, even);
        self.push(second, even);
        self.from_above.pop();
    }

    /// Uneven light on a leaf.
    fn on_leaf(&self, leaf: u32) -> Vec3 {
        let clusters = self.hierarchy.nodes.len() as u32;
        let mut sum = self.uneven_of_clusters + self.from_above[self.from_above.len() - 1];
        for kept in self.openness.kept_of(leaf) {
            let light = match { kept.node }.checked_sub(clusters) {
                Some(level) => self.from_above[level as usize],
                None => self.arriving[self.hierarchy.cluster_place(kept.node)].uneven_on(self.normal),
            };
            sum -= light * kept.share();
        }
        sum
    }
}

/// Sums over the leaf elements of one side, of which there may be very many.
#[derive(Default)]
struct SideSums {
    /// Area of the leaves below each inner element, and as much of it as lies hidden beside the element; 0 and 0 for leaves.
    below: Vec<[f64; 2]>,
    /// Area as much of which lies hidden in clusters that hold the side.
    in_clusters: Vec<(u32, f64)>,
}

impl SideSums {
    /// Forgets everything, for a side of so many elements.
    fn begin(&mut self, elements: usize) {
        self.below.clear();
        self.below.resize(elements, [0.0; 2]);
        self.in_clusters.clear();
    }

    /// Adds a leaf to all that it is a part of; `first` is the first element of the side.
    fn add_leaf(&mut self, hierarchy: &Hierarchy, forest: &Forest, first: u32, leaf: u32, kept: &[Kept]) {
        let area = f64::from(forest.area[leaf as usize]);
        forest.above(leaf).for_each(|element| self.below[(element - first) as usize][0] += area);
        for kept in kept {
            let hidden = area * f64::from(kept.share());
            let Some(count) = { kept.node }.checked_sub(hierarchy.nodes.len() as u32) else {
                match self.in_clusters.iter_mut().find(|(cluster, _)| *cluster == kept.node) {
                    Some((_, sum)) => *sum += hidden,
                    None => self.in_clusters.push((kept.node, hidden)),
                }
                continue;
            };
            let above = forest.above(leaf).take(count as usize);
            above.for_each(|element| self.below[(element - first) as usize][1] += hidden);
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

/// Adds where the rays of one leaf element end.
fn add_kept(hierarchy: &Hierarchy, forest: &Forest, tracer: &dyn Tracer, piece: &Piece, all: &mut Vec<Kept>) {
    let sequence = PairSequence::new(0);
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
    all.extend(ends.chunk_by(|a, b| a == b).map(|run| Kept { node: run[0], rays: run.len() as u8 }));
    // Beside a wall half of the rays end at it, yet nothing keeps light off: so rays count in pairs that mirror each
    // other, and one of the two that goes far is enough. Nor does it matter in a room where some of the pairs end.
    let widths: Vec<f32> =
        forest.above(piece.id).map(|element| forest.area[element as usize].sqrt()).collect();
    let mut counts: Vec<usize> = hits
        .chunks(2)
        .filter_map(|pair| {
            let [Some(a), Some(b)] = pair else { return None };
            let far = a.t.max(b.t);
            Some(widths.iter().take_while(|&&width| width * REACH > far).count())
        })
        .collect();
    counts.sort_unstable_by(|a, b| b.cmp(a));
    let begin = all.len();
    for (&count, rays) in counts.iter().zip(RAYS_OF_PAIRS).filter(|&(&count, rays)| count > 0 && rays > 0) {
        let node = (hierarchy.nodes.len() + count) as u32;
        match all[begin..].last_mut().filter(|last| last.node == node) {
            Some(last) => last.rays += rays,
            None => all.push(Kept { node, rays }),
        }
    }
}

/// Where ray `index` goes, for [`cosine_direction`]: in pairs that mirror each other at the normal, one pair in each
/// ring of equal weight at its mean cosine.
fn direction_of(index: usize) -> [f64; 2] {
    let (pair, is_second) = (index / 2, index % 2 == 1);
    let pairs = (RAYS / 2) as f64;
    let turn = 0.5 * golden_fraction(pair);
    let upto = |ring: usize| (1.0 - ring as f64 / pairs).powf(1.5);
    let cosine = (upto(pair) - upto(pair + 1)) * pairs / 1.5;
    [turn + if is_second { 0.5 } else { 0.0 }, 1.0 - cosine * cosine]
}
