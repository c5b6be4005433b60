//! Segments between random points, and the exhaustive tracer as the judge of them.

use glam::{DVec3, Vec3};
use lightshaft::math::Polygon;
use lightshaft::tracer::{BruteTracer, Candidates, FilterAudit, NO_FACET, PACKET, Segment, Tracer};

use crate::solving::Case;

/// A small deterministic generator of numbers in `[0, 1)`.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((self.next() * count as f64) as usize).min(count - 1)
    }

    /// A point of `polygon`: anywhere, on its border, or in a corner.
    pub(crate) fn point_of(&mut self, polygon: &Polygon) -> DVec3 {
        let v = polygon.vertices();
        let corner = self.below(v.len());
        match self.below(8) {
            0 => v[corner],
            1 => v[corner].lerp(v[(corner + 1) % v.len()], self.next()),
            _ => polygon.point_at(self.next(), self.next()),
        }
    }
}

/// The blocker of each segment.
pub(crate) fn blockers(tracer: &dyn Tracer, segments: &[Segment]) -> Vec<u32> {
    let mut all = vec![NO_FACET; segments.len()];
    let mut audit = FilterAudit::default();
    for (packet, blockers) in segments.chunks(PACKET).zip(all.chunks_mut(PACKET)) {
        tracer.blockers(packet, Candidates::All, blockers, &mut audit);
    }
    all
}

/// The facet that most often is in the way between two random points on surfaces.
pub(crate) fn most_frequent_blocker(case: &Case) -> u32 {
    let mut numbers = Numbers(1);
    let count = case.hierarchy.facets.len();
    let segments: Vec<Segment> = (0..4000)
        .map(|_| {
            let skip = [numbers.below(count), numbers.below(count)].map(|facet| facet as u32);
            let [from, to]: [Vec3; 2] =
                skip.map(|facet| numbers.point_of(&case.hierarchy.polygon(facet)).as_vec3());
            Segment { from, to, skip }
        })
        .collect();
    let mut hits = vec![0; count];
    for blocker in blockers(&BruteTracer::new(&case.hierarchy.mesh), &segments) {
        if blocker != NO_FACET {
            hits[blocker as usize] += 1;
        }
    }
    let most = hits.iter().copied().max().unwrap_or(0);
    assert!(most > 100, "nothing is ever in the way");
    hits.iter().position(|&h| h == most).map_or(NO_FACET, |facet| facet as u32)
}
