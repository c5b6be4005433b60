//! Light from surfaces, part by part: exact form factors, each with the visibility of one ray.

use crate::hierarchy::{Hierarchy, Side, TOLERANCE};
use crate::math::{PairSequence, Plane, hash_pair};
use crate::radiosity::{Forest, Light, Piece, SourceShape};
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
pub(super) struct SentOut<'a, 'l> {
    pub(super) forest: &'a Forest,
    pub(super) light: &'l Light,
}

impl<'a> Shining<'a> for SentOut<'a, '_> {
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

/// A surface that shines, or a part of one.
pub(super) struct Source<'a> {
    shape: SourceShape,
    /// W/m².
    pub(super) exitance: DVec3,
    pub(super) piece: Piece<'a>,
}

impl<'a> Source<'a> {
    pub(super) fn new(piece: Piece<'a>, shining: &impl Shining<'a>) -> Source<'a> {
        let shape = SourceShape::of(&piece.polygon, piece.plane);
        Source { shape, exitance: shining.exitance(&piece), piece }
    }

    /// What it brings to a point when nothing is in between.
    pub(super) fn irradiance(&self, at: Spotlit) -> DVec3 {
        self.exitance * self.shape.form_factor(&self.piece.polygon, at.point, at.normal)
    }

    /// Its two parts.
    pub(super) fn halves(&self, shining: &impl Shining<'a>) -> [Source<'a>; 2] {
        shining.halves(&self.piece).map(|half| Source::new(half, shining))
    }

    /// Hands over itself, or its parts, so that none brings more than `share` to a point, sum of the channels; parts
    /// that bring nothing are left out.
    pub(super) fn cut(
        self,
        share: f64,
        shining: &impl Shining<'a>,
        at: Spotlit,
        take: &mut impl FnMut(Source<'a>),
    ) {
        let mut stack = vec![(self, 0)];
        while let Some((source, cuts)) = stack.pop() {
            let brought = source.irradiance(at).element_sum();
            if brought > share && cuts < MOST_CUTS {
                stack.extend(source.halves(shining).into_iter().rev().map(|half| (half, cuts + 1)));
            } else if brought > 0.0 {
                take(source);
            }
        }
    }
}

/// Light that rays find to arrive at a point.
pub(super) struct Arriving<'a> {
    rays: Rays<'a>,
    sequence: PairSequence,
    horizon: Plane,
    share: f64,
    /// What is left of the last small parts, towards the next ray that stands for them.
    due: f64,
    index: u64,
}

impl<'a> Arriving<'a> {
    /// Nothing yet. Parts that bring much less than `share`, sum of the channels, share rays.
    pub(super) fn new(tracer: &'a dyn Tracer, at: Spotlit, share: f64, sequence: PairSequence) -> Self {
        let rays = Rays { tracer, at, segments: Vec::new(), carried: Vec::new(), arrived: DVec3::ZERO };
        let horizon = Plane::through(at.point, at.normal);
        Arriving { rays, sequence, horizon, share, due: 0.5, index: 0 }
    }

    /// Adds a part that brings this `irradiance` where one point of it is seen.
    pub(super) fn add(&mut self, source: &Source<'_>, irradiance: DVec3) {
        let chance = (4.0 * irradiance.element_sum() / self.share).min(1.0);
        self.due += chance;
        if chance < 1.0 && self.due < 1.0 {
            return;
        }
        self.due -= 1.0;
        // One point after the other would lie in the same halves of all parts that are the first of two.
        let [u, v, ..] = self.sequence.point(hash_pair(self.index, 0) as u32);
        let polygon = &source.piece.polygon;
        let point = if polygon.vertices().iter().all(|&vertex| self.horizon.distance(vertex) >= 0.0) {
            polygon.point_at(u, v)
        } else {
            let Some(above) = polygon.clipped(&self.horizon) else { return };
            above.point_at(u, v)
        };
        self.index += 1;
        self.rays.cast(point, source.piece.side.facet, irradiance / chance);
    }

    /// All of it, W/m².
    pub(super) fn sum(mut self) -> DVec3 {
        self.rays.flush();
        self.rays.arrived
    }
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
