//! Strategies and tracers side by side: where visibility time goes, and how wrong the result is.

use super::detail::{OTHER, RunDetail};
use super::look::Look;
use super::setup::Setup;
use super::text::counted;
use crate::probe::Deviation;
use crate::radiosity::VisibilityError;
use serde::Serialize;

mod table;
mod words;

/// All runs over one scene.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Profile {
    /// Version of the record, [`Profile::FORMAT`].
    pub format: u32,
    /// What the runs were made with.
    pub setup: Setup,
    /// The scene's name.
    pub scene: String,
    /// Triangles in the input.
    pub triangles: u64,
    /// Worker threads.
    pub threads: usize,
    /// How often each run is made; times are medians.
    pub repeats: u32,
    /// In the order in which they were made.
    pub runs: Vec<ProfiledRun>,
    /// How many were still to be made, repeats among them; 0 when all have been.
    pub runs_to_come: u64,
    /// Index of the aim, a run of the first strategy and tracer: its errors are those that others have to reach. 0 before
    /// it has been made.
    pub aim: usize,
    /// Index of the run that ratios of time are to: `sampled` with 16 rays, or else the first.
    pub yardstick: usize,
}

/// One strategy with one tracer and one number of rays.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ProfiledRun {
    /// As `--visibility`.
    pub strategy: String,
    /// As `--tracer`; `none` for `all`, which asks none about visibility.
    pub tracer: String,
    /// As `--rays`.
    pub rays: u32,
    /// Seconds in visibility, summed over threads.
    pub visibility_seconds: Spread,
    /// Wall-clock seconds of refinement and iteration.
    pub total_seconds: Spread,
    /// Rays cast.
    pub rays_cast: u64,
    /// Rays not cast because something else decided.
    pub rays_avoided: u64,
    /// Pairs tested, not inherited.
    pub pairs_tested: u64,
    /// Shafts built.
    pub shafts_built: u64,
    /// Links stored.
    pub links: u64,
    /// Of all pairs that refinement ended at, stored or not, the share whose class is proved.
    pub certified_share: f64,
    /// How far resident memory was during the run, at most of the repeats, above that before it, bytes.
    pub solving_bytes: u64,
    /// What the tracer keeps besides the mesh, bytes.
    pub tracer_bytes: u64,
    /// What links and elements take, bytes.
    pub solution_bytes: u64,
    /// Visibility of links against many rays.
    pub visibility_error: VisibilityError,
    /// Irradiance against the reference, if there is one.
    pub irradiance_error: Option<Deviation>,
    /// Where the work went, in the repeat whose time in visibility is in the middle.
    pub detail: RunDetail,
}

/// The median of some measurements, and how far they spread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Smallest.
    pub min: f64,
    /// In the middle; the mean of the two in the middle.
    pub median: f64,
    /// Largest.
    pub max: f64,
}

impl Spread {
    /// Of some measurements; all 0 of none.
    pub fn of(mut all: Vec<f64>) -> Spread {
        all.sort_by(f64::total_cmp);
        let (Some(&min), Some(&max)) = (all.first(), all.last()) else { return Spread::default() };
        let median = 0.5 * (all[(all.len() - 1) / 2] + all[all.len() / 2]);
        Spread { min, median, max }
    }

    /// Half the way from the smallest to the largest, over the median.
    pub(super) fn relative(&self) -> f64 {
        0.5 * (self.max - self.min) / self.median.max(f64::MIN_POSITIVE)
    }
}

/// What the ratios are to, when it is among the runs: classic radiosity with this many rays.
const YARDSTICK_RAYS: u32 = 16;

/// The tracer of runs that ask none about visibility.
pub const NO_TRACER: &str = "none";

/// An error that runs are compared at.
type Error = (&'static str, fn(&ProfiledRun) -> Option<f64>);

/// Errors that differ by no more than this part of the aim's are the same: tracers round differently.
const SAME: f64 = 1e-3;

const ERRORS: [Error; 2] = [
    ("visibility error", |run| Some(run.visibility_error.mean).filter(|_| run.has_light())),
    ("irradiance error", |run| run.irradiance_error.map(|error| error.rms)),
];

impl ProfiledRun {
    /// Such as `adaptive, embree`, and `all`.
    pub fn kind(&self) -> String {
        match self.tracer.as_str() {
            NO_TRACER => self.strategy.clone(),
            tracer => format!("{}, {tracer}", self.strategy),
        }
    }

    /// Whether any light came over links: a run that lost all of it is quick, and no link is wrong.
    pub(super) fn has_light(&self) -> bool {
        self.links > 0
    }

    /// What the run needs besides the scene: its tracer, and what it took while it ran; bytes.
    pub(super) fn memory_bytes(&self) -> u64 {
        self.tracer_bytes + self.solving_bytes
    }

    /// Such as `adaptive, embree, 16 rays`.
    pub fn name(&self) -> String {
        format!("{}, {}", self.kind(), counted(self.rays.into(), "ray"))
    }
}

/// Runs at one error: what others need to be as exact as the aim.
pub(super) struct AtEqualError {
    /// The error.
    what: &'static str,
    /// How large it is in the aim.
    wanted: f64,
    /// Name of the aim.
    aim: String,
    /// Each other strategy and tracer, and what it needs.
    pub(super) others: Vec<String>,
}

impl AtEqualError {
    /// What the lines of the others are about.
    pub(super) fn words(&self) -> String {
        format!(
            "The aim is the {} of {} ({:.3} %). The cheapest runs that reach it:",
            self.what,
            self.aim,
            100.0 * self.wanted
        )
    }
}

impl Profile {
    /// Version of the record; another one where a field has another meaning or is gone.
    pub const FORMAT: u32 = 3;

    /// Finds the runs that others are compared with among those that have been made; `aim` is the index of the aim when
    /// all have.
    pub fn refer(&mut self, aim: usize, runs_to_come: u64) {
        let is_yardstick =
            |run: &ProfiledRun| run.strategy == "sampled" && run.rays == YARDSTICK_RAYS && run.has_light();
        let find = |wanted: &dyn Fn(&ProfiledRun) -> bool| self.runs.iter().position(wanted);
        self.yardstick = find(&is_yardstick).or_else(|| find(&ProfiledRun::has_light)).unwrap_or(0);
        self.aim = if aim < self.runs.len() { aim } else { 0 };
        self.runs_to_come = runs_to_come;
    }

    /// Strategies with tracers, in the order in which runs have them, and how each looks in plots and legends: strategies
    /// differ in colour, and what was asked of a second tracer is hollow.
    pub(super) fn kinds(&self) -> Vec<(String, Look)> {
        let index = |names: &mut Vec<String>, name: &str| {
            names.iter().position(|known| known == name).unwrap_or_else(|| {
                names.push(name.to_owned());
                names.len() - 1
            })
        };
        let (mut strategies, mut tracers) = (Vec::new(), Vec::new());
        let mut kinds: Vec<(String, Look)> = Vec::new();
        for run in &self.runs {
            let look = Look::filled(index(&mut strategies, &run.strategy));
            let is_hollow = run.tracer != NO_TRACER && index(&mut tracers, &run.tracer) > 0;
            if !kinds.iter().any(|(name, _)| *name == run.kind()) {
                kinds.push((run.kind(), Look { is_hollow, ..look }));
            }
        }
        kinds
    }

    /// Seconds in visibility over those of the yardstick.
    pub(super) fn ratio(&self, run: &ProfiledRun) -> f64 {
        let yardstick = self.runs.get(self.yardstick).map_or(0.0, |run| run.visibility_seconds.median);
        run.visibility_seconds.median / yardstick.max(f64::MIN_POSITIVE)
    }

    /// Phases that any of the runs has, in the order in which they come up; `other` is the last.
    pub(super) fn phases(&self) -> Vec<&'static str> {
        let mut names: Vec<&str> = Vec::new();
        for phase in self.runs.iter().flat_map(|run| &run.detail.phases) {
            if !names.contains(&phase.name) {
                names.push(phase.name);
            }
        }
        names.sort_by_key(|&name| name == OTHER);
        names
    }

    /// For each other strategy and tracer, its cheapest run that is no further off than the aim, by each error.
    pub(super) fn at_equal_error(&self) -> Vec<AtEqualError> {
        let Some(aim) = self.runs.get(self.aim) else { return Vec::new() };
        let of = |&(what, error): &Error| {
            let wanted = error(aim)?;
            let others: Vec<String> = self
                .kinds()
                .into_iter()
                .skip(1)
                .map(|(kind, _)| {
                    let own = || self.runs.iter().filter(|run| run.kind() == kind);
                    let cheapest = own()
                        .filter(|run| error(run).is_some_and(|error| error <= wanted * (1.0 + SAME)))
                        .min_by(|a, b| a.visibility_seconds.median.total_cmp(&b.visibility_seconds.median));
                    let times = |of: fn(&ProfiledRun) -> Spread, run: &ProfiledRun| {
                        of(run).median / of(aim).median.max(f64::MIN_POSITIVE)
                    };
                    match cheapest {
                        Some(run) => format!(
                            "{}: {:.3} s in visibility, {:.2} times as long; {:.2} s in all, {:.2} times",
                            run.name(),
                            run.visibility_seconds.median,
                            times(|run| run.visibility_seconds, run),
                            run.total_seconds.median,
                            times(|run| run.total_seconds, run)
                        ),
                        None if own().all(|run| !run.has_light()) => format!("{kind}: without links"),
                        None => format!("{kind}: not reached"),
                    }
                })
                .collect();
            let found = AtEqualError { what, wanted, aim: aim.name(), others };
            Some(found).filter(|found| !found.others.is_empty())
        };
        ERRORS.iter().filter_map(of).collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::detail::Seconds;
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn spread_of_few_and_of_none() {
        assert_eq!(Spread::of(vec![3.0, 1.0]), Spread { min: 1.0, median: 2.0, max: 3.0 });
        assert_eq!(Spread::of(vec![5.0, 1.0, 2.0]), Spread { min: 1.0, median: 2.0, max: 5.0 });
        assert_eq!(Spread::of(Vec::new()), Spread::default());
    }

    pub(super) fn run(strategy: &str, rays: u32, seconds: f64, error: f64) -> ProfiledRun {
        ProfiledRun {
            strategy: strategy.to_owned(),
            tracer: "embree".to_owned(),
            rays,
            links: 1,
            visibility_seconds: Spread::of(vec![seconds]),
            total_seconds: Spread::of(vec![2.0 * seconds]),
            visibility_error: VisibilityError { mean: error, ..VisibilityError::default() },
            ..ProfiledRun::default()
        }
    }

    #[test]
    fn the_cheapest_run_that_is_good_enough_is_compared() {
        let runs = vec![
            run("adaptive", 16, 1.0, 0.02),
            run("root", 4, 0.5, 0.05),
            run("root", 64, 3.0, 0.02 + 1e-9),
            run("root", 256, 9.0, 0.01),
            run("sampled", 16, 10.0, 0.03),
        ];
        let table = Profile { runs, yardstick: 4, ..Profile::default() }.table();
        assert!(
            table.contains(
                "root, embree, 64 rays: 3.000 s in visibility, 3.00 times as long; 6.00 s in all, 3.00 times"
            ),
            "{table}"
        );
        assert!(table.contains("sampled, embree: not reached"), "{table}");
        let adaptive = table.lines().find(|line| line.starts_with("adaptive")).expect("a row");
        assert!(adaptive.contains(" 0.100 "), "{adaptive}");
        assert!(!table.contains("irradiance error"), "{table}");
        let aim = table.find("The aim is the visibility error of adaptive, embree, 16 rays (2.000 %)");
        assert!(
            aim.is_some() && table.contains("yardstick of the ratios: sampled, embree, 16 rays"),
            "{table}"
        );
    }

    #[test]
    fn the_spread_of_one_measurement_is_left_away() {
        let table = |repeats| {
            let runs = vec![run("adaptive", 1, 1.0, 0.02)];
            Profile { runs, repeats, threads: 1, triangles: 1, ..Profile::default() }.table()
        };
        assert!(table(2).contains("±%") && !table(1).contains('±'), "{}", table(1));
        assert!(table(1).contains("1 triangle, 1 thread, made once; "), "{}", table(1));
        assert!(!table(1).contains("The aim"), "there is nothing else: {}", table(1));
    }

    #[test]
    fn no_two_kinds_look_alike() {
        use crate::visibility::Strategy::{Adaptive, All, Root, Sampled, Shaft};
        for tracers in [&["embree", "fallback"][..], &["fallback", "embree"], &["fallback"]] {
            let mut runs = Vec::new();
            for (which, &tracer) in tracers.iter().enumerate() {
                for strategy in [All, Root, Shaft, Adaptive, Sampled] {
                    let of = |tracer: &str| ProfiledRun {
                        tracer: tracer.to_owned(),
                        ..run(strategy.name(), 4, 1.0, 0.1)
                    };
                    match (strategy, which) {
                        (All, 0) => runs.push(of(NO_TRACER)),
                        (All, _) => {}
                        _ => runs.push(of(tracer)),
                    }
                }
            }
            let kinds = Profile { runs, ..Profile::default() }.kinds();
            let looks: HashSet<Look> = kinds.iter().map(|&(_, look)| look).collect();
            assert_eq!((kinds.len(), looks.len()), (1 + 4 * tracers.len(), kinds.len()), "{kinds:?}");
        }
    }

    #[test]
    fn phases_are_those_of_all_runs_and_the_rest_is_last() {
        let with = |names: &[&'static str]| {
            let phases = names.iter().map(|&name| Seconds { name, seconds: 1.0 }).collect();
            ProfiledRun { detail: RunDetail { phases, ..RunDetail::default() }, ..ProfiledRun::default() }
        };
        let runs = vec![with(&["refine", "other"]), with(&["refine", "weigh", "other"])];
        assert_eq!(Profile { runs, ..Profile::default() }.phases(), ["refine", "weigh", "other"]);
    }
}
