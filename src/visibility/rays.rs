//! Casting the rays of a pair in packets.

use super::steps::Step;
use super::worker::Worker;
use super::{Brightness, Pair, Tester};
use crate::math::PairSequence;
use crate::shaft::Shaft;
use crate::tracer::{Candidates, FilterAudit, Interval, NO_FACET, PACKET, Segment};
use glam::DVec3;

/// Rays of the first packet where two that disagree end the test: most that disagree do so at once.
const FIRST_PACKET: u32 = 4;

/// Most pairs of points tried to find two that face each other.
const MOST_TRIED: u32 = 256;

/// How many rays a pair gets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quota {
    /// Rays to cast, as far as twice as many pairs of points face each other.
    pub(super) count: u32,
    /// Rays to cast in all when those are all blocked. Asking on only then adds a little light in the mean: where one
    /// ray in 25 is clear, a third of what 16 rays find.
    pub(super) if_blocked: u32,
    /// Stop after a packet in which two rays disagreed (paper §2.4).
    pub(super) until_mixed: bool,
}

/// One ray of a pair, kept until it is known whether its weight is wanted.
#[derive(Clone, Copy, Debug)]
pub struct Sighting {
    /// The facet of the source that it meets.
    pub facet: u32,
    /// Whether on its front.
    pub front: bool,
    /// Where, local coordinates.
    pub point: DVec3,
    /// Light it stands for, if the source is uniform.
    pub kernel: f64,
    /// Whether nothing blocks it.
    clear: bool,
}

/// Share of the light that gets through: rays count by kernel and by how bright the source is where they
/// end, against its mean. May put the rays in another order.
fn clear_share(sightings: &mut [Sighting], brightness: Option<&dyn Brightness>) -> f32 {
    let kernels = |sightings: &[Sighting]| sightings.iter().map(|sighting| sighting.kernel).sum::<f64>();
    let (mut clear, mut all) = (0.0, kernels(sightings));
    let mut count = 0;
    for i in 0..sightings.len() {
        if sightings[i].clear {
            clear += sightings[i].kernel;
            sightings.swap(count, i);
            count += 1;
        }
    }
    let (seen, hidden) = sightings.split_at_mut(count);
    match brightness.map(|source| (source, source.mean())) {
        Some((source, Some(mean))) if mean > 0.0 => (clear, all) = (source.sum(seen), all * mean),
        Some((source, None)) => {
            let lit = source.sum(seen);
            let bright = lit + source.sum(hidden);
            if bright > 0.0 {
                (clear, all) = (lit, bright);
            }
        }
        _ => {}
    }
    if all > 0.0 { (clear / all) as f32 } else { 1.0 }
}

/// What the rays of one pair met.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RayCount {
    pub(super) clear: u32,
    pub(super) blocked: u32,
    /// Share of the light that gets through; 1 when no ray could be cast.
    pub(super) fraction: f32,
}

impl RayCount {
    pub(super) fn cast(&self) -> u32 {
        self.clear + self.blocked
    }

    pub(super) fn is_mixed(&self) -> bool {
        self.clear > 0 && self.blocked > 0
    }
}

impl Tester<'_> {
    /// Casts rays between points of both nodes that face each other.
    ///
    /// `shaft`, when at hand, is asked about rejected hits; otherwise one is built for that.
    pub(super) fn cast(
        &self,
        worker: &mut Worker,
        pair: &Pair<'_>,
        quota: Quota,
        candidates: Candidates<'_>,
        shaft: Option<&Shaft>,
    ) -> RayCount {
        let (receiver, source) = (pair.receiver, pair.source);
        let sequence = PairSequence::new(pair.seed);
        let (on_receiver, on_source) = (receiver.sampler(), source.sampler());
        let mut met = RayCount::default();
        let mut audit = FilterAudit::default();
        let mut segments =
            [Segment { from: glam::Vec3::ZERO, to: glam::Vec3::ZERO, skip: [NO_FACET; 2] }; PACKET];
        let mut sightings = std::mem::take(&mut worker.sightings);
        sightings.clear();
        let mut blockers = [NO_FACET; PACKET];
        let softening =
            0.01 * receiver.center(self.hierarchy).distance_squared(source.center(self.hierarchy));
        // Points that face away are passed over; twice the rays are tried, or more to find one at all.
        let (mut count, mut tried) = (quota.count, 0);
        loop {
            if met.clear == 0 && (met.cast() >= count || tried >= 2 * count) {
                count = quota.if_blocked;
            }
            if !(met.cast() < count && tried < 2 * count || met.cast() == 0 && tried < MOST_TRIED) {
                break;
            }
            let packet = if quota.until_mixed && met.cast() == 0 { FIRST_PACKET } else { PACKET as u32 };
            let wanted = (count - met.cast()).min(packet) as usize;
            let mut ready = 0;
            while ready < wanted && (tried < 2 * count || ready == 0 && tried < MOST_TRIED) {
                let [a, b, c, d] = sequence.point(tried);
                tried += 1;
                let (from, from_facet) = on_receiver.point_at(self.hierarchy, a, b);
                let (to, to_facet) = on_source.point_at(self.hierarchy, c, d);
                let heights = receiver.height(self.hierarchy, from_facet, to)
                    * source.height(self.hierarchy, to_facet, from);
                if from_facet == to_facet || heights <= 0.0 {
                    continue;
                }
                // Near parts of the nodes exchange most of the light: a ray counts as much as the
                // kernel cos·cos/d² along it, kept finite where the nodes touch.
                let distance_squared = from.distance_squared(to) + softening;
                sightings.push(Sighting {
                    facet: to_facet,
                    front: source.is_front(self.hierarchy, to_facet, from),
                    point: to,
                    kernel: heights / (distance_squared * distance_squared),
                    clear: false,
                });
                segments[ready] =
                    Segment { from: from.as_vec3(), to: to.as_vec3(), skip: [from_facet, to_facet] };
                ready += 1;
            }
            worker.lap(Step::Points);
            if ready == 0 {
                continue;
            }
            worker.segments.clear();
            worker.segments.extend_from_slice(&segments[..ready]);
            self.tracer_for_rays().blockers(
                &segments[..ready],
                candidates,
                &mut blockers[..ready],
                &mut audit,
            );
            worker.lap(Step::Rays);
            let last = sightings.len() - ready;
            for (&blocker, sighting) in blockers[..ready].iter().zip(&mut sightings[last..]) {
                sighting.clear = blocker == NO_FACET;
                met.clear += u32::from(sighting.clear);
                met.blocked += u32::from(!sighting.clear);
            }
            if quota.until_mixed && met.is_mixed() {
                break;
            }
        }
        met.fraction = match (met.clear, met.blocked) {
            (_, 0) => 1.0,
            (0, _) => 0.0,
            // Disagreement was all that was asked for.
            _ if quota.until_mixed => 0.5,
            _ => {
                let share = clear_share(&mut sightings, pair.brightness);
                worker.lap(Step::Brightness);
                share
            }
        };
        worker.sightings = sightings;
        let counters = &mut worker.counters;
        counters.rays_cast += met.cast() as u64;
        counters.filter_calls += audit.calls;
        counters.filter_rejects += audit.rejects;
        if audit.outsiders > 0 {
            let built;
            let shaft = match shaft {
                Some(shaft) => shaft,
                None => {
                    built =
                        Shaft::between(receiver.shaft_end(self.hierarchy), source.shaft_end(self.hierarchy));
                    &built
                }
            };
            // Tolerance was spent once by the cull and once by rounding the ray.
            let margin = 2.0 * crate::hierarchy::TOLERANCE;
            let is_inside =
                |facet: u32| shaft.holds_part_of(self.hierarchy.polygon(facet).vertices(), margin);
            let outsiders = audit.named.facets().iter();
            let anomalies = outsiders.filter(|&&facet| is_inside(facet)).count() as u64;
            counters.culling_anomalies += anomalies;
            counters.border_hits += audit.outsiders.saturating_sub(anomalies);
            worker.lap(Step::Other);
        }
        met
    }

    /// All facets that block one of the last rays.
    pub(super) fn facets_on_one(&self, worker: &mut Worker) -> Vec<u32> {
        let mut found: Vec<u32> = Vec::new();
        let Some(&segment) = worker.segments.first() else { return found };
        loop {
            let ends = found.iter().copied().chain([self.hierarchy.facets.len() as u32]);
            let starts = [0].into_iter().chain(found.iter().map(|facet| facet + 1));
            let between = starts.zip(ends).filter(|(start, end)| start < end);
            let others: Vec<Interval> = between.map(|(start, end)| Interval { start, end }).collect();
            let (mut blocker, mut audit) = ([NO_FACET], FilterAudit::default());
            let others = Candidates::Only(&others);
            self.tracer_for_rays().blockers(&[segment], others, &mut blocker, &mut audit);
            worker.lap(Step::Rays);
            worker.counters.rays_cast += 1;
            match found.binary_search(&blocker[0]) {
                Err(at) if blocker[0] != NO_FACET => found.insert(at, blocker[0]),
                _ => return found,
            }
        }
    }
}
