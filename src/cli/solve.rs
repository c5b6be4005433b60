//! `solve`: from a scene file to a solution file, and the statistics of the run.

use super::config::KeepConfig;
use super::console;
use super::errors::CliError;
use super::solved::{Loaded, Solved, add_display, in_pool};
use crate::export::write_solution;
use crate::image::write::check_destination;
use crate::memory;
use crate::progress::Progress;
use crate::report::{json, table};

/// Solves as configured.
///
/// # Errors
/// The first thing that goes wrong; then no output has been touched, except that the solution stays
/// when writing the statistics fails after it.
pub(super) fn run(config: &KeepConfig) -> Result<(), CliError> {
    for path in &config.run.outputs {
        check_destination(path)?;
    }
    in_pool(&config.run, |progress| run_in_pool(config, progress))
}

fn run_in_pool(config: &KeepConfig, progress: &dyn Progress) -> Result<(), CliError> {
    let Solved { scene, hierarchy, tracer, mut solution, quality, origin, mut stats, clock } =
        Loaded::load(&config.run, progress)?.solve(&config.run, progress)?;
    if config.local_pass {
        stats.local_pass = add_display(&mut solution, &hierarchy, tracer.as_ref(), quality, progress);
    }
    let origin = origin.at(&config.output, &config.run.scene);
    write_solution(&config.output, &hierarchy, scene.meters_per_unit, &solution, &origin)?;
    stats.seconds.total = clock.total();
    stats.memory.peak_rss_bytes = memory::peak_rss_bytes();
    if !config.run.quiet {
        console::note(&table::table(&[(scene.name.as_str(), &stats)]));
    }
    if let Some(path) = &config.stats {
        json::write_json(path, &stats)?;
    }
    Ok(())
}
