//! Where the work of visibility tests goes: time by step, pairs by what answered them, by their size, and histograms.
//! Kept per worker only where it is asked for, and added up.

use super::steps::StepTimes;
use serde::Serialize;
use std::ops::AddAssign;
use std::time::Duration;

/// What settled a pair that refinement came to; each settles it one way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Invisible: they face away from each other.
    Facing,
    /// Not tested: the source is dark.
    Dark,
    /// Visible, taken over from the pair above.
    Inherited,
    /// Visible: the shaft is empty.
    EmptyShaft,
    /// Visible, as far as rays tell.
    RaysClear,
    /// Invisible: one facet blocks everything.
    SingleBlocker,
    /// Invisible: several facets in one plane block everything.
    FusedBlockers,
    /// Invisible, as far as rays tell.
    RaysBlocked,
    /// Partial: rays disagree.
    RaysDisagree,
    /// A partial link, weighed again after the refinement.
    WeighedAgain,
}

impl Answer {
    /// All of them: what costs no test, visible, invisible, partial.
    pub const ALL: [Answer; 10] = [
        Answer::Facing,
        Answer::Dark,
        Answer::Inherited,
        Answer::EmptyShaft,
        Answer::RaysClear,
        Answer::SingleBlocker,
        Answer::FusedBlockers,
        Answer::RaysBlocked,
        Answer::RaysDisagree,
        Answer::WeighedAgain,
    ];

    /// For tables and records.
    pub fn name(self) -> &'static str {
        match self {
            Answer::Facing => "facing away",
            Answer::Dark => "dark source",
            Answer::Inherited => "inherited",
            Answer::EmptyShaft => "empty shaft",
            Answer::RaysClear => "rays clear",
            Answer::SingleBlocker => "single blocker",
            Answer::FusedBlockers => "fused blockers",
            Answer::RaysBlocked => "rays blocked",
            Answer::RaysDisagree => "rays disagree",
            Answer::WeighedAgain => "weighed again",
        }
    }

    /// `"visible"`, `"invisible"`, `"partial"`, or `"untested"`.
    pub fn class(self) -> &'static str {
        match self {
            Answer::Dark => "untested",
            Answer::Inherited | Answer::EmptyShaft | Answer::RaysClear => "visible",
            Answer::Facing | Answer::SingleBlocker | Answer::FusedBlockers | Answer::RaysBlocked => {
                "invisible"
            }
            Answer::RaysDisagree | Answer::WeighedAgain => "partial",
        }
    }
}

/// Some pairs and the work they took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Pairs.
    pub pairs: u64,
    /// Rays cast for them.
    pub rays: u64,
    /// Nanoseconds, summed over workers.
    pub nanoseconds: u64,
}

impl AddAssign for Effort {
    fn add_assign(&mut self, other: Effort) {
        self.pairs += other.pairs;
        self.rays += other.rays;
        self.nanoseconds += other.nanoseconds;
    }
}

/// How often values of each size came up: 0, 1, 2 to 3, 4 to 7 and so on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Histogram([u64; Histogram::BINS]);

/// A part of a histogram.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Bin {
    /// Smallest value in it.
    pub from: u64,
    /// Largest value in it; of the last bin that there is, whatever is larger counts, too.
    pub to: u64,
    /// Values counted.
    pub count: u64,
}

impl Histogram {
    const BINS: usize = 24;

    pub(super) fn add(&mut self, value: u64) {
        let bin = (u64::BITS - value.leading_zeros()) as usize;
        self.0[bin.min(Self::BINS - 1)] += 1;
    }

    /// From that of 0 to the last that is not empty.
    pub fn bins(&self) -> Vec<Bin> {
        let used = self.0.iter().rposition(|&count| count > 0).map_or(0, |last| last + 1);
        let of = |bin: usize| match bin {
            0 => Bin { from: 0, to: 0, count: self.0[0] },
            _ => Bin { from: 1 << (bin - 1), to: (1 << bin) - 1, count: self.0[bin] },
        };
        (0..used).map(of).collect()
    }
}

impl AddAssign for Histogram {
    fn add_assign(&mut self, other: Histogram) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, count)| *sum += count);
    }
}

/// Sizes of pairs that are told apart: each half of the one before.
pub(super) const LEVELS: usize = 24;

/// Everything that is kept besides [`VisibilityCounters`](super::VisibilityCounters). All sums.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Detail {
    /// By [`Step`](super::Step), of one test in sixteen.
    pub steps: StepTimes,
    /// By what settled the pair, in the order of [`Answer::ALL`].
    pub answers: [Effort; Answer::ALL.len()],
    /// The same by size: of the pairs at level n the larger node has a radius of at most 1/2ⁿ of the scene's.
    pub levels: [[Effort; Answer::ALL.len()]; LEVELS],
    /// Rays of a pair tested.
    pub rays: Histogram,
    /// Facets left in a shaft.
    pub candidates: Histogram,
    /// Hits offered to the candidate filter for a pair tested.
    pub filter_calls: Histogram,
}

impl Detail {
    pub(super) fn count(&mut self, answer: Answer, level: usize, effort: Effort) {
        self.answers[answer as usize] += effort;
        self.levels[level.min(LEVELS - 1)][answer as usize] += effort;
    }
}

impl Detail {
    /// Adds what others kept, if they kept anything.
    pub fn merge(sum: &mut Option<Box<Detail>>, part: Option<Box<Detail>>) {
        match (sum, part) {
            (Some(sum), Some(part)) => **sum += &part,
            (sum @ None, part) => *sum = part,
            (Some(_), None) => {}
        }
    }
}

impl AddAssign<&Detail> for Detail {
    fn add_assign(&mut self, other: &Detail) {
        self.steps += &other.steps;
        let own = self.answers.iter_mut().chain(self.levels.iter_mut().flatten());
        let others = other.answers.iter().chain(other.levels.iter().flatten());
        own.zip(others).for_each(|(sum, part)| *sum += *part);
        self.rays += other.rays;
        self.candidates += other.candidates;
        self.filter_calls += other.filter_calls;
    }
}

pub(super) fn nanoseconds(duration: Duration) -> u64 {
    duration.as_nanos() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_has_every_value_in_its_bin() {
        let mut histogram = Histogram::default();
        assert_eq!(histogram.bins(), []);
        [0, 1, 2, 3, 3, 4, 7, 8].into_iter().for_each(|value| histogram.add(value));
        let bin = |from, to, count| Bin { from, to, count };
        assert_eq!(histogram.bins(), [bin(0, 0, 1), bin(1, 1, 1), bin(2, 3, 3), bin(4, 7, 2), bin(8, 15, 1)]);
        histogram.add(u64::MAX);
        assert_eq!(histogram.bins().len(), Histogram::BINS);
    }

    #[test]
    fn lists_are_in_the_order_of_their_indices() {
        Answer::ALL.into_iter().enumerate().for_each(|(index, answer)| assert_eq!(answer as usize, index));
    }

    #[test]
    fn details_add_up() {
        let effort = Effort { pairs: 1, rays: 16, nanoseconds: 5 };
        let mut one = Detail::default();
        one.count(Answer::RaysClear, 3, effort);
        one.count(Answer::RaysClear, 300, effort);
        one.rays.add(16);
        let mut sum = one.clone();
        sum += &one;
        assert_eq!(sum.answers[Answer::RaysClear as usize], Effort { pairs: 4, rays: 64, nanoseconds: 20 });
        assert_eq!(sum.levels[3][Answer::RaysClear as usize].pairs, 2);
        assert_eq!(sum.levels[LEVELS - 1][Answer::RaysClear as usize].pairs, 2);
        assert_eq!(sum.rays.bins().last().map(|bin| bin.count), Some(2));
    }
}
