//! Light at visible points, gathered anew over the links of the elements and clusters they lie in: crisp where
//! interpolation blurs.
//!
//! The sides that most surfaces get their light from are gathered from, at every point the same ones, so that no seam
//! shows where elements meet: exactly and without rays over links that are proved visible, with rays over all others.
//! The rest is interpolated. Points on one element, and on neighbouring ones, share the work of finding their links.

use super::levels::Levels;
use super::reconstruct::Reconstruction;
use super::sources::gathered_light;
use crate::hierarchy::{Hierarchy, Side};
use crate::progress::Progress;
use crate::radiosity::{Light, Piece, Solution};
use crate::tracer::Tracer;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::borrow::Cow;

/// A side is gathered from if it lights so many walls, or what adds up to them.
const LEAST_LIT: f64 = 0.005;

/// Likewise of a side that emits: it may be one of very many of a lamp.
const LEAST_LIT_BY_LAMP: f64 = 0.001;

/// How often the sources are gathered at themselves: light that has been reflected so often is as a gather finds it.
const PASSES: u32 = 2;

/// Rays for a point of a source, at least: what they get wrong is in all that the source lights.
const RAYS_OF_SOURCES: u32 = 256;

/// Points handed to a thread at a time.
const RUN: usize = 256;

/// A visible point on a side.
#[derive(Clone, Copy, Debug)]
pub struct VisiblePoint {
    /// The side.
    pub side: Side,
    /// The point, local coordinates.
    pub point: DVec3,
    /// The leaf element it lies on: [`FinalGather::element_at`].
    pub element: u32,
    /// Chooses the rays.
    pub seed: u64,
}

/// Gathers light at visible points.
pub struct FinalGather<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) solution: &'a Solution,
    pub(super) tracer: &'a dyn Tracer,
    /// What sides send out that are gathered from.
    pub(super) light: Light,
    /// What comes from all other sides.
    pub(super) rest: Reconstruction<'a>,
    /// The sides that are gathered from: their numbers, in order.
    pub(super) sources: Vec<usize>,
    /// Those of them that emit.
    pub(super) lamps: Vec<Piece>,
    /// What is known of each side.
    pub(super) roles: Vec<Role>,
    pub(super) rays: u32,
}

/// What a side is to the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Its light is interpolated.
    Interpolated,
    /// It is gathered from, over links.
    Source,
    /// It emits, and is gathered from whether there are links or not: its number among the lamps.
    Lamp(u32),
}

impl<'a> FinalGather<'a> {
    /// Gathers with about `rays` rays for a point at which no light is proved to arrive.
    pub fn new(
        hierarchy: &'a Hierarchy,
        tracer: &'a dyn Tracer,
        solution: &'a Solution,
        rays: u32,
        progress: &dyn Progress,
    ) -> FinalGather<'a> {
        progress.start("sources", 0);
        let forest = &solution.forest;
        let walls_lit = solution.walls_lit(hierarchy, tracer);
        let (mut sources, mut lamps) = (Vec::new(), Vec::new());
        let mut roles = vec![Role::Interpolated; forest.side_count()];
        for (side, &lit) in walls_lit.iter().enumerate() {
            let emits = hierarchy.emitted(forest.side(side)) != Vec3::ZERO;
            if lit < if emits { LEAST_LIT_BY_LAMP } else { LEAST_LIT } {
                continue;
            }
            roles[side] = Role::Source;
            if emits {
                roles[side] = Role::Lamp(lamps.len() as u32);
                lamps.push(forest.root(hierarchy, side));
            }
            sources.push(side);
        }
        let is_left_out: Vec<bool> = roles.iter().map(|&role| role != Role::Interpolated).collect();
        let rest = solution.irradiance_without(hierarchy, &is_left_out);
        let rest = Reconstruction::of(hierarchy, forest, Cow::Owned(rest));
        let light = solution.light.clone();
        let rays_of_picture = rays;
        let rays = rays.max(RAYS_OF_SOURCES);
        let mut gather =
            FinalGather { hierarchy, solution, tracer, light, rest, sources, lamps, roles, rays };
        for _ in 0..PASSES {
            gather.light = gathered_light(&gather);
        }
        gather.rays = rays_of_picture;
        progress.finish();
        gather
    }

    /// The leaf element at a point on a side; `None` for a side that takes no part.
    pub fn element_at(&self, side: Side, point: DVec3) -> Option<u32> {
        Some(self.solution.forest.leaf_at(self.hierarchy, side, point)?.id)
    }

    /// Irradiance at points, W/m². Quick when points on one element, and on neighbouring ones, follow each other.
    pub fn irradiance(&self, points: &[VisiblePoint]) -> Vec<Vec3> {
        let runs: Vec<Vec<Vec3>> = points
            .par_chunks(RUN)
            .map(|run| {
                let mut levels = Levels::new(self);
                run.iter().map(|point| levels.irradiance(point)).collect()
            })
            .collect();
        runs.concat()
    }
}
