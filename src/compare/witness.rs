//! The rays of real work: a tracer whose every answer is put beside that of another one, with the same candidates.

use super::rays::{Judged, judged_rays, judged_segments, note};
use super::referee::{Referee, Ruling};
use super::sample::Sample;
use super::tally::{Question, RayComparison, Tally, Worst};
use crate::tracer::{Candidates, FilterAudit, Hit, NO_FACET, PACKET, Ray, Segment, Tracer};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// What came of one kind of rays, added to from any thread.
#[derive(Debug)]
pub struct Account {
    kind: &'static str,
    /// Of packets that both answer as the referee does: traced, blocked and renamed. They are nearly all.
    plain: [AtomicU64; 3],
    others: Mutex<(Tally, Worst)>,
}

impl Account {
    /// For rays of this kind.
    pub fn new(kind: &'static str) -> Account {
        Account { kind, plain: Default::default(), others: Mutex::default() }
    }

    fn add(&self, within: Candidates<'_>, judged: impl Iterator<Item = (Question, Judged)>) {
        let mut tally = Tally::default();
        let mut off: Vec<(Question, Judged)> = Vec::new();
        for (question, (answers, rulings)) in judged {
            if rulings == [Ruling::RIGHT; 2] {
                tally.count(question, answers, &rulings);
            } else {
                off.push((question, (answers, rulings)));
            }
        }
        let counts = [tally.traced, tally.blocked, tally.renamed];
        if off.is_empty() && tally.differing == 0 {
            for (sum, count) in self.plain.iter().zip(counts) {
                sum.fetch_add(count, Ordering::Relaxed);
            }
            return;
        }
        let mut others = self.others.lock().unwrap_or_else(PoisonError::into_inner);
        let (sum, worst) = &mut *others;
        sum.add(&tally);
        off.into_iter().for_each(|judged| note(sum, worst, self.kind, within, judged));
    }

    /// Hands over what was found.
    pub(super) fn settle(self, found: &mut RayComparison) {
        let (mut tally, worst) = self.others.into_inner().unwrap_or_else(PoisonError::into_inner);
        let [traced, blocked, renamed] = self.plain.map(AtomicU64::into_inner);
        tally.add(&Tally { traced, blocked, renamed, ..Tally::default() });
        found.push(Tally { name: self.kind.to_owned(), ..tally }, worst);
    }
}

/// Answers with one of two tracers, and asks the other the same.
pub struct Witness<'a> {
    /// Both.
    pub tracers: [&'a dyn Tracer; 2],
    /// Which of them answers.
    pub side: usize,
    /// Who is right.
    pub referee: &'a Referee<'a>,
    /// Where segments are counted.
    pub segments: &'a Account,
    /// Where rays are counted.
    pub rays: &'a Account,
    /// Keeps some of the segments.
    pub sample: &'a Sample,
}

impl Tracer for Witness<'_> {
    fn name(&self) -> &'static str {
        self.tracers[self.side].name()
    }

    fn blockers(
        &self,
        segments: &[Segment],
        candidates: Candidates<'_>,
        blockers: &mut [u32],
        audit: &mut FilterAudit,
    ) {
        self.tracers[self.side].blockers(segments, candidates, blockers, audit);
        let mut others = [NO_FACET; PACKET];
        let others = &mut others[..segments.len()];
        let other = self.tracers[1 - self.side];
        other.blockers(segments, candidates, others, &mut FilterAudit::default());
        let answers = if self.side == 0 { [&*blockers, &*others] } else { [&*others, &*blockers] };
        self.segments.add(candidates, judged_segments(segments, candidates, answers, self.referee));
        self.sample.offer(segments, candidates);
    }

    fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.tracers[self.side].first_hits(rays, hits);
        let mut others = [None; PACKET];
        let others = &mut others[..rays.len()];
        self.tracers[1 - self.side].first_hits(rays, others);
        let answers = if self.side == 0 { [&*hits, &*others] } else { [&*others, &*hits] };
        self.rays.add(Candidates::All, judged_rays(rays, answers, self.referee));
    }
}
