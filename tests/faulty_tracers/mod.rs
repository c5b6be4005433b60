//! A fault to plant in a tracer, so that what looks for faults can be seen to find one. Tests of several crates share
//! it.

use lightshaft::tracer::{Candidates, FilterAudit, Hit, Interval, Ray, Segment, Tracer};

/// Answers with a tracer, but no segment ever meets one facet.
pub(crate) struct Blind<'a> {
    pub(crate) tracer: &'a dyn Tracer,
    pub(crate) facet: u32,
    /// As if the facet had been culled: where the whole scene is asked it is seen.
    pub(crate) only_in_lists: bool,
}

impl<'a> Blind<'a> {
    /// Whoever asks.
    pub(crate) fn to(tracer: &'a dyn Tracer, facet: u32) -> Blind<'a> {
        Blind { tracer, facet, only_in_lists: false }
    }
}

impl Tracer for Blind<'_> {
    fn name(&self) -> &'static str {
        "blind"
    }

    fn blockers(
        &self,
        segments: &[Segment],
        candidates: Candidates<'_>,
        blockers: &mut [u32],
        audit: &mut FilterAudit,
    ) {
        if self.only_in_lists && matches!(candidates, Candidates::All) {
            return self.tracer.blockers(segments, candidates, blockers, audit);
        }
        let left = without(candidates, self.facet);
        // Who is blind does not tell; who was given too short a list does.
        let mut untold = FilterAudit::default();
        let audit = if self.only_in_lists { audit } else { &mut untold };
        self.tracer.blockers(segments, Candidates::Only(&left), blockers, audit);
    }

    fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.tracer.first_hits(rays, hits);
    }
}

/// The candidates, less one facet.
pub(crate) fn without(candidates: Candidates<'_>, facet: u32) -> Vec<Interval> {
    let everything = [Interval { start: 0, end: u32::MAX }];
    let intervals = match candidates {
        Candidates::All => &everything[..],
        Candidates::Only(list) => list,
    };
    let around = |i: &Interval| {
        [
            Interval { start: i.start, end: i.end.min(facet) },
            Interval { start: i.start.max(facet.saturating_add(1)), end: i.end },
        ]
    };
    intervals.iter().flat_map(around).filter(|i| i.start < i.end).collect()
}
