//! A profile as tables for people; errors in per cent.

use super::super::detail::{RunDetail, Seconds};
use super::super::text::{aligned, counted, times};
use super::{Profile, ProfiledRun};
use crate::visibility::Step;

/// A column: its head, and what stands in it.
type Column = (&'static str, fn(&Profile, &ProfiledRun) -> String);

/// What names a run.
const NAMES: [Column; 3] = [
    ("strategy", |_, run| run.strategy.clone()),
    ("tracer", |_, run| run.tracer.clone()),
    ("rays", |_, run| run.rays.to_string()),
];

const SECONDS: [Column; 2] = [
    ("links", |_, run| run.links.to_string()),
    ("visibility (s)", |_, run| format!("{:.3}", run.visibility_seconds.median)),
];

/// Where there are several measurements.
const SPREAD: Column = ("±%", |_, run| format!("{:.0}", 100.0 * run.visibility_seconds.relative()));

const FIGURES: [Column; 8] = [
    ("ratio", |found, run| format!("{:.3}", found.ratio(run))),
    ("total (s)", |_, run| format!("{:.2}", run.total_seconds.median)),
    ("rays (M)", |_, run| format!("{:.2}", run.rays_cast as f64 * 1e-6)),
    ("avoided (M)", |_, run| format!("{:.2}", run.rays_avoided as f64 * 1e-6)),
    ("proved (%)", |_, run| format!("{:.1}", 100.0 * run.certified_share)),
    ("memory (MB)", |_, run| (run.memory_bytes() >> 20).to_string()),
    ("V error (%)", |_, run| run.told(format!("{:.3}", 100.0 * run.visibility_error.mean))),
    ("V 99.9 (%)", |_, run| run.told(format!("{:.2}", 100.0 * run.visibility_error.percentile_999))),
];

/// Where there is a reference.
const IRRADIANCE: Column = ("E error (%)", |_, run| {
    run.irradiance_error.map_or_else(String::new, |error| format!("{:.2}", 100.0 * error.rms))
});

impl ProfiledRun {
    /// An error, or that there are no links which could have one.
    fn told(&self, error: String) -> String {
        if self.has_light() { error } else { "no links".to_owned() }
    }
}

impl Profile {
    /// All of it.
    pub fn table(&self) -> String {
        let (Some(yardstick), Some(aim)) = (self.runs.get(self.yardstick), self.runs.get(self.aim)) else {
            return String::new();
        };
        let mut text = format!(
            "{}: {}, {}, made {}; yardstick of the ratios: {}\n",
            self.scene,
            counted(self.triangles, "triangle"),
            counted(self.threads as u64, "thread"),
            times(self.repeats),
            yardstick.name()
        );
        self.headline().iter().for_each(|words| text += &format!("{words}\n"));
        let spread = (self.repeats > 1).then_some(SPREAD);
        let irradiance = aim.irradiance_error.is_some().then_some(IRRADIANCE);
        let columns: Vec<Column> =
            NAMES.into_iter().chain(SECONDS).chain(spread).chain(FIGURES).chain(irradiance).collect();
        text += &self.rows(&columns);
        for found in self.at_equal_error() {
            text += &format!("\n{}\n", found.words());
            found.others.iter().for_each(|other| text += &format!("  {other}\n"));
        }
        text += "\nSeconds in visibility by step, summed over threads\n";
        text += &self.seconds(&Step::ALL.map(Step::name), |detail| &detail.steps);
        text += "\nSeconds by phase, wall clock\n";
        text += &self.seconds(&self.phases(), |detail| &detail.phases);
        text + &format!("\nPairs of {}, by what settled them\n{}", aim.name(), aim.detail.text())
    }

    /// A row for each run.
    fn rows(&self, columns: &[Column]) -> String {
        let heads: Vec<String> = columns.iter().map(|(head, _)| (*head).to_owned()).collect();
        let row = |run: &ProfiledRun| columns.iter().map(|(_, cell)| cell(self, run)).collect();
        aligned(&heads, &self.runs.iter().map(row).collect::<Vec<Vec<String>>>())
    }

    /// A row for each run, a column for each part of its time.
    fn seconds(&self, parts: &[&str], list: fn(&RunDetail) -> &[Seconds]) -> String {
        let heads: Vec<String> =
            NAMES.iter().map(|(head, _)| head).chain(parts).map(|head| (*head).to_owned()).collect();
        let row = |run: &ProfiledRun| {
            let of = |name: &&str| {
                let seconds = list(&run.detail).iter().find(|part| part.name == *name);
                format!("{:.3}", seconds.map_or(0.0, |part| part.seconds))
            };
            NAMES.iter().map(|(_, cell)| cell(self, run)).chain(parts.iter().map(of)).collect()
        };
        aligned(&heads, &self.runs.iter().map(row).collect::<Vec<Vec<String>>>())
    }
}
