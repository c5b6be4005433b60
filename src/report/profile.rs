//! Strategies and tracers side by side: where visibility time goes, and how wrong the result is.

use super::detail::{RunDetail, Seconds};
use super::text::aligned;
use crate::probe::Deviation;
use crate::radiosity::VisibilityError;
use crate::visibility::Step;
use serde::Serialize;

/// All runs over one scene.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Profile {
    /// The scene's name.
    pub scene: String,
    /// Triangles in the input.
    pub triangles: u64,
    /// Worker threads.
    pub threads: usize,
    /// How often each run was made; times are medians.
    pub repeats: u32,
    /// In the order in which they were made.
    pub runs: Vec<ProfiledRun>,
    /// Index of the run that the ratios are to: `sampled` with 16 rays, or else the first.
    pub yardstick: usize,
}

/// One strategy with one tracer and one number of rays.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ProfiledRun {
    /// As `--visibility`.
    pub strategy: String,
    /// As `--tracer`.
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
    /// Largest resident memory during the run, bytes.
    pub peak_rss_bytes: u64,
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

/// The phases of a solution, in order.
const PHASES: [&str; 7] = ["openness", "refine", "damping", "gather", "weigh", "stray light", "other"];

/// An error that runs are compared at.
type Error = (&'static str, fn(&ProfiledRun) -> Option<f64>);

const ERRORS: [Error; 2] = [
    ("visibility error", |run| Some(run.visibility_error.mean)),
    ("irradiance error", |run| run.irradiance_error.map(|error| error.rms)),
];

impl ProfiledRun {
    /// Such as `adaptive, embree`.
    pub fn kind(&self) -> String {
        format!("{}, {}", self.strategy, self.tracer)
    }

    /// Such as `adaptive, embree, 16 rays`.
    pub fn name(&self) -> String {
        format!("{}, {} rays", self.kind(), self.rays)
    }
}

impl Profile {
    /// Strategies with tracers, in the order in which runs have them: curves, colours and legends follow it.
    pub(super) fn kinds(&self) -> Vec<String> {
        let mut kinds: Vec<String> = Vec::new();
        for kind in self.runs.iter().map(ProfiledRun::kind) {
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        kinds
    }

    /// For people; errors in per cent.
    pub fn table(&self) -> String {
        let (Some(yardstick), Some(first)) = (self.runs.get(self.yardstick), self.runs.first()) else {
            return String::new();
        };
        let mut text = format!(
            "{}: {} triangles, {} threads, {} repeats; ratio to {}\n",
            self.scene,
            self.triangles,
            self.threads,
            self.repeats,
            yardstick.name()
        );
        text += "strategy  tracer    rays     links  visibility (s)    ±%   ratio  total (s)  rays (M)  avoided (M)  \
                 proved (%)  memory (MB)  V error (%)  V 99.9 (%)";
        text += if first.irradiance_error.is_some() { "  E error (%)\n" } else { "\n" };
        for run in &self.runs {
            let (seconds, total) = (&run.visibility_seconds, &run.total_seconds);
            text += &format!(
                "{:<8}  {:<8}  {:4}  {:8}  {:14.3}  {:4.0}  {:6.3}  {:9.2}  {:8.2}  {:11.2}  {:10.1}  {:11}  {:11.3}  {:10.2}",
                run.strategy,
                run.tracer,
                run.rays,
                run.links,
                seconds.median,
                100.0 * seconds.relative(),
                seconds.median / yardstick.visibility_seconds.median.max(f64::MIN_POSITIVE),
                total.median,
                run.rays_cast as f64 * 1e-6,
                run.rays_avoided as f64 * 1e-6,
                100.0 * run.certified_share,
                run.peak_rss_bytes >> 20,
                100.0 * run.visibility_error.mean,
                100.0 * run.visibility_error.percentile_999,
            );
            text += &run.irradiance_error.map_or_else(String::new, |e| format!("  {:11.2}", 100.0 * e.rms));
            text += "\n";
        }
        text += &self.at_equal_error(first);
        text += &self.where_time_goes();
        text + &format!("\nPairs of {}, by what settled them\n{}", first.name(), first.detail.text())
    }

    /// A row for each run: the steps of visibility tests, and the phases of the whole run.
    fn where_time_goes(&self) -> String {
        let of = |list: &[Seconds], name: &str| {
            let seconds = list.iter().find(|part| part.name == name).map_or(0.0, |part| part.seconds);
            format!("{seconds:.3}")
        };
        let kind = |run: &ProfiledRun| [run.strategy.clone(), run.tracer.clone(), run.rays.to_string()];
        let heads = |names: &[&'static str; 7]| {
            let all = [&["strategy", "tracer", "rays"][..], names].concat();
            std::array::from_fn::<String, 10, _>(|column| all[column].to_owned())
        };
        let table = |names: [&'static str; 7], list: fn(&RunDetail) -> &[Seconds]| {
            let row = |run: &ProfiledRun| {
                let cells = names.map(|name| of(list(&run.detail), name));
                let all = [&kind(run)[..], &cells[..]].concat();
                std::array::from_fn::<String, 10, _>(|column| all[column].clone())
            };
            aligned(&heads(&names), &self.runs.iter().map(row).collect::<Vec<_>>())
        };
        let steps = Step::ALL.map(Step::name);
        format!(
            "\nSeconds in visibility by step, summed over threads\n{}\nSeconds by phase, wall clock\n{}",
            table(steps, |detail| &detail.steps),
            table(PHASES, |detail| &detail.phases),
        )
    }

    /// For each other strategy and tracer, its cheapest run that is no further off than `aim`.
    fn at_equal_error(&self, aim: &ProfiledRun) -> String {
        let mut text = String::new();
        for (what, error) in ERRORS {
            let Some(wanted) = error(aim) else { continue };
            text += &format!("\nTo the {what} of {} ({:.3} %):\n", aim.name(), 100.0 * wanted);
            let mut seen = vec![(&aim.strategy, &aim.tracer)];
            for run in &self.runs {
                let kind = (&run.strategy, &run.tracer);
                if seen.contains(&kind) {
                    continue;
                }
                seen.push(kind);
                let reach = self.runs.iter().filter(|r| (&r.strategy, &r.tracer) == kind);
                let cheapest = reach
                    .filter(|r| error(r).is_some_and(|e| e <= wanted))
                    .min_by(|a, b| a.visibility_seconds.median.total_cmp(&b.visibility_seconds.median));
                text += &match cheapest {
                    Some(run) => format!(
                        "  {}: {:.3} s in visibility, {:.2} times as long\n",
                        run.name(),
                        run.visibility_seconds.median,
                        run.visibility_seconds.median / aim.visibility_seconds.median.max(f64::MIN_POSITIVE)
                    ),
                    None => format!("  {}, {}: not reached\n", run.strategy, run.tracer),
                };
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_of_few_and_of_none() {
        assert_eq!(Spread::of(vec![3.0, 1.0]), Spread { min: 1.0, median: 2.0, max: 3.0 });
        assert_eq!(Spread::of(vec![5.0, 1.0, 2.0]), Spread { min: 1.0, median: 2.0, max: 5.0 });
        assert_eq!(Spread::of(Vec::new()), Spread::default());
    }

    fn run(strategy: &str, rays: u32, seconds: f64, error: f64) -> ProfiledRun {
        ProfiledRun {
            strategy: strategy.to_owned(),
            tracer: "embree".to_owned(),
            rays,
            visibility_seconds: Spread { min: seconds, median: seconds, max: seconds },
            visibility_error: VisibilityError { mean: error, ..VisibilityError::default() },
            ..ProfiledRun::default()
        }
    }

    #[test]
    fn the_cheapest_run_that_is_good_enough_is_compared() {
        let runs = vec![
            run("adaptive", 16, 1.0, 0.02),
            run("root", 4, 0.5, 0.05),
            run("root", 64, 3.0, 0.02),
            run("root", 256, 9.0, 0.01),
            run("sampled", 16, 10.0, 0.03),
        ];
        let table = Profile { runs, yardstick: 4, ..Profile::default() }.table();
        assert!(
            table.contains("root, embree, 64 rays: 3.000 s in visibility, 3.00 times as long"),
            "{table}"
        );
        assert!(table.contains("sampled, embree: not reached"), "{table}");
        let adaptive = table.lines().find(|line| line.starts_with("adaptive")).expect("a row");
        assert!(adaptive.contains(" 0.100 "), "{adaptive}");
        assert!(!table.contains("irradiance error"), "{table}");
    }
}
