//! Light straight from the emitters: exact form factors of their parts, each with the visibility of one
//! ray.

use crate::hierarchy::Hierarchy;
use crate::math::{PairSequence, Plane, Polygon, hash_pair};
use crate::radiosity::PolygonSource;
use crate::tracer::{Candidates, FilterAudit, NO_FACET, PACKET, Segment, Tracer};
use glam::DVec3;
use std::f64::consts::PI;

/// No emitter is cut more often than this.
const MOST_CUTS: u32 = 24;

/// A facet that emits from its front.
#[derive(Clone, Debug)]
pub(super) struct Emitter {
    facet: u32,
    polygon: Polygon,
    plane: Plane,
    /// Emitted exitance, W/m².
    exitance: DVec3,
}

/// All emitters of a scene.
pub(super) fn emitters(hierarchy: &Hierarchy) -> Vec<Emitter> {
    (0..hierarchy.facets.len() as u32)
        .filter(|&facet| hierarchy.material(facet).is_emitter())
        .map(|facet| Emitter {
            facet,
            polygon: hierarchy.polygon(facet),
            plane: hierarchy.facets[facet as usize].plane,
            exitance: glam::Vec3::from(hierarchy.material(facet).radiance).as_dvec3() * PI,
        })
        .collect()
}

/// A part of an emitter, above the horizon of the point.
struct Part {
    polygon: Polygon,
    /// Irradiance it brings when nothing is in between.
    irradiance: DVec3,
    emitter: usize,
}

/// Where light is asked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spotlit {
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
    /// Unit normal of the side it lies on; nothing comes from below that. In mid-air, `normal`.
    pub(super) surface: DVec3,
    /// The facet it lies on, or [`NO_FACET`].
    pub(super) facet: u32,
}

/// Irradiance at a point, straight from `emitters`, with about `samples` rays.
///
/// Emitters are cut until every part brings less than its share of the irradiance. Each part counts with
/// its exact form factor and the visibility of one point in it; parts that bring much less share rays.
pub(super) fn direct(
    emitters: &[Emitter],
    tracer: &dyn Tracer,
    at: Spotlit,
    samples: u32,
    sequence: &PairSequence,
) -> DVec3 {
    let horizons = [at.normal, at.surface].map(|normal| Plane::through(at.point, normal));
    let mut whole: Vec<Part> = Vec::new();
    for (index, emitter) in emitters.iter().enumerate() {
        if emitter.facet == at.facet || emitter.plane.distance(at.point) <= 0.0 {
            continue;
        }
        let above = horizons.iter().try_fold(emitter.polygon, |polygon, horizon| polygon.clipped(horizon));
        let Some(polygon) = above else { continue };
        let irradiance = unblocked(&polygon, emitter, at);
        if irradiance.max_element() > 0.0 {
            whole.push(Part { polygon, irradiance, emitter: index });
        }
    }
    let total: f64 = whole.iter().map(|part| part.irradiance.element_sum()).sum();
    if total <= 0.0 {
        return DVec3::ZERO;
    }
    let share = total / samples as f64;
    let mut rays = Rays { tracer, at, segments: Vec::new(), carried: Vec::new(), arrived: DVec3::ZERO };
    // What is left of the last small parts, towards the next ray that stands for them.
    let (mut due, mut index) = (0.5, 0);
    let mut stack: Vec<(Part, u32)> = whole.into_iter().rev().map(|part| (part, 0)).collect();
    while let Some((part, cuts)) = stack.pop() {
        let brought = part.irradiance.element_sum();
        let emitter = &emitters[part.emitter];
        if brought > share && cuts < MOST_CUTS {
            for polygon in part.polygon.bisect().into_iter().rev() {
                let irradiance = unblocked(&polygon, emitter, at);
                stack.push((Part { polygon, irradiance, emitter: part.emitter }, cuts + 1));
            }
            continue;
        }
        let chance = (4.0 * brought / share).min(1.0);
        due += chance;
        if chance < 1.0 && due < 1.0 {
            continue;
        }
        due -= 1.0;
        // One point after the other would lie in the same halves of all parts that are the first of two.
        let [u, v, ..] = sequence.point(hash_pair(index, 0) as u32);
        index += 1;
        rays.cast(part.polygon.point_at(u, v), emitter.facet, part.irradiance / chance);
    }
    rays.flush();
    rays.arrived
}

fn unblocked(polygon: &Polygon, emitter: &Emitter, at: Spotlit) -> DVec3 {
    emitter.exitance * PolygonSource::new(polygon, emitter.plane).form_factor(at.point, at.normal)
}

/// Rays to parts of emitters, cast in packets.
struct Rays<'a> {
    tracer: &'a dyn Tracer,
    at: Spotlit,
    segments: Vec<Segment>,
    carried: Vec<DVec3>,
    arrived: DVec3,
}

impl Rays<'_> {
    fn cast(&mut self, to: DVec3, facet: u32, irradiance: DVec3) {
        let skip = [self.at.facet, facet];
        self.segments.push(Segment { from: self.at.point.as_vec3(), to: to.as_vec3(), skip });
        self.carried.push(irradiance);
        if self.segments.len() == PACKET {
            self.flush();
        }
    }

    fn flush(&mut self) {
        let mut blockers = [NO_FACET; PACKET];
        let blockers = &mut blockers[..self.segments.len()];
        self.tracer.blockers(&self.segments, Candidates::All, blockers, &mut FilterAudit::default());
        for (blocker, irradiance) in blockers.iter().zip(&self.carried) {
            if *blocker == NO_FACET {
                self.arrived += *irradiance;
            }
        }
        self.segments.clear();
        self.carried.clear();
    }
}
