//! Rays that carry the light of a solution one step, from where it leaves to where it lands. They know
//! nothing of links, so they can judge them.

use super::subject::{Lottery, Subject};
use crate::math::{PairSequence, cosine_direction};
use crate::radiosity::{Piece, Way};
use crate::tracer::{Departure, PACKET, Ray, departing_hits};
use glam::Vec3;
use rayon::prelude::*;

/// Rays, each standing for the same power: what becomes of a share p of the light is found to within
/// √(p/RAYS) of all, 0.2 % of it at most.
pub(super) const RAYS: u32 = 1 << 18;

/// Where the light of one ray ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Landing {
    /// It met nothing.
    Escaped,
    /// On the back of a one-sided surface, which takes no part.
    OnBack,
    /// On a leaf element.
    On(u32),
}

/// One ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    /// Leaf element that it left.
    pub(super) from: u32,
    pub(super) landing: Landing,
}

/// All light on its way.
pub(super) struct Flights {
    pub(super) all: Vec<Flight>,
    /// Power that each stands for: sum over channels, local areas.
    pub(super) power: f64,
}

impl Flights {
    /// Power of all light on its way: what all surfaces send out.
    pub(super) fn sent(&self) -> f64 {
        self.power * self.all.len() as f64
    }

    /// Power of the flights that `is_counted` counts.
    pub(super) fn power_of(&self, is_counted: impl Fn(&Flight) -> bool) -> f64 {
        self.power * self.all.iter().filter(|flight| is_counted(flight)).count() as f64
    }
}

/// Sends the light of all leaf elements on its way with `count` rays, a multiple of [`PACKET`]; the same rays for any
/// number of threads. Every other ray is of a sequence of its own: how far the two halves differ shows how much is noise.
pub(super) fn flights(subject: &Subject<'_>, count: u32) -> Flights {
    let exitance = &subject.solution.light.exitance;
    let lottery =
        Lottery::new(&subject.leaves, |e| exitance[e as usize].element_sum() as f64 * subject.area(e));
    if lottery.total <= 0.0 {
        return Flights { all: Vec::new(), power: 0.0 };
    }
    let way = || Way::new(subject.hierarchy, &subject.solution.forest);
    let sequences = [2, 3].map(PairSequence::new);
    let all = (0..count / PACKET as u32)
        .into_par_iter()
        .with_min_len(64)
        .map_init(way, |way, packet| {
            let mut from = [0; PACKET];
            let departures: [Departure; PACKET] = std::array::from_fn(|i| {
                let index = packet * PACKET as u32 + i as u32;
                from[i] = lottery.pick((index as f64 + 0.5) / count as f64);
                departure(way.to(from[i]), sequences[i % 2].point(index / 2))
            });
            let landings = landings(subject, &departures);
            (0..PACKET).map(move |i| Flight { from: from[i], landing: landings[i] })
        })
        .flatten_iter()
        .collect();
    Flights { all, power: lottery.total / count as f64 }
}

/// A ray from a point of an element; directions are distributed like the cosine.
pub(super) fn departure(piece: &Piece, [u, v, s, t]: [f64; 4]) -> Departure {
    let normal = piece.plane.normal;
    let (point, direction) = (piece.polygon.point_at(u, v), cosine_direction(normal, s, t));
    Departure { point, normal, facet: piece.side.facet, direction }
}

/// Where rays end.
pub(super) fn landings(subject: &Subject<'_>, departures: &[Departure; PACKET]) -> [Landing; PACKET] {
    let mut rays = [Ray { origin: Vec3::ZERO, direction: Vec3::Z }; PACKET];
    let mut hits = [None; PACKET];
    departing_hits(subject.tracer, departures, &mut rays, &mut hits);
    std::array::from_fn(|i| {
        let Some(hit) = &hits[i] else { return Landing::Escaped };
        let leaf = subject.solution.forest.leaf_met(subject.hierarchy, &rays[i], hit);
        leaf.map_or(Landing::OnBack, |leaf| Landing::On(leaf.id))
    })
}
