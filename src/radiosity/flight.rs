//! Where the light of a solution goes, found with rays: independent of links, so that the energy balance
//! tests them.

use super::forest::{Forest, Way};
use super::transport::Light;
use crate::hierarchy::Hierarchy;
use crate::math::{PairSequence, cosine_direction};
use crate::tracer::{Departure, PACKET, Ray, Tracer, departing_hits};
use glam::Vec3;
use rayon::prelude::*;

/// Rays of a first look, each standing for the same power: rooms are measured with them.
const FEW: u32 = 1 << 12;

/// Where half of the light escapes or more, so many rays find how much to about a seventh of a per cent; where less
/// does, fewer rays find it as well.
const MOST: u32 = 1 << 17;

/// So many rays that meet a surface tell how large the rooms are.
const ENOUGH: usize = 256;

/// Light caught in a narrow gap makes no room smaller than this share of the smaller facet at its ends.
const LEAST_WALL: f64 = 0.04;

/// Cells as wide as a wall that the light of one room falls in, at most about.
const CELLS: f64 = 20.0;

/// Where light goes after it leaves a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    /// Share of the light that meets no surface.
    pub(super) escaped: f64,
    /// Share of the light that ends on the backs of one-sided surfaces.
    pub(super) on_backs: f64,
    /// Rays that found it.
    pub(super) rays: u32,
}

/// The rooms that the light of a scene fills.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rooms {
    /// Mean square distance that light flies which meets a surface, local units: about the area of a wall of the
    /// rooms, but no less than a share of the facets it flies between. 1 when there is no such light.
    pub(super) wall_area: f64,
    /// How many such rooms there are, about; at least 1.
    pub(super) count: f64,
}

/// Follows the light one step.
pub(super) fn flight(hierarchy: &Hierarchy, forest: &Forest, light: &Light, tracer: &dyn Tracer) -> Flight {
    let senders = Senders::new(forest, light);
    let followed = |rays: u32| {
        let landings = senders.followed(hierarchy, forest, tracer, rays);
        let share = |count: usize| count as f64 / f64::from(rays);
        let on_backs = landings.iter().filter(|landing| landing.on_back).count();
        Flight { escaped: share(rays as usize - landings.len()), on_backs: share(on_backs), rays }
    };
    if senders.total <= 0.0 {
        return Flight { escaped: 0.0, on_backs: 0.0, rays: 0 };
    }
    let first = followed(FEW);
    let gone = first.escaped + first.on_backs;
    // As exact as the most rays are about one half, and what lands in proportion to itself, too.
    let share = (4.0 * gone * (1.0 - gone)).max(gone / (1.0 - gone));
    let wanted = (share.min(1.0) * f64::from(MOST)) as u32;
    if wanted > FEW { followed(wanted.next_multiple_of(PACKET as u32)) } else { first }
}

/// Measures the rooms that the light fills.
pub(super) fn rooms(hierarchy: &Hierarchy, forest: &Forest, light: &Light, tracer: &dyn Tracer) -> Rooms {
    let senders = Senders::new(forest, light);
    let mut landings = senders.followed(hierarchy, forest, tracer, FEW);
    if landings.len() < ENOUGH {
        landings = senders.followed(hierarchy, forest, tracer, MOST);
    }
    if landings.is_empty() {
        return Rooms { wall_area: 1.0, count: 1.0 };
    }
    let sum = |value: fn(&Landing) -> f64| landings.iter().map(value).sum::<f64>();
    let squares = sum(|landing| landing.square).max(sum(|landing| landing.least));
    let wall_area = rounded(squares / landings.len() as f64);
    Rooms { wall_area, count: rooms_of_walls(&landings, wall_area.sqrt() as f32) }
}

/// The leaf elements with the power they send out.
struct Senders {
    leaves: Vec<u32>,
    /// Power of each and those before it, summed over channels, local areas.
    sums: Vec<f64>,
    /// Power of all.
    total: f64,
}

impl Senders {
    fn new(forest: &Forest, light: &Light) -> Senders {
        let leaves: Vec<u32> = forest.leaves().map(|e| e as u32).collect();
        let mut total = 0.0;
        let power = |e: u32| (light.exitance[e as usize].element_sum() * forest.area[e as usize]) as f64;
        let add = |&e: &u32| {
            total += power(e);
            total
        };
        let sums = leaves.iter().map(add).collect();
        Senders { leaves, sums, total }
    }

    /// Where so many rays end, each with an equal share of the power. Nowhere if all is dark.
    fn followed(
        &self,
        hierarchy: &Hierarchy,
        forest: &Forest,
        tracer: &dyn Tracer,
        rays: u32,
    ) -> Vec<Landing> {
        if self.total <= 0.0 {
            return Vec::new();
        }
        let sequence = PairSequence::new(1);
        let departure = |way: &mut Way<'_>, index: u32| {
            let [u, v, s, t] = sequence.point(index);
            let at = (index as f64 + 0.5) / f64::from(rays) * self.total;
            let sender = self.sums.partition_point(|&sum| sum <= at).min(self.leaves.len() - 1);
            let piece = way.to(self.leaves[sender]);
            let normal = piece.plane.normal;
            let (point, direction) = (piece.polygon.point_at(u, v), cosine_direction(normal, s, t));
            Departure { point, normal, facet: piece.side.facet, direction }
        };
        let packet = |way: &mut Way<'_>, packet: u32| -> [Departure; PACKET] {
            std::array::from_fn(|i| departure(way, packet * PACKET as u32 + i as u32))
        };
        (0..rays / PACKET as u32)
            .into_par_iter()
            .with_min_len(64)
            .map_init(|| Way::new(hierarchy, forest), packet)
            .flat_map_iter(|departures| {
                let mut rays = [Ray { origin: Vec3::ZERO, direction: Vec3::Z }; PACKET];
                let mut hits = [None; PACKET];
                departing_hits(tracer, &departures, &mut rays, &mut hits);
                (0..PACKET).filter_map(move |i| {
                    let (ray, hit) = (&rays[i], hits[i]?);
                    let side = hierarchy.side_met(hit.facet, ray.direction);
                    let area = |facet| f64::from(hierarchy.nodes[hierarchy.leaf(facet) as usize].area);
                    Some(Landing {
                        point: ray.origin + ray.direction * hit.t,
                        square: (hit.t as f64).powi(2),
                        least: LEAST_WALL * area(departures[i].facet).min(area(hit.facet)),
                        on_back: forest.side_index(side).is_none(),
                    })
                })
            })
            .collect()
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
fn rooms_of_walls(landings: &[Landing], wall: f32) -> f64 {
    let mut cells: Vec<_> =
        landings.iter().map(|landing| (landing.point / wall).floor().as_ivec3().to_array()).collect();
    cells.sort_unstable();
    // Pairs of rays in one cell, of all pairs.
    let pairs = |count: usize| count as f64 * (count as f64 - 1.0);
    let shared: f64 = cells.chunk_by(|a, b| a == b).map(|cell| pairs(cell.len())).sum();
    rounded((pairs(cells.len()) / shared.max(1.0) / CELLS).max(1.0))
}

/// To the nearest quarter of a power of two, so that two tracers that round differently refine alike.
fn rounded(x: f64) -> f64 {
    ((4.0 * x.log2()).round() / 4.0).exp2()
}
