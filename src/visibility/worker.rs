//! What one task carries from test to test: scratch memory, counters, and the clock of the steps.

use super::detail::{Answer, Detail, Effort, nanoseconds};
use super::rays::Sighting;
use super::steps::{Step, StepClock};
use super::{CandidateSet, VisibilityCounters};
use crate::tracer::Segment;
use std::time::Instant;

/// Scratch memory and counters of one thread's current task.
#[derive(Debug, Default)]
pub struct Worker {
    /// What the tests did.
    pub counters: VisibilityCounters,
    pub(super) sightings: Vec<Sighting>,
    /// The last packet of rays.
    pub(super) segments: Vec<Segment>,
    spare: Vec<CandidateSet>,
    is_detailed: bool,
    /// Made with the first thing that goes in it.
    detail: Option<Box<Detail>>,
    /// Of the test that goes on, if steps are timed.
    clock: Option<StepClock>,
}

/// Where a test began.
pub(super) struct Begun {
    start: Instant,
    /// What had been counted before.
    pub(super) counters: VisibilityCounters,
}

impl Worker {
    /// One that keeps a [`Detail`], if `is_detailed`.
    pub(super) fn new(is_detailed: bool) -> Worker {
        Worker { is_detailed, ..Worker::default() }
    }

    /// Gives back a candidate set for reuse.
    pub fn recycle(&mut self, set: CandidateSet) {
        self.spare.push(set);
    }

    /// Counters, and the detail if there is any.
    pub fn into_counted(self) -> (VisibilityCounters, Option<Box<Detail>>) {
        (self.counters, self.detail)
    }

    /// The same counters without scratch memory.
    pub fn closed(self) -> Worker {
        let Worker { counters, is_detailed, detail, .. } = self;
        Worker { counters, is_detailed, detail, ..Worker::default() }
    }

    /// Counts a pair that needed no test; `level` as of [`Tester::level`](super::Tester::level).
    ///
    /// Pairs that face away from each other are as quick to refuse as to measure: they are not told apart by size.
    pub fn count_untested(&mut self, answer: Answer, level: impl FnOnce() -> usize) {
        if self.is_detailed {
            let level = if answer == Answer::Facing { 0 } else { level() };
            self.detail().count(answer, level, Effort { pairs: 1, ..Effort::default() });
        }
    }

    /// Adds what another worker counted.
    pub fn absorb(&mut self, other: Worker) {
        self.counters += other.counters;
        Detail::merge(&mut self.detail, other.detail);
    }

    pub(super) fn empty_set(&mut self) -> CandidateSet {
        let mut set = self.spare.pop().unwrap_or_default();
        set.nodes.clear();
        set.intervals.clear();
        set
    }

    fn detail(&mut self) -> &mut Detail {
        self.detail.get_or_insert_default()
    }

    /// The test of a pair with this seed begins.
    pub(super) fn begin(&mut self, seed: u64) -> Begun {
        let start = Instant::now();
        if self.is_detailed {
            self.clock = StepClock::of(seed, start);
        }
        Begun { start, counters: self.counters }
    }

    /// A step of the test has ended just now.
    #[inline]
    pub(super) fn lap(&mut self, step: Step) {
        if let Some(clock) = &mut self.clock {
            clock.lap(step, Instant::now());
        }
    }

    /// A shaft was culled.
    pub(super) fn note_candidates(&mut self, facets: u64) {
        if self.is_detailed {
            self.detail().candidates.add(facets);
        }
    }

    /// The test has ended; `outcome` says what settled it and the level of the pair.
    pub(super) fn end(
        &mut self,
        begun: &Begun,
        outcome: impl FnOnce(&VisibilityCounters) -> (Answer, usize),
    ) {
        let now = Instant::now();
        let nanoseconds = nanoseconds(now - begun.start);
        self.counters.nanoseconds += nanoseconds;
        if !self.is_detailed {
            return;
        }
        if let Some(mut clock) = self.clock.take() {
            clock.lap(Step::Other, now);
            let work = self.counters.work_since(&begun.counters);
            clock.add_to(&mut self.detail().steps, work);
        }
        let (answer, level) = outcome(&self.counters);
        let rays = self.counters.rays_cast - begun.counters.rays_cast;
        let filter_calls = self.counters.filter_calls - begun.counters.filter_calls;
        let detail = self.detail();
        detail.count(answer, level, Effort { pairs: 1, rays, nanoseconds });
        if answer != Answer::WeighedAgain {
            detail.rays.add(rays);
            detail.filter_calls.add(filter_calls);
        }
    }
}
