//! Who is right when two tracers disagree: within rounding of an edge or an end both may be, anywhere else
//! one is wrong.

use std::fmt;

use lightshaft::compare::{Referee, Ruling, Standing};
use lightshaft::hierarchy::TOLERANCE;
use lightshaft::tracer::{
    BruteTracer, Candidates, FilterAudit, NO_FACET, PACKET, Segment, TraceMesh, Tracer,
};

/// What came of a comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Verdicts {
    pub(crate) segments: usize,
    /// That the judge says are blocked.
    pub(crate) blocked: usize,
    /// Answers that are not the judge's, for a segment within the tolerance of the edge or the end that
    /// decides.
    pub(crate) within_tolerance: usize,
    /// Largest distance of those.
    pub(crate) farthest: f64,
    /// Hits on a facet beside which a segment passes that lies in its plane, but for the last digit of
    /// single precision: all that tells where it meets the facet has been rounded away.
    pub(crate) edge_on: usize,
    /// All other answers that are not the judge's.
    pub(crate) wrong: usize,
}

impl fmt::Display for Verdicts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Verdicts { segments, blocked, within_tolerance, farthest, edge_on, wrong } = self;
        write!(
            f,
            "{segments} segments, {blocked} blocked; {within_tolerance} differ within {farthest:.1e}, \
             {edge_on} edge-on, {wrong} wrong"
        )
    }
}

/// The blocker of each segment.
pub(crate) fn blockers(tracer: &dyn Tracer, segments: &[Segment], candidates: Candidates<'_>) -> Vec<u32> {
    let mut all = vec![NO_FACET; segments.len()];
    for (packet, blockers) in segments.chunks(PACKET).zip(all.chunks_mut(PACKET)) {
        tracer.blockers(packet, candidates, blockers, &mut FilterAudit::default());
    }
    all
}

/// Compares a tracer with the exhaustive one; the tolerance is a local length.
pub(crate) fn compare_within(
    tolerance: f64,
    mesh: &TraceMesh,
    tracer: &dyn Tracer,
    segments: &[Segment],
) -> Verdicts {
    let referee = Referee::new(mesh);
    let expected = blockers(&BruteTracer::new(mesh), segments, Candidates::All);
    let got = blockers(tracer, segments, Candidates::All);
    let mut verdicts = Verdicts { segments: segments.len(), ..Verdicts::default() };
    for ((segment, &got), &expected) in segments.iter().zip(&got).zip(&expected) {
        verdicts.blocked += usize::from(expected != NO_FACET);
        let [ruling, of_the_judge] = referee.rule(segment, [got, expected], Candidates::All, tolerance);
        assert_eq!(of_the_judge, Ruling::RIGHT);
        match ruling.standing {
            Standing::Right => {}
            Standing::Tolerance => {
                verdicts.within_tolerance += 1;
                verdicts.farthest = verdicts.farthest.max(ruling.distance);
            }
            Standing::EdgeOn => verdicts.edge_on += 1,
            Standing::Wrong => verdicts.wrong += 1,
        }
    }
    verdicts
}

/// [`compare_within`] the tolerance of the whole program: 2·10⁻⁶ of half the size of the scene, a few
/// roundings of single precision, in which Embree computes.
pub(crate) fn compare(mesh: &TraceMesh, tracer: &dyn Tracer, segments: &[Segment]) -> Verdicts {
    compare_within(TOLERANCE, mesh, tracer, segments)
}
