//! What visibility tests did; kept per worker and added up.

use std::ops::AddAssign;

/// Work done by visibility tests. All sums, so that the order of adding does not matter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VisibilityCounters {
    /// Pairs tested (not inherited).
    pub pairs_tested: u64,
    /// Shafts built.
    pub shafts_built: u64,
    /// Hierarchy nodes tested against shafts.
    pub nodes_tested: u64,
    /// Shafts found empty.
    pub empty_shafts: u64,
    /// Pairs proved blocked by one facet.
    pub single_blockers: u64,
    /// Pairs proved blocked by several facets in one plane.
    pub fused_blockers: u64,
    /// Rays cast.
    pub rays_cast: u64,
    /// Rays not cast because something else decided.
    pub rays_avoided: u64,
    /// Hits offered to the candidate filter.
    pub filter_calls: u64,
    /// Hits the filter rejected.
    pub filter_rejects: u64,
    /// Other rejected hits: on facets that only touch the border of the shaft.
    pub border_hits: u64,
    /// Facets of a pair that rays hit, that are inside the shaft and should have been candidates.
    pub culling_anomalies: u64,
    /// Shafts that were not empty.
    pub filled_shafts: u64,
    /// Facets left in those.
    pub candidates: u64,
    /// Nanoseconds spent, summed over workers.
    pub nanoseconds: u64,
}

/// Work of building a shaft: about as much as so many rays.
const WORK_OF_SHAFT: u64 = 8;

/// Tests of nodes against a shaft that are about as much work as a ray.
const NODES_PER_RAY: u64 = 16;

impl VisibilityCounters {
    /// Work done since some earlier state of the same counters, in rays; a measure that does not depend on the clock.
    pub fn work_since(&self, before: &VisibilityCounters) -> u64 {
        let nodes = self.nodes_tested - before.nodes_tested;
        self.rays_cast - before.rays_cast
            + WORK_OF_SHAFT * (self.shafts_built - before.shafts_built)
            + nodes.div_ceil(NODES_PER_RAY)
    }
}

impl AddAssign for VisibilityCounters {
    fn add_assign(&mut self, o: VisibilityCounters) {
        self.pairs_tested += o.pairs_tested;
        self.shafts_built += o.shafts_built;
        self.nodes_tested += o.nodes_tested;
        self.empty_shafts += o.empty_shafts;
        self.single_blockers += o.single_blockers;
        self.fused_blockers += o.fused_blockers;
        self.rays_cast += o.rays_cast;
        self.rays_avoided += o.rays_avoided;
        self.filter_calls += o.filter_calls;
        self.filter_rejects += o.filter_rejects;
        self.border_hits += o.border_hits;
        self.culling_anomalies += o.culling_anomalies;
        self.filled_shafts += o.filled_shafts;
        self.candidates += o.candidates;
        self.nanoseconds += o.nanoseconds;
    }
}
