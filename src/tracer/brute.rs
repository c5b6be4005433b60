//! The referee: every triangle, one by one, in double precision. Slow by design; it settles
//! disagreements and serves the strategy that has no tree.

use super::triangle::Probe;
use super::{Candidates, FilterAudit, Hit, NO_FACET, Ray, Segment, TraceMesh, Tracer};

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
            let [near, far] = segment.open_part().map(f64::from);
            let probe = Probe::new(segment.from, segment.to - segment.from);
            *blocker = (0..self.mesh.triangles.len() as u32)
                .filter(|&t| probe.meet(&self.mesh, t).is_some_and(|t| t > near && t < far))
                .map(|t| self.mesh.facet_of_triangle[t as usize])
                .find(|&facet| audit.accepts(facet, segment.skip, &candidates))
                .unwrap_or(NO_FACET);
        }
    }

    fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            let probe = Probe::new(ray.origin, ray.direction);
            *hit = (0..self.mesh.triangles.len() as u32)
                .filter_map(|triangle| {
                    let t = probe.meet(&self.mesh, triangle)?;
                    let facet = self.mesh.facet_of_triangle[triangle as usize];
                    (t > 0.0).then_some(Hit { facet, triangle, t: t as f32 })
                })
                .min_by(|a, b| a.t.total_cmp(&b.t));
        }
    }
}
