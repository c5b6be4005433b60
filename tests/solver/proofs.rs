//! Trying to refute proofs of visibility with many random segments, the exhaustive tracer judging.

use glam::DVec3;
use lightshaft::tracer::{BruteTracer, NO_FACET, Segment};

use crate::covered_pairs::Leaf;
use crate::segments::{Numbers, blockers};

/// How far segment ends are moved inwards to tell a wrong proof from a ray that rounds to the other
/// side of a shaft's border, local length. Shafts are exact to 2e-6.
const INWARDS: f64 = 2e-5;

/// What the judge said of the segments between two elements.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Attack {
    pub(crate) segments: u64,
    /// Segments that contradict the proof.
    pub(crate) against: u64,
    /// Those of them that still do when both ends are moved a little inwards.
    pub(crate) refuted: u64,
}

impl std::ops::AddAssign for Attack {
    fn add_assign(&mut self, other: Attack) {
        self.segments += other.segments;
        self.against += other.against;
        self.refuted += other.refuted;
    }
}

/// Tries `count` segments against the claim that all of them are blocked, or that none is.
pub(crate) fn attack(
    judge: &BruteTracer,
    receiver: &Leaf,
    source: &Leaf,
    is_blocked: bool,
    count: usize,
    numbers: &mut Numbers,
) -> Attack {
    let skip = [receiver.facet, source.facet];
    let ends: Vec<(DVec3, DVec3)> = (0..count)
        .map(|_| (numbers.point_of(&receiver.polygon), numbers.point_of(&source.polygon)))
        .filter(|&(from, to)| receiver.exchanges(from, source, to))
        .collect();
    let against = |ends: &[(DVec3, DVec3)]| -> Vec<(DVec3, DVec3)> {
        let segments: Vec<Segment> =
            ends.iter().map(|(from, to)| Segment { from: from.as_vec3(), to: to.as_vec3(), skip }).collect();
        let found = blockers(judge, &segments);
        ends.iter().zip(found).filter(|(_, b)| (*b != NO_FACET) != is_blocked).map(|(&e, _)| e).collect()
    };
    let contradicting = against(&ends);
    let inwards = |leaf: &Leaf, p: DVec3| {
        let center = leaf.polygon.center();
        p + (center - p).clamp_length_max(INWARDS)
    };
    let moved: Vec<(DVec3, DVec3)> =
        contradicting.iter().map(|&(a, b)| (inwards(receiver, a), inwards(source, b))).collect();
    let refuted = against(&moved).len() as u64;
    Attack { segments: ends.len() as u64, against: contradicting.len() as u64, refuted }
}
