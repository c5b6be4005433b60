//! Where the light of a solution goes, found with rays: independent of links, so that the energy balance
//! tests them.

use super::forest::{Forest, Way};
use super::transport::Light;
use crate::hierarchy::Hierarchy;
use crate::math::{PairSequence, cosine_direction, golden_fraction, hash_pair};
use crate::progress::{Progress, Silent, Work};
use crate::tracer::{Departure, Hit, NO_FACET, PACKET, Ray, Tracer, departing_hits};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

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

/// To be replaced.
const NOWHERE: Departure =
    Departure { point: DVec3::ZERO, normal: DVec3::Z, facet: NO_FACET, direction: Vec3::Z };

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

/// Where light lands.
#[derive(Clone, Debug)]
pub(super) struct Landings {
    /// How much of it does.
    pub(super) flight: Flight,
    /// How many of the rays, by leaf element.
    pub(super) on: Vec<u32>,
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
    let first = senders.flight(hierarchy, forest, tracer, FEW);
    let wanted = first.rays_wanted();
    if wanted > FEW { senders.flight(hierarchy, forest, tracer, wanted) } else { first }
}

/// Follows the light one step to the leaf elements it ends on, with about `rays` rays or more; with none if all is dark.
/// They are others each `time`.
pub(super) fn landings(
    hierarchy: &Hierarchy,
    forest: &Forest,
    light: &Light,
    tracer: &dyn Tracer,
    (rays, time): (u32, u32),
    progress: &dyn Progress,
) -> Landings {
    progress.start("landings", 0);
    let senders = Senders::new(forest, light);
    let first = senders.flight(hierarchy, forest, tracer, FEW);
    let on: Vec<AtomicU32> = (0..forest.len()).map(|_| AtomicU32::new(0)).collect();
    // Sums of whole numbers are the same in any order.
    let add = |count: &AtomicU32| count.fetch_add(1, Ordering::Relaxed);
    let is_on_back = |_: &Departure, ray: &Ray, hit: &Hit| {
        let leaf = forest.leaf_met(hierarchy, ray, hit);
        leaf.map(|leaf| add(&on[leaf.id as usize])).is_none()
    };
    let wanted = rays.max(first.rays_wanted()).max(FEW);
    let (rays, landed) = senders.followed(hierarchy, forest, tracer, (wanted, time), progress, is_on_back);
    progress.finish();
    Landings { flight: Flight::of(&landed, rays), on: on.into_iter().map(AtomicU32::into_inner).collect() }
}

impl Flight {
    /// From whether each of the rays that met a surface did so at its back.
    fn of(landed: &[bool], rays: u32) -> Flight {
        let share = |count: usize| if rays > 0 { count as f64 / f64::from(rays) } else { 0.0 };
        let on_backs = landed.iter().filter(|&&on_back| on_back).count();
        Flight {
            escaped: share((rays as usize).saturating_sub(landed.len())),
            on_backs: share(on_backs),
            rays,
        }
    }

    /// How many rays know the share that lands well enough: as exact as the most are about one half, and what lands in
    /// proportion to itself, too.
    fn rays_wanted(&self) -> u32 {
        let gone = self.escaped + self.on_backs;
        let share = (4.0 * gone * (1.0 - gone)).max(gone / (1.0 - gone));
        ((share.min(1.0) * f64::from(MOST)) as u32).next_multiple_of(PACKET as u32)
    }
}

/// Measures the rooms that the light fills.
pub(super) fn rooms(hierarchy: &Hierarchy, forest: &Forest, light: &Light, tracer: &dyn Tracer) -> Rooms {
    let senders = Senders::new(forest, light);
    let landed = |departure: &Departure, ray: &Ray, hit: &Hit| {
        let area = |facet| f64::from(hierarchy.nodes[hierarchy.leaf(facet) as usize].area);
        Landing {
            point: ray.origin + ray.direction * hit.t,
            square: (hit.t as f64).powi(2),
            least: LEAST_WALL * area(departure.facet).min(area(hit.facet)),
        }
    };
    let (_, mut landings) = senders.followed(hierarchy, forest, tracer, (FEW, 1), &Silent, landed);
    if landings.len() < ENOUGH {
        (_, landings) = senders.followed(hierarchy, forest, tracer, (MOST, 1), &Silent, landed);
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
    /// Power of each, summed over channels, local areas.
    power: Vec<f64>,
    /// Power of all.
    total: f64,
}

impl Senders {
    fn new(forest: &Forest, light: &Light) -> Senders {
        let leaves: Vec<u32> = forest.leaves().map(|e| e as u32).collect();
        let power = |&e: &u32| (light.exitance[e as usize].element_sum() * forest.area[e as usize]) as f64;
        let power: Vec<f64> = leaves.iter().map(power).collect();
        let total = power.iter().sum();
        Senders { leaves, power, total }
    }

    /// How many of about `rays` rays, each with an equal share of the power, leave each sender and those before it. None if all
    /// is dark.
    ///
    /// Each has as many as its own power says, rounded up or down: where light differs a little elsewhere its rays stay
    /// the same.
    fn upto(&self, rays: u32) -> Vec<u32> {
        if self.total <= 0.0 {
            return vec![0; self.power.len()];
        }
        let per_power = f64::from(rays) / self.total;
        let mut sum = 0;
        let add = |(index, power): (usize, &f64)| {
            sum += (power * per_power + golden_fraction(index)) as u32;
            sum
        };
        self.power.iter().enumerate().map(add).collect()
    }

    fn flight(&self, hierarchy: &Hierarchy, forest: &Forest, tracer: &dyn Tracer, rays: u32) -> Flight {
        let is_on_back = |_: &Departure, ray: &Ray, hit: &Hit| {
            forest.side_index(hierarchy.side_met(hit.facet, ray.direction)).is_none()
        };
        let (rays, landed) = self.followed(hierarchy, forest, tracer, (rays, 1), &Silent, is_on_back);
        Flight::of(&landed, rays)
    }

    /// What `landed` says of each of about `rays` rays that meets a surface, and how many rays there were in truth. They
    /// are others each `time`.
    fn followed<T: Send>(
        &self,
        hierarchy: &Hierarchy,
        forest: &Forest,
        tracer: &dyn Tracer,
        (rays, time): (u32, u32),
        progress: &dyn Progress,
        landed: impl Fn(&Departure, &Ray, &Hit) -> T + Sync,
    ) -> (u32, Vec<T>) {
        let upto = self.upto(rays);
        let count = upto.last().copied().unwrap_or(0);
        let depart = |way: &mut Way<'_>, first: u32| -> [Departure; PACKET] {
            // The last packet may have a few of its rays twice.
            let index = |i: usize| (first + i as u32).min(count - 1);
            let mut departures = [NOWHERE; PACKET];
            let (mut i, mut sender) = (0, upto.partition_point(|&upto| upto <= first));
            while i < PACKET {
                while upto[sender] <= index(i) {
                    sender += 1;
                }
                let before = sender.checked_sub(1).map_or(0, |before| upto[before]);
                let piece = way.to(self.leaves[sender]);
                let (normal, points) = (piece.plane.normal, piece.polygon.sampler());
                // Rays of one sender are spread evenly; those of several, which would else repeat a pattern, are at random.
                let sequence = PairSequence::new(hash_pair(sender as u64, u64::from(time)));
                while i < PACKET && index(i) < upto[sender] {
                    let [u, v, s, t] = sequence.point(index(i) - before);
                    let (point, direction) = (points.point_at(u, v), cosine_direction(normal, s, t));
                    departures[i] = Departure { point, normal, facet: piece.side.facet, direction };
                    i += 1;
                }
            }
            departures
        };
        let working = || (Work::begin(progress, "landings"), Way::new(hierarchy, forest));
        let all = (0..count.div_ceil(PACKET as u32))
            .into_par_iter()
            .with_min_len(64)
            .map_init(working, |(_, way), index| -> [Option<T>; PACKET] {
                let first = index * PACKET as u32;
                let own = PACKET.min((count - first) as usize);
                let departures = depart(way, first);
                let mut rays = [Ray { origin: Vec3::ZERO, direction: Vec3::Z }; PACKET];
                let mut hits = [None; PACKET];
                departing_hits(tracer, &departures, &mut rays, &mut hits);
                std::array::from_fn(|i| {
                    let hit = hits[i].as_ref().filter(|_| i < own)?;
                    Some(landed(&departures[i], &rays[i], hit))
                })
            })
            .flat_map_iter(|landed| landed.into_iter().flatten())
            .collect();
        (count, all)
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
