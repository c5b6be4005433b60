//! The tracer in Rust alone, for machines without Embree and as a second opinion: a binary tree (`obvhs`)
//! with the triangle test of this room. Segments of a packet walk the tree together, in SIMD lanes.

use super::lanes::{LEAST_DIRECTION, Lanes};
use super::triangle::Probe;
use super::{Candidates, FilterAudit, Hit, NO_FACET, PACKET, Ray, Segment, TraceMesh, Tracer};
use crate::math::Aabb;
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use std::time::Duration;

/// Boxes are grown by this much, local units: a few roundings of the box test.
const BOX_MARGIN: f32 = 1e-6;

/// A step down the tree costs about as much as the test of a triangle.
const BUILD: BvhBuildParams =
    BvhBuildParams { collapse_traversal_cost: 1.0, ..BvhBuildParams::medium_build() };

/// Lanes for a packet with no more segments.
const FEW: usize = 4;

/// Traces through a tree of boxes.
pub struct FallbackTracer {
    tree: Bvh2,
    /// In the order of the leaves of the tree.
    leaves: Vec<Leaf>,
    /// How far the scene reaches out along the axes.
    extent: f32,
    processor: pulp::Arch,
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
        let tree = build_bvh2(&boxes, BUILD, &mut Duration::default());
        let leaf = |&triangle: &u32| Leaf {
            corners: mesh.corners(triangle),
            triangle,
            facet: mesh.facet_of_triangle[triangle as usize],
        };
        let leaves = tree.primitive_indices.iter().map(leaf).collect();
        let extent = boxes.iter().map(|b| b.0.min.abs().max(b.0.max.abs()).max_element()).fold(0.0, f32::max);
        FallbackTracer { tree, leaves, extent, processor: pulp::Arch::new() }
    }

    /// A ray as the tree takes it.
    fn tree_ray(ray: &Ray) -> obvhs::ray::Ray {
        let direction = ray.direction.to_array().map(|x| if x.abs() < LEAST_DIRECTION { 0.0 } else { x });
        let inverse = direction.map(|x: f32| if x == 0.0 { 1.0 / LEAST_DIRECTION } else { 1.0 / x });
        obvhs::ray::Ray {
            origin: Vec3A::from(ray.origin),
            direction: Vec3A::from(direction),
            inv_direction: Vec3A::from(inverse),
            tmin: 0.0,
            tmax: f32::MAX,
        }
    }
}

/// One packet on its way through the tree, see [`Tracer::blockers`].
struct Walk<'a, const N: usize> {
    tracer: &'a FallbackTracer,
    segments: &'a [Segment],
    candidates: Candidates<'a>,
    blockers: &'a mut [u32],
    audit: &'a mut FilterAudit,
}

/// Compiled for each kind of processor; what it does for all lanes has to be inlined for that, which closures may
/// not be.
impl<const N: usize> pulp::NullaryFnOnce for Walk<'_, N> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Walk {
            tracer: FallbackTracer { tree, leaves, extent, .. },
            segments,
            candidates,
            blockers,
            audit,
        } = self;
        let mut lanes = Lanes::<N>::new(segments, *extent);
        let mut open = segments.len();
        let along: Vec3 = segments.iter().map(|segment| segment.to - segment.from).sum();
        let mut stack = Vec::with_capacity(64);
        stack.push(0usize);
        while let Some(index) = stack.pop() {
            let node = &tree.nodes[index];
            if !node.is_leaf() {
                let first = node.first_index as usize;
                let (one, other) = (tree.nodes[first].aabb(), tree.nodes[first + 1].aabb());
                let enters_one = lanes.enter(one.min.into(), one.max.into());
                let enters_other = lanes.enter(other.min.into(), other.max.into());
                // The nearer one on top.
                let is_one_nearer = along.dot((other.min + other.max - one.min - one.max).into()) > 0.0;
                if enters_other && is_one_nearer {
                    stack.push(first + 1);
                }
                if enters_one {
                    stack.push(first);
                }
                if enters_other && !is_one_nearer {
                    stack.push(first + 1);
                }
                continue;
            }
            for slot in node.first_index..node.first_index + node.prim_count {
                let leaf = &leaves[slot as usize];
                let [mut met, certain] = lanes.meet(leaf.corners);
                while met != 0 {
                    let lane = met.trailing_zeros() as usize;
                    met &= met - 1;
                    let segment = &segments[lane];
                    // Most segments begin and end on facets that they skip: no need to look closer.
                    if !segment.skip.contains(&leaf.facet)
                        && (certain >> lane & 1 == 1 || is_blocked_by(segment, leaf))
                        && audit.accepts(leaf.facet, segment.skip, &candidates)
                    {
                        blockers[lane] = leaf.facet;
                        lanes.close(lane);
                        open -= 1;
                    }
                }
                if open == 0 {
                    return;
                }
            }
        }
    }
}

/// Whether a triangle is on the open part of a segment.
fn is_blocked_by(segment: &Segment, leaf: &Leaf) -> bool {
    let [near, far] = segment.open_part().map(f64::from);
    let hit = Probe::new(segment.from, segment.to - segment.from).meet(&leaf.corners);
    hit.is_some_and(|t| t > near && t < far)
}

impl Tracer for FallbackTracer {
    fn name(&self) -> &'static str {
        "fallback"
    }

    fn bytes(&self) -> u64 {
        let FallbackTracer { tree, leaves, .. } = self;
        let tree = size_of_val(&tree.nodes[..]) + size_of_val(&tree.primitive_indices[..]);
        (tree + size_of_val(&leaves[..])) as u64
    }

    fn blockers(
        &self,
        segments: &[Segment],
        candidates: Candidates<'_>,
        blockers: &mut [u32],
        audit: &mut FilterAudit,
    ) {
        debug_assert!(segments.len() <= PACKET && segments.len() == blockers.len());
        blockers.fill(NO_FACET);
        if segments.len() <= FEW {
            self.processor.dispatch(Walk::<FEW> { tracer: self, segments, candidates, blockers, audit });
        } else {
            self.processor.dispatch(Walk::<PACKET> { tracer: self, segments, candidates, blockers, audit });
        }
    }

    fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            let probe = Probe::new(ray.origin, ray.direction);
            let mut record = obvhs::ray::RayHit::none();
            *hit = None;
            self.tree.ray_traverse(FallbackTracer::tree_ray(ray), &mut record, |current, slot| {
                let &Leaf { corners, triangle, facet } = &self.leaves[slot];
                match probe.meet(&corners) {
                    Some(t) if t > 0.0 && (t as f32) < current.tmax => {
                        *hit = Some(Hit { facet, triangle, t: t as f32 });
                        t as f32
                    }
                    _ => f32::INFINITY,
                }
            });
        }
    }
}
