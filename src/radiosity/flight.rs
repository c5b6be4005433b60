//! Where the light of a solution goes, found with rays: independent of links, so that the energy balance
//! tests them.

use super::forest::{Forest, Way};
use super::transport::Light;
use crate::hierarchy::Hierarchy;
use crate::math::{PairSequence, cosine_direction};
use crate::tracer::{Departure, PACKET, Ray, Tracer, departing_hits};
use glam::Vec3;
use rayon::prelude::*;

/// Rays, each standing for the same power: the answer is good to about a quarter of a per cent.
pub(super) const RAYS: u32 = 1 << 17;

/// Light caught in a narrow gap makes no room smaller than this share of the smaller facet at its ends.
const LEAST_WALL: f64 = 0.04;

/// Cells as wide as a wall that the light of one room falls in, at most about.
const CELLS: f64 = 20.0;

/// Where light goes after it leaves a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    /// Power (sum over channels, local areas) of the light that meets no surface.
    pub(super) escaped: f64,
    /// Power (likewise) of the light that ends on the backs of one-sided surfaces.
    pub(super) on_backs: f64,
    /// Mean square distance the other light flies, local units: about the area of a wall of the rooms it
    /// fills, but no less than a share of the facets it flies between. 1 when there is no such light.
    pub(super) wall_area: f64,
    /// How many such rooms it fills, about; at least 1.
    pub(super) rooms: f64,
}

/// Follows the light one step.
pub(super) fn flight(hierarchy: &Hierarchy, forest: &Forest, light: &Light, tracer: &dyn Tracer) -> Flight {
    let leaves: Vec<u32> = forest.leaves().map(|e| e as u32).collect();
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
        return Flight { escaped: 0.0, on_backs: 0.0, wall_area: 1.0, rooms: 1.0 };
    }
    let sequence = PairSequence::new(1);
    let landings: Vec<Landing> = (0..RAYS / PACKET as u32)
        .into_par_iter()
        .with_min_len(64)
        .map_init(
            || Way::new(hierarchy, forest),
            |way, packet| {
                std::array::from_fn(|i| {
                    let index = packet * PACKET as u32 + i as u32;
                    let [u, v, s, t] = sequence.point(index);
                    let at = (index as f64 + 0.5) / RAYS as f64 * total;
                    let element = leaves[sums.partition_point(|&sum| sum <= at).min(leaves.len() - 1)];
                    let piece = way.to(element);
                    let normal = piece.plane.normal;
                    let (point, direction) = (piece.polygon.point_at(u, v), cosine_direction(normal, s, t));
                    Departure { point, normal, facet: piece.side.facet, direction }
                })
            },
        )
        .flat_map_iter(|departures: [Departure; PACKET]| {
            let mut rays = [Ray { origin: Vec3::ZERO, direction: Vec3::Z }; PACKET];
            let mut hits = [None; PACKET];
            departing_hits(tracer, &departures, &mut rays, &mut hits);
            (0..PACKET).filter_map(move |i| {
                let (ray, hit) = (&rays[i], hits[i]?);
                let side = hierarchy.side_met(hit.facet, ray.direction);
                let areas = [departures[i].facet, hit.facet].map(|facet| hierarchy.polygon(facet).area());
                Some(Landing {
                    point: ray.origin + ray.direction * hit.t,
                    square: (hit.t as f64).powi(2),
                    least: LEAST_WALL * areas[0].min(areas[1]),
                    on_back: forest.side_index(side).is_none(),
                })
            })
        })
        .collect();
    let power = total / RAYS as f64;
    let sum = |value: fn(&Landing) -> f64| landings.iter().map(value).sum::<f64>();
    let wall_area = if landings.is_empty() {
        1.0
    } else {
        rounded(sum(|landing| landing.square).max(sum(|landing| landing.least)) / landings.len() as f64)
    };
    Flight {
        escaped: power * (RAYS as usize - landings.len()) as f64,
        on_backs: power * sum(|landing| f64::from(landing.on_back)),
        wall_area,
        rooms: rooms(&landings, wall_area.sqrt() as f32),
    }
}

/// Where a ray ended.
#[derive(Clone, Copy, Debug)]
struct Landing {
    point: Vec3,
    /// Squared distance it flew.
    square: f64,
    /// The least wall area between the facets at its ends.
    least: f64,
    /// On the back of a one-sided surface.
    on_back: bool,
}

/// Rooms with walls of this length that the light falls in: from the number of cells of a grid that would
/// share it if all had the same.
fn rooms(landings: &[Landing], wall: f32) -> f64 {
    let mut cells: Vec<_> =
        landings.iter().map(|landing| (landing.point / wall).floor().as_ivec3().to_array()).collect();
    cells.sort_unstable();
    let squares: f64 = cells.chunk_by(|a, b| a == b).map(|cell| (cell.len() as f64).powi(2)).sum();
    let shared = (cells.len() as f64).powi(2) / squares.max(1.0);
    rounded((shared / CELLS).max(1.0))
}

/// To the nearest quarter of a power of two, so that two tracers that round differently refine alike.
fn rounded(x: f64) -> f64 {
    ((4.0 * x.log2()).round() / 4.0).exp2()
}
