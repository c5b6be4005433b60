//! Light by way of other surfaces: rays over the hemisphere of a point find what it sees, and the
//! solution says how bright that is.

use super::parts::Spotlit;
use crate::hierarchy::Hierarchy;
use crate::math::{PairSequence, cosine_direction};
use crate::radiosity::Solution;
use crate::tracer::{Departure, PACKET, Ray, Tracer, departing_hits};
use glam::{DVec3, Vec3};

/// Irradiance at a point by reflection from everything it sees: the mean exitance, own emission left out,
/// over `samples` directions distributed like the cosine.
pub(super) fn reflected(
    hierarchy: &Hierarchy,
    solution: &Solution,
    tracer: &dyn Tracer,
    at: Spotlit,
    samples: u32,
    sequence: &PairSequence,
) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for first in (0..samples).step_by(PACKET) {
        let count = (samples - first).min(PACKET as u32) as usize;
        let departures: [Departure; PACKET] = std::array::from_fn(|i| {
            let [s, t, ..] = sequence.point(first + i as u32);
            let direction = cosine_direction(at.normal, s, t);
            Departure { point: at.point, normal: at.surface, facet: at.facet, direction }
        });
        let mut rays = [Ray { origin: Vec3::ZERO, direction: Vec3::Z }; PACKET];
        let mut hits = [None; PACKET];
        departing_hits(tracer, &departures[..count], &mut rays[..count], &mut hits[..count]);
        for (ray, hit) in rays.iter().zip(hits.iter().take(count)) {
            let Some(hit) = hit else { continue };
            if at.surface.dot(ray.direction.as_dvec3()) <= 0.0 {
                continue;
            }
            if let Some(leaf) = solution.forest.leaf_met(hierarchy, ray, hit) {
                let reflectance = solution.forest.reflectance_of(hierarchy, leaf);
                sum += (reflectance * solution.light.irradiance[leaf.id as usize]).as_dvec3();
            }
        }
    }
    sum / samples.max(1) as f64
}
