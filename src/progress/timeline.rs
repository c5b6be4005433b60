//! When each phase of a run began and ended, and who worked on it when: a [`Progress`] that keeps what is reported.

use super::Progress;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Slices that are kept, at most, of all threads and of one; of one there are some however many threads there are.
const MOST_SLICES: usize = 16_384;
const MOST_OF_ONE: usize = 4096;
const LEAST_OF_ONE: usize = 128;

/// Slices of one thread that lie closer than this belong together, at first.
const GAP: Duration = Duration::from_micros(20);

/// Slices that belong together become one up to this length, at first.
const GRAIN: Duration = Duration::from_millis(1);

/// A stretch of time, since the timeline began.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The phase, as it was reported.
    pub name: &'static str,
    /// When it began.
    pub start: Duration,
    /// When it ended.
    pub end: Duration,
}

impl Span {
    /// How long it took.
    pub fn length(&self) -> Duration {
        self.end - self.start
    }
}

/// Keeps the phases, and the work of each thread.
pub struct Timeline {
    begun: Instant,
    phases: Mutex<Phases>,
    /// Phases that have begun or ended so far.
    turns: AtomicUsize,
    threads: Vec<Mutex<Thread>>,
}

#[derive(Default)]
struct Phases {
    ended: Vec<Span>,
    open: Option<(&'static str, Duration)>,
}

impl Phases {
    fn close(&mut self, end: Duration) {
        if let Some((name, start)) = self.open.take() {
            self.ended.push(Span { name, start, end });
        }
    }
}

/// What one thread did.
struct Thread {
    /// Pieces of work it is in: while it waits for others it may take up a piece within a piece.
    depth: u32,
    start: Duration,
    /// With the number of the phase that each belongs to.
    slices: Vec<(Span, usize)>,
    most: usize,
    gap: Duration,
    grain: Duration,
}

impl Thread {
    /// Keeps at most so many slices.
    fn new(most: usize) -> Thread {
        Thread { depth: 0, start: Duration::ZERO, slices: Vec::new(), most, gap: GAP, grain: GRAIN }
    }

    fn begin(&mut self, now: Duration) {
        if self.depth == 0 {
            self.start = now;
        }
        self.depth += 1;
    }

    fn end(&mut self, name: &'static str, phase: usize, now: Duration) {
        self.depth -= 1;
        if self.depth > 0 {
            return;
        }
        self.keep(Span { name, start: self.start, end: now }, phase);
        if self.slices.len() >= self.most {
            // Coarser from here on, and what there is, too.
            while self.slices.len() > self.most / 2 {
                self.gap *= 2;
                self.grain *= 2;
                std::mem::take(&mut self.slices)
                    .into_iter()
                    .for_each(|(slice, phase)| self.keep(slice, phase));
            }
        }
    }

    /// Adds a slice, or lengthens the last one.
    fn keep(&mut self, slice: Span, phase: usize) {
        match self.slices.last_mut() {
            Some((last, of))
                if last.name == slice.name
                    && *of == phase
                    && slice.start - last.end <= self.gap
                    && slice.end - last.start <= self.grain =>
            {
                last.end = slice.end;
            }
            _ => self.slices.push((slice, phase)),
        }
    }
}

impl Timeline {
    /// Begins now. `threads` of the pool it is used in are those whose work is kept, 0 for none.
    pub fn new(threads: usize) -> Timeline {
        let most = (MOST_SLICES / threads.max(1)).clamp(LEAST_OF_ONE, MOST_OF_ONE);
        Timeline {
            begun: Instant::now(),
            phases: Mutex::new(Phases::default()),
            turns: AtomicUsize::new(0),
            threads: (0..threads).map(|_| Mutex::new(Thread::new(most))).collect(),
        }
    }

    /// Time since it began.
    pub fn now(&self) -> Duration {
        self.begun.elapsed()
    }

    /// The phases that have ended, in order; no two overlap.
    pub fn phases(&self) -> Vec<Span> {
        self.phases.lock().unwrap_or_else(PoisonError::into_inner).ended.clone()
    }

    /// What each thread did, in order; no two slices of one thread overlap. Short ones that follow each other are
    /// joined, so that there are at most some thousand.
    pub fn slices(&self) -> Vec<Vec<Span>> {
        let of = |thread: &Mutex<Thread>| {
            let thread = thread.lock().unwrap_or_else(PoisonError::into_inner);
            thread.slices.iter().map(|&(slice, _)| slice).collect()
        };
        self.threads.iter().map(of).collect()
    }

    fn thread(&self) -> Option<&Mutex<Thread>> {
        self.threads.get(rayon::current_thread_index()?)
    }
}

impl Progress for Timeline {
    fn start(&self, phase: &'static str, _total: u64) {
        let now = self.now();
        let mut phases = self.phases.lock().unwrap_or_else(PoisonError::into_inner);
        phases.close(now);
        self.turns.fetch_add(1, Ordering::Relaxed);
        phases.open = Some((phase, now));
    }

    fn advance(&self, _done: u64) {}

    fn finish(&self) {
        self.turns.fetch_add(1, Ordering::Relaxed);
        self.phases.lock().unwrap_or_else(PoisonError::into_inner).close(self.now());
    }

    fn begin_work(&self) {
        if let Some(thread) = self.thread() {
            thread.lock().unwrap_or_else(PoisonError::into_inner).begin(self.now());
        }
    }

    fn end_work(&self, name: &'static str) {
        if let Some(thread) = self.thread() {
            let turns = self.turns.load(Ordering::Relaxed);
            thread.lock().unwrap_or_else(PoisonError::into_inner).end(name, turns, self.now());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Work;

    fn at(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn a_phase_ends_where_the_next_begins_or_it_is_said() {
        let timeline = Timeline::new(0);
        timeline.start("one", 3);
        timeline.start("two", 0);
        timeline.finish();
        timeline.finish();
        timeline.start("three", 0);
        let phases = timeline.phases();
        assert_eq!(phases.iter().map(|phase| phase.name).collect::<Vec<_>>(), ["one", "two"]);
        assert_eq!(phases[0].end, phases[1].start);
        assert!(phases[1].end >= phases[1].start);
    }

    #[test]
    fn work_within_work_is_part_of_it() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        let timeline = Timeline::new(1);
        pool.install(|| {
            let _outer = Work::begin(&timeline, "refine");
            let _inner = Work::begin(&timeline, "refine");
        });
        let [slices] = &timeline.slices()[..] else { panic!("one thread") };
        assert_eq!(slices.len(), 1);
    }

    #[test]
    fn there_are_never_many_slices_and_none_overlap() {
        const MOST: usize = 1000;
        let mut thread = Thread::new(MOST);
        for index in 0..40 * MOST as u64 {
            thread.begin(at(3 * index));
            thread.end(
                if index.is_multiple_of(7000) { "weigh" } else { "refine" },
                index as usize / 9000,
                at(3 * index + 2),
            );
        }
        let slices: Vec<Span> = thread.slices.iter().map(|&(slice, _)| slice).collect();
        assert!((MOST / 100..MOST).contains(&slices.len()), "{}", slices.len());
        assert!(slices.windows(2).all(|pair| pair[0].end <= pair[1].start));
        assert_eq!(
            (slices[0].start, slices[slices.len() - 1].end),
            (at(0), at(3 * (40 * MOST as u64 - 1) + 2))
        );
        assert!(slices.iter().any(|slice| slice.name == "weigh"));
        let turn = at(3 * 9000);
        assert!(slices.iter().all(|slice| slice.end <= turn || slice.start >= turn), "none is of two phases");
    }
}
