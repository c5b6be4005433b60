//! Rays through both tracers, and every disagreement to the referee.

use super::hard::{FAMILIES, far_segments, random_segments, segments};
use super::referee::{Referee, Ruling, Standing, tolerance_for, tolerance_for_ray};
use crate::tracer::{Candidates, FilterAudit, NO_FACET, PACKET, Ray, Segment, TraceMesh, Tracer};
use rayon::prelude::*;
use serde::Serialize;

/// Disagreements of each kind of rays that are kept with their places, at most: the worst.
const WORST: usize = 20;

/// Fixes the segments that are made by rule.
const SEED: u64 = 0x11_6874;

/// Segments or rays of one kind, in the packets in which they are cast.
pub struct Batch<T> {
    /// What kind.
    pub name: &'static str,
    /// Up to [`PACKET`] each.
    pub packets: Vec<Vec<T>>,
}

/// What a tracer is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Question {
    /// What blocks it?
    Segment(Segment),
    /// What does it meet first?
    Ray(Ray),
}

/// What two tracers are asked in packets.
pub trait Ask: Copy + Sync {
    /// What each says: what blocks, or is met first, or [`NO_FACET`]; and the referee on that.
    fn ask(packet: &[Self], tracers: [&dyn Tracer; 2], referee: &Referee<'_>)
    -> Vec<([u32; 2], [Ruling; 2])>;

    /// One of a packet.
    fn question(self) -> Question;
}

impl Ask for Segment {
    fn ask(
        packet: &[Segment],
        tracers: [&dyn Tracer; 2],
        referee: &Referee<'_>,
    ) -> Vec<([u32; 2], [Ruling; 2])> {
        let [native, other] = tracers.map(|tracer| {
            let mut blockers = vec![NO_FACET; packet.len()];
            tracer.blockers(packet, Candidates::All, &mut blockers, &mut FilterAudit::default());
            blockers
        });
        let answers = native.into_iter().zip(other).map(|(a, b)| [a, b]);
        packet
            .iter()
            .zip(answers)
            .map(|(segment, answers)| (answers, referee.rule(segment, answers, tolerance_for(segment))))
            .collect()
    }

    fn question(self) -> Question {
        Question::Segment(self)
    }
}

impl Ask for Ray {
    fn ask(packet: &[Ray], tracers: [&dyn Tracer; 2], referee: &Referee<'_>) -> Vec<([u32; 2], [Ruling; 2])> {
        let [native, other] = tracers.map(|tracer| {
            let mut hits = vec![None; packet.len()];
            tracer.first_hits(packet, &mut hits);
            hits
        });
        let hits = native.into_iter().zip(other).map(|(a, b)| [a, b]);
        packet
            .iter()
            .zip(hits)
            .map(|(ray, hits)| {
                let answers = hits.map(|hit| hit.map_or(NO_FACET, |hit| hit.facet));
                (answers, referee.rule_hits(ray, hits, tolerance_for_ray(ray)))
            })
            .collect()
    }

    fn question(self) -> Question {
        Question::Ray(self)
    }
}

/// What came of one kind of rays; of two numbers the first is for the native tracer.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tally {
    /// What kind.
    pub name: String,
    /// Rays traced.
    pub traced: u64,
    /// Those that the native tracer says are blocked, or meet something.
    pub blocked: u64,
    /// Those on which the two disagree whether they are blocked, or what they meet first.
    pub differing: u64,
    /// Answers that are not the referee's, but within the tolerance.
    pub tolerance: [u64; 2],
    /// Answers that are not the referee's, on segments in the plane of a facet.
    pub edge_on: [u64; 2],
    /// All other answers that are not the referee's.
    pub wrong: [u64; 2],
}

/// An answer that is not the referee's.
#[derive(Clone, Debug, PartialEq)]
pub struct Disagreement {
    /// The kind of ray.
    pub kind: String,
    /// What was asked.
    pub question: Question,
    /// What each says blocks it, or is met first; [`NO_FACET`] when nothing is.
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

/// Both tracers on many rays.
#[derive(Clone, Debug, Default)]
pub struct RayComparison {
    /// By kind.
    pub tallies: Vec<Tally>,
    /// The worst first.
    pub worst: Vec<Disagreement>,
}

impl RayComparison {
    /// Takes over what was found of other rays.
    pub fn extend(&mut self, other: RayComparison) {
        self.tallies.extend(other.tallies);
        self.worst.extend(other.worst);
        sort(&mut self.worst);
    }

    /// The sum over all kinds.
    pub fn total(&self) -> Tally {
        let mut total = Tally { name: "all".to_owned(), ..Tally::default() };
        self.tallies.iter().for_each(|tally| total.add(tally));
        total
    }
}

impl Tally {
    fn add(&mut self, other: &Tally) {
        self.traced += other.traced;
        self.blocked += other.blocked;
        self.differing += other.differing;
        for side in 0..2 {
            self.tolerance[side] += other.tolerance[side];
            self.edge_on[side] += other.edge_on[side];
            self.wrong[side] += other.wrong[side];
        }
    }

    fn count(&mut self, question: Question, answers: [u32; 2], rulings: &[Ruling; 2]) {
        let is_met = answers.map(|facet| facet != NO_FACET);
        let differ = match question {
            // Which of several blockers is named is up to the tracer.
            Question::Segment(_) => is_met[0] != is_met[1],
            Question::Ray(_) => answers[0] != answers[1],
        };
        self.traced += 1;
        self.blocked += u64::from(is_met[0]);
        self.differing += u64::from(differ);
        for (side, ruling) in rulings.iter().enumerate() {
            match ruling.standing {
                Standing::Right => {}
                Standing::Tolerance => self.tolerance[side] += 1,
                Standing::EdgeOn => self.edge_on[side] += 1,
                Standing::Wrong => self.wrong[side] += 1,
            }
        }
    }
}

/// About `count` segments made by rule, the same for the same mesh: half of them random, an eighth from far away,
/// the others hard to decide.
pub fn made_batches(mesh: &TraceMesh, count: usize) -> Vec<Batch<Segment>> {
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

/// Traces everything with both tracers against the whole scene; the same answer for any number of threads.
pub fn compare_rays<T: Ask>(
    referee: &Referee<'_>,
    tracers: [&dyn Tracer; 2],
    batches: &[Batch<T>],
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
                    for (asked, (answers, rulings)) in packet.iter().zip(T::ask(packet, tracers, referee)) {
                        let question = asked.question();
                        tally.count(question, answers, &rulings);
                        if rulings != [Ruling::RIGHT; 2] {
                            let kind = batch.name.to_owned();
                            disagreements.push(Disagreement { kind, question, answers, rulings });
                        }
                    }
                }
                keep_worst(&mut disagreements);
                advance(packets.len() as u64);
                (tally, disagreements)
            })
            .collect();
        let mut tally = Tally { name: batch.name.to_owned(), ..Tally::default() };
        let mut worst = Vec::new();
        for (part, disagreements) in parts {
            tally.add(&part);
            worst.extend(disagreements);
        }
        keep_worst(&mut worst);
        found.worst.extend(worst);
        found.tallies.push(tally);
    }
    sort(&mut found.worst);
    found
}

fn keep_worst(disagreements: &mut Vec<Disagreement>) {
    sort(disagreements);
    disagreements.truncate(WORST);
}

/// The worst first; stable, so that the order does not depend on the threads.
fn sort(disagreements: &mut [Disagreement]) {
    disagreements.sort_by(|a, b| {
        let (a, b) = (a.severity(), b.severity());
        b.0.cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
}
