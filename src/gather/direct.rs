//! Light straight from the emitters: exact form factors of their parts, each with the visibility of one
//! ray.

use super::parts::{Arriving, Emitted, Source, Spotlit};
use crate::hierarchy::{Hierarchy, Side};
use crate::math::{PairSequence, Plane};
use crate::radiosity::{Forest, Piece};
use crate::tracer::Tracer;
use glam::DVec3;

/// The fronts of all facets that emit.
pub(super) fn emitters(hierarchy: &Hierarchy, forest: &Forest) -> Vec<Piece> {
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
    emitters: &[Piece],
    tracer: &dyn Tracer,
    at: Spotlit,
    samples: u32,
    sequence: &PairSequence,
) -> DVec3 {
    let horizons = [at.normal, at.surface].map(|normal| Plane::through(at.point, normal));
    let emitted = Emitted(hierarchy);
    let (mut whole, mut total) = (Vec::new(), 0.0);
    for emitter in emitters {
        if emitter.side.facet == at.facet || emitter.plane.distance(at.point) <= 0.0 {
            continue;
        }
        let above = horizons.iter().try_fold(emitter.polygon, |polygon, horizon| polygon.clipped(horizon));
        let Some(polygon) = above else { continue };
        let source = Source::new(emitter.part(polygon), true, &emitted);
        let irradiance = source.irradiance(at).element_sum();
        if irradiance > 0.0 {
            whole.push(source);
            total += irradiance;
        }
    }
    let share = total / samples as f64;
    let mut arriving = Arriving::new(tracer, at, share, *sequence);
    for source in whole {
        source.cut(share, &emitted, at, &mut |part| arriving.add(&part, part.irradiance(at), &emitted));
    }
    arriving.sum()
}
