//! From a scene file to its solution: the steps that every verb which needs one begins with.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use rayon::ThreadPoolBuilder;

use super::args::{QualityArg, TracerArg, VisibilityArg};
use super::config::{RunConfig, SolveConfig, check_not_read, local_pass_rays};
use super::console;
use super::errors::CliError;
use crate::check::{UNBALANCED, UNSETTLED};
use crate::export::{Origin, SolutionFile, SolutionFileError};
use crate::gather::local_pass;
use crate::hierarchy::Hierarchy;
use crate::memory;
use crate::progress::{Progress, Silent, TerminalProgress};
use crate::radiosity::{self, Link, LinkClass, Solution, SolveOptions};
use crate::report::stats::{
    EnergyStats, LinkStats, LocalPassStats, MemoryStats, SceneStats, Stats, VisibilityStats,
};
use crate::scene::{self, LoadOptions, Scene, check_names};
use crate::tracer::embree::{EmbreeError, EmbreeLibrary, EmbreeOptions, EmbreeTracer};
use crate::tracer::{FallbackTracer, Tracer};
use crate::visibility::{Strategy, VisibilityCounters, VisibilityOptions};

/// Runs `work` with the threads and the progress bar that the configuration asks for.
///
/// # Errors
/// Those of `work`, and [`CliError::Internal`] when the threads cannot be started.
pub(super) fn in_pool<T: Send>(
    config: &RunConfig,
    work: impl FnOnce(&dyn Progress) -> Result<T, CliError> + Send,
) -> Result<T, CliError> {
    // 0 means all cores to rayon.
    let threads = config.threads.unwrap_or(0) as usize;
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| CliError::Internal(format!("cannot start {threads} threads: {error}")))?;
    if config.quiet {
        pool.install(|| work(&Silent))
    } else {
        pool.install(|| work(&TerminalProgress::new()))
    }
}

/// A scene as it was loaded, and what will trace it.
pub(super) struct Loaded {
    pub(super) scene: Scene,
    embree: Option<Arc<EmbreeLibrary>>,
    /// Where the solution is to be read from.
    stored: Option<SolutionFile>,
    stats: Stats,
    clock: Clock,
}

/// A scene with its light.
pub(super) struct Solved {
    pub(super) scene: Scene,
    pub(super) hierarchy: Hierarchy,
    pub(super) tracer: Box<dyn Tracer>,
    pub(super) solution: Solution,
    /// What it was solved with, in this run or in an earlier one.
    pub(super) quality: QualityArg,
    pub(super) origin: Origin,
    /// Filled in but for the time of what is done with the solution.
    pub(super) stats: Stats,
    pub(super) clock: Clock,
}

impl Loaded {
    /// Opens the solution file if there is one, finds Embree and reads the scene; warnings go to standard error.
    ///
    /// # Errors
    /// What is wrong with the file or the scene, or Embree when it is demanded and not usable.
    pub(super) fn load(config: &RunConfig, progress: &dyn Progress) -> Result<Loaded, CliError> {
        let mut stats = Stats { threads: rayon::current_num_threads(), ..Stats::default() };
        let mut clock = Clock::start();
        let stored = config.stored.as_deref().map(SolutionFile::open).transpose().map_err(file_failure)?;
        let embree = find_embree(config)?;
        stats.seconds.build = clock.lap();
        progress.start("load", 0);
        // What was changed for a solution is part of its scene.
        let changes = stored.as_ref().map(|file| file.origin().changes.clone()).unwrap_or_default();
        let options = LoadOptions { changes, ..LoadOptions::default() };
        let scene = scene::load(&config.scene, &options, progress).map_err(scene_failure);
        progress.finish();
        let scene = scene?;
        // Otherwise the light would seem to be for other materials.
        check_names(&options.changes, &scene.materials).map_err(|why| {
            let stored = config.stored.as_deref().unwrap_or(Path::new("")).display();
            CliError::Malformed(format!(
                "{stored}: was relit, and in the scene {why}; relight what was solved anew"
            ))
        })?;
        check_not_read(&config.outputs, &scene.files)?;
        if !config.quiet {
            scene.warnings.iter().for_each(|warning| console::warning(warning));
        }
        stats.seconds.load = clock.lap();
        Ok(Loaded { scene, embree, stored, stats, clock })
    }

    /// A tracer of this kind over the mesh.
    ///
    /// # Errors
    /// Embree when it is demanded and not usable.
    pub(super) fn tracer(
        &self,
        config: &RunConfig,
        kind: TracerArg,
        hierarchy: &Hierarchy,
    ) -> Result<Box<dyn Tracer>, CliError> {
        let library = self.embree.clone().filter(|_| kind != TracerArg::Fallback);
        let config = RunConfig { tracer: kind, ..config.clone() };
        build_tracer(&config, library, hierarchy, &mut self.stats.clone())
    }

    /// Whether an Embree was found.
    pub(super) fn has_embree(&self) -> bool {
        self.embree.is_some()
    }

    /// Version and instruction set of the Embree that was found, such as `4.4.0 (AVX2)`.
    pub(super) fn embree_version(&self) -> Option<String> {
        let library = self.embree.as_ref()?;
        Some(format!("{} ({})", library.version(), library.instruction_set().name()))
    }

    /// The [solution](Self::solution), and says what is doubtful about it.
    ///
    /// # Errors
    /// Those of the solution.
    pub(super) fn solve(self, config: &RunConfig, progress: &dyn Progress) -> Result<Solved, CliError> {
        let solved = self.solution(config, progress)?;
        if !config.quiet {
            warn_if_unfinished(&solved.solution, solved.origin.iterations);
            warn_if_unbalanced(&solved.solution);
        }
        Ok(solved)
    }

    /// Builds the hierarchy and the tracer, and solves, or reads what was solved before.
    ///
    /// # Errors
    /// Embree when it is demanded and not usable; what is wrong with a solution file.
    pub(super) fn solution(self, config: &RunConfig, progress: &dyn Progress) -> Result<Solved, CliError> {
        let Loaded { scene, embree, stored, mut stats, mut clock } = self;
        let one_sided = stored.as_ref().map_or(config.solve.one_sided, SolutionFile::is_one_sided);
        let hierarchy = Hierarchy::build(&scene, one_sided, progress);
        progress.start("build", 0);
        let tracer = build_tracer(config, embree, &hierarchy, &mut stats);
        progress.finish();
        let tracer = tracer?;
        stats.seconds.build += clock.lap();

        let (solution, quality, origin) = match stored {
            Some(file) => {
                let read = read_solution(file, config, &hierarchy, &scene, progress)?;
                stats.seconds.load += clock.lap();
                read
            }
            None => {
                let (options, quality) = (solve_options(&config.solve), config.solve.quality);
                let square_meters = hierarchy.square_meters_per_unit(scene.meters_per_unit);
                let solution =
                    radiosity::solve(&hierarchy, tracer.as_ref(), &options, square_meters, progress);
                clock.lap();
                (solution, quality, Origin::new(&options, quality.into(), tracer.name()))
            }
        };
        stats.strategy.clone_from(&origin.strategy);
        fill_stats(&mut stats, &scene, &hierarchy, &solution);
        Ok(Solved { scene, hierarchy, tracer, solution, quality, origin, stats, clock })
    }
}

/// The solution of a file, and says how that was made.
fn read_solution(
    file: SolutionFile,
    config: &RunConfig,
    hierarchy: &Hierarchy,
    scene: &Scene,
    progress: &dyn Progress,
) -> Result<(Solution, QualityArg, Origin), CliError> {
    let origin = file.origin().clone();
    let quality = origin.quality.into();
    if let Some(path) = config.stored.as_deref().filter(|_| !config.quiet) {
        console::note(&format!("{}: {origin}\n", path.display()));
    }
    progress.start("read", 0);
    let solution = file.read(hierarchy, scene.meters_per_unit);
    progress.finish();
    Ok((solution.map_err(file_failure)?, quality, origin))
}

/// What an unusable solution file means for the caller.
pub(super) fn file_failure(error: SolutionFileError) -> CliError {
    match error {
        SolutionFileError::Unreadable { .. } => CliError::Unreadable(error.to_string()),
        _ => CliError::Malformed(error.to_string()),
    }
}

/// Says so when so many iterations ran out before the light had settled.
fn warn_if_unfinished(solution: &Solution, most: u32) {
    let (changing, emitted) = (solution.energy.error, solution.energy.emitted);
    if solution.iterations >= most && changing > UNSETTLED * emitted {
        console::warning(&format!(
            "stopped after {} iterations while {:.1} % of the emitted power still changes; raise --iterations",
            solution.iterations,
            100.0 * changing / emitted
        ));
    }
}

/// Says so when links lose or make much light on the way.
pub(super) fn warn_if_unbalanced(solution: &Solution) {
    let error = solution.energy.balance_error();
    if error > UNBALANCED {
        console::warning(&format!(
            "links lose or make {:.1} % of the emitted light over all bounces, which was made up for evenly; \
             `lightshaft check` says why, and a higher --quality, a smaller --epsilon or more --rays make it less",
            100.0 * error
        ));
    }
}

/// The Embree to use, looked for before the long run starts; absent when the fallback is asked for, or
/// when none is usable and `auto` lets the fallback take its place.
fn find_embree(config: &RunConfig) -> Result<Option<Arc<EmbreeLibrary>>, CliError> {
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
    config: &RunConfig,
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
fn without_embree(config: &RunConfig, reason: &EmbreeError) -> Result<(), CliError> {
    let what = format!("Embree is not usable: {}", reason.summary());
    if config.tracer == TracerArg::Embree {
        return Err(CliError::Embree(format!(
            "{what}; see `lightshaft doctor`; only `compare` and what is told to use embree require it"
        )));
    }
    if !config.quiet {
        console::warning(&format!("{what}; using the slower pure-Rust tracer, see `lightshaft doctor`"));
    }
    Ok(())
}

pub(super) fn solve_options(config: &SolveConfig) -> SolveOptions {
    SolveOptions {
        epsilon: config.epsilon,
        contrast: config.contrast,
        min_size: config.min_size,
        resolution: config.resolution,
        iterations: config.iterations,
        visibility: VisibilityOptions {
            strategy: config.strategy.into(),
            rays: config.rays,
            certify: config.certify,
        },
        record: config.record,
    }
}

impl From<VisibilityArg> for Strategy {
    fn from(typed: VisibilityArg) -> Strategy {
        match typed {
            VisibilityArg::All => Strategy::All,
            VisibilityArg::Root => Strategy::Root,
            VisibilityArg::Shaft => Strategy::Shaft,
            VisibilityArg::Adaptive => Strategy::Adaptive,
            VisibilityArg::Sampled => Strategy::Sampled,
        }
    }
}

/// Copies what the rooms counted into the record.
pub(super) fn fill_stats(stats: &mut Stats, scene: &Scene, hierarchy: &Hierarchy, solution: &Solution) {
    stats.scene = SceneStats {
        triangles_initial: scene.counts.triangles_initial,
        triangles_final: solution.triangle_count(hierarchy),
        patches: solution.forest.side_count() as u64,
        elements: solution.forest.len() as u64,
        clusters: hierarchy.cluster_count() as u64,
        facets: hierarchy.facets.len() as u64,
        covered_facets: hierarchy.covered_facets as u64,
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
        corrected_w: solution.energy.corrected,
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

pub(super) fn link_stats(solution: &Solution) -> LinkStats {
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
        inherited: count(|l| l.is_inherited()),
    }
}

fn visibility_stats(counters: &VisibilityCounters) -> VisibilityStats {
    VisibilityStats {
        pairs_tested: counters.pairs_tested,
        shafts_built: counters.shafts_built,
        nodes_tested: counters.nodes_tested,
        empty_shafts: counters.empty_shafts,
        single_blockers: counters.single_blockers,
        fused_blockers: counters.fused_blockers,
        rays_cast: counters.rays_cast,
        rays_avoided: counters.rays_avoided,
        filter_calls: counters.filter_calls,
        filter_rejects: counters.filter_rejects,
        culling_anomalies: counters.culling_anomalies,
        candidates_mean: counters.candidates as f64 / (counters.filled_shafts as f64).max(1.0),
        seconds: counters.nanoseconds as f64 * 1e-9,
    }
}

/// Makes elements for display, and says what was made.
pub(super) fn add_display(
    solution: &mut Solution,
    hierarchy: &Hierarchy,
    tracer: &dyn Tracer,
    quality: QualityArg,
    progress: &dyn Progress,
) -> Option<LocalPassStats> {
    let start = Instant::now();
    solution.display = local_pass(hierarchy, tracer, solution, local_pass_rays(quality), progress);
    let mesh = solution.display.as_ref()?;
    let (elements, seconds) = (mesh.forest.len() as u64, start.elapsed().as_secs_f64());
    Some(LocalPassStats { elements, bytes: mesh.bytes(), seconds })
}

/// What a scene error means for the caller.
pub(super) fn scene_failure(error: scene::SceneError) -> CliError {
    let message = error.to_string();
    match error.kind() {
        scene::SceneErrorKind::Io => CliError::Unreadable(message),
        scene::SceneErrorKind::Parse => CliError::Malformed(message),
        scene::SceneErrorKind::Invalid => CliError::InvalidScene(message),
    }
}

/// Wall-clock seconds of one phase after another.
pub(super) struct Clock {
    started: Instant,
    lap_started: Instant,
}

impl Clock {
    fn start() -> Self {
        let now = Instant::now();
        Self { started: now, lap_started: now }
    }

    /// Seconds since the last lap.
    pub(super) fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let seconds = (now - self.lap_started).as_secs_f64();
        self.lap_started = now;
        seconds
    }

    /// Seconds since the start.
    pub(super) fn total(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}
