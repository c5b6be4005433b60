//! Time of visibility tests by step.
//!
//! Only some tests are timed, and they stand for all: one of them that another program interrupts would count for many.
//! How much a test has to do is known without a clock, so those that took far too long for it are found and held back.

use super::detail::nanoseconds;
use std::ops::AddAssign;
use std::time::Instant;

/// A step of a visibility test that is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Points on both nodes for rays to join, and how much each ray counts.
    Points,
    /// Rays through the tracer, with the candidate filter.
    Rays,
    /// How bright the source is where rays end.
    Brightness,
    /// Shafts built.
    Shafts,
    /// Nodes and facets tested against shafts.
    Culling,
    /// Facets tried as blockers, and the search for them.
    Blockers,
    /// What is left, and rejected hits looked at again.
    Other,
}

impl Step {
    /// All of them, in the order of a test.
    pub const ALL: [Step; 7] = [
        Step::Points,
        Step::Rays,
        Step::Brightness,
        Step::Shafts,
        Step::Culling,
        Step::Blockers,
        Step::Other,
    ];

    /// For tables and records.
    pub fn name(self) -> &'static str {
        match self {
            Step::Points => "points",
            Step::Rays => "rays",
            Step::Brightness => "brightness",
            Step::Shafts => "shafts",
            Step::Culling => "culling",
            Step::Blockers => "blockers",
            Step::Other => "other",
        }
    }
}

/// Nanoseconds by [`Step`], in the order of [`Step::ALL`].
type Laps = [u64; Step::ALL.len()];

/// Some tests, what they did, and how long their steps took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Paced {
    tests: u64,
    work: u64,
    laps: Laps,
}

/// Paces that are told apart: nanoseconds for a unit of work, each twice the one before.
const PACES: usize = 40;

/// The pace that so many of a hundred tests keep is that of a test that nothing disturbs.
const KEPT_BY: u64 = 95;

/// Tests that are slower than that this many times, by halves, count as if they were not.
const HALVES: usize = 4;

/// Time by step of the tests that are timed, apart by their pace. All sums.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StepTimes([Paced; PACES]);

impl Default for StepTimes {
    fn default() -> StepTimes {
        StepTimes([Paced::default(); PACES])
    }
}

impl StepTimes {
    /// A test that did so much work.
    fn add(&mut self, work: u64, laps: &Laps) {
        let work = work.max(1);
        let pace = laps.iter().sum::<u64>() / work;
        self.0[(pace.max(1).ilog2() as usize).min(PACES - 1)] += Paced { tests: 1, work, laps: *laps };
    }

    /// All that was timed, nanoseconds.
    pub fn nanoseconds(&self) -> u64 {
        self.0.iter().flat_map(|paced| paced.laps).sum()
    }

    /// The share of each step, in the order of [`Step::ALL`]; all 0 where nothing was timed.
    ///
    /// A test that took more than 16 times as long for what it did as 95 in 100 tests do counts as if it had taken 16
    /// times as long: what it did does not explain that, other programs do.
    pub fn shares(&self) -> [f64; Step::ALL.len()] {
        let rank = self.0.iter().map(|paced| paced.tests).sum::<u64>() * KEPT_BY / 100;
        let mut seen = 0;
        let kept = self.0.iter().position(|paced| {
            seen += paced.tests;
            seen > rank
        });
        let most = kept.map_or(PACES, |kept| kept + HALVES);
        let mut sums = [0.0; Step::ALL.len()];
        for (pace, paced) in self.0.iter().enumerate() {
            let all = paced.laps.iter().sum::<u64>().max(1) as f64;
            let believed = if pace > most { (2u64 << most) as f64 * paced.work as f64 / all } else { 1.0 };
            sums.iter_mut().zip(paced.laps).for_each(|(sum, lap)| *sum += believed * lap as f64);
        }
        let all = sums.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        sums.map(|sum| sum / all)
    }
}

impl AddAssign for Paced {
    fn add_assign(&mut self, other: Paced) {
        self.tests += other.tests;
        self.work += other.work;
        self.laps.iter_mut().zip(other.laps).for_each(|(sum, part)| *sum += part);
    }
}

impl AddAssign<&StepTimes> for StepTimes {
    fn add_assign(&mut self, other: &StepTimes) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, part)| *sum += part);
    }
}

/// The steps of one test in so many are timed: a look at the clock costs as much as a few tens of nanoseconds, and a test
/// of few rays takes no more than a microsecond.
const TIMED: u64 = 16;

/// Times the steps of one test.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepClock {
    last: Instant,
    laps: Laps,
    /// Laps so far: a blocker that is tried is one, and no other work is counted for it.
    count: u64,
}

impl StepClock {
    /// For the test of a pair with this seed, if it is one of those that are timed.
    pub(super) fn of(seed: u64, start: Instant) -> Option<StepClock> {
        seed.is_multiple_of(TIMED).then_some(StepClock { last: start, laps: Laps::default(), count: 0 })
    }

    /// A step has ended.
    pub(super) fn lap(&mut self, step: Step, now: Instant) {
        self.laps[step as usize] += nanoseconds(now - self.last);
        self.last = now;
        self.count += 1;
    }

    /// The test has ended; `work` is what it did, in rays.
    pub(super) fn add_to(self, times: &mut StepTimes, work: u64) {
        times.add(work + self.count, &self.laps);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laps(step: Step, nanoseconds: u64) -> Laps {
        let mut laps = Laps::default();
        laps[step as usize] = nanoseconds;
        laps
    }

    fn share(times: &StepTimes, step: Step) -> f64 {
        times.shares()[step as usize]
    }

    #[test]
    fn steps_are_in_the_order_of_their_indices() {
        Step::ALL.into_iter().enumerate().for_each(|(index, step)| assert_eq!(step as usize, index));
    }

    /// Half rays, half shafts, in tests of 16 units of work that take 1 to 2 µs.
    fn undisturbed() -> StepTimes {
        let mut times = StepTimes::default();
        for index in 0..500 {
            times.add(16, &laps(Step::Rays, 1000 + 2 * index));
            times.add(16, &laps(Step::Shafts, 1000 + 2 * index));
        }
        times
    }

    #[test]
    fn shares_are_those_of_the_sums_where_nothing_disturbs() {
        let mut times = undisturbed();
        assert_eq!(share(&times, Step::Rays), 0.5);
        times.add(16, &laps(Step::Culling, times.nanoseconds() / 999));
        let wanted = 1.0 / 1000.0;
        assert!((share(&times, Step::Culling) - wanted).abs() < 1e-5, "{:?}", times.shares());
    }

    #[test]
    fn a_test_that_is_interrupted_does_not_decide() {
        let mut times = undisturbed();
        times.add(16, &laps(Step::Shafts, 4_000_000));
        assert!((share(&times, Step::Shafts) - 0.5).abs() < 0.02, "{:?}", times.shares());
        // The clock still has it.
        assert!(times.nanoseconds() > 4_000_000);
    }

    /// What takes long because there is much to do is kept, however long and rare it is.
    #[test]
    fn a_test_that_has_much_to_do_counts_in_full() {
        let mut times = undisturbed();
        let before = times.nanoseconds();
        times.add(50_000, &laps(Step::Culling, 4_500_000));
        let wanted = 4_500_000.0 / (before + 4_500_000) as f64;
        assert_eq!(share(&times, Step::Culling), wanted);
    }

    #[test]
    fn few_tests_and_none_have_shares() {
        let mut times = StepTimes::default();
        assert_eq!(times.shares(), [0.0; 7]);
        times.add(0, &laps(Step::Other, 0));
        assert_eq!(times.shares(), [0.0; 7]);
        times.add(1, &laps(Step::Rays, u64::MAX / 8));
        times.add(1, &laps(Step::Points, 0));
        assert!((times.shares().iter().sum::<f64>() - 1.0).abs() < 1e-9, "{:?}", times.shares());
    }

    #[test]
    fn times_add_up() {
        let mut sum = undisturbed();
        sum += &undisturbed();
        assert_eq!(sum.nanoseconds(), 2 * undisturbed().nanoseconds());
        assert_eq!(sum.shares(), undisturbed().shares());
    }
}
