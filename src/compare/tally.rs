//! What came of rays: counts by kind, and the worst answers.

use super::referee::{Ruling, Standing};
use crate::tracer::{Candidates, Interval, NO_FACET, Ray, Segment};
use serde::Serialize;
use std::cmp::Ordering;

/// Disagreements of each kind of rays that are kept with their places, at most: the worst.
const WORST: usize = 20;

/// What a tracer is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Question {
    /// What blocks it?
    Segment(Segment),
    /// What does it meet first?
    Ray(Ray),
}

/// What came of one kind of rays; of two numbers the first is for the native tracer.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tally {
    /// What kind.
    pub name: String,
    /// Rays traced, each as often as it was.
    pub traced: u64,
    /// Those that the native tracer says are blocked, or meet something.
    pub blocked: u64,
    /// Those that both say are blocked, by different facets: which of several is named is up to the tracer.
    pub renamed: u64,
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
    /// The facets that could block; `None` for the whole scene, and for rays.
    pub within: Option<Vec<Interval>>,
    /// What each says blocks it, or is met first; [`NO_FACET`] when nothing is.
    pub answers: [u32; 2],
    /// What the referee says of that.
    pub rulings: [Ruling; 2],
}

/// The worse of two standings, and how far that answer is off.
fn severity(rulings: &[Ruling; 2]) -> (Standing, f64) {
    let [a, b] = rulings.map(|ruling| (ruling.standing, ruling.distance));
    if (b.0, b.1) > (a.0, a.1) { b } else { a }
}

impl Disagreement {
    /// The worse of the two standings, and how far that answer is off.
    pub fn severity(&self) -> (Standing, f64) {
        severity(&self.rulings)
    }

    /// The worst first; of equally bad ones the order is by place, and only the same ray is equal.
    fn order(&self, other: &Disagreement) -> Ordering {
        let (a, b) = (self.severity(), other.severity());
        let by_severity = b.0.cmp(&a.0).then(b.1.total_cmp(&a.1));
        by_severity.then_with(|| bits(&self.question).cmp(&bits(&other.question)))
    }
}

/// All that tells one question from another.
fn bits(question: &Question) -> ([u32; 6], [u32; 2]) {
    let (ends, skip) = match question {
        Question::Segment(segment) => ([segment.from, segment.to], segment.skip),
        Question::Ray(ray) => ([ray.origin, ray.direction], [NO_FACET; 2]),
    };
    let [[a, b, c], [d, e, f]] = ends.map(|end| end.to_array().map(f32::to_bits));
    ([a, b, c, d, e, f], skip)
}

/// The worst of some disagreements of one kind, each ray once: the same ones in whatever order they come.
#[derive(Debug, Default)]
pub(super) struct Worst(Vec<Disagreement>);

impl Worst {
    /// Whether one with these rulings may be among them.
    pub(super) fn has_place_for(&self, rulings: &[Ruling; 2]) -> bool {
        let last = self.0.get(WORST - 1).map(Disagreement::severity);
        last.is_none_or(|last| severity(rulings) >= last)
    }

    pub(super) fn add(&mut self, new: Disagreement) {
        match self.0.binary_search_by(|known| known.order(&new)) {
            // Of several lists the least, so that it does not matter which came first.
            Ok(at) if new.within < self.0[at].within => self.0[at] = new,
            Ok(_) => {}
            Err(at) => {
                self.0.insert(at, new);
                self.0.truncate(WORST);
            }
        }
    }

    pub(super) fn into_inner(self) -> Vec<Disagreement> {
        self.0
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
        self.worst.sort_by(Disagreement::order);
    }

    /// Takes over what was found of one more kind.
    pub(super) fn push(&mut self, tally: Tally, worst: Worst) {
        self.tallies.push(tally);
        self.worst.extend(worst.into_inner());
        self.worst.sort_by(Disagreement::order);
    }

    /// The sum over all kinds.
    pub fn total(&self) -> Tally {
        let mut total = Tally { name: "all".to_owned(), ..Tally::default() };
        self.tallies.iter().for_each(|tally| total.add(tally));
        total
    }
}

impl Tally {
    /// Adds what was counted of others.
    pub fn add(&mut self, other: &Tally) {
        self.traced += other.traced;
        self.blocked += other.blocked;
        self.renamed += other.renamed;
        self.differing += other.differing;
        for side in 0..2 {
            self.tolerance[side] += other.tolerance[side];
            self.edge_on[side] += other.edge_on[side];
            self.wrong[side] += other.wrong[side];
        }
    }

    pub(super) fn count(&mut self, question: Question, answers: [u32; 2], rulings: &[Ruling; 2]) {
        let is_met = answers.map(|facet| facet != NO_FACET);
        let is_other = answers[0] != answers[1];
        let differ = match question {
            Question::Segment(_) => is_met[0] != is_met[1],
            Question::Ray(_) => is_other,
        };
        self.traced += 1;
        self.blocked += u64::from(is_met[0]);
        self.differing += u64::from(differ);
        self.renamed += u64::from(is_other && !differ);
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

/// The list of candidates, to be kept.
pub(super) fn kept(within: Candidates<'_>) -> Option<Vec<Interval>> {
    match within {
        Candidates::All => None,
        Candidates::Only(list) => Some(list.to_vec()),
    }
}

/// A kept list, to be asked with.
pub fn candidates(within: &Option<Vec<Interval>>) -> Candidates<'_> {
    within.as_deref().map_or(Candidates::All, Candidates::Only)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::random_segments;

    #[test]
    fn the_worst_are_kept_once_in_any_order() {
        let of = |index: usize, segment: Segment, list: u32| Disagreement {
            kind: "random".to_owned(),
            question: Question::Segment(segment),
            within: Some(vec![Interval { start: list, end: 9 }]),
            answers: [0, NO_FACET],
            rulings: [
                Ruling::RIGHT,
                Ruling { standing: Standing::Wrong, distance: (index / 4) as f64, facet: 0 },
            ],
        };
        let segments = random_segments(100, 5);
        let both = |list: u32| segments.iter().enumerate().map(move |(i, &s)| of(i, s, list));
        let all: Vec<Disagreement> = both(1).chain(both(0)).collect();
        let kept = |order: &mut dyn Iterator<Item = &Disagreement>| {
            let mut worst = Worst::default();
            for new in order {
                if worst.has_place_for(&new.rulings) {
                    worst.add(new.clone());
                }
            }
            worst.into_inner()
        };
        let forwards = kept(&mut all.iter());
        assert_eq!(forwards.len(), WORST);
        assert_eq!(forwards, kept(&mut all.iter().rev()));
        assert!(forwards.iter().all(|worst| worst.severity().1 >= 20.0), "{forwards:?}");
        assert!(forwards.iter().all(|worst| worst.within.as_ref().is_some_and(|list| list[0].start == 0)));
    }
}
