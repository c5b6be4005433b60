//! Row sums: the share of its hemisphere that the links of an element cover.

use super::carried::even_light;
use super::finding::root;
use super::flights::{Landing, departure, landings};
use super::subject::{Lottery, SIDES, Subject, fraction};
use crate::math::{CosineLobes, PairSequence, hash_pair};
use crate::radiosity::{Light, Link, LinkClass, Piece, direction};
use crate::tracer::{Candidates, FilterAudit, NO_FACET, PACKET, Segment};
use glam::Vec3;
use rayon::prelude::*;

/// Elements whose rows are compared with rays.
const ROWS: u32 = 16_384;

/// Rays over the hemisphere of each.
const RAYS: u32 = 256;

/// Segments for each partial link.
const SEGMENTS: u32 = 16;

/// Row sums between 1 and this are what quadrature gets wrong in the corners of a room.
pub(super) const MOST: f64 = 1.05;

/// Keeps the weight of segments finite where two nodes touch, squared local length.
const SOFTENING: f64 = 1e-9;

/// The row of one element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub(super) element: u32,
    /// Share of its hemisphere that links cover.
    pub(super) linked: f64,
    /// Share in which rays meet a surface.
    pub(super) found: f64,
    /// Variance of the difference: the rays, and the segments of partial links.
    noise: f64,
}

impl Row {
    pub(super) fn off(&self) -> f64 {
        self.linked - self.found
    }
}

/// What is found of many rows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pub(super) linked: f64,
    pub(super) found: f64,
    /// Difference of single rows, roughly without its noise, relative to what rays find: both as the root of the mean
    /// square.
    pub(super) deviation: f64,
}

impl Sums {
    pub(super) fn of(rows: &[Row]) -> Sums {
        let mean = |of: fn(&Row) -> f64| rows.iter().map(of).sum::<f64>() / rows.len().max(1) as f64;
        Sums {
            linked: mean(|row| row.linked),
            found: mean(|row| row.found),
            deviation: root(mean(|row| row.off().powi(2) - row.noise))
                / root(mean(|row| row.found.powi(2))).max(f64::MIN_POSITIVE),
        }
    }
}

/// Rows of leaf elements, picked by the light they receive. Surfaces that send out next to no light do not
/// count: of them the links need not know.
///
/// The visibility that a link stores is a share of the light, not of the hemisphere: what is bright counts
/// for more. So partial links count with the share of segments that are clear.
pub(super) fn rows(subject: &Subject<'_>) -> Vec<Row> {
    let even = even_light(subject);
    let light = &subject.solution.light;
    let lottery = Lottery::new(&subject.leaves, |e| {
        light.irradiance[e as usize].element_sum() as f64 * subject.area(e)
    });
    if lottery.total <= 0.0 {
        return Vec::new();
    }
    let count = ROWS.min(subject.leaves.len() as u32);
    (0..count)
        .into_par_iter()
        .map(|index| {
            let element = lottery.pick((index as f64 + 0.5) / count as f64);
            let (linked, noise) = covered_by_links(subject, element, &even);
            let found = covered_by_rays(subject, element, &even, index);
            Row { element, linked, found, noise: noise + found * (1.0 - found) / RAYS as f64 }
        })
        .collect()
}

/// With its variance.
fn covered_by_links(subject: &Subject<'_>, element: u32, even: &Light) -> (f64, f64) {
    let (hierarchy, forest) = (subject.hierarchy, &subject.solution.forest);
    let piece = subject.piece(element);
    let normal = piece.plane.normal.as_vec3();
    let (mut sum, mut noise, mut lobes) = (0.0, 0.0, CosineLobes::<Vec3>::default());
    for receiver in subject.lineage(subject.node(element)) {
        for link in subject.solution.links.of(receiver) {
            let mut link = *link;
            let is_partial = link.class == LinkClass::Partial;
            let (clear, variance) =
                if is_partial { clear_share(subject, &piece, &link, even) } else { (1.0, 0.0) };
            if is_partial {
                link.visibility = clear as f32;
            }
            let covered = even.carried(hierarchy, forest, &link);
            let on_element = match subject.element(receiver) {
                Some(_) => {
                    sum += covered.x as f64;
                    covered.x as f64
                }
                None => {
                    let direction = direction(hierarchy, forest, &link);
                    lobes.add(direction, covered);
                    (covered.x * normal.dot(direction).max(0.0)) as f64
                }
            };
            if clear > 0.0 {
                noise += (on_element / clear).powi(2) * variance;
            }
        }
    }
    (sum + lobes.evaluate(normal).x as f64, noise)
}

/// Share of the segments to the source of a link that are clear, weighted by the kernel, and its variance.
fn clear_share(subject: &Subject<'_>, receiver: &Piece, link: &Link, even: &Light) -> (f64, f64) {
    let seed = hash_pair(receiver.id as u64, link.source as u64);
    let sequence = PairSequence::new(seed);
    let area = subject.area_of(link.source);
    let segments: Vec<(Segment, f64)> = (0..SEGMENTS)
        .filter_map(|index| {
            let [a, b, c, d] = sequence.point(index);
            let source = subject.spot(&area, fraction(seed, SIDES + u64::from(index)), (c, d));
            let (from, to) = (receiver.polygon.point_at(a, b), source.point);
            let heights = [receiver.plane.distance(to), source.plane.distance(from)];
            if heights[0] <= 0.0 || heights[1] <= 0.0 || even.exitance[source.leaf as usize].x <= 0.0 {
                return None;
            }
            let skip = [receiver.side.facet, source.facet];
            let segment = Segment { from: from.as_vec3(), to: to.as_vec3(), skip };
            let distance_squared = from.distance_squared(to) + SOFTENING;
            Some((segment, heights[0] * heights[1] / (distance_squared * distance_squared)))
        })
        .collect();
    let (mut clear, mut all, mut squares) = (0.0, 0.0, 0.0);
    for packet in segments.chunks(PACKET) {
        let rays: Vec<Segment> = packet.iter().map(|(segment, _)| *segment).collect();
        let mut blockers = [NO_FACET; PACKET];
        let blockers = &mut blockers[..rays.len()];
        subject.tracer.blockers(&rays, Candidates::All, blockers, &mut FilterAudit::default());
        for (&blocker, (_, weight)) in blockers.iter().zip(packet) {
            all += weight;
            squares += weight * weight;
            clear += if blocker == NO_FACET { *weight } else { 0.0 };
        }
    }
    if all <= 0.0 {
        return (1.0, 0.0);
    }
    let (share, each) = (clear / all, squares / (all * all));
    // As many as count alike would be 1 / each.
    (share, share * (1.0 - share) * each / (1.0 - each).max(0.5))
}

fn covered_by_rays(subject: &Subject<'_>, element: u32, even: &Light, index: u32) -> f64 {
    let piece = subject.piece(element);
    let sequence = PairSequence::new(hash_pair(index as u64, 3));
    let met: usize = (0..RAYS / PACKET as u32)
        .map(|packet| {
            let departures =
                std::array::from_fn(|i| departure(&piece, sequence.point(packet * PACKET as u32 + i as u32)));
            let is_lit =
                |on: &Landing| matches!(on, Landing::On(leaf) if even.exitance[*leaf as usize].x > 0.0);
            landings(subject, &departures).iter().filter(|landing| is_lit(landing)).count()
        })
        .sum();
    met as f64 / RAYS as f64
}

/// How much row sums exceed [`MOST`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Excess {
    /// Mean over all leaf elements, weighted by the light they receive.
    pub(super) mean: f64,
    /// The largest row sum, and its element.
    pub(super) largest: f64,
    pub(super) element: u32,
}

/// Row sums of all leaf elements over the elements they see in full: those cannot overlap, so their form
/// factors add up to 1 at most.
pub(super) fn excess(subject: &Subject<'_>) -> Excess {
    let solution = subject.solution;
    let forest = &solution.forest;
    let is_full = |link: &&Link| {
        let is_visible = matches!(link.class, LinkClass::Visible | LinkClass::CertifiedVisible);
        is_visible && subject.element(link.source).is_some()
    };
    let mut sums: Vec<f64> = (0..forest.len() as u32)
        .into_par_iter()
        .map(|element| {
            let links = solution.links.of(subject.node(element)).iter();
            links.filter(is_full).map(|link| link.factor as f64).sum()
        })
        .collect();
    for element in 0..sums.len() {
        let (second, own) = (forest.second[element] as usize, sums[element]);
        if second != 0 {
            sums[element + 1] += own;
            sums[second] += own;
        }
    }
    let (mut found, mut beyond, mut light) = (Excess::default(), 0.0, 0.0);
    for &leaf in &subject.leaves {
        let sum = sums[leaf as usize];
        let received = solution.light.irradiance[leaf as usize].element_sum() as f64 * subject.area(leaf);
        light += received;
        beyond += (sum - MOST).max(0.0) * received;
        if sum > found.largest {
            (found.largest, found.element) = (sum, leaf);
        }
    }
    found.mean = if light > 0.0 { beyond / light } else { 0.0 };
    found
}
