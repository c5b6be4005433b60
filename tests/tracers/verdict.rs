//! Who is right when two tracers disagree: within rounding of an edge or an end both may be, anywhere else
//! one is wrong.

use std::fmt;

use glam::DVec3;
use lightshaft::hierarchy::TOLERANCE;
use lightshaft::tracer::{
    BruteTracer, Candidates, FilterAudit, Interval, NO_FACET, PACKET, Segment, TraceMesh, Tracer,
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
    let judge = BruteTracer::new(mesh);
    let expected = blockers(&judge, segments, Candidates::All);
    let got = blockers(tracer, segments, Candidates::All);
    let mut verdicts = Verdicts { segments: segments.len(), ..Verdicts::default() };
    for ((segment, &got), &expected) in segments.iter().zip(&got).zip(&expected) {
        verdicts.blocked += usize::from(expected != NO_FACET);
        if got == expected {
            continue;
        }
        let all = all_blockers(&judge, segment);
        let distance = if got == NO_FACET {
            // Everything that blocks was missed.
            all.into_iter().map(|facet| distance_to_change(mesh, facet, segment)).fold(0.0, f64::max)
        } else if all.contains(&got) {
            continue;
        } else {
            distance_to_change(mesh, got, segment)
        };
        if distance <= tolerance {
            verdicts.within_tolerance += 1;
            verdicts.farthest = verdicts.farthest.max(distance);
        } else if got != NO_FACET && lies_in_plane(mesh, got, segment) {
            verdicts.edge_on += 1;
        } else {
            verdicts.wrong += 1;
        }
    }
    verdicts
}

/// Every facet that the judge says blocks.
fn all_blockers(judge: &BruteTracer, segment: &Segment) -> Vec<u32> {
    let mut found = Vec::new();
    let mut rest = vec![Interval { start: 0, end: u32::MAX }];
    loop {
        let [facet] = blockers(judge, &[*segment], Candidates::Only(&rest))[..] else { return found };
        if facet == NO_FACET {
            return found;
        }
        found.push(facet);
        // The judge names the first that blocks: all before it do not.
        rest = vec![Interval { start: facet + 1, end: u32::MAX }];
    }
}

/// [`compare_within`] the tolerance of the whole program: 2·10⁻⁶ of half the size of the scene, a few
/// roundings of single precision, in which Embree computes.
pub(crate) fn compare(mesh: &TraceMesh, tracer: &dyn Tracer, segments: &[Segment]) -> Verdicts {
    compare_within(TOLERANCE, mesh, tracer, segments)
}

/// Whether both ends are in the plane of a facet, but for one rounding to single precision.
pub(crate) fn lies_in_plane(mesh: &TraceMesh, facet: u32, segment: &Segment) -> bool {
    triangles_of(mesh, facet).iter().any(|t| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3());
        let normal = (b - a).cross(c - a).normalize_or_zero();
        [segment.from, segment.to].into_iter().all(|p| normal.dot(p.as_dvec3() - a).abs() < 1.2e-7)
    })
}

/// How far a segment is from where the answer for one facet changes: from the outline of the facet, and its
/// ends, less what is left out there, from the facet itself.
pub(crate) fn distance_to_change(mesh: &TraceMesh, facet: u32, segment: &Segment) -> f64 {
    distance_between(mesh, facet, trimmed(segment))
}

/// How far a line between two ends is from the outline of a facet, and its ends from the facet itself.
pub(crate) fn distance_between(mesh: &TraceMesh, facet: u32, ends: [DVec3; 2]) -> f64 {
    let triangles = triangles_of(mesh, facet);
    let at = |v: u32| mesh.positions[v as usize].as_dvec3();
    let from_ends =
        ends.into_iter().flat_map(|end| triangles.iter().map(move |t| to_triangle(end, t.map(at))));
    let edges = || triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let outline = edges().filter(|&(a, b)| !edges().any(|(c, d)| (c, d) == (b, a)));
    let from_outline = outline.map(|(a, b)| between_segments(ends, [at(a), at(b)]));
    from_outline.chain(from_ends).fold(f64::INFINITY, f64::min)
}

pub(crate) fn triangles_of(mesh: &TraceMesh, facet: u32) -> &[[u32; 3]] {
    let first = &mesh.first_triangle[facet as usize..];
    &mesh.triangles[first[0] as usize..first[1] as usize]
}

/// The ends of what can be blocked.
fn trimmed(segment: &Segment) -> [DVec3; 2] {
    let (from, to) = (segment.from.as_dvec3(), segment.to.as_dvec3());
    segment.open_part().map(|share| from.lerp(to, share as f64))
}

/// Distance of two segments.
pub(crate) fn between_segments([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> f64 {
    let (u, v) = (b - a, d - c);
    let normal = u.cross(v);
    let ends = [to_segment(a, [c, d]), to_segment(b, [c, d]), to_segment(c, [a, b]), to_segment(d, [a, b])];
    let nearest_end = ends.into_iter().fold(f64::INFINITY, f64::min);
    let square = normal.length_squared();
    if square <= 0.0 {
        return nearest_end;
    }
    // Where the lines come nearest to each other, if that is on both segments.
    let s = (c - a).cross(v).dot(normal) / square;
    let t = (c - a).cross(u).dot(normal) / square;
    let is_inside = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    if is_inside { nearest_end.min((c - a).dot(normal).abs() / square.sqrt()) } else { nearest_end }
}

fn to_segment(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(a + along * t)
}

fn to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let is_over = |start: DVec3, end: DVec3| normal.dot((end - start).cross(p - start)) >= 0.0;
    let from_edges = [[a, b], [b, c], [c, a]].map(|edge| to_segment(p, edge));
    let nearest_edge = from_edges.into_iter().fold(f64::INFINITY, f64::min);
    let is_inside = normal != DVec3::ZERO && is_over(a, b) && is_over(b, c) && is_over(c, a);
    if is_inside { nearest_edge.min((p - a).dot(normal).abs()) } else { nearest_edge }
}

/// The distances by which the tests judge, on figures that can be checked by hand.
#[test]
fn distances_are_what_they_are_by_hand() {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    assert_eq!(between_segments([-x, x], [z - y, z + y]), 1.0);
    assert_eq!(between_segments([-x, x], [x * 3.0 + z, x * 3.0 - z]), 2.0);
    assert_eq!(between_segments([-x, x], [y - x, y + x]), 1.0, "parallel");
    assert_eq!(between_segments([-x, x], [DVec3::ZERO, y]), 0.0, "touching");
    let triangle = [DVec3::ZERO, x * 2.0, y * 2.0];
    assert_eq!(to_triangle(DVec3::new(0.5, 0.5, -3.0), triangle), 3.0);
    assert_eq!(to_triangle(DVec3::new(-4.0, -3.0, 0.0), triangle), 5.0);
}
