//! Light straight from the emitters: exact form factors of their parts, each with the visibility of one
//! ray.

use super::parts::{Emitted, Part, Spotlit, visible};
use crate::hierarchy::{Hierarchy, Side};
use crate::math::{PairSequence, Plane};
use crate::radiosity::{Forest, Piece};
use crate::tracer::Tracer;
use glam::DVec3;

/// The fronts of all facets that emit.
pub(super) fn emitters<'a>(hierarchy: &Hierarchy, forest: &'a Forest) -> Vec<Piece<'a>> {
    (0..hierarchy.facets.len() as u32)
        .filter(|&facet| hierarchy.material(facet).is_emitter())
        .filter_map(|facet| forest.side_index(Side { facet, back: false }))
        .map(|side| forest.root(hierarchy, side))
        .collect()
}

/// Irradiance at a point, straight from `emitters`, with about `samples` rays.
///
/// Emitters are cut until every part brings less than its share of the irradiance.
pub(super) fn direct(
    hierarchy: &Hierarchy,
    emitters: &[Piece<'_>],
    tracer: &dyn Tracer,
    at: Spotlit,
    samples: u32,
    sequence: &PairSequence,
) -> DVec3 {
    let horizons = [at.normal, at.surface].map(|normal| Plane::through(at.point, normal));
    let emitted = Emitted(hierarchy);
    let mut whole = Vec::new();
    for emitter in emitters {
        if emitter.side.facet == at.facet || emitter.plane.distance(at.point) <= 0.0 {
            continue;
        }
        let above = horizons.iter().try_fold(emitter.polygon, |polygon, horizon| polygon.clipped(horizon));
        let Some(polygon) = above else { continue };
        let part = Part::new(emitter.part(polygon), &emitted, at);
        if part.irradiance.max_element() > 0.0 {
            whole.push(part);
        }
    }
    let total: f64 = whole.iter().map(|part| part.irradiance.element_sum()).sum();
    if total <= 0.0 {
        return DVec3::ZERO;
    }
    visible(whole, total / samples as f64, &emitted, tracer, at, sequence)
}
