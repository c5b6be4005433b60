//! Where the work of one run goes: phases, steps of visibility tests, what settled pairs, their sizes, histograms.
//! `docs/profile.md` explains every field.

use std::time::Duration;

use serde::Serialize;

use super::text::aligned;
use crate::progress::Span;
use crate::visibility::{Answer, Bin, Detail, Effort, Step, StepTimes, VisibilityCounters};

/// What is in no phase.
pub(super) const OTHER: &str = "other";

/// One run, told in detail.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RunDetail {
    /// Wall-clock seconds by phase, in the order in which they first came up; `other` is what is left.
    pub phases: Vec<Seconds>,
    /// Seconds in visibility tests by step, summed over threads.
    pub steps: Vec<Seconds>,
    /// Pairs that refinement came to, by what settled them.
    pub answers: Vec<AnswerRow>,
    /// The same pairs by the size of the larger node, from large to small.
    pub levels: Vec<LevelRow>,
    /// Rays of pairs tested.
    pub rays_per_pair: Vec<Bin>,
    /// Facets left in shafts.
    pub candidates_per_shaft: Vec<Bin>,
    /// Calls of the candidate filter for pairs tested.
    pub filter_calls_per_pair: Vec<Bin>,
    /// Calls of the candidate filter in all.
    pub filter_calls: u64,
    /// Hits it rejected.
    pub filter_rejects: u64,
}

/// How long something took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Seconds {
    /// What.
    pub name: &'static str,
    /// Seconds.
    pub seconds: f64,
}

/// Pairs that one thing settled.
#[derive(Clone, Debug, Serialize)]
pub struct AnswerRow {
    /// What settled them.
    pub name: &'static str,
    /// `visible`, `invisible`, `partial`, or `untested`.
    pub class: &'static str,
    /// How many.
    pub pairs: u64,
    /// Rays cast for them.
    pub rays: u64,
    /// Seconds in their tests, summed over threads.
    pub seconds: f64,
}

/// Pairs of one size.
#[derive(Clone, Debug, Serialize)]
pub struct LevelRow {
    /// Their larger node is smaller than the scene by this many halves, rounded down.
    pub level: usize,
    /// Radius of the larger node, at most, scene units.
    pub radius: f64,
    /// Pairs, but for those that face away from each other.
    pub pairs: u64,
    /// Of those: the source is dark.
    pub dark: u64,
    /// Of those: inherited.
    pub inherited: u64,
    /// Of those: tested and visible.
    pub visible: u64,
    /// Of those: tested and invisible.
    pub invisible: u64,
    /// Of those: tested and partial.
    pub partial: u64,
    /// Rays cast, also for weighing links again.
    pub rays: u64,
    /// Seconds in visibility tests, also for weighing links again, summed over threads.
    pub seconds: f64,
}

fn seconds(nanoseconds: u64) -> f64 {
    nanoseconds as f64 * 1e-9
}

impl RunDetail {
    /// From what a run kept. `radius` is that of the scene, in scene units; `phases` are those of the run, which took
    /// `total`.
    pub fn new(
        detail: &Detail,
        counters: &VisibilityCounters,
        radius: f64,
        phases: &[Span],
        total: Duration,
    ) -> RunDetail {
        let levels =
            detail.levels.iter().enumerate().map(|(level, efforts)| LevelRow::of(level, radius, efforts));
        RunDetail {
            phases: by_phase(phases, total),
            steps: by_step(&detail.steps, seconds(counters.nanoseconds)),
            answers: Answer::ALL.map(|answer| AnswerRow::of(answer, detail)).into(),
            levels: levels.filter(|row| row.pairs > 0 || row.rays > 0).collect(),
            rays_per_pair: detail.rays.bins(),
            candidates_per_shaft: detail.candidates.bins(),
            filter_calls_per_pair: detail.filter_calls.bins(),
            filter_calls: counters.filter_calls,
            filter_rejects: counters.filter_rejects,
        }
    }

    /// Of some repeats of one run, the one whose time in visibility tests is in the middle, the less of two; with the
    /// shares that steps have in all of them, and those that rows have in the middle of them. Nothing of none.
    pub fn of_repeats(mut repeats: Vec<RunDetail>, times: &StepTimes) -> Option<RunDetail> {
        repeats.sort_by(|a, b| a.tested().total_cmp(&b.tested()));
        let middle = repeats.len().checked_sub(1)? / 2;
        let answers = by_middle(&repeats, |detail| detail.answers.iter().map(|row| row.seconds).collect());
        let levels = by_middle(&repeats, |detail| detail.levels.iter().map(|row| row.seconds).collect());
        let mut median = repeats.swap_remove(middle);
        median.steps = by_step(times, median.tested());
        median.answers.iter_mut().zip(answers).for_each(|(row, seconds)| row.seconds = seconds);
        median.levels.iter_mut().zip(levels).for_each(|(row, seconds)| row.seconds = seconds);
        Some(median)
    }

    /// The step that takes the most time, and its share; none where nothing was timed.
    pub(super) fn largest_step(&self) -> Option<(&'static str, f64)> {
        let all: f64 = self.steps.iter().map(|step| step.seconds).sum();
        let most = self.steps.iter().max_by(|a, b| a.seconds.total_cmp(&b.seconds))?;
        (all > 0.0).then_some((most.name, most.seconds / all))
    }

    /// Seconds in visibility tests.
    fn tested(&self) -> f64 {
        self.answers.iter().map(|row| row.seconds).sum()
    }

    /// For people: what settled pairs, their sizes, histograms.
    pub(super) fn text(&self) -> String {
        let tested = self.tested();
        let share = |part: f64| format!("{:.1}", 100.0 * part / tested.max(f64::MIN_POSITIVE));
        let millions = |count: u64| format!("{:.3}", count as f64 * 1e-6);
        let heads = ["class", "settled by", "pairs", "rays (M)", "rays/pair", "µs/pair", "visibility (%)"];
        let rows: Vec<_> = self
            .answers
            .iter()
            .filter(|row| row.pairs > 0)
            .map(|row| {
                let per_pair = |amount: f64| format!("{:.2}", amount / row.pairs as f64);
                [
                    row.class.to_owned(),
                    row.name.to_owned(),
                    row.pairs.to_string(),
                    millions(row.rays),
                    per_pair(row.rays as f64),
                    per_pair(row.seconds * 1e6),
                    share(row.seconds),
                ]
            })
            .collect();
        let mut text = aligned(&heads.map(str::to_owned), &rows);

        text += "\nPairs by size: radius of the larger node, in scene units\n";
        let heads = [
            "level",
            "radius",
            "pairs",
            "dark",
            "inherited",
            "visible",
            "invisible",
            "partial",
            "rays (M)",
            "visibility (%)",
        ];
        let rows: Vec<_> = self
            .levels
            .iter()
            .map(|row| {
                [
                    row.level.to_string(),
                    format!("{:.3}", row.radius),
                    row.pairs.to_string(),
                    row.dark.to_string(),
                    row.inherited.to_string(),
                    row.visible.to_string(),
                    row.invisible.to_string(),
                    row.partial.to_string(),
                    millions(row.rays),
                    share(row.seconds),
                ]
            })
            .collect();
        text += &aligned(&heads.map(str::to_owned), &rows);

        for (what, bins) in [
            ("Pairs tested by their rays", &self.rays_per_pair),
            ("Shafts by the facets left in them", &self.candidates_per_shaft),
            ("Pairs tested by calls of the candidate filter", &self.filter_calls_per_pair),
        ] {
            if !bins.is_empty() {
                text += &format!("\n{what}\n{}", bars(bins));
            }
        }
        let filtered = 100.0 * self.rejected();
        text + &format!("The filter was called {} times and rejected {filtered:.1} %.\n", self.filter_calls)
    }

    /// Share of the calls of the filter in which it rejected the hit.
    pub(super) fn rejected(&self) -> f64 {
        self.filter_rejects as f64 / (self.filter_calls as f64).max(1.0)
    }
}

/// Seconds of each row of a table, each from the repeat in which it is in the middle, and all together as much as in the
/// repeat in the middle: what another program interrupts takes long in one repeat, and in other rows than in the next. What
/// is counted is the same in all repeats, so there are the same rows.
fn by_middle(repeats: &[RunDetail], rows: fn(&RunDetail) -> Vec<f64>) -> Vec<f64> {
    let middle = (repeats.len() - 1) / 2;
    let lists: Vec<Vec<f64>> = repeats.iter().map(rows).collect();
    let of_row = |row: usize| {
        let mut values: Vec<f64> = lists.iter().filter_map(|list| list.get(row).copied()).collect();
        values.sort_by(f64::total_cmp);
        values.get(middle).copied().unwrap_or(0.0)
    };
    let middles: Vec<f64> = (0..lists[middle].len()).map(of_row).collect();
    let [all, told] = [&lists[middle], &middles].map(|list| list.iter().sum::<f64>());
    let scale = if told > 0.0 { all / told } else { 1.0 };
    middles.into_iter().map(|seconds| seconds * scale).collect()
}

/// Seconds of each step, `total` in all: the tests that were timed stand for all of them.
fn by_step(times: &StepTimes, total: f64) -> Vec<Seconds> {
    let shares = times.shares();
    Step::ALL.map(|step| Seconds { name: step.name(), seconds: total * shares[step as usize] }).into()
}

/// Seconds of each phase, and what is left of `total`.
fn by_phase(phases: &[Span], total: Duration) -> Vec<Seconds> {
    let mut sums: Vec<Seconds> = Vec::new();
    for phase in phases {
        let seconds = phase.length().as_secs_f64();
        match sums.iter_mut().find(|sum| sum.name == phase.name) {
            Some(sum) => sum.seconds += seconds,
            None => sums.push(Seconds { name: phase.name, seconds }),
        }
    }
    let known: f64 = sums.iter().map(|sum| sum.seconds).sum();
    sums.push(Seconds { name: OTHER, seconds: (total.as_secs_f64() - known).max(0.0) });
    sums
}

/// A line for each bin, with a bar as long as its share.
fn bars(bins: &[Bin]) -> String {
    const LONGEST: f64 = 40.0;
    let total = bins.iter().map(|bin| bin.count).sum::<u64>() as f64;
    let most = bins.iter().map(|bin| bin.count).max().unwrap_or(0) as f64;
    let rows: Vec<[String; 4]> = bins
        .iter()
        .map(|bin| {
            let range =
                if bin.from == bin.to { bin.to.to_string() } else { format!("{} to {}", bin.from, bin.to) };
            let length = (LONGEST * bin.count as f64 / most).round() as usize;
            let share = format!("{:.1} %", 100.0 * bin.count as f64 / total);
            [range, bin.count.to_string(), share, "#".repeat(length)]
        })
        .collect();
    aligned(&Default::default(), &rows).trim_start_matches('\n').to_owned()
}

impl AnswerRow {
    fn of(answer: Answer, detail: &Detail) -> AnswerRow {
        let effort = detail.answers[answer as usize];
        AnswerRow {
            name: answer.name(),
            class: answer.class(),
            pairs: effort.pairs,
            rays: effort.rays,
            seconds: seconds(effort.nanoseconds),
        }
    }
}

impl LevelRow {
    fn of(level: usize, radius: f64, efforts: &[Effort]) -> LevelRow {
        let pairs =
            |answers: &[Answer]| answers.iter().map(|&answer| efforts[answer as usize].pairs).sum::<u64>();
        let [dark, inherited] = [Answer::Dark, Answer::Inherited].map(|answer| pairs(&[answer]));
        let visible = pairs(&[Answer::EmptyShaft, Answer::RaysClear]);
        let invisible = pairs(&[Answer::SingleBlocker, Answer::FusedBlockers, Answer::RaysBlocked]);
        let partial = pairs(&[Answer::RaysDisagree]);
        LevelRow {
            level,
            radius: radius / (1u64 << level) as f64,
            pairs: dark + inherited + visible + invisible + partial,
            dark,
            inherited,
            visible,
            invisible,
            partial,
            rays: efforts.iter().map(|effort| effort.rays).sum(),
            seconds: seconds(efforts.iter().map(|effort| effort.nanoseconds).sum()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::profile::{Profile, ProfiledRun};
    use super::*;
    use serde_json::Value;

    fn sample() -> RunDetail {
        let mut detail = Detail::default();
        detail.levels[2][Answer::RaysClear as usize] = Effort { pairs: 3, rays: 48, nanoseconds: 9_000 };
        detail.answers[Answer::RaysClear as usize] = detail.levels[2][Answer::RaysClear as usize];
        let phase = |name, start, end| Span {
            name,
            start: Duration::from_secs(start),
            end: Duration::from_secs(end),
        };
        let phases = [phase("refine", 1, 3), phase("gather", 3, 4), phase("refine", 4, 9)];
        let counters = VisibilityCounters { filter_calls: 4, filter_rejects: 1, ..Default::default() };
        RunDetail {
            rays_per_pair: vec![Bin { from: 16, to: 31, count: 3 }, Bin { from: 32, to: 63, count: 1 }],
            ..RunDetail::new(&detail, &counters, 8.0, &phases, Duration::from_secs(10))
        }
    }

    #[test]
    fn phases_are_summed_and_the_rest_is_other() {
        let seconds = |name, seconds| Seconds { name, seconds };
        assert_eq!(sample().phases, [seconds("refine", 7.0), seconds("gather", 1.0), seconds("other", 2.0)]);
    }

    #[test]
    fn the_repeat_in_the_middle_stands_for_all() {
        let of = |nanoseconds| {
            let mut detail = Detail::default();
            detail.answers[Answer::RaysClear as usize] = Effort { pairs: 1, rays: 1, nanoseconds };
            RunDetail::new(&detail, &VisibilityCounters::default(), 1.0, &[], Duration::ZERO)
        };
        let chosen = |all: &[u64]| {
            let repeats = all.iter().copied().map(of).collect();
            RunDetail::of_repeats(repeats, &StepTimes::default()).map(|detail| detail.tested())
        };
        assert_eq!(chosen(&[9_000, 1_000, 3_000]), Some(seconds(3_000)));
        assert_eq!(chosen(&[9_000, 3_000]), Some(seconds(3_000)));
        assert_eq!(chosen(&[]), None);
    }

    /// Of three repeats each was interrupted once, in another row: 40 ms where 1 to 3 ms are usual.
    #[test]
    fn a_test_that_is_interrupted_does_not_decide_what_a_row_takes() {
        let of = |[clear, blocked, disagree]: [u64; 3]| {
            let mut detail = Detail::default();
            for (answer, nanoseconds) in
                [(Answer::RaysClear, clear), (Answer::RaysBlocked, blocked), (Answer::RaysDisagree, disagree)]
            {
                detail.answers[answer as usize] = Effort { pairs: 1, rays: 1, nanoseconds };
                detail.levels[3][answer as usize] = detail.answers[answer as usize];
            }
            RunDetail::new(&detail, &VisibilityCounters::default(), 1.0, &[], Duration::ZERO)
        };
        let ms = |x: u64| x * 1_000_000;
        let repeats = [[ms(40), ms(2), ms(3)], [ms(1), ms(41), ms(3)], [ms(1), ms(2), ms(42)]].map(of).into();
        let found = RunDetail::of_repeats(repeats, &StepTimes::default()).expect("three repeats");
        let rows: Vec<f64> = found.answers.iter().map(|row| row.seconds).filter(|&s| s > 0.0).collect();
        let all: f64 = rows.iter().sum();
        let shares: Vec<f64> = rows.iter().map(|seconds| 6.0 * seconds / all).collect();
        assert!((all - 0.045).abs() < 1e-9, "the repeat in the middle is told: {all}");
        assert!(shares.iter().zip([1.0, 2.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{shares:?}");
        assert!((found.levels.iter().map(|row| row.seconds).sum::<f64>() - all).abs() < 1e-9);
    }

    #[test]
    fn rows_say_what_settled_pairs_and_how_large_they_are() {
        let text = sample().text();
        let row = text.lines().find(|line| line.contains("rays clear")).expect("a row");
        assert_eq!(
            row.split_whitespace().collect::<Vec<_>>(),
            ["visible", "rays", "clear", "3", "0.000", "16.00", "3.00", "100.0"]
        );
        assert!(!text.contains("rays blocked"), "there are none: {text}");
        let level =
            text.lines().find(|line| line.split_whitespace().take(2).eq(["2", "2.000"])).expect("a row");
        assert_eq!(level.split_whitespace().nth(2), Some("3"), "{level}");
        assert!(
            text.lines().any(|line| line.contains("16 to 31") && line.ends_with(&"#".repeat(40))),
            "{text}"
        );
        assert!(text.contains("called 4 times and rejected 25.0 %"), "{text}");
    }

    /// Names of all fields, at any depth.
    fn names(value: &Value, found: &mut Vec<String>) {
        match value {
            Value::Object(fields) => fields.iter().for_each(|(name, inner)| {
                found.push(name.clone());
                names(inner, found);
            }),
            Value::Array(rows) => rows.iter().for_each(|row| names(row, found)),
            _ => {}
        }
    }

    #[test]
    fn every_field_of_the_record_is_explained() {
        let documented = include_str!("../../docs/profile.md");
        let run = ProfiledRun { detail: sample(), ..Default::default() };
        let profile = Profile { runs: vec![run], ..Default::default() };
        let mut found = Vec::new();
        names(&serde_json::to_value(profile).expect("serialisable"), &mut found);
        assert!(found.len() > 60, "the record has lost fields: {found:?}");
        for name in found {
            assert!(documented.contains(&format!("`{name}`")), "docs/profile.md does not explain {name}");
        }
        for name in Step::ALL.map(Step::name).into_iter().chain(Answer::ALL.map(Answer::name)) {
            assert!(documented.contains(&format!("| {name} |")), "docs/profile.md does not explain '{name}'");
        }
    }
}
