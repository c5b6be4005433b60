//! `compare`: the same work on Embree and on the fallback tracer.

use std::path::Path;

use super::args::TracerArg;
use super::camera::choose_camera;
use super::config::{CompareConfig, Pictures};
use super::console;
use super::errors::CliError;
use super::solved::{Loaded, in_pool, solve_options};
use crate::compare::{
    CompareOptions, Disagreement, Referee, ReplayError, Replayed, Standing, answers_of, compare,
    difference_picture, distance_to_change, read_replay, tolerance_for, write_replay,
};
use crate::hierarchy::Hierarchy;
use crate::image::picture::Picture;
use crate::image::tone::Exposure;
use crate::image::write::{OutputError, check_destination, write_picture};
use crate::image::{RenderOptions, View};
use crate::progress::Progress;
use crate::report::compare::{CompareReport, DescribedDisagreement, ReplayedSegment};
use crate::report::json::write_json;
use crate::tracer::Tracer;

/// How much brighter the picture of the difference is.
const GAIN: f32 = 16.0;

/// Compares as configured; the answer goes to standard output.
///
/// # Errors
/// The first thing that goes wrong; when the tracers disagree, after everything has been written.
pub(super) fn run(config: &CompareConfig) -> Result<(), CliError> {
    for path in config.replay_file.iter().chain(&config.json) {
        check_destination(path)?;
    }
    if let Some(Pictures { folder, files }) = &config.pictures {
        // A folder that is still to be made needs what a file in its place would need.
        let places = if folder.is_dir() { &files[..] } else { std::slice::from_ref(folder) };
        places.iter().try_for_each(|path| check_destination(path))?;
    }
    in_pool(&config.run, |progress| match &config.replay {
        Some(file) => replay(config, file, progress),
        None => run_in_pool(config, progress),
    })
}

fn run_in_pool(config: &CompareConfig, progress: &dyn Progress) -> Result<(), CliError> {
    let loaded = Loaded::load(&config.run, progress)?;
    let camera = choose_camera(&loaded.scene, &config.view)?;
    let (hierarchy, tracers) = built(config, &loaded, progress)?;
    let options = CompareOptions {
        solve: solve_options(&config.run.solve),
        rays: config.rays as usize,
        repeats: config.repeats,
        camera,
        render: RenderOptions { samples: config.view.samples, view: View::Shaded },
        square_meters: hierarchy.square_meters_per_unit(loaded.scene.meters_per_unit),
    };
    let tracers = tracers.each_ref().map(AsRef::as_ref);
    let (found, pictures) = compare(&hierarchy, tracers, &options, progress);
    let names = tracers.map(|tracer| tracer.name());
    let threads = rayon::current_num_threads();
    let report = CompareReport::new(&loaded.scene.name, names, threads, &hierarchy, &found);

    if !config.run.quiet {
        console::answer(&report.text())?;
    }
    if let Some(path) = &config.json {
        write_json(path, &report)?;
    }
    if let Some(path) = &config.replay_file {
        let explain =
            |worst: &Disagreement| DescribedDisagreement::new(&hierarchy, worst).line(&report.tracers);
        write_replay(path, &hierarchy.mesh, &found.rays.worst, &explain)?;
    }
    if let Some(places) = &config.pictures {
        write_pictures(places, &pictures)?;
    }
    verdict(&report)
}

/// The error when the tracers disagree.
fn verdict(report: &CompareReport) -> Result<(), CliError> {
    match report.objection() {
        None => Ok(()),
        Some(objection) => Err(CliError::TracersDisagree(format!("{}: {objection}", report.scene))),
    }
}

/// The hierarchy with Embree and the fallback over it.
fn built(
    config: &CompareConfig,
    loaded: &Loaded,
    progress: &dyn Progress,
) -> Result<(Hierarchy, [Box<dyn Tracer>; 2]), CliError> {
    let hierarchy = Hierarchy::build(&loaded.scene, config.run.solve.one_sided, progress);
    progress.start("build", 0);
    let tracer = |kind| loaded.tracer(&config.run, kind, &hierarchy);
    let tracers = tracer(TracerArg::Embree).and_then(|native| Ok([native, tracer(TracerArg::Fallback)?]));
    progress.finish();
    Ok((hierarchy, tracers?))
}

/// Both pictures with the exposure of the first, and their difference.
fn write_pictures(places: &Pictures, [native, other]: &[Picture; 2]) -> Result<(), OutputError> {
    if !places.folder.is_dir() {
        std::fs::create_dir(&places.folder)
            .map_err(|source| OutputError::Io { path: places.folder.clone(), source })?;
    }
    let exposure = Exposure::Automatic.multiplier(native);
    let difference = difference_picture([native, other], GAIN);
    for (path, picture) in places.files.iter().zip([native, other, &difference]) {
        write_picture(path, picture, exposure)?;
    }
    Ok(())
}

/// Traces the rays of a file one by one and tells everything about them.
fn replay(config: &CompareConfig, file: &Path, progress: &dyn Progress) -> Result<(), CliError> {
    let loaded = Loaded::load(&config.run, progress)?;
    let (hierarchy, tracers) = built(config, &loaded, progress)?;
    let rays = read_replay(file, &hierarchy.mesh).map_err(replay_failure)?;
    let tracers = tracers.each_ref().map(AsRef::as_ref);
    let (referee, names) = (Referee::new(&hierarchy.mesh), tracers.map(|tracer| tracer.name()));
    let mut text = format!("{}: {} rays of {}\n", loaded.scene.name, rays.len(), file.display());
    let mut wrong = 0;
    for (number, ray) in (1..).zip(rays) {
        let replayed = replayed(&hierarchy, &referee, tracers, ray);
        wrong += u32::from(replayed.in_packet.severity().0 == Standing::Wrong);
        text += &format!("\n{number}. {}", replayed.text(&hierarchy, names));
    }
    if !config.run.quiet {
        console::answer(&text)?;
    }
    match wrong {
        0 => Ok(()),
        _ => Err(CliError::TracersDisagree(format!("{}: {wrong} rays are wrong", file.display()))),
    }
}

fn replayed(
    hierarchy: &Hierarchy,
    referee: &Referee<'_>,
    tracers: [&dyn Tracer; 2],
    Replayed { kind, segment }: Replayed,
) -> ReplayedSegment {
    // A packet of one is traced in another way than one of several.
    let answers = answers_of(tracers, &[segment; 2])[0];
    let rulings = referee.rule(&segment, answers, tolerance_for(&segment));
    let blockers = referee.blockers(&segment).into_iter();
    ReplayedSegment {
        in_packet: Disagreement { kind, segment, answers, rulings },
        alone: answers_of(tracers, &[segment])[0],
        blockers: blockers
            .map(|facet| (facet, distance_to_change(&hierarchy.mesh, facet, &segment)))
            .collect(),
    }
}

/// What an unusable replay file means for the caller.
fn replay_failure(error: ReplayError) -> CliError {
    let message = error.to_string();
    match error {
        ReplayError::Unreadable { .. } => CliError::Unreadable(message),
        ReplayError::Malformed { .. }
        | ReplayError::OtherVersion { .. }
        | ReplayError::OtherGeometry { .. } => CliError::Malformed(message),
    }
}
