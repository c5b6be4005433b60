//! Rays through both tracers, and every disagreement to the referee.

use super::hard::{FAMILIES, Numbers, far_segments, random_segments, segments};
use super::referee::{Referee, Ruling, tolerance_for, tolerance_for_ray};
use super::tally::{Disagreement, Question, RayComparison, Tally, Worst, candidates, kept};
use crate::tracer::{
    Candidates, FilterAudit, Hit, Interval, NO_FACET, PACKET, Ray, Segment, TraceMesh, Tracer,
};
use rayon::prelude::*;

/// Fixes the segments that are made by rule.
const SEED: u64 = 0x11_6874;

/// Longest run of facets in a list of candidates made by rule.
const LONGEST_RUN: usize = 16;

/// Segments of one kind, in the packets in which they are cast.
pub struct Batch {
    /// What kind.
    pub name: &'static str,
    /// Up to [`PACKET`] each.
    pub packets: Vec<Vec<Segment>>,
    /// The facets that may block; `None` for the whole scene.
    pub within: Option<Vec<Interval>>,
}

/// What two tracers said of one question, and the referee of that.
pub type Judged = ([u32; 2], [Ruling; 2]);

/// The referee on what two tracers say of a packet of segments: what blocks each.
pub(super) fn judged_segments<'a>(
    packet: &'a [Segment],
    within: Candidates<'a>,
    [native, other]: [&'a [u32]; 2],
    referee: &'a Referee<'_>,
) -> impl Iterator<Item = (Question, Judged)> + 'a {
    let answers = native.iter().zip(other).map(|(&a, &b)| [a, b]);
    packet.iter().zip(answers).map(move |(segment, answers)| {
        let rulings = referee.rule(segment, answers, within, tolerance_for(segment));
        (Question::Segment(*segment), (answers, rulings))
    })
}

/// The referee on what two tracers say of a packet of rays: what each meets first.
pub(super) fn judged_rays<'a>(
    packet: &'a [Ray],
    [native, other]: [&'a [Option<Hit>]; 2],
    referee: &'a Referee<'_>,
) -> impl Iterator<Item = (Question, Judged)> + 'a {
    let hits = native.iter().zip(other).map(|(&a, &b)| [a, b]);
    packet.iter().zip(hits).map(move |(ray, hits)| {
        let answers = hits.map(|hit| hit.map_or(NO_FACET, |hit| hit.facet));
        (Question::Ray(*ray), (answers, referee.rule_hits(ray, hits, tolerance_for_ray(ray))))
    })
}

/// What each tracer says blocks the segments of a packet.
fn blockers(tracer: &dyn Tracer, packet: &[Segment], within: Candidates<'_>) -> Vec<u32> {
    let mut blockers = vec![NO_FACET; packet.len()];
    tracer.blockers(packet, within, &mut blockers, &mut FilterAudit::default());
    blockers
}

/// Asks both the same question `times` at once, up to [`PACKET`]: a packet of one is traced in another way than one
/// of several. `within` has no say for rays. The answers to the first.
pub fn ask(
    question: Question,
    within: Candidates<'_>,
    times: usize,
    tracers: [&dyn Tracer; 2],
    referee: &Referee<'_>,
) -> Judged {
    let first = match question {
        Question::Segment(segment) => {
            let packet = vec![segment; times];
            let [native, other] = tracers.map(|tracer| blockers(tracer, &packet, within));
            judged_segments(&packet[..1], within, [&native, &other], referee).next()
        }
        Question::Ray(ray) => {
            let packet = vec![ray; times];
            let [native, other] = tracers.map(|tracer| {
                let mut hits = vec![None; times];
                tracer.first_hits(&packet, &mut hits);
                hits
            });
            judged_rays(&packet[..1], [&native, &other], referee).next()
        }
    };
    first.map_or(([NO_FACET; 2], [Ruling::RIGHT; 2]), |(_, judged)| judged)
}

/// About `count` segments made by rule, the same for the same mesh: half of them random, and half of those within
/// lists of candidates; an eighth from far away, the others hard to decide.
pub fn made_batches(mesh: &TraceMesh, count: usize) -> Vec<Batch> {
    let batch = |name, segments: &[Segment], within| Batch {
        name,
        packets: segments.chunks(PACKET).map(<[Segment]>::to_vec).collect(),
        within,
    };
    let random = random_segments(count / 2, SEED);
    let (whole, listed) = random.split_at(random.len() / 2);
    let (some, others) = listed.split_at(listed.len() / 2);
    let [list, rest] = lists(mesh.first_triangle.len().saturating_sub(1));
    let mut batches = vec![
        batch("random", whole, None),
        batch("random, among some candidates", some, Some(list)),
        batch("random, among all others", others, Some(rest)),
        batch("from far away", &far_segments(count / 8, SEED + 1), None),
    ];
    let hard = (count - count / 2 - count / 8).div_ceil(FAMILIES.len());
    for (family, seed) in FAMILIES.into_iter().zip(SEED + 2..) {
        let Batch { name, packets, within } = batch(family.name(), &segments(mesh, family, hard, seed), None);
        // Those that differ in a distance or an angle go together.
        match batches.iter_mut().find(|batch| batch.name == name) {
            Some(batch) => batch.packets.extend(packets),
            None => batches.push(Batch { name, packets, within }),
        }
    }
    batches
}

/// Two lists that have every facet between them, in runs of all lengths.
fn lists(facets: usize) -> [Vec<Interval>; 2] {
    let (mut numbers, mut lists) = (Numbers(SEED), [Vec::new(), Vec::new()]);
    let (mut start, mut which) = (0, 0);
    while start < facets {
        let end = (start + 1 + numbers.below(LONGEST_RUN)).min(facets);
        lists[which].push(Interval { start: start as u32, end: end as u32 });
        (start, which) = (end, 1 - which);
    }
    lists
}

/// Traces everything with both tracers; the same answer for any number of threads.
pub fn compare_rays(
    referee: &Referee<'_>,
    tracers: [&dyn Tracer; 2],
    batches: &[Batch],
    advance: &(dyn Fn(u64) + Sync),
) -> RayComparison {
    let mut found = RayComparison::default();
    for batch in batches {
        let within = candidates(&batch.within);
        let parts: Vec<(Tally, Vec<Disagreement>)> = batch
            .packets
            .par_chunks(64)
            .map(|packets| {
                let (mut tally, mut worst) = (Tally::default(), Worst::default());
                for packet in packets {
                    let [native, other] = tracers.map(|tracer| blockers(tracer, packet, within));
                    for judged in judged_segments(packet, within, [&native, &other], referee) {
                        note(&mut tally, &mut worst, batch.name, within, judged);
                    }
                }
                advance(packets.len() as u64);
                (tally, worst.into_inner())
            })
            .collect();
        let mut tally = Tally { name: batch.name.to_owned(), ..Tally::default() };
        let mut worst = Worst::default();
        for (part, disagreements) in parts {
            tally.add(&part);
            disagreements.into_iter().for_each(|disagreement| worst.add(disagreement));
        }
        found.push(tally, worst);
    }
    found
}

/// Counts one answer, and keeps it if it is among the worst.
pub(super) fn note(
    tally: &mut Tally,
    worst: &mut Worst,
    kind: &str,
    within: Candidates<'_>,
    (question, (answers, rulings)): (Question, Judged),
) {
    tally.count(question, answers, &rulings);
    if rulings != [Ruling::RIGHT; 2] && worst.has_place_for(&rulings) {
        worst.add(Disagreement { kind: kind.to_owned(), question, within: kept(within), answers, rulings });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_lists_have_every_facet_once() {
        for facets in [0, 1, 7, 1000] {
            let lists = lists(facets);
            let [some, others] = lists.each_ref().map(|list| Candidates::Only(list));
            assert!((0..facets as u32).all(|facet| some.contains(facet) != others.contains(facet)));
            assert!(facets < 1000 || lists.iter().all(|list| list.len() > 20), "{lists:?}");
        }
    }
}
