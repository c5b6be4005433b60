//! `render`: from a scene file to a picture and its statistics, one step after the other.

use std::sync::Arc;
use std::time::Instant;

use rayon::ThreadPoolBuilder;

use super::args::{TracerArg, ViewArg, VisibilityArg};
use super::camera::choose_camera;
use super::config::{RenderConfig, SolveConfig};
use super::console;
use super::errors::CliError;
use crate::hierarchy::Hierarchy;
use crate::image::picture::Picture;
use crate::image::tone::Exposure;
use crate::image::write::{PictureFormat, check_destination, check_output, write_picture};
use crate::image::{self, RenderOptions, View};
use crate::progress::{Progress, Silent, TerminalProgress};
use crate::radiosity::{self, Link, LinkClass, Solution, SolveOptions};
use crate::report::stats::{EnergyStats, LinkStats, MemoryStats, SceneStats, Stats, VisibilityStats};
use crate::report::{json, memory, table};
use crate::scene::{self, Scene};
use crate::tracer::embree::{EmbreeError, EmbreeLibrary, EmbreeOptions, EmbreeTracer};
use crate::tracer::{FallbackTracer, Tracer};
use crate::visibility::{Strategy, VisibilityCounters, VisibilityOptions};

/// A solution is said to be unfinished when more than this share of the emitted power still changes.
const UNSETTLED: f64 = 0.01;

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

    let embree = find_embree(config)?;
    stats.seconds.build = clock.lap();

    let scene = scene::load(&config.scene, &scene::LoadOptions::default()).map_err(scene_failure)?;
    if !config.quiet {
        scene.warnings.iter().for_each(|warning| console::warning(warning));
    }
    let camera = choose_camera(&scene, &config.view)?;
    stats.seconds.load = clock.lap();

    let hierarchy = Hierarchy::build(&scene, config.solve.one_sided);
    let tracer = build_tracer(config, embree, &hierarchy, &mut stats)?;
    stats.seconds.build += clock.lap();

    let options = solve_options(&config.solve);
    let square_meters = hierarchy.square_meters_per_unit(scene.meters_per_unit);
    let solution = radiosity::solve(&hierarchy, tracer.as_ref(), &options, square_meters, progress);
    clock.lap();
    if !config.quiet {
        warn_if_unfinished(&solution, &options);
    }

    let render_options = RenderOptions {
        samples: config.view.samples,
        view: match config.view.kind {
            ViewArg::Shaded => View::Shaded,
            ViewArg::Mesh => View::Mesh,
        },
    };
    let picture = image::render(&hierarchy, tracer.as_ref(), &solution, &camera, render_options, progress);
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

/// Says so when the iterations ran out before the light had settled.
fn warn_if_unfinished(solution: &Solution, options: &SolveOptions) {
    let (changing, emitted) = (solution.energy.error, solution.energy.emitted);
    if solution.iterations >= options.iterations && changing > UNSETTLED * emitted {
        console::warning(&format!(
            "stopped after {} iterations while {:.1} % of the emitted power still changes; raise --iterations",
            solution.iterations,
            100.0 * changing / emitted
        ));
    }
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

/// The Embree to use, looked for before the long run starts; absent when the fallback is asked for, or
/// when none is usable and `auto` lets the fallback take its place.
fn find_embree(config: &RenderConfig) -> Result<Option<Arc<EmbreeLibrary>>, CliError> {
    if config.tracer == TracerArg::Fallback {
        return Ok(None);
    }
    match EmbreeLibrary::find(config.embree_lib.as_deref()) {
        Ok(library) => Ok(Some(library)),
        Err(reason) => without_embree(config, &reason).map(|()| None),
    }
}

/// The tracer over the mesh, Embree's when there is a library.
fn build_tracer(
    config: &RenderConfig,
    library: Option<Arc<EmbreeLibrary>>,
    hierarchy: &Hierarchy,
    stats: &mut Stats,
) -> Result<Box<dyn Tracer>, CliError> {
    let mut tracer: Option<Box<dyn Tracer>> = None;
    if let Some(library) = library {
        let options = EmbreeOptions { threads: stats.threads, ..EmbreeOptions::default() };
        match EmbreeTracer::new(&library, &hierarchy.mesh, options) {
            Ok(embree) => {
                if !config.quiet {
                    console::note(&format!("{library}\n"));
                }
                stats.embree_version = Some(library.version().to_string());
                tracer = Some(Box::new(embree));
            }
            Err(reason) => without_embree(config, &reason)?,
        }
    }
    let tracer = tracer.unwrap_or_else(|| Box::new(FallbackTracer::new(&hierarchy.mesh)));
    stats.tracer = tracer.name().to_owned();
    Ok(tracer)
}

/// Embree cannot be used: an error when it is demanded, one warning when it is not.
fn without_embree(config: &RenderConfig, reason: &EmbreeError) -> Result<(), CliError> {
    let what = format!("Embree is not usable: {}", reason.summary());
    if config.tracer == TracerArg::Embree {
        return Err(CliError::Embree(format!(
            "{what}; see `lightshaft doctor`, or leave out --tracer embree"
        )));
    }
    if !config.quiet {
        console::warning(&format!("{what}; using the slower pure-Rust tracer, see `lightshaft doctor`"));
    }
    Ok(())
}

fn solve_options(config: &SolveConfig) -> SolveOptions {
    SolveOptions {
        epsilon: config.epsilon,
        contrast: config.contrast,
        min_size: config.min_size,
        resolution: config.resolution,
        iterations: config.iterations,
        visibility: VisibilityOptions {
            strategy: strategy(config),
            rays: config.rays,
            certify: config.certify,
        },
    }
}

fn strategy(config: &SolveConfig) -> Strategy {
    match config.strategy {
        VisibilityArg::All => Strategy::All,
        VisibilityArg::Root => Strategy::Root,
        VisibilityArg::Shaft => Strategy::Shaft,
        VisibilityArg::Adaptive => Strategy::Adaptive,
        VisibilityArg::Sampled => Strategy::Sampled,
    }
}

/// Copies what the rooms counted into the record.
fn fill_stats(
    stats: &mut Stats,
    config: &RenderConfig,
    scene: &Scene,
    hierarchy: &Hierarchy,
    solution: &Solution,
) {
    stats.strategy = strategy(&config.solve).name().to_owned();
    stats.scene = SceneStats {
        triangles_initial: scene.counts.triangles_initial,
        triangles_final: solution.triangle_count(hierarchy),
        patches: solution.forest.side_count() as u64,
        elements: solution.forest.len() as u64,
        clusters: hierarchy.cluster_count() as u64,
        facets: hierarchy.facets.len() as u64,
        materials: scene.materials.len() as u64,
        dropped_degenerate: scene.counts.dropped_degenerate,
        dropped_duplicate: scene.counts.dropped_duplicate,
    };
    stats.links = link_stats(solution);
    stats.visibility = visibility_stats(&solution.counters.visibility);
    stats.energy = EnergyStats {
        emitted_w: solution.energy.emitted,
        absorbed_w: solution.energy.absorbed,
        escaped_w: solution.energy.escaped,
        balance_error: solution.energy.balance_error(),
    };
    stats.iterations = solution.iterations;
    stats.energy_error_w = solution.energy.error;
    stats.memory = MemoryStats {
        peak_rss_bytes: memory::peak_rss_bytes(),
        links_bytes: solution.links.bytes(),
        elements_bytes: solution.elements_bytes(),
    };
    stats.seconds.refine = solution.refine_seconds;
    stats.seconds.solve = solution.solve_seconds;
}

fn link_stats(solution: &Solution) -> LinkStats {
    let links = &solution.links.links;
    let count = |test: fn(&Link) -> bool| links.iter().filter(|l| test(l)).count() as u64;
    let invisible = solution.counters.invisible;
    LinkStats {
        total: links.len() as u64 + invisible,
        visible: count(|l| l.class != LinkClass::Partial),
        invisible,
        partial: count(|l| l.class == LinkClass::Partial),
        certified_visible: count(|l| l.class == LinkClass::CertifiedVisible),
        certified_invisible: solution.counters.certified_invisible,
        inherited: count(|l| l.inherited),
    }
}

fn visibility_stats(counters: &VisibilityCounters) -> VisibilityStats {
    VisibilityStats {
        pairs_tested: counters.pairs_tested,
        shafts_built: counters.shafts_built,
        nodes_tested: counters.nodes_tested,
        empty_shafts: counters.empty_shafts,
        single_blockers: counters.single_blockers,
        rays_cast: counters.rays_cast,
        rays_avoided: counters.rays_avoided,
        filter_calls: counters.filter_calls,
        filter_rejects: counters.filter_rejects,
        culling_anomalies: counters.culling_anomalies,
        candidates_mean: counters.candidates as f64 / (counters.filled_shafts as f64).max(1.0),
        seconds: counters.nanoseconds as f64 * 1e-9,
    }
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
