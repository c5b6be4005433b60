//! `check`: from a scene file to a solution, and whether that is physically right.

use super::args::QualityArg;
use super::config::CheckConfig;
use super::console;
use super::errors::CliError;
use super::solved::{Loaded, Solved, in_pool};
use crate::check::{Limits, Verdict, check};
use crate::export::Quality;
use crate::image::write::check_destination;
use crate::progress::Progress;
use crate::report::check::CheckReport;

/// Checks as configured; the table goes to standard output.
///
/// # Errors
/// The first thing that goes wrong; when a check fails, after table and file have been written.
pub(super) fn run(config: &CheckConfig) -> Result<(), CliError> {
    if let Some(path) = &config.json {
        check_destination(path)?;
    }
    in_pool(&config.run, |progress| run_in_pool(config, progress))
}

fn run_in_pool(config: &CheckConfig, progress: &dyn Progress) -> Result<(), CliError> {
    let Solved { scene, hierarchy, tracer, solution, quality, .. } =
        Loaded::load(&config.run, progress)?.solve(&config.run, progress)?;
    let limits = match quality {
        QualityArg::Draft => Limits::DRAFT,
        QualityArg::Normal => Limits::NORMAL,
        QualityArg::High => Limits::HIGH,
    };
    let found = check(&hierarchy, tracer.as_ref(), &solution, &limits, progress);
    let report = CheckReport {
        scene: &scene.name,
        quality: Quality::from(quality).name(),
        tracer: tracer.name(),
        passed: found.passed(),
        check: &found,
    };
    if !config.run.quiet {
        console::answer(&report.table())?;
    }
    if let Some(path) = &config.json {
        report.write(path)?;
    }
    if report.passed {
        return Ok(());
    }
    let failed = found.findings.iter().filter(|finding| finding.verdict == Verdict::Failed);
    let named: Vec<String> = failed.map(|finding| format!("{} ({})", finding.name, finding.group)).collect();
    Err(CliError::CheckFailed(format!("{}: the check failed: {}", scene.name, named.join(", "))))
}
