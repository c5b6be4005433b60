//! `probe`: irradiance at points of a scene, as a table.

use std::path::Path;

use rayon::prelude::*;

use super::config::{Places, ProbeConfig};
use super::console;
use super::errors::CliError;
use super::solved::{Loaded, Solved, in_pool};
use crate::gather::{Gatherer, Irradiance};
use crate::image::write::{FillError, check_destination, write_atomically};
use crate::memory;
use crate::probe::{
    Answer, Comparison, Deviation, Grid, ProbeError, ProbePoint, ProbeRun, Reference, check_points,
    grid_points, read_points, read_reference, write_csv,
};
use crate::progress::Progress;
use crate::report::json;
use crate::scene::Scene;

/// Probes as configured.
///
/// # Errors
/// The first thing that goes wrong; then no output has been touched.
pub(super) fn run(config: &ProbeConfig) -> Result<(), CliError> {
    if let Some(path) = &config.output {
        check_destination(path)?;
    }
    in_pool(&config.run, |progress| run_in_pool(config, progress))
}

fn run_in_pool(config: &ProbeConfig, progress: &dyn Progress) -> Result<(), CliError> {
    let reference = match &config.reference {
        Some(path) => Some(read_reference(path).map_err(probe_failure)?),
        None => None,
    };
    // A file is looked at before the scene, which may take long to load.
    let mut points = Vec::new();
    if let Places::File(path) = &config.places {
        points = read_points(path).map_err(probe_failure)?;
        if let (Some(file), Some(reference)) = (&config.reference, &reference) {
            check_points(file, reference, &points).map_err(probe_failure)?;
        }
    }
    let loaded = Loaded::load(&config.run, progress)?;
    if let Places::Grid(text, spacing) = &config.places {
        points = grid(&loaded.scene, text, *spacing)?;
    }
    let Solved { scene, hierarchy, tracer, solution, mut stats, mut clock, .. } =
        loaded.solve(&config.run, progress)?;
    stats.seconds.total = clock.total();

    let gatherer = Gatherer::new(&hierarchy, tracer.as_ref(), &solution, config.samples);
    let found = probe_all(&gatherer, &points, progress);
    let comparison = reference.map(|reference| compared(&found, &reference));
    // Only JSON has a place for it.
    let is_told = !(config.run.quiet && config.is_json);
    if let Some(comparison) = comparison.as_ref().filter(|_| is_told) {
        console::note(&described(comparison));
    }
    let run = ProbeRun {
        scene: scene.name,
        tracer: stats.tracer,
        samples: config.samples,
        seconds_solution: stats.seconds.total,
        seconds_points: clock.lap(),
        peak_rss_bytes: memory::peak_rss_bytes(),
        elements: stats.scene.elements,
        links: stats.links.total,
        balance_error: stats.energy.balance_error,
        reference: comparison,
        points: points.iter().zip(&found).map(|(point, light)| Answer::new(point, light)).collect(),
    };
    write(config, &run)
}

/// Gathers at all points, in order.
pub(super) fn probe_all(
    gatherer: &Gatherer<'_>,
    points: &[ProbePoint],
    progress: &dyn Progress,
) -> Vec<Irradiance> {
    progress.start("probe", points.len() as u64);
    let found = points
        .par_iter()
        .map(|point| {
            let irradiance = gatherer.irradiance(point.position, point.normal);
            progress.advance(1);
            irradiance
        })
        .collect();
    progress.finish();
    found
}

/// The points of a grid.
fn grid(scene: &Scene, text: &str, spacing: Option<f64>) -> Result<Vec<ProbePoint>, CliError> {
    Grid::named(scene, text)
        .and_then(|grid| grid_points(scene, &grid, spacing))
        .map_err(|error| CliError::Usage(error.to_string()))
}

/// Points at which the irradiance is known.
pub(super) struct Target {
    pub(super) points: Vec<ProbePoint>,
    pub(super) reference: Vec<Reference>,
}

impl Target {
    /// Reads both files; the first thing that is wrong with them is the error.
    pub(super) fn read(points_file: &Path, reference_file: &Path) -> Result<Target, CliError> {
        let points = read_points(points_file).map_err(probe_failure)?;
        let reference = read_reference(reference_file).map_err(probe_failure)?;
        check_points(reference_file, &reference, &points).map_err(probe_failure)?;
        Ok(Target { points, reference })
    }
}

/// How far light is from its reference.
pub(super) fn compared(found: &[Irradiance], reference: &[Reference]) -> Comparison {
    Comparison {
        total: Deviation::of(found, reference, |light| light.total),
        direct: Deviation::of(found, reference, |light| light.direct),
    }
}

fn described(comparison: &Comparison) -> String {
    let line = |name: &str, d: &Deviation| {
        if !d.is_defined() {
            return format!("{name:<7} error      - : the reference has no such light\n");
        }
        format!(
            "{name:<7} error {:6.2} % root mean square, {:+.2} % mean, {:.2} % at point {}\n",
            100.0 * d.rms,
            100.0 * d.bias,
            100.0 * d.worst,
            d.worst_at + 1
        )
    };
    line("total", &comparison.total) + &line("direct", &comparison.direct)
}

/// Writes the table to its file or to standard output.
fn write(config: &ProbeConfig, run: &ProbeRun) -> Result<(), CliError> {
    match &config.output {
        None => {
            let mut text = Vec::new();
            write_csv(&run.points, config.lux, &mut text)
                .map_err(|error| CliError::Internal(error.to_string()))?;
            console::answer(&String::from_utf8_lossy(&text))?;
        }
        Some(path) if config.is_json => json::write_json(path, run)?,
        Some(path) => write_atomically(path, |file| -> Result<(), FillError> {
            write_csv(&run.points, config.lux, file).map_err(FillError::Io)
        })?,
    }
    Ok(())
}

/// What an unusable file of points or reference values means for the caller.
fn probe_failure(error: ProbeError) -> CliError {
    let message = error.to_string();
    match error {
        ProbeError::Unreadable { .. } => CliError::Unreadable(message),
        ProbeError::Malformed { .. } | ProbeError::Unfit { .. } => CliError::Malformed(message),
    }
}
