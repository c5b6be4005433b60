//! The power that leaves the scene, found with rays: independent of links, so that the energy balance
//! tests them.

use super::forest::Forest;
use super::transport::Light;
use crate::hierarchy::Hierarchy;
use crate::math::PairSequence;
use crate::tracer::{PACKET, Ray, Tracer};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Rays, each standing for the same power: the answer is good to about a quarter of a per cent.
const RAYS: u32 = 1 << 17;

/// How far above its surface a ray starts, local units.
const LIFT: f64 = 1e-5;

/// Power (sum over channels, local areas) of the light that meets no surface after leaving one.
pub(super) fn escaped_power(
    hierarchy: &Hierarchy,
    forest: &Forest,
    light: &Light,
    tracer: &dyn Tracer,
) -> f64 {
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
        return 0.0;
    }
    let sequence = PairSequence::new(1);
    let missed: u64 = (0..RAYS / PACKET as u32)
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
            hits.iter().filter(|hit| hit.is_none()).count() as u64
        })
        .sum();
    total * missed as f64 / RAYS as f64
}

/// A direction about `normal` with probability proportional to its cosine.
fn cosine_direction(normal: DVec3, s: f64, t: f64) -> Vec3 {
    let (x, y) = normal.any_orthonormal_pair();
    let (sin, cos) = (s * TAU).sin_cos();
    let radius = t.sqrt();
    (x * (radius * cos) + y * (radius * sin) + normal * (1.0 - t).sqrt()).as_vec3()
}
