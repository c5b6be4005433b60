//! A tracer that asks another one about every segment and counts where they disagree.

use std::sync::atomic::{AtomicU64, Ordering};

use lightshaft::tracer::{Candidates, FilterAudit, Hit, NO_FACET, PACKET, Ray, Segment, Tracer};

/// Answers with the first tracer, compares with the second.
pub(crate) struct SecondOpinion<'a> {
    first: &'a dyn Tracer,
    second: &'a dyn Tracer,
    rays: AtomicU64,
    differing: AtomicU64,
}

impl<'a> SecondOpinion<'a> {
    pub(crate) fn new(first: &'a dyn Tracer, second: &'a dyn Tracer) -> SecondOpinion<'a> {
        SecondOpinion { first, second, rays: AtomicU64::new(0), differing: AtomicU64::new(0) }
    }

    /// Segments asked about, and those on which the tracers disagree whether something blocks them.
    pub(crate) fn counts(&self) -> (u64, u64) {
        (self.rays.load(Ordering::Relaxed), self.differing.load(Ordering::Relaxed))
    }
}

impl Tracer for SecondOpinion<'_> {
    fn name(&self) -> &'static str {
        self.first.name()
    }

    fn blockers(
        &self,
        segments: &[Segment],
        candidates: Candidates<'_>,
        blockers: &mut [u32],
        audit: &mut FilterAudit,
    ) {
        self.first.blockers(segments, candidates, blockers, audit);
        let mut others = [NO_FACET; PACKET];
        let others = &mut others[..segments.len()];
        self.second.blockers(segments, candidates, others, &mut FilterAudit::default());
        let differ = |(a, b): &(&u32, &u32)| (**a == NO_FACET) != (**b == NO_FACET);
        let differing = blockers.iter().zip(others.iter()).filter(differ).count();
        self.rays.fetch_add(segments.len() as u64, Ordering::Relaxed);
        self.differing.fetch_add(differing as u64, Ordering::Relaxed);
    }

    fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.first.first_hits(rays, hits);
    }
}
