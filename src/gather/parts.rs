//! Light from surfaces, part by part: exact form factors, each with the visibility of one ray.

use crate::hierarchy::{Hierarchy, Side, TOLERANCE};
use crate::math::{PairSequence, Plane, hash_pair};
use crate::radiosity::{Forest, Light, Piece, PolygonSource};
use crate::tracer::{Candidates, FilterAudit, NO_FACET, PACKET, Segment, Tracer};
use glam::DVec3;

/// No part is cut more often than this.
const MOST_CUTS: u32 = 24;

/// How far above its facet a point is taken to be, local length.
const LIFT: f64 = 5.0 * TOLERANCE;

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

impl Spotlit {
    /// On a side, with its normal: just above it, and off the border, where others may stand on it.
    pub(super) fn on(hierarchy: &Hierarchy, Side { facet, back }: Side, point: DVec3) -> Spotlit {
        let plane = hierarchy.facets[facet as usize].plane;
        let point = hierarchy.polygon(facet).inside(point, plane.normal, LIFT);
        let plane = if back { plane.flipped() } else { plane };
        let point = point + plane.normal * (LIFT - plane.distance(point));
        Spotlit { point, normal: plane.normal, surface: plane.normal, facet }
    }
}

/// How bright surfaces are, and how they are divided.
pub(super) trait Shining<'a> {
    /// W/m².
    fn exitance(&self, piece: &Piece<'a>) -> DVec3;

    /// Two parts of it.
    fn halves(&self, piece: &Piece<'a>) -> [Piece<'a>; 2];
}

/// What surfaces emit.
pub(super) struct Emitted<'a>(pub(super) &'a Hierarchy);

impl<'a> Shining<'a> for Emitted<'_> {
    fn exitance(&self, piece: &Piece<'a>) -> DVec3 {
        self.0.emitted(piece.side).as_dvec3()
    }

    fn halves(&self, piece: &Piece<'a>) -> [Piece<'a>; 2] {
        cut(piece)
    }
}

/// All that surfaces send out.
#[derive(Clone, Copy)]
pub(super) struct SentOut<'a> {
    pub(super) forest: &'a Forest,
    pub(super) light: &'a Light,
}

impl<'a> Shining<'a> for SentOut<'a> {
    fn exitance(&self, piece: &Piece<'a>) -> DVec3 {
        self.light.exitance[piece.id() as usize].as_dvec3()
    }

    fn halves(&self, piece: &Piece<'a>) -> [Piece<'a>; 2] {
        if self.forest.second[piece.id() as usize] == 0 { cut(piece) } else { piece.halves(self.forest) }
    }
}

/// The halves of a piece that is one element, whose parts are none.
fn cut<'a>(piece: &Piece<'a>) -> [Piece<'a>; 2] {
    piece.polygon.bisect().map(|polygon| piece.part(polygon))
}

/// A part of a surface that shines on a point.
pub(super) struct Part<'a> {
    pub(super) piece: Piece<'a>,
    /// Irradiance it brings when nothing is in between.
    pub(super) irradiance: DVec3,
}

impl<'a> Part<'a> {
    pub(super) fn new(piece: Piece<'a>, shining: &impl Shining<'a>, at: Spotlit) -> Part<'a> {
        let factor = PolygonSource::new(&piece.polygon, piece.plane).form_factor(at.point, at.normal);
        Part { irradiance: shining.exitance(&piece) * factor, piece }
    }
}

/// Irradiance at a point from `parts`, as far as rays find them visible.
///
/// They are cut until none brings more than `share`, sum of the channels. Each counts with its exact form factor and
/// the visibility of one point in it; those that bring much less share rays.
pub(super) fn visible<'a>(
    parts: Vec<Part<'a>>,
    share: f64,
    shining: &impl Shining<'a>,
    tracer: &dyn Tracer,
    at: Spotlit,
    sequence: &PairSequence,
) -> DVec3 {
    let horizon = Plane::through(at.point, at.normal);
    let mut rays = Rays { tracer, at, segments: Vec::new(), carried: Vec::new(), arrived: DVec3::ZERO };
    // What is left of the last small parts, towards the next ray that stands for them.
    let (mut due, mut index) = (0.5, 0);
    let mut stack: Vec<(Part, u32)> = parts.into_iter().rev().map(|part| (part, 0)).collect();
    while let Some((part, cuts)) = stack.pop() {
        let brought = part.irradiance.element_sum();
        if brought > share && cuts < MOST_CUTS {
            for half in shining.halves(&part.piece).into_iter().rev() {
                stack.push((Part::new(half, shining, at), cuts + 1));
            }
            continue;
        }
        let chance = (4.0 * brought / share).min(1.0);
        due += chance;
        if chance < 1.0 && due < 1.0 {
            continue;
        }
        due -= 1.0;
        let Some(seen) = part.piece.polygon.clipped(&horizon) else { continue };
        // One point after the other would lie in the same halves of all parts that are the first of two.
        let [u, v, ..] = sequence.point(hash_pair(index, 0) as u32);
        index += 1;
        rays.cast(seen.point_at(u, v), part.piece.side.facet, part.irradiance / chance);
    }
    rays.flush();
    rays.arrived
}

/// Rays to parts of surfaces, cast in packets.
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
