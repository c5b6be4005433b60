//! Where the light of a solution goes, found with rays: independent of links, so that the energy balance
//! tests them.

use super::forest::Forest;
use super::transport::Light;
use crate::hierarchy::{Hierarchy, Side};
use crate::math::PairSequence;
use crate::tracer::{PACKET, Ray, Tracer};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Rays, each standing for the same power: the answer is good to about a quarter of a per cent.
const RAYS: u32 = 1 << 17;

/// Light caught in a narrow gap makes no room smaller than this share of the facets it falls on.
const LEAST_WALL: f64 = 0.01;

/// How far above its surface a ray starts, local units.
const LIFT: f64 = 1e-5;

/// Where light goes after it leaves a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    /// Power (sum over channels, local areas) of the light that meets no surface.
    pub(super) escaped: f64,
    /// Power (likewise) of the light that ends on the backs of one-sided surfaces.
    pub(super) on_backs: f64,
    /// Mean square distance the other light flies, local units: about the area of a wall of the rooms it
    /// fills, but no less than a share of the facets it meets. 1 when there is no such light.
    pub(super) wall_area: f64,
}

/// Follows the light one step.
pub(super) fn flight(hierarchy: &Hierarchy, forest: &Forest, light: &Light, tracer: &dyn Tracer) -> Flight {
    let leaves: Vec<u32> = (0..forest.len() as u32).filter(|&e| forest.second[e as usize] == 0).collect();
    let power_of = |e: u32| {
        let b = light.exitance[e as usize];
        (b.x + b.y + b.z) as f64 * forest.area[e as usize] as f64
    };
    let mut total = 0.0;
    let sums: Vec<f64> = leaves
        .iter()
        .map(|&e| {
            total += power_of(e);
            total
        })
        .collect();
    if total <= 0.0 {
        return Flight { escaped: 0.0, on_backs: 0.0, wall_area: 1.0 };
    }
    let sequence = PairSequence::new(1);
    let packets: Vec<Ended> = (0..RAYS / PACKET as u32)
        .into_par_iter()
        .map(|packet| {
            let rays: [Ray; PACKET] = std::array::from_fn(|i| {
                let index = packet * PACKET as u32 + i as u32;
                let [u, v, s, t] = sequence.point(index);
                let at = (index as f64 + 0.5) / RAYS as f64 * total;
                let element = leaves[sums.partition_point(|&sum| sum <= at).min(leaves.len() - 1)];
                let piece = forest.piece(hierarchy, element);
                let normal = piece.plane.normal;
                let origin = piece.polygon.point_at(u, v) + normal * LIFT;
                Ray { origin: origin.as_vec3(), direction: cosine_direction(normal, s, t) }
            });
            let mut hits = [None; PACKET];
            tracer.first_hits(&rays, &mut hits);
            let mut ended = Ended::default();
            for (ray, hit) in rays.iter().zip(&hits) {
                let Some(hit) = hit else {
                    ended.missed += 1;
                    continue;
                };
                let normal = hierarchy.facets[hit.facet as usize].plane.normal;
                let back = normal.dot(ray.direction.as_dvec3()) > 0.0;
                ended.on_backs += u32::from(forest.side_index(Side { facet: hit.facet, back }).is_none());
                ended.squares += (hit.t as f64).powi(2);
                ended.areas += hierarchy.polygon(hit.facet).area();
            }
            ended
        })
        .collect();
    let ended = packets.iter().fold(Ended::default(), |sum, packet| Ended {
        missed: sum.missed + packet.missed,
        on_backs: sum.on_backs + packet.on_backs,
        squares: sum.squares + packet.squares,
        areas: sum.areas + packet.areas,
    });
    let power = total / RAYS as f64;
    Flight {
        escaped: power * ended.missed as f64,
        on_backs: power * ended.on_backs as f64,
        wall_area: if ended.missed < RAYS {
            rounded(ended.squares.max(LEAST_WALL * ended.areas) / (RAYS - ended.missed) as f64)
        } else {
            1.0
        },
    }
}

/// Where rays ended.
#[derive(Clone, Copy, Debug, Default)]
struct Ended {
    missed: u32,
    on_backs: u32,
    /// Sum of the squared distances of those that hit.
    squares: f64,
    /// Sum of the areas of the facets they hit.
    areas: f64,
}

/// To the nearest quarter of a power of two, so that two tracers that round differently refine alike.
fn rounded(x: f64) -> f64 {
    ((4.0 * x.log2()).round() / 4.0).exp2()
}

/// A direction about `normal` with probability proportional to its cosine.
fn cosine_direction(normal: DVec3, s: f64, t: f64) -> Vec3 {
    let (x, y) = normal.any_orthonormal_pair();
    let (sin, cos) = (s * TAU).sin_cos();
    let radius = t.sqrt();
    (x * (radius * cos) + y * (radius * sin) + normal * (1.0 - t).sqrt()).as_vec3()
}
