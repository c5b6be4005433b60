//! Light from surfaces, part by part: exact form factors, each with the visibility of one ray.

use crate::hierarchy::{Hierarchy, Side, TOLERANCE};
use crate::math::{PairSequence, Plane, Polygon, hash_pair};
use crate::radiosity::{Forest, Light, Piece, SourceShape};
use crate::tracer::{Candidates, FilterAudit, NO_FACET, PACKET, Segment, Tracer};
use glam::DVec3;
use std::rc::Rc;

/// No part is cut more often than this.
const MOST_CUTS: u32 = 24;

/// How far above its facet a point is taken to be, local length.
const LIFT: f64 = 5.0 * TOLERANCE;

/// No point counts more than this times as bright as the part it stands for.
const BRIGHTEST: f64 = 16.0;

/// Points of a part that a ray may go to, where near ones count for more than others.
const CANDIDATES: u32 = 4;

/// A part that looks larger than this (extent over distance, squared) has near and far points.
const LARGE: f64 = 0.1;

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
pub(super) trait Shining {
    /// W/m².
    fn exitance(&self, piece: &Piece) -> DVec3;

    /// That at a point of it, if it is not the same everywhere.
    fn exitance_at(&self, piece: &Piece, point: DVec3) -> Option<DVec3>;

    /// Two parts of it.
    fn halves(&self, piece: &Piece) -> [Piece; 2];
}

/// What surfaces emit.
pub(super) struct Emitted<'a>(pub(super) &'a Hierarchy);

impl Shining for Emitted<'_> {
    fn exitance(&self, piece: &Piece) -> DVec3 {
        self.0.emitted(piece.side).as_dvec3()
    }

    fn exitance_at(&self, _: &Piece, _: DVec3) -> Option<DVec3> {
        None
    }

    fn halves(&self, piece: &Piece) -> [Piece; 2] {
        cut(piece)
    }
}

/// All that surfaces send out.
#[derive(Clone, Copy)]
pub(super) struct SentOut<'a> {
    pub(super) forest: &'a Forest,
    pub(super) light: &'a Light,
}

impl Shining for SentOut<'_> {
    fn exitance(&self, piece: &Piece) -> DVec3 {
        self.light.exitance[piece.id as usize].as_dvec3()
    }

    fn exitance_at(&self, piece: &Piece, point: DVec3) -> Option<DVec3> {
        if self.light.is_even(piece.id) {
            return None;
        }
        let element = self.forest.element_in(piece, point, |element| self.light.is_even(element));
        Some(self.light.exitance[element as usize].as_dvec3())
    }

    fn halves(&self, piece: &Piece) -> [Piece; 2] {
        if self.forest.second[piece.id as usize] == 0 { cut(piece) } else { piece.halves(self.forest) }
    }
}

/// The halves of a piece that is one element, whose parts are none.
fn cut(piece: &Piece) -> [Piece; 2] {
    piece.polygon.bisect().map(|polygon| piece.part(polygon))
}

/// A surface that shines, or a part of one. Small, and its outline apart: most sources of a point bring it so little that
/// all that is asked is how little.
#[derive(Clone)]
pub(super) struct Source {
    shape: SourceShape,
    /// W/m².
    pub(super) exitance: DVec3,
    pub(super) piece: Rc<Piece>,
    /// Most of it is probably in view.
    is_mostly_seen: bool,
}

impl Source {
    pub(super) fn new(piece: Piece, is_mostly_seen: bool, shining: &impl Shining) -> Source {
        let shape = SourceShape::of(&piece.polygon, piece.plane);
        Source { shape, exitance: shining.exitance(&piece), piece: Rc::new(piece), is_mostly_seen }
    }

    /// What it brings to a point when nothing is in between.
    pub(super) fn irradiance(&self, at: Spotlit) -> DVec3 {
        self.exitance * self.shape.form_factor(&self.piece.polygon, at.point, at.normal)
    }

    /// Its two parts.
    pub(super) fn halves(&self, shining: &impl Shining) -> [Source; 2] {
        shining.halves(&self.piece).map(|half| Source::new(half, self.is_mostly_seen, shining))
    }

    /// Hands over itself, or its parts, so that none brings more than `share` to a point, sum of the channels; parts
    /// that bring nothing are left out.
    pub(super) fn cut(self, share: f64, shining: &impl Shining, at: Spotlit, take: &mut impl FnMut(Source)) {
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
    ///
    /// What is bright of a source is seen more often than what is dark, so how bright it is counts where a ray decides:
    /// of one that is mostly seen, what is hidden is taken away; of another, what is seen is added.
    pub(super) fn add(&mut self, source: &Source, irradiance: DVec3, shining: &impl Shining) {
        let chance = (4.0 * irradiance.element_sum() / self.share).min(1.0);
        self.due += chance;
        if chance < 1.0 && self.due < 1.0 {
            return;
        }
        self.due -= 1.0;
        let polygon = &source.piece.polygon;
        let is_above = polygon.vertices().iter().all(|&vertex| self.horizon.distance(vertex) >= 0.0);
        let point = if is_above {
            self.point_of(polygon, source)
        } else {
            let Some(above) = polygon.clipped(&self.horizon) else { return };
            self.point_of(&above, source)
        };
        let irradiance = irradiance / chance;
        let relative = shining.exitance_at(&source.piece, point).map_or(DVec3::ONE, |exitance| {
            (exitance / source.exitance.max(DVec3::splat(f64::MIN_POSITIVE))).min(DVec3::splat(BRIGHTEST))
        });
        let if_seen = if source.is_mostly_seen { irradiance } else { irradiance * relative };
        self.rays.cast(point, source.piece.side.facet, [if_seen, if_seen - irradiance * relative]);
    }

    /// A point of a polygon, with about the probability by which points of it count.
    fn point_of(&mut self, polygon: &Polygon, source: &Source) -> DVec3 {
        let at = self.rays.at;
        let mut next = || {
            // One point after the other would lie in the same halves of all parts that are the first of two.
            let numbers = self.sequence.point(hash_pair(self.index, 0) as u32);
            self.index += 1;
            numbers
        };
        let [u, v, choice, _] = next();
        let sampler = polygon.sampler();
        let first = sampler.point_at(u, v);
        if !source.shape.looks_larger(LARGE, at.point) {
            return first;
        }
        let candidates: [DVec3; CANDIDATES as usize] = std::array::from_fn(|i| {
            if i == 0 {
                return first;
            }
            let [u, v, ..] = next();
            sampler.point_at(u, v)
        });
        // cos θr · cos θs / d², of which the height above the source is the same everywhere.
        let kernel = candidates.map(|to| {
            let way = to - at.point;
            way.dot(at.normal).max(0.0) / way.length_squared().powi(2)
        });
        let mut left = choice * kernel.iter().sum::<f64>();
        let chosen = kernel.iter().position(|kernel| {
            left -= kernel;
            left < 0.0
        });
        candidates[chosen.unwrap_or(0)]
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
    /// What arrives if the ray is clear, and if it is not.
    carried: Vec<[DVec3; 2]>,
    arrived: DVec3,
}

impl Rays<'_> {
    fn cast(&mut self, to: DVec3, facet: u32, irradiance: [DVec3; 2]) {
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
        for (blocker, [if_clear, if_blocked]) in blockers.iter().zip(&self.carried) {
            self.arrived += if *blocker == NO_FACET { *if_clear } else { *if_blocked };
        }
        self.segments.clear();
        self.carried.clear();
    }
}
