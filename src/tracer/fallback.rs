//! The tracer in Rust alone, for machines without Embree and as a second opinion: an eight-wide
//! compressed tree (`obvhs`) with the triangle test of this room.

use super::triangle::Probe;
use super::{Candidates, ENDPOINT_EPSILON, FilterAudit, Hit, NO_FACET, Ray, Segment, TraceMesh, Tracer};
use crate::math::Aabb;
use glam::Vec3A;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use std::time::Duration;

/// Boxes are grown by this much, local units: a few roundings of the box test.
const BOX_MARGIN: f32 = 1e-6;

/// Traces through an eight-wide tree of boxes.
pub struct FallbackTracer {
    tree: CwBvh,
    mesh: TraceMesh,
}

struct Bounded(Aabb);

impl obvhs::Boundable for Bounded {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        let margin = glam::Vec3::splat(BOX_MARGIN);
        obvhs::aabb::Aabb::new((self.0.min - margin).into(), (self.0.max + margin).into())
    }
}

impl FallbackTracer {
    /// Builds the tree over `mesh`.
    pub fn new(mesh: &TraceMesh) -> FallbackTracer {
        let boxes: Vec<Bounded> = mesh
            .triangles
            .iter()
            .map(|t| Bounded(Aabb::around(t.iter().map(|&v| mesh.positions[v as usize]))))
            .collect();
        let tree = build_cwbvh(&boxes, obvhs::BvhBuildParams::medium_build(), &mut Duration::default());
        FallbackTracer { tree, mesh: mesh.clone() }
    }

    /// The tree works with unit directions; distances are scaled back with the returned length.
    fn unit_ray(origin: glam::Vec3, direction: glam::Vec3, near: f32, far: f32) -> (obvhs::ray::Ray, f32) {
        let length = direction.length().max(f32::MIN_POSITIVE);
        let ray = obvhs::ray::Ray::new(
            Vec3A::from(origin),
            Vec3A::from(direction / length),
            near * length,
            far * length,
        );
        (ray, length)
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
        let (near, far) = (ENDPOINT_EPSILON as f64, 1.0 - ENDPOINT_EPSILON as f64);
        for (segment, blocker) in segments.iter().zip(blockers) {
            let direction = segment.to - segment.from;
            let probe = Probe::new(segment.from, direction);
            let (ray, _) = FallbackTracer::unit_ray(segment.from, direction, 0.0, 1.0);
            *blocker = NO_FACET;
            self.tree.ray_traverse_miss(ray, |_, slot| {
                let triangle = self.tree.primitive_indices[slot];
                match probe.meet(&self.mesh, triangle) {
                    Some(t) if t > near && t < far => {
                        let facet = self.mesh.facet_of_triangle[triangle as usize];
                        if audit.accepts(facet, segment.skip, &candidates) {
                            *blocker = facet;
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
            let (unit, length) = FallbackTracer::unit_ray(ray.origin, ray.direction, 0.0, f32::MAX);
            let mut record = obvhs::ray::RayHit::none();
            *hit = None;
            self.tree.ray_traverse(unit, &mut record, |current, slot| {
                let triangle = self.tree.primitive_indices[slot];
                match probe.meet(&self.mesh, triangle) {
                    Some(t) if t > 0.0 && (t as f32) * length < current.tmax => {
                        let facet = self.mesh.facet_of_triangle[triangle as usize];
                        *hit = Some(Hit { facet, triangle, t: t as f32 });
                        t as f32 * length
                    }
                    _ => f32::INFINITY,
                }
            });
        }
    }
}
