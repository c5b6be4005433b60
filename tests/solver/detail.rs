//! The detail that is kept of visibility tests agrees with the counters, changes nothing, and is the same for any
//! number of threads.

use lightshaft::radiosity::{Record, Solution, SolveOptions};
use lightshaft::visibility::{Answer, Detail, Effort, StepTimes, Strategy, VisibilityCounters};
use rayon::ThreadPoolBuilder;

use crate::solving::{Case, STRATEGIES, rough};

const UNTESTED: [Answer; 3] = [Answer::Facing, Answer::Dark, Answer::Inherited];

fn solved(options: SolveOptions, record: Record, threads: usize) -> Solution {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a few threads");
    pool.install(|| {
        let case = Case::load("paper-1");
        case.solve(&case.fallback(), &SolveOptions { record, ..options })
    })
}

fn detail(solution: &Solution) -> &Detail {
    solution.counters.detail.as_deref().expect("detail was asked for")
}

fn without_clock(detail: &Detail) -> Detail {
    let mut still = detail.clone();
    still.steps = StepTimes::default();
    still
        .answers
        .iter_mut()
        .chain(still.levels.iter_mut().flatten())
        .for_each(|effort| effort.nanoseconds = 0);
    still
}

fn summed(efforts: impl Iterator<Item = Effort>) -> Effort {
    efforts.fold(Effort::default(), |mut sum, effort| {
        sum += effort;
        sum
    })
}

#[test]
fn the_detail_adds_up_to_the_counters() {
    for strategy in STRATEGIES {
        let name = strategy.name();
        let solution = solved(rough(strategy), Record::Steps, 2);
        let (counters, detail) = (solution.counters.visibility, detail(&solution));
        let timed = detail.steps.nanoseconds();
        assert!(0 < timed && timed < counters.nanoseconds, "{name}: {timed} of {} ns", counters.nanoseconds);
        let all = summed(detail.answers.into_iter());
        assert_eq!((all.rays, all.nanoseconds), (counters.rays_cast, counters.nanoseconds), "{name}");
        let of = |answer: Answer| detail.answers[answer as usize];
        let untested = summed(UNTESTED.into_iter().map(of));
        assert_eq!(untested, Effort { pairs: untested.pairs, ..Effort::default() }, "{name}");
        let tested = all.pairs - untested.pairs - of(Answer::WeighedAgain).pairs;
        assert_eq!(tested, counters.pairs_tested, "{name}");
        for answer in Answer::ALL {
            let by_level = summed(detail.levels.iter().map(|efforts| efforts[answer as usize]));
            assert_eq!(by_level, of(answer), "{name}: {} by level", answer.name());
        }
        let counted = |histogram: lightshaft::visibility::Histogram| {
            histogram.bins().iter().map(|bin| bin.count).sum::<u64>()
        };
        assert_eq!(counted(detail.rays), tested, "{name}");
        assert_eq!(counted(detail.filter_calls), tested, "{name}");
        assert_eq!(counted(detail.candidates), counters.shafts_built, "{name}");
        let empty = detail.candidates.bins().first().map_or(0, |bin| bin.count);
        assert_eq!(empty, counters.empty_shafts, "{name}");
        assert_eq!(of(Answer::EmptyShaft).pairs, counters.empty_shafts, "{name}");
        let blocked = of(Answer::SingleBlocker).pairs + of(Answer::FusedBlockers).pairs;
        assert_eq!(blocked, counters.single_blockers + counters.fused_blockers, "{name}");
        assert!(of(Answer::Facing).pairs > 0 && of(Answer::RaysDisagree).pairs > 0, "{name}");
    }
}

#[test]
fn the_detail_changes_nothing_and_no_thread_changes_it() {
    for strategy in STRATEGIES.into_iter().filter(|&strategy| strategy != Strategy::All) {
        let [without, one, three] = [(Record::Nothing, 2), (Record::Steps, 1), (Record::Steps, 3)]
            .map(|(record, threads)| solved(rough(strategy), record, threads));
        assert!(without.counters.detail.is_none());
        let still =
            |solution: &Solution| VisibilityCounters { nanoseconds: 0, ..solution.counters.visibility };
        assert_eq!(still(&without), still(&one));
        assert_eq!(without.links.links, one.links.links);
        assert_eq!(without.light.exitance, one.light.exitance);
        assert_eq!(without_clock(detail(&one)), without_clock(detail(&three)), "{}", strategy.name());
    }
}

#[test]
fn the_work_by_receiver_is_all_work_and_no_thread_changes_it() {
    for strategy in [Strategy::Adaptive, Strategy::Shaft, Strategy::Sampled] {
        let name = strategy.name();
        let [one, three] = [1, 3].map(|threads| solved(rough(strategy), Record::Work, threads));
        assert_eq!(one.work, three.work, "{name}");
        let counters = one.counters.visibility;
        let done = one.work.iter().sum::<u64>();
        let least = counters.rays_cast + 8 * counters.shafts_built + counters.nodes_tested / 16;
        let most = least + counters.shafts_built;
        assert!((least..=most).contains(&done), "{name}: {done}, not {least} to {most}");
        let stored: u64 = one.links.links.iter().map(|link| u64::from(link.work())).sum();
        assert!(0 < stored && stored <= done, "{name}: {stored} of {done} for links that are left");
        let without = solved(rough(strategy), Record::Nothing, 2);
        assert!(without.work.is_empty() && without.links.links == one.links.links, "{name}");
    }
}
