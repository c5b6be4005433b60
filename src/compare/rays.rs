//! Segments through both tracers, and every disagreement to the referee.

use super::hard::{FAMILIES, far_segments, random_segments, segments};
use super::referee::{Referee, Ruling, Standing, tolerance_for};
use crate::tracer::{Candidates, FilterAudit, NO_FACET, PACKET, Segment, TraceMesh, Tracer};
use rayon::prelude::*;
use serde::Serialize;

/// Disagreements that are kept with their places, at most: the worst.
const WORST: usize = 100;

/// Fixes the segments that are made by rule.
const SEED: u64 = 0x11_6874;

/// Segments of one kind, in the packets in which they are cast.
pub struct Batch {
    /// What kind.
    pub name: &'static str,
    /// Up to [`PACKET`] segments each.
    pub packets: Vec<Vec<Segment>>,
}

/// What came of one kind of segments; of two numbers the first is for the native tracer.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tally {
    /// What kind.
    pub name: String,
    /// Segments traced.
    pub segments: u64,
    /// Those that the native tracer says are blocked.
    pub blocked: u64,
    /// Those on which the two disagree whether they are blocked.
    pub differing: u64,
    /// Answers that are not the referee's, but within the tolerance.
    pub tolerance: [u64; 2],
    /// Answers that are not the referee's, on segments in the plane of a facet.
    pub in_plane: [u64; 2],
    /// All other answers that are not the referee's.
    pub wrong: [u64; 2],
}

/// An answer that is not the referee's.
#[derive(Clone, Debug, PartialEq)]
pub struct Disagreement {
    /// The kind of segment.
    pub kind: String,
    /// The segment.
    pub segment: Segment,
    /// What each says blocks it; [`NO_FACET`] when it is clear.
    pub answers: [u32; 2],
    /// What the referee says of that.
    pub rulings: [Ruling; 2],
}

impl Disagreement {
    /// The worse of the two standings, and how far that answer is off.
    pub fn severity(&self) -> (Standing, f64) {
        let severities = self.rulings.map(|ruling| (ruling.standing, ruling.distance));
        let [a, b] = severities;
        if (b.0, b.1) > (a.0, a.1) { b } else { a }
    }
}

/// Both tracers on many segments.
#[derive(Clone, Debug, Default)]
pub struct RayComparison {
    /// By kind.
    pub tallies: Vec<Tally>,
    /// The worst first.
    pub worst: Vec<Disagreement>,
}

impl RayComparison {
    /// The sum over all kinds.
    pub fn total(&self) -> Tally {
        let mut total = Tally { name: "all".to_owned(), ..Tally::default() };
        self.tallies.iter().for_each(|tally| total.add(tally));
        total
    }
}

impl Tally {
    fn add(&mut self, other: &Tally) {
        self.segments += other.segments;
        self.blocked += other.blocked;
        self.differing += other.differing;
        for side in 0..2 {
            self.tolerance[side] += other.tolerance[side];
            self.in_plane[side] += other.in_plane[side];
            self.wrong[side] += other.wrong[side];
        }
    }

    fn count(&mut self, answers: [u32; 2], rulings: &[Ruling; 2]) {
        let [native, other] = answers.map(|facet| facet != NO_FACET);
        self.segments += 1;
        self.blocked += u64::from(native);
        self.differing += u64::from(native != other);
        for (side, ruling) in rulings.iter().enumerate() {
            match ruling.standing {
                Standing::Right => {}
                Standing::Tolerance => self.tolerance[side] += 1,
                Standing::InPlane => self.in_plane[side] += 1,
                Standing::Wrong => self.wrong[side] += 1,
            }
        }
    }
}

/// About `count` segments made by rule, the same for the same mesh: half of them random, an eighth from far away,
/// the others hard to decide.
pub fn made_batches(mesh: &TraceMesh, count: usize) -> Vec<Batch> {
    let batch = |name, segments: Vec<Segment>| Batch {
        name,
        packets: segments.chunks(PACKET).map(<[Segment]>::to_vec).collect(),
    };
    let hard = (count - count / 2 - count / 8).div_ceil(FAMILIES.len());
    let mut batches = vec![
        batch("random", random_segments(count / 2, SEED)),
        batch("from far away", far_segments(count / 8, SEED + 1)),
    ];
    for (family, seed) in FAMILIES.into_iter().zip(SEED + 2..) {
        let Batch { name, packets } = batch(family.name(), segments(mesh, family, hard, seed));
        // Those that differ in a distance or an angle go together.
        match batches.iter_mut().find(|batch| batch.name == name) {
            Some(batch) => batch.packets.extend(packets),
            None => batches.push(Batch { name, packets }),
        }
    }
    batches
}

/// What both say blocks each segment of a packet.
pub fn answers_of(tracers: [&dyn Tracer; 2], packet: &[Segment]) -> Vec<[u32; 2]> {
    let [native, other] = tracers.map(|tracer| {
        let mut blockers = vec![NO_FACET; packet.len()];
        tracer.blockers(packet, Candidates::All, &mut blockers, &mut FilterAudit::default());
        blockers
    });
    native.into_iter().zip(other).map(|(a, b)| [a, b]).collect()
}

/// Traces every segment with both tracers against the whole scene; the same answer for any number of threads.
pub fn compare_rays(
    referee: &Referee<'_>,
    tracers: [&dyn Tracer; 2],
    batches: &[Batch],
    advance: &(dyn Fn(u64) + Sync),
) -> RayComparison {
    let mut found = RayComparison::default();
    for batch in batches {
        let parts: Vec<(Tally, Vec<Disagreement>)> = batch
            .packets
            .par_chunks(64)
            .map(|packets| {
                let (mut tally, mut disagreements) = (Tally::default(), Vec::new());
                for packet in packets {
                    for (&segment, answers) in packet.iter().zip(answers_of(tracers, packet)) {
                        let rulings = referee.rule(&segment, answers, tolerance_for(&segment));
                        tally.count(answers, &rulings);
                        if rulings != [Ruling::RIGHT; 2] {
                            let kind = batch.name.to_owned();
                            disagreements.push(Disagreement { kind, segment, answers, rulings });
                        }
                    }
                }
                keep_worst(&mut disagreements);
                advance(packets.len() as u64);
                (tally, disagreements)
            })
            .collect();
        let mut tally = Tally { name: batch.name.to_owned(), ..Tally::default() };
        for (part, disagreements) in parts {
            tally.add(&part);
            found.worst.extend(disagreements);
        }
        found.tallies.push(tally);
    }
    keep_worst(&mut found.worst);
    found
}

/// Stable, so that the order does not depend on the threads.
fn keep_worst(disagreements: &mut Vec<Disagreement>) {
    disagreements.sort_by(|a, b| {
        let (a, b) = (a.severity(), b.severity());
        b.0.cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    disagreements.truncate(WORST);
}
