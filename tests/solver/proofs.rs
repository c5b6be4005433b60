//! Trying to refute proofs of visibility with many random segments, the exhaustive tracer judging.

use glam::DVec3;
use lightshaft::hierarchy::{Hierarchy, TOLERANCE};
use lightshaft::math::Plane;
use lightshaft::tracer::{BruteTracer, END_MARGIN, NO_FACET, Segment};

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

/// What is claimed of the segments between two elements.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Claim {
    /// None is blocked.
    Clear,
    /// All are, by what lies in this plane. It does not hide points on it.
    BlockedAt(Plane),
}

/// Points nearer than this to an occluder are on it, local length: rays do not see it there.
const ON_IT: f64 = 2.0 * END_MARGIN as f64;

/// Whether a segment runs along a facet or through its border, as along the side of a table's leg: it is neither
/// blocked nor clear.
fn only_touches(hierarchy: &Hierarchy, facet: u32, from: DVec3, to: DVec3) -> bool {
    if facet as usize >= hierarchy.facets.len() {
        return false;
    }
    let plane = &hierarchy.facets[facet as usize].plane;
    let (a, b) = (plane.distance(from), plane.distance(to));
    if a.abs() <= TOLERANCE && b.abs() <= TOLERANCE {
        return true;
    }
    let at = from.lerp(to, a / (a - b));
    hierarchy.polygon(facet).outside_distance(at, plane.normal) >= -TOLERANCE
}

/// Tries `count` segments against a claim.
pub(crate) fn attack(
    hierarchy: &Hierarchy,
    judge: &BruteTracer,
    receiver: &Leaf,
    source: &Leaf,
    claim: Claim,
    count: usize,
    numbers: &mut Numbers,
) -> Attack {
    let skip = [receiver.facet, source.facet];
    let ends: Vec<(DVec3, DVec3)> = (0..count)
        .map(|_| (numbers.point_of(&receiver.polygon), numbers.point_of(&source.polygon)))
        .filter(|&(from, to)| receiver.exchanges(from, source, to))
        .filter(|&(from, to)| match claim {
            Claim::Clear => true,
            Claim::BlockedAt(plane) => [from, to].iter().all(|&end| plane.distance(end).abs() > ON_IT),
        })
        .collect();
    let against = |ends: &[(DVec3, DVec3)]| -> Vec<(DVec3, DVec3)> {
        let segments: Vec<Segment> =
            ends.iter().map(|(from, to)| Segment { from: from.as_vec3(), to: to.as_vec3(), skip }).collect();
        let found = blockers(judge, &segments);
        let is_blocked = matches!(claim, Claim::BlockedAt(_));
        let contradicts = |&(&(from, to), blocker): &(&(DVec3, DVec3), u32)| {
            (blocker != NO_FACET) != is_blocked && !only_touches(hierarchy, blocker, from, to)
        };
        ends.iter().zip(found).filter(contradicts).map(|(&ends, _)| ends).collect()
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
