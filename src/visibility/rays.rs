//! Casting the rays of a pair in packets.

use super::test::Worker;
use super::{Pair, Tester};
use crate::math::PairSequence;
use crate::shaft::Shaft;
use crate::tracer::{Candidates, FilterAudit, NO_FACET, PACKET, Segment};

/// Most different blockers remembered of one pair.
const REMEMBERED: usize = 4;

/// What the rays of one pair met.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RayCount {
    pub(super) clear: u32,
    pub(super) blocked: u32,
    clear_weight: f64,
    weight: f64,
    blockers: [u32; REMEMBERED],
    blocker_count: usize,
}

impl RayCount {
    pub(super) fn cast(&self) -> u32 {
        self.clear + self.blocked
    }

    pub(super) fn is_mixed(&self) -> bool {
        self.clear > 0 && self.blocked > 0
    }

    /// Share of the light that gets through; 1 when no ray could be cast.
    pub(super) fn fraction(&self) -> f32 {
        if self.cast() == 0 { 1.0 } else { (self.clear_weight / self.weight) as f32 }
    }

    /// Some of the facets that were hit.
    pub(super) fn blockers(&self) -> &[u32] {
        &self.blockers[..self.blocker_count]
    }

    fn add(&mut self, blocker: u32, weight: f64) {
        self.weight += weight;
        if blocker == NO_FACET {
            self.clear += 1;
            self.clear_weight += weight;
            return;
        }
        self.blocked += 1;
        if self.blocker_count < REMEMBERED && !self.blockers().contains(&blocker) {
            self.blockers[self.blocker_count] = blocker;
            self.blocker_count += 1;
        }
    }
}

impl Tester<'_> {
    /// Casts up to `count` rays between points of both nodes that face each other; with
    /// `until_mixed`, stops after the packet in which two rays disagreed (paper §2.4).
    ///
    /// `shaft`, when at hand, is asked about rejected hits; otherwise one is built for that.
    pub(super) fn cast(
        &self,
        worker: &mut Worker,
        pair: &Pair<'_>,
        count: u32,
        until_mixed: bool,
        candidates: Candidates<'_>,
        shaft: Option<&Shaft>,
    ) -> RayCount {
        let (receiver, source) = (pair.receiver, pair.source);
        let sequence = PairSequence::new(pair.seed);
        let mut met = RayCount::default();
        let mut audit = FilterAudit::default();
        let mut segments =
            [Segment { from: glam::Vec3::ZERO, to: glam::Vec3::ZERO, skip: [NO_FACET; 2] }; PACKET];
        let mut weights = [0.0; PACKET];
        let mut blockers = [NO_FACET; PACKET];
        let softening =
            0.01 * receiver.center(self.hierarchy).distance_squared(source.center(self.hierarchy));
        // Points that face away are passed over; twice the rays are tried at most.
        let mut tried = 0;
        while met.cast() < count && tried < 2 * count {
            let wanted = (count - met.cast()).min(PACKET as u32) as usize;
            let mut ready = 0;
            while ready < wanted && tried < 2 * count {
                let [a, b, c, d] = sequence.point(tried);
                tried += 1;
                let (from, from_facet) = receiver.surface_point(self.hierarchy, a, b);
                let (to, to_facet) = source.surface_point(self.hierarchy, c, d);
                let heights = receiver.height(self.hierarchy, from_facet, to)
                    * source.height(self.hierarchy, to_facet, from);
                if from_facet == to_facet || heights <= 0.0 {
                    continue;
                }
                // Near parts of the nodes exchange most of the light: a ray counts as much as the
                // kernel cos·cos/d² along it, kept finite where the nodes touch.
                let distance_squared = from.distance_squared(to) + softening;
                weights[ready] = heights / (distance_squared * distance_squared);
                segments[ready] =
                    Segment { from: from.as_vec3(), to: to.as_vec3(), skip: [from_facet, to_facet] };
                ready += 1;
            }
            if ready == 0 {
                break;
            }
            self.tracer_for_rays().blockers(
                &segments[..ready],
                candidates,
                &mut blockers[..ready],
                &mut audit,
            );
            blockers[..ready].iter().zip(weights).for_each(|(&b, weight)| met.add(b, weight));
            if until_mixed && met.is_mixed() {
                break;
            }
        }
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
            if shaft.holds_part_of(self.hierarchy.polygon(audit.outsider).vertices(), margin) {
                counters.culling_anomalies += audit.outsiders;
            } else {
                counters.border_hits += audit.outsiders;
            }
        }
        met
    }
}
