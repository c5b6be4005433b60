//! `profile`: the same scene with several strategies, tracers and numbers of rays.

use super::args::{TracerArg, VisibilityArg};
use super::config::{ProfileConfig, SolveConfig};
use super::console;
use super::errors::CliError;
use super::probe::{Target, compared, probe_all};
use super::setup::{self, setup};
use super::solved::{Loaded, in_pool, link_stats, solve_options};
use crate::compare::warm_up;
use crate::gather::Gatherer;
use crate::hierarchy::Hierarchy;
use crate::image::write::{OutputError, check_destination, png_bytes};
use crate::image::{self, Heat, HeatMap, RenderOptions, Renderer, View};
use crate::memory::Rise;
use crate::progress::{Both, Progress, Silent, Span, Timeline};
use crate::radiosity::{self, Record, Solution, SolveOptions, VisibilityError};
use crate::report::detail::RunDetail;
use crate::report::html::ShownMap;
use crate::report::profile::{NO_TRACER, Profile, ProfiledRun, Spread};
use crate::report::setup::Setting;
use crate::report::text::{counted, times};
use crate::report::trace::{self, Stage};
use crate::report::{html, json, plot};
use crate::scene::Camera;
use crate::tracer::Tracer;
use crate::visibility::{Detail, StepTimes, Strategy};
use std::path::Path;
use std::slice;
use std::time::{Duration, Instant};

/// Makes all runs, as configured.
///
/// # Errors
/// The first thing that goes wrong; then no output has been touched but for the record, which has the runs that were made.
pub(super) fn run(config: &ProfileConfig) -> Result<(), CliError> {
    for path in &config.run.outputs {
        check_destination(path)?;
    }
    in_pool(&config.run, |progress| run_in_pool(config, progress))
}

fn run_in_pool(config: &ProfileConfig, progress: &dyn Progress) -> Result<(), CliError> {
    let target = match &config.reference {
        Some((points, reference)) => Some(Target::read(points, reference)?),
        None => None,
    };
    // Who worked when is kept for the trace only.
    let timeline = Timeline::new(config.trace.as_ref().map_or(0, |_| rayon::current_num_threads()));
    let both = Both(progress, &timeline);
    let loaded = Loaded::load(&config.run, &both)?;
    let hierarchy = Hierarchy::build(&loaded.scene, config.run.solve.one_sided, &both);
    both.start("build", 0);
    let mut kinds: Vec<TracerArg> = Vec::new();
    for &kind in &config.tracers {
        let kind = meant(kind, &loaded, &config.tracers);
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    let tracers = kinds.into_iter().map(|kind| loaded.tracer(&config.run, kind, &hierarchy));
    let tracers = tracers.collect::<Result<Vec<_>, _>>();
    both.finish();
    let tracers = each_once(tracers?);
    let target = target.as_ref();
    let bench = Bench { config, loaded: &loaded, hierarchy: &hierarchy, target, timeline: &timeline };

    let kinds: Vec<(&dyn Tracer, &SolveConfig)> = tracers
        .iter()
        .enumerate()
        .flat_map(|pair| config.settings.iter().map(move |settings| (pair, settings)))
        .filter(|((index, _), settings)| *index == 0 || asks_tracer(settings))
        .map(|((_, tracer), settings)| (tracer.as_ref(), settings))
        .collect();
    let square_meters = hierarchy.square_meters_per_unit(loaded.scene.meters_per_unit);
    for tracer in &tracers {
        warm_up(&hierarchy, tracer.as_ref(), &solve_options(&config.run.solve), square_meters);
    }
    let mut found = Profile {
        format: Profile::FORMAT,
        setup: setup(&config.run, &loaded, &hierarchy),
        scene: loaded.scene.name.clone(),
        triangles: loaded.scene.counts.triangles_initial,
        threads: rayon::current_num_threads(),
        repeats: config.repeats,
        ..Profile::default()
    };
    found.setup.values.extend(varied(config, &tracers));
    if let Some((points, reference)) = &config.reference {
        found.setup.values.extend(setup::reference(points, reference, config.samples));
    }
    // Maps are for a page, and need a camera.
    let camera =
        config.html.as_ref().and(loaded.scene.cameras.first()).map(|camera| within(camera, MAP_PIXELS));
    if let Some(camera) = &camera {
        found.setup.values.extend(setup::view(camera, MAP_SAMPLES));
    }
    let all = kinds.len() as u64 * u64::from(config.repeats);
    progress.start("profile", all);
    let mut timed: Vec<Timed> = vec![Timed::default(); kinds.len()];
    let (mut made, mut stages) = (0, Vec::new());
    for repeat in 0..config.repeats {
        for (index, &(tracer, settings)) in kinds.iter().enumerate() {
            let begun = timeline.now();
            let phases_before = timeline.phases().len();
            let solution = bench.solve(tracer, settings, &mut timed[index]);
            stages.push(Stage { name: named(tracer, settings), start: begun, end: timeline.now() });
            let (phases, ended) = (&timeline.phases()[phases_before..], timeline.now());
            let detail = solution.counters.detail.as_deref().cloned().unwrap_or_default();
            timed[index].steps += &detail.steps;
            timed[index].details.push(bench.detail(&detail, &solution, phases, ended - begun));
            // What does not depend on the clock is the same every time.
            if repeat == 0 {
                found.runs.push(bench.judge(tracer, settings, &solution));
                stages.push(Stage { name: "errors".to_owned(), start: ended, end: timeline.now() });
            }
            timed[index].tell(&mut found.runs[index]);
            made += 1;
            found.refer(config.aim, all - made);
            // Whoever ends it early has the runs that were made.
            if let Some(path) = &config.json {
                json::write_json(path, &found)?;
            }
            progress.say(&format!(
                "run {made} of {all}: {}, {:.1} s, {:.1} s in visibility",
                named(tracer, settings),
                timed[index].total.last().copied().unwrap_or_default(),
                timed[index].visibility.last().copied().unwrap_or_default()
            ));
            progress.advance(1);
        }
    }
    progress.finish();
    let mut maps = Vec::new();
    if let (Some(path), Some(&(tracer, settings)), Some(camera)) =
        (&config.html, kinds.get(config.aim), &camera)
    {
        maps = bench.maps(path, tracer, settings, camera, progress)?;
    }
    if let Some(path) = &config.trace {
        trace::write_trace(path, &timeline, &stages)?;
    }
    if let Some(path) = &config.plot {
        plot::write_profile(path, &found)?;
    }
    if let Some(path) = &config.html {
        html::write_profile(path, &found, maps)?;
    }
    // Last: whoever reads it may have left.
    console::answer(&found.table())?;
    Ok(())
}

/// What `auto` stands for, where that is named as well: no tracer is built twice.
fn meant(kind: TracerArg, loaded: &Loaded, named: &[TracerArg]) -> TracerArg {
    let own = if loaded.has_embree() { TracerArg::Embree } else { TracerArg::Fallback };
    if kind == TracerArg::Auto && named.contains(&own) { own } else { kind }
}

/// What the runs differ in, and how often they are made.
fn varied(config: &ProfileConfig, tracers: &[Box<dyn Tracer>]) -> [Setting; 4] {
    let all = |name: &dyn Fn(&SolveConfig) -> String| {
        let mut names: Vec<String> = Vec::new();
        for settings in &config.settings {
            let name = name(settings);
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names.join(", ")
    };
    let tracers: Vec<&str> = tracers.iter().map(|tracer| tracer.name()).collect();
    [
        Setting::new("strategies", all(&|settings| Strategy::from(settings.strategy).name().to_owned())),
        Setting::new("tracers", tracers.join(", ")),
        Setting::new("rays for a pair", all(&|settings| settings.rays.to_string())),
        Setting::new("each run made", times(config.repeats)),
    ]
}

/// An Embree that was found may still not work, and `auto` be the fallback then.
fn each_once(tracers: Vec<Box<dyn Tracer>>) -> Vec<Box<dyn Tracer>> {
    let mut kept: Vec<Box<dyn Tracer>> = Vec::new();
    for tracer in tracers {
        if !kept.iter().any(|known| known.name() == tracer.name()) {
            kept.push(tracer);
        }
    }
    kept
}

/// Whether a tracer decides about visibility; the rays of `all` walk the list of triangles.
fn asks_tracer(settings: &SolveConfig) -> bool {
    settings.strategy != VisibilityArg::All
}

/// What casts the rays of visibility tests.
fn asked(tracer: &dyn Tracer, settings: &SolveConfig) -> &'static str {
    if asks_tracer(settings) { tracer.name() } else { NO_TRACER }
}

/// A run, as the trace calls it.
fn named(tracer: &dyn Tracer, settings: &SolveConfig) -> String {
    let strategy = Strategy::from(settings.strategy).name();
    format!("{strategy}, {}, {}", asked(tracer, settings), counted(settings.rays.into(), "ray"))
}

/// Longer side of a heat map on a page, pixels, and its samples per pixel.
const MAP_PIXELS: u32 = 640;
const MAP_SAMPLES: u32 = 4;

/// The same camera with a picture that is no larger.
fn within(camera: &Camera, most: u32) -> Camera {
    let longer = camera.width.max(camera.height);
    if longer <= most {
        return camera.clone();
    }
    let scaled = |side: u32| (u64::from(side) * u64::from(most) / u64::from(longer)).max(1) as u32;
    Camera { width: scaled(camera.width), height: scaled(camera.height), ..camera.clone() }
}

/// What was measured of one run, over all repeats.
#[derive(Clone, Default)]
struct Timed {
    visibility: Vec<f64>,
    total: Vec<f64>,
    solving_bytes: u64,
    details: Vec<RunDetail>,
    steps: StepTimes,
}

impl Timed {
    /// Fills in what was measured so far.
    fn tell(&self, run: &mut ProfiledRun) {
        run.visibility_seconds = Spread::of(self.visibility.clone());
        run.total_seconds = Spread::of(self.total.clone());
        run.solving_bytes = self.solving_bytes;
        run.detail = RunDetail::of_repeats(self.details.clone(), &self.steps).unwrap_or_default();
    }
}

/// What all runs share.
struct Bench<'a> {
    config: &'a ProfileConfig,
    loaded: &'a Loaded,
    hierarchy: &'a Hierarchy,
    target: Option<&'a Target>,
    timeline: &'a Timeline,
}

impl Bench<'_> {
    fn solve(&self, tracer: &dyn Tracer, settings: &SolveConfig, timed: &mut Timed) -> Solution {
        let rise = Rise::begin();
        let start = Instant::now();
        let square_meters = self.hierarchy.square_meters_per_unit(self.loaded.scene.meters_per_unit);
        let options = solve_options(settings);
        let solution = radiosity::solve(self.hierarchy, tracer, &options, square_meters, self.timeline);
        timed.total.push(start.elapsed().as_secs_f64());
        timed.visibility.push(solution.counters.visibility.nanoseconds as f64 * 1e-9);
        timed.solving_bytes = timed.solving_bytes.max(rise.bytes());
        solution
    }

    /// Where the work went.
    fn detail(&self, detail: &Detail, solution: &Solution, phases: &[Span], total: Duration) -> RunDetail {
        let radius = self.hierarchy.nodes[0].bounds.radius() * self.hierarchy.frame.scene_units_per_local();
        RunDetail::new(detail, &solution.counters.visibility, radius, phases, total)
    }

    /// The heat maps of one setting, for the page at `path`. It is solved once more: what they need is not kept while
    /// time is measured.
    fn maps(
        &self,
        path: &Path,
        tracer: &dyn Tracer,
        settings: &SolveConfig,
        camera: &Camera,
        progress: &dyn Progress,
    ) -> Result<Vec<ShownMap>, CliError> {
        let square_meters = self.hierarchy.square_meters_per_unit(self.loaded.scene.meters_per_unit);
        let options = SolveOptions { record: Record::Work, ..solve_options(settings) };
        let solution = radiosity::solve(self.hierarchy, tracer, &options, square_meters, progress);
        let seen = image::seen(self.hierarchy, tracer, &solution, slice::from_ref(camera));
        let maps = [
            (Heat::Cost, "cost of visibility by area"),
            (Heat::Links, "links"),
            (Heat::Class, "class of the links that cost most"),
            (Heat::Partial, "share of the light over partial links"),
        ];
        let options = RenderOptions { samples: MAP_SAMPLES, view: View::Shaded };
        let renderer = Renderer::new(self.hierarchy, tracer, &solution, options, progress);
        let shown = maps.map(|(heat, name)| {
            let map = HeatMap::new(self.hierarchy, &solution, square_meters, heat, &seen);
            progress.start("render", camera.height.into());
            let picture = renderer.heat(camera, &map, progress);
            progress.finish();
            let png = png_bytes(&picture, None)
                .map_err(|message| OutputError::Encode { path: path.to_owned(), message })?;
            Ok(ShownMap { name, legend: map.legend(), size: [picture.width, picture.height], png })
        });
        shown.into_iter().collect()
    }

    /// All but the times and where the work went.
    fn judge(&self, tracer: &dyn Tracer, settings: &SolveConfig, solution: &Solution) -> ProfiledRun {
        let (visibility, links) = (&solution.counters.visibility, link_stats(solution));
        let strategy = Strategy::from(settings.strategy);
        let irradiance_error = self.target.map(|target| {
            let gatherer = Gatherer::new(self.hierarchy, tracer, solution, self.config.samples);
            compared(&probe_all(&gatherer, &target.points, &Silent), &target.reference).total
        });
        ProfiledRun {
            strategy: strategy.name().to_owned(),
            tracer: asked(tracer, settings).to_owned(),
            rays: settings.rays,
            rays_cast: visibility.rays_cast,
            rays_avoided: visibility.rays_avoided,
            pairs_tested: visibility.pairs_tested,
            shafts_built: visibility.shafts_built,
            links: solution.links.links.len() as u64,
            tracer_bytes: if asks_tracer(settings) { tracer.bytes() } else { 0 },
            solution_bytes: solution.links.bytes() + solution.elements_bytes(),
            certified_share: (links.certified_visible + links.certified_invisible) as f64
                / (links.total as f64).max(1.0),
            visibility_error: VisibilityError::of(solution, self.hierarchy, tracer, strategy),
            irradiance_error,
            ..ProfiledRun::default()
        }
    }
}
