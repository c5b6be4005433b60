//! `render`: from a scene file to a picture and its statistics, one step after the other.

use std::time::Instant;

use rayon::ThreadPoolBuilder;

use super::args::{TracerArg, ViewArg, VisibilityArg};
use super::camera::choose_camera;
use super::config::{RenderConfig, SolveConfig};
use super::console;
use super::errors::CliError;
use super::pending::{hierarchy, image, radiosity, scene, tracer, visibility};
use crate::image::picture::Picture;
use crate::image::tone::Exposure;
use crate::image::write::{PictureFormat, check_destination, check_output, write_picture};
use crate::progress::{Progress, Silent, TerminalProgress};
use crate::report::stats::Stats;
use crate::report::{json, memory, table};
use crate::tracer::Tracer;

/// Renders as configured.
///
/// # Errors
/// The first thing that goes wrong; then no output has been touched, except that the picture stays
/// when writing the statistics fails after it.
pub(super) fn run(config: &RenderConfig) -> Result<(), CliError> {
    check_output(&config.output)?;
    if let Some(path) = &config.stats {
        check_destination(path)?;
    }
    // 0 means all cores to rayon.
    let threads = config.threads.unwrap_or(0) as usize;
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| CliError::Internal(format!("cannot start {threads} threads: {error}")))?;
    if config.quiet {
        pool.install(|| run_in_pool(config, &Silent))
    } else {
        pool.install(|| run_in_pool(config, &TerminalProgress::new()))
    }
}

fn run_in_pool(config: &RenderConfig, progress: &dyn Progress) -> Result<(), CliError> {
    let mut stats = Stats { threads: rayon::current_num_threads(), ..Stats::default() };
    let mut clock = Clock::start();

    let scene = scene::load(&config.scene, &scene::LoadOptions::default()).map_err(scene_failure)?;
    if !config.quiet {
        scene.warnings.iter().for_each(|warning| console::warning(warning));
    }
    let camera = choose_camera(&scene, &config.view)?;
    stats.seconds.load = clock.lap();

    let hierarchy = hierarchy::Hierarchy::build(&scene, config.solve.one_sided);
    let tracer = choose_tracer(config, &hierarchy, &mut stats)?;
    stats.seconds.build = clock.lap();

    let options = solve_options(&config.solve, &scene);
    let solution = radiosity::solve(&scene, &hierarchy, tracer.as_ref(), &options, progress);
    clock.lap();

    let render_options = image::RenderOptions {
        samples: config.view.samples,
        view: match config.view.kind {
            ViewArg::Shaded => image::View::Shaded,
            ViewArg::Mesh => image::View::Mesh,
        },
    };
    let picture =
        image::render(&scene, &hierarchy, tracer.as_ref(), &solution, &camera, render_options, progress);
    write_shown(config, &picture)?;
    stats.seconds.render = clock.lap();
    stats.seconds.total = clock.total();

    fill_stats(&mut stats, config, &scene, &hierarchy, &solution);
    if !config.quiet {
        console::note(&table::table(&[(scene.name.as_str(), &stats)]));
    }
    if let Some(path) = &config.stats {
        json::write_stats(path, &stats)?;
    }
    Ok(())
}

/// Exposes and writes the picture, and says which exposure was chosen.
fn write_shown(config: &RenderConfig, picture: &Picture) -> Result<(), CliError> {
    let exposure = config.view.exposure.multiplier(picture);
    write_picture(&config.output, picture, exposure)?;
    let is_chosen = config.view.exposure == Exposure::Automatic && config.format == PictureFormat::Png;
    if is_chosen && !config.quiet {
        console::note(&format!(
            "exposure chosen from the picture: {exposure:.4e} (repeat it with --exposure)\n"
        ));
    }
    Ok(())
}

/// The tracer asked for; with `auto` Embree if it is usable, the fallback with one warning if not.
fn choose_tracer(
    config: &RenderConfig,
    hierarchy: &hierarchy::Hierarchy,
    stats: &mut Stats,
) -> Result<Box<dyn Tracer>, CliError> {
    let tracer: Box<dyn Tracer> = match config.tracer {
        TracerArg::Fallback => tracer::fallback(hierarchy),
        TracerArg::Auto | TracerArg::Embree => {
            match tracer::embree(hierarchy, config.embree_lib.as_deref()) {
                Ok((tracer, version)) => {
                    stats.embree_version = Some(version);
                    tracer
                }
                Err(reason) if config.tracer == TracerArg::Embree => return Err(CliError::Embree(reason)),
                Err(reason) => {
                    if !config.quiet {
                        console::warning(&format!(
                            "Embree is not usable ({reason}); using the slower pure-Rust tracer"
                        ));
                    }
                    tracer::fallback(hierarchy)
                }
            }
        }
    };
    stats.tracer = tracer.name().to_owned();
    Ok(tracer)
}

fn solve_options(config: &SolveConfig, scene: &crate::scene::Scene) -> radiosity::SolveOptions {
    radiosity::SolveOptions {
        epsilon: config.epsilon,
        min_size: config.min_size.in_scene_units(scene_diagonal(scene)),
        rays: config.rays,
        iterations: config.iterations,
        strategy: strategy(config),
        certify: config.certify,
    }
}

fn strategy(config: &SolveConfig) -> visibility::Strategy {
    match config.strategy {
        VisibilityArg::All => visibility::Strategy::All,
        VisibilityArg::Root => visibility::Strategy::Root,
        VisibilityArg::Shaft => visibility::Strategy::Shaft,
        VisibilityArg::Adaptive => visibility::Strategy::Adaptive,
        VisibilityArg::Sampled => visibility::Strategy::Sampled,
    }
}

/// The diagonal of the bounding box, in scene units.
fn scene_diagonal(scene: &crate::scene::Scene) -> f64 {
    let Some(&first) = scene.positions.first() else { return 0.0 };
    let (low, high) =
        scene.positions.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
    low.distance(high)
}

/// Copies what the rooms counted into the record.
fn fill_stats(
    stats: &mut Stats,
    config: &RenderConfig,
    scene: &crate::scene::Scene,
    hierarchy: &hierarchy::Hierarchy,
    solution: &radiosity::Solution,
) {
    stats.strategy = strategy(&config.solve).name().to_owned();
    stats.scene.triangles_initial = scene.counts.triangles_initial;
    stats.scene.dropped_degenerate = scene.counts.dropped_degenerate;
    stats.scene.dropped_duplicate = scene.counts.dropped_duplicate;
    stats.scene.materials = scene.materials.len() as u64;
    stats.scene.facets = hierarchy.facets.len() as u64;
    stats.scene.clusters = hierarchy.cluster_count() as u64;
    stats.scene.patches = solution.patches;
    stats.scene.elements = solution.elements;
    stats.scene.triangles_final = solution.triangles_final;
    stats.links = solution.links.clone();
    stats.visibility = solution.visibility.clone();
    stats.energy = solution.energy.clone();
    stats.iterations = solution.iterations;
    stats.energy_error_w = solution.energy_error_w;
    stats.memory.links_bytes = solution.links_bytes;
    stats.memory.elements_bytes = solution.elements_bytes;
    stats.memory.peak_rss_bytes = memory::peak_rss_bytes();
    stats.seconds.refine = solution.refine_seconds;
    stats.seconds.solve = solution.solve_seconds;
}

/// What a scene error means for the caller.
fn scene_failure(error: scene::SceneError) -> CliError {
    let message = error.to_string();
    match error.kind() {
        scene::SceneErrorKind::Io => CliError::Unreadable(message),
        scene::SceneErrorKind::Parse => CliError::Malformed(message),
        scene::SceneErrorKind::Invalid => CliError::InvalidScene(message),
    }
}

/// Wall-clock seconds of one phase after another.
struct Clock {
    started: Instant,
    lap_started: Instant,
}

impl Clock {
    fn start() -> Self {
        let now = Instant::now();
        Self { started: now, lap_started: now }
    }

    /// Seconds since the last lap.
    fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let seconds = (now - self.lap_started).as_secs_f64();
        self.lap_started = now;
        seconds
    }

    /// Seconds since the start.
    fn total(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}
