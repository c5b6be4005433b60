//! The referee: every triangle, one by one, in double precision. Slow by design; it settles
//! disagreements and serves the strategy that has no tree.

use super::triangle::Probe;
use super::{Candidates, FilterAudit, Hit, NO_FACET, Ray, Segment, TraceMesh, Tracer};
use std::ops::Range;

/// Tests all triangles for every query.
#[derive(Debug)]
pub struct BruteTracer {
    mesh: TraceMesh,
}

impl BruteTracer {
    /// A referee for `mesh`.
    pub fn new(mesh: &TraceMesh) -> BruteTracer {
        BruteTracer { mesh: mesh.clone() }
    }

    /// Whether one facet blocks a segment.
    pub fn is_blocked_by(&self, segment: &Segment, facet: u32) -> bool {
        let [first, end] = [0, 1].map(|i| self.mesh.first_triangle[facet as usize + i]);
        !segment.skip.contains(&facet) && self.met(segment, first..end).next().is_some()
    }

    /// Every facet that blocks a segment, ascending.
    pub fn all_blockers(&self, segment: &Segment) -> Vec<u32> {
        let met = self.met(segment, 0..self.mesh.triangles.len() as u32);
        let mut found: Vec<u32> = met.filter(|facet| !segment.skip.contains(facet)).collect();
        // Triangles are in the order of their facets.
        found.dedup();
        found
    }

    /// Where a ray meets a facet first, in units of its direction.
    pub fn hit_on(&self, ray: &Ray, facet: u32) -> Option<f64> {
        let [first, end] = [0, 1].map(|i| self.mesh.first_triangle[facet as usize + i]);
        let probe = Probe::new(ray.origin, ray.direction);
        (first..end)
            .filter_map(|t| probe.meet(&self.mesh.corners(t)))
            .filter(|&t| t > 0.0)
            .min_by(f64::total_cmp)
    }

    /// The facets of those of some triangles that a segment meets between its ends.
    fn met(&self, segment: &Segment, triangles: Range<u32>) -> impl Iterator<Item = u32> + '_ {
        let [near, far] = segment.open_part().map(f64::from);
        let probe = Probe::new(segment.from, segment.to - segment.from);
        triangles
            .filter(move |&t| probe.meet(&self.mesh.corners(t)).is_some_and(|t| t > near && t < far))
            .map(|t| self.mesh.facet_of_triangle[t as usize])
    }
}

impl Tracer for BruteTracer {
    fn name(&self) -> &'static str {
        "brute"
    }

    fn blockers(
        &self,
        segments: &[Segment],
        candidates: Candidates<'_>,
        blockers: &mut [u32],
        audit: &mut FilterAudit,
    ) {
        for (segment, blocker) in segments.iter().zip(blockers) {
            *blocker = self
                .met(segment, 0..self.mesh.triangles.len() as u32)
                .find(|&facet| audit.accepts(facet, segment.skip, &candidates))
                .unwrap_or(NO_FACET);
        }
    }

    fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            let probe = Probe::new(ray.origin, ray.direction);
            *hit = (0..self.mesh.triangles.len() as u32)
                .filter_map(|triangle| {
                    let t = probe.meet(&self.mesh.corners(triangle))?;
                    let facet = self.mesh.facet_of_triangle[triangle as usize];
                    (t > 0.0).then_some(Hit { facet, triangle, t: t as f32 })
                })
                .min_by(|a, b| a.t.total_cmp(&b.t));
        }
    }
}
