//! Form factors and visibilities as links store them: their range, another computation of the same
//! figures, and what both directions of a pair have in common.

use super::contour::{Surface, exchange};
use super::limits::MOST_FACTOR;
use super::subject::{Area, SIDES, Subject, fraction};
use crate::hierarchy::TOLERANCE;
use crate::math::{PairSequence, hash_pair};
use crate::radiosity::{Link, LinkClass};
use crate::tracer::{Candidates, FilterAudit, NO_FACET, PACKET, Segment};
use rayon::prelude::*;

/// Links looked at one by one, each standing for the same power.
const PICKED: usize = 1 << 15;

/// Links handed to a thread at a time.
const CHUNK: usize = 1 << 14;

/// Points this near to a plane count as points in it, local length.
const GRAZING: f64 = 5.0 * TOLERANCE;

/// How far figures are off, over all links that were looked at.
#[derive(Clone, Debug, Default)]
pub(super) struct Errors {
    pub(super) count: u64,
    pub(super) sum: f64,
    pub(super) largest: f64,
    /// The link of the largest error.
    pub(super) worst: Option<Link>,
}

impl Errors {
    fn of(errors: impl IntoIterator<Item = (f64, Link)>) -> Errors {
        let mut found = Errors::default();
        for (error, link) in errors {
            found.count += 1;
            found.sum += error;
            // What is not a number is the largest error of all.
            if error > found.largest || error.is_nan() {
                (found.largest, found.worst) = (error, Some(link));
            }
        }
        found
    }

    pub(super) fn mean(&self) -> f64 {
        self.sum / self.count.max(1) as f64
    }
}

/// Links of which something is wrong, and one of them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wrong {
    pub(super) count: u64,
    pub(super) one: Option<Link>,
}

fn wrong(subject: &Subject<'_>, is_wrong: impl Fn(&Link) -> bool + Sync) -> Wrong {
    let links = &subject.solution.links.links;
    Wrong {
        count: links.par_iter().filter(|link| is_wrong(link)).count() as u64,
        one: links.par_iter().find_first(|link| is_wrong(link)).copied(),
    }
}

/// Links with a form factor or visibility that is negative or no finite number.
pub(super) fn signs(subject: &Subject<'_>) -> Wrong {
    let is_right = |figure: f32| figure.is_finite() && figure >= 0.0;
    wrong(subject, |link| !is_right(link.factor) || !is_right(link.visibility))
}

/// Links between elements with a form factor above 1.
pub(super) fn above_one(subject: &Subject<'_>) -> Wrong {
    wrong(subject, |link| joins_elements(subject, link) && link.factor > MOST_FACTOR)
}

fn joins_elements(subject: &Subject<'_>, link: &Link) -> bool {
    subject.element(link.receiver).is_some() && subject.element(link.source).is_some()
}

fn area(subject: &Subject<'_>, node: u32) -> f64 {
    match subject.element(node) {
        Some(element) => subject.area(element),
        None => subject.hierarchy.nodes[node as usize].area as f64,
    }
}

/// Power that a link carries: sum over channels, local areas.
fn power(subject: &Subject<'_>, link: &Link) -> f64 {
    let solution = subject.solution;
    let arriving = solution.light.carried(subject.hierarchy, &solution.forest, link);
    arriving.element_sum() as f64 * area(subject, link.receiver)
}

/// Power that each link carries beyond what would arrive if nothing stood in between: an element is no
/// brighter than its brightest part, and no more than all of a cluster is visible.
pub(super) fn beyond_unobstructed(subject: &Subject<'_>) -> Errors {
    let forest = &subject.solution.forest;
    let mut brightest: Vec<f32> = subject.solution.light.exitance.iter().map(|b| b.element_sum()).collect();
    for element in (0..brightest.len()).rev() {
        let second = forest.second[element] as usize;
        if second != 0 {
            brightest[element] = brightest[element + 1].max(brightest[second]);
        }
    }
    let beyond = |link: &Link| {
        let carried = power(subject, link);
        let most = match subject.element(link.source) {
            Some(source) => (link.factor * brightest[source as usize]) as f64 * area(subject, link.receiver),
            None => carried / link.visibility.max(1.0) as f64,
        };
        (carried - most).max(0.0)
    };
    let parts: Vec<Vec<(f64, Link)>> = subject
        .solution
        .links
        .links
        .par_chunks(CHUNK)
        .map(|links| links.iter().map(|link| (beyond(link), *link)).filter(|(b, _)| *b != 0.0).collect())
        .collect();
    Errors::of(parts.into_iter().flatten())
}

/// Links picked from those that are wanted by the power they carry: each as often as it carries one share.
fn picked(subject: &Subject<'_>, is_wanted: impl Fn(&Link) -> bool + Sync) -> Vec<Link> {
    let weight = |link: &Link| match is_wanted(link) {
        true => Some(power(subject, link)).filter(|power| power.is_finite()).map_or(0.0, f64::abs),
        false => 0.0,
    };
    let chunks = subject.solution.links.links.par_chunks(CHUNK);
    let sums: Vec<f64> = chunks.clone().map(|links| links.iter().map(weight).sum()).collect();
    let share = sums.iter().sum::<f64>() / PICKED as f64;
    if share <= 0.0 {
        return Vec::new();
    }
    let before = sums.iter().scan(0.0, |sum, part| Some(std::mem::replace(sum, *sum + part)));
    let before: Vec<f64> = before.collect();
    let parts: Vec<Vec<Link>> = chunks
        .zip(before)
        .map(|(links, mut sum)| {
            let mut found = Vec::new();
            for link in links {
                // One is picked in the middle of every share.
                let first = (sum / share - 0.5).ceil();
                sum += weight(link);
                let times = (sum / share - 0.5).ceil() - first;
                found.extend(std::iter::repeat_n(*link, times as usize));
            }
            found
        })
        .collect();
    parts.into_iter().flatten().collect()
}

/// Form factors between elements against contour integrals.
#[derive(Clone, Debug)]
pub(super) struct AgainstContours {
    /// Relative to the larger of the two.
    pub(super) relative: Errors,
    /// As power that goes wrong: local areas.
    pub(super) power: Errors,
}

pub(super) fn against_contours(subject: &Subject<'_>) -> AgainstContours {
    let links = picked(subject, |link| joins_elements(subject, link));
    let surface = |node| {
        let piece = subject.piece(subject.element(node)?);
        Some(Surface { polygon: piece.polygon, plane: piece.plane })
    };
    let errors: Vec<(f64, f64, Link)> = links
        .par_iter()
        .filter_map(|link| {
            let (receiver, source) = (surface(link.receiver)?, surface(link.source)?);
            let exact = exchange(&receiver, &source) / receiver.polygon.area();
            let factor = link.factor as f64;
            let error = (factor - exact).abs();
            Some((error / factor.max(exact), error / factor * power(subject, link), *link))
        })
        .collect();
    AgainstContours {
        relative: Errors::of(errors.iter().map(|&(relative, _, link)| (relative, link))),
        power: Errors::of(errors.iter().map(|&(_, power, link)| (power, link))),
    }
}

/// A_i F_ij against A_j F_ji where there are links both ways: differences, the mean of both being 1 on the
/// average.
pub(super) fn against_reverse(subject: &Subject<'_>) -> Errors {
    let links = &subject.solution.links;
    let ways: Vec<([f64; 2], Link)> = links
        .links
        .par_iter()
        .filter(|link| joins_elements(subject, link) && link.receiver < link.source)
        .filter_map(|link| {
            let back = links.of(link.source);
            let reverse = &back[back.binary_search_by_key(&link.receiver, |l| l.source).ok()?];
            Some(([link, reverse].map(|way| way.factor as f64 * area(subject, way.receiver)), *link))
        })
        .collect();
    let mean = ways.iter().map(|([to, fro], _)| 0.5 * (to + fro)).sum::<f64>() / ways.len().max(1) as f64;
    Errors::of(ways.into_iter().map(|([to, fro], link)| ((to - fro).abs() / mean, link)))
}

/// Share of the segments that is blocked between the two ends of links that are proved visible.
pub(super) fn against_proofs(subject: &Subject<'_>) -> Errors {
    let links = picked(subject, |link| link.class == LinkClass::CertifiedVisible);
    let errors: Vec<(f64, Link)> = links
        .par_iter()
        .enumerate()
        .filter_map(|(index, link)| {
            let areas = [link.receiver, link.source].map(|node| subject.area_of(node));
            let segments: Vec<Segment> = (0..PACKET as u64)
                .filter_map(|i| segment(subject, &areas, hash_pair(index as u64, i)))
                .collect();
            let mut blockers = [NO_FACET; PACKET];
            let blockers = &mut blockers[..segments.len()];
            subject.tracer.blockers(&segments, Candidates::All, blockers, &mut FilterAudit::default());
            let blocked = blockers.iter().filter(|&&blocker| blocker != NO_FACET).count();
            (!segments.is_empty()).then(|| (blocked as f64 / segments.len() as f64, *link))
        })
        .collect();
    Errors::of(errors)
}

/// The segment between a point of each end, without what lies as good as in the plane of either: surfaces that
/// overlap in one plane do not block. The rest stays in the shaft of the pair, however flat that is.
fn segment(subject: &Subject<'_>, areas: &[Area; 2], seed: u64) -> Option<Segment> {
    let [a, b, c, d] = PairSequence::new(seed).point(0);
    let receiver = subject.spot(&areas[0], fraction(seed, SIDES), (a, b));
    let source = subject.spot(&areas[1], fraction(seed, SIDES + 1), (c, d));
    let (from, to) = (receiver.point, source.point);
    let heights = [receiver.plane.distance(to), source.plane.distance(from)];
    if heights.iter().any(|&height| height <= GRAZING) {
        return None;
    }
    let [near, far] = heights.map(|height| GRAZING / height);
    (near + far < 1.0).then(|| Segment {
        from: from.lerp(to, near).as_vec3(),
        to: to.lerp(from, far).as_vec3(),
        skip: [receiver.facet, source.facet],
    })
}
