//! The tracer in Rust alone, for machines without Embree and as a second opinion: an eight-wide
//! compressed tree (`obvhs`) with the triangle test of this room.

use super::triangle::Probe;
use super::{Candidates, FilterAudit, Hit, NO_FACET, Ray, Segment, TraceMesh, Tracer};
use crate::math::Aabb;
use glam::{Vec3, Vec3A};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use std::time::Duration;

/// Boxes are grown by this much, local units: a few roundings of the box test.
const BOX_MARGIN: f32 = 1e-6;

/// See [`FallbackTracer::tree_ray`].
const STRETCH: f32 = 1024.0;

/// What is less in a direction, after it is stretched, counts as 0.
const LEAST_DIRECTION: f32 = 1e-18;

/// Traces through an eight-wide tree of boxes.
pub struct FallbackTracer {
    tree: CwBvh,
    /// In the order of the leaves of the tree.
    leaves: Vec<Leaf>,
}

/// A triangle with all that a query needs of it.
struct Leaf {
    corners: [Vec3; 3],
    triangle: u32,
    facet: u32,
}

struct Bounded(Aabb);

impl obvhs::Boundable for Bounded {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        let margin = Vec3::splat(BOX_MARGIN);
        obvhs::aabb::Aabb::new((self.0.min - margin).into(), (self.0.max + margin).into())
    }
}

impl FallbackTracer {
    /// Builds the tree over `mesh`.
    pub fn new(mesh: &TraceMesh) -> FallbackTracer {
        let count = mesh.triangles.len() as u32;
        let boxes: Vec<Bounded> =
            (0..count).map(|triangle| Bounded(Aabb::around(mesh.corners(triangle)))).collect();
        let tree = build_cwbvh(&boxes, obvhs::BvhBuildParams::medium_build(), &mut Duration::default());
        let leaf = |&triangle: &u32| Leaf {
            corners: mesh.corners(triangle),
            triangle,
            facet: mesh.facet_of_triangle[triangle as usize],
        };
        let leaves = tree.primitive_indices.iter().map(leaf).collect();
        FallbackTracer { tree, leaves }
    }

    /// A ray as the tree takes it. Distances are in units of `direction / STRETCH`.
    ///
    /// The tree passes over boxes it leaves before 1e-4, so distances are stretched to make that
    /// nothing; and it takes the order of planes from the signs of the direction, which have to be those
    /// of its inverse, so what is as good as 0 is exactly that.
    fn tree_ray(origin: Vec3, direction: Vec3, far: f32) -> obvhs::ray::Ray {
        let direction =
            (direction / STRETCH).to_array().map(|x| if x.abs() < LEAST_DIRECTION { 0.0 } else { x });
        let inverse = direction.map(|x: f32| if x == 0.0 { 1.0 / LEAST_DIRECTION } else { 1.0 / x });
        obvhs::ray::Ray {
            origin: Vec3A::from(origin),
            direction: Vec3A::from(direction),
            inv_direction: Vec3A::from(inverse),
            tmin: 0.0,
            tmax: far * STRETCH,
        }
    }
}

impl Tracer for FallbackTracer {
    fn name(&self) -> &'static str {
        "fallback"
    }

    fn blockers(
        &self,
        segments: &[Segment],
        candidates: Candidates<'_>,
        blockers: &mut [u32],
        audit: &mut FilterAudit,
    ) {
        debug_assert!(segments.len() <= super::PACKET && segments.len() == blockers.len());
        for (segment, blocker) in segments.iter().zip(blockers) {
            let [near, far] = segment.open_part().map(f64::from);
            let direction = segment.to - segment.from;
            let probe = Probe::new(segment.from, direction);
            let ray = FallbackTracer::tree_ray(segment.from, direction, 1.0);
            *blocker = NO_FACET;
            self.tree.ray_traverse_miss(ray, |_, slot| {
                let leaf = &self.leaves[slot];
                match probe.meet(&leaf.corners) {
                    Some(t) if t > near && t < far => {
                        if audit.accepts(leaf.facet, segment.skip, &candidates) {
                            *blocker = leaf.facet;
                            return f32::NEG_INFINITY;
                        }
                        f32::INFINITY
                    }
                    _ => f32::INFINITY,
                }
            });
        }
    }

    fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            let probe = Probe::new(ray.origin, ray.direction);
            let stretched = FallbackTracer::tree_ray(ray.origin, ray.direction, 1e30);
            let mut record = obvhs::ray::RayHit::none();
            *hit = None;
            self.tree.ray_traverse(stretched, &mut record, |current, slot| {
                let &Leaf { corners, triangle, facet } = &self.leaves[slot];
                match probe.meet(&corners) {
                    Some(t) if t > 0.0 && t as f32 * STRETCH < current.tmax => {
                        *hit = Some(Hit { facet, triangle, t: t as f32 });
                        t as f32 * STRETCH
                    }
                    _ => f32::INFINITY,
                }
            });
        }
    }
}
