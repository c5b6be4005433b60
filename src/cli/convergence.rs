//! `convergence`: how the error against a reference falls as more work is put into the solution.

use super::config::ConvergenceConfig;
use super::console;
use super::errors::CliError;
use super::probe::{Target, compared, probe_all};
use super::solved::{Loaded, Solved, in_pool};
use crate::gather::Gatherer;
use crate::image::write::check_destination;
use crate::memory;
use crate::progress::Progress;
use crate::report::convergence::{Convergence, Rung};
use crate::report::{json, plot};

/// Solves at one setting after the other, as configured.
///
/// # Errors
/// The first thing that goes wrong; then no output has been touched, unless the second of two cannot be written.
pub(super) fn run(config: &ConvergenceConfig) -> Result<(), CliError> {
    for path in &config.run.outputs {
        check_destination(path)?;
    }
    in_pool(&config.run, |progress| run_in_pool(config, progress))
}

fn run_in_pool(config: &ConvergenceConfig, progress: &dyn Progress) -> Result<(), CliError> {
    let Target { points, reference } = Target::read(&config.points, &config.reference)?;
    let mut found = Convergence::default();
    for (index, solve) in config.settings.iter().enumerate() {
        let mut run = config.run.clone();
        run.solve = solve.clone();
        // What the first run warned of need not be said again.
        run.quiet |= index > 0;
        let Solved { scene, hierarchy, tracer, solution, stats, .. } =
            Loaded::load(&run, progress)?.solve(&run, progress)?;
        let gatherer = Gatherer::new(&hierarchy, tracer.as_ref(), &solution, config.samples);
        let comparison = compared(&probe_all(&gatherer, &points, progress), &reference);
        found.scene = scene.name;
        found.tracer = stats.tracer;
        found.points = points.len();
        found.rungs.push(Rung {
            epsilon: solve.epsilon,
            contrast: solve.contrast,
            resolution: solve.resolution,
            rays: solve.rays,
            elements: stats.scene.elements,
            links: stats.links.total,
            seconds: stats.seconds.refine + stats.seconds.solve,
            peak_rss_bytes: memory::peak_rss_bytes(),
            balance_error: stats.energy.balance_error,
            total: comparison.total,
            direct: comparison.direct,
        });
        if !config.run.quiet {
            console::note(&format!("{} of {} settings\n", index + 1, config.settings.len()));
        }
    }
    console::answer(&found.table())?;
    if let Some(path) = &config.output {
        json::write_json(path, &found)?;
    }
    if let Some(path) = &config.plot {
        plot::write_convergence(path, &found)?;
    }
    Ok(())
}
