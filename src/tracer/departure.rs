//! Rays that leave a surface.

use super::{Hit, NO_FACET, PACKET, Ray, Tracer};
use glam::{DVec3, Vec3};

/// How far above its surface a ray starts, local units: some roundings. A surface nearer than this is
/// stepped over.
const LIFT: f64 = 1e-6;

/// A ray that still meets its own surface, which is not quite flat, goes on this far behind it.
const STEP: f32 = 1e-6;

/// Where a ray leaves.
#[derive(Clone, Copy, Debug)]
pub struct Departure {
    /// The point, local coordinates.
    pub point: DVec3,
    /// Unit normal of the surface, on the side where the ray leaves.
    pub normal: DVec3,
    /// The facet the point lies on, which the ray does not meet; [`NO_FACET`] in mid-air.
    pub facet: u32,
    /// Unit direction.
    pub direction: Vec3,
}

/// For each of up to [`PACKET`] departures the ray and the first thing it meets that is not its own facet.
///
/// # Panics
/// In debug builds, when there are more than [`PACKET`] departures or the lengths differ.
pub fn departing_hits(
    tracer: &dyn Tracer,
    departures: &[Departure],
    rays: &mut [Ray],
    hits: &mut [Option<Hit>],
) {
    debug_assert!(departures.len() <= PACKET && departures.len() == rays.len());
    for (ray, from) in rays.iter_mut().zip(departures) {
        let lift = if from.facet == NO_FACET { 0.0 } else { LIFT };
        *ray = Ray { origin: (from.point + from.normal * lift).as_vec3(), direction: from.direction };
    }
    tracer.first_hits(rays, hits);
    for (i, from) in departures.iter().enumerate() {
        if let Some(own) = hits[i].filter(|hit| hit.facet == from.facet) {
            rays[i].origin += from.direction * (own.t + STEP) + (from.normal * LIFT).as_vec3();
            tracer.first_hits(&rays[i..=i], &mut hits[i..=i]);
            hits[i] = hits[i].filter(|hit| hit.facet != from.facet);
        }
    }
}
