//! `compare`: the same work on Embree and on the fallback tracer.

use std::path::Path;

use super::args::TracerArg;
use super::camera::choose_camera;
use super::config::{CompareConfig, Pictures};
use super::console;
use super::errors::CliError;
use super::folder::{check_folder, make_folder};
use super::setup::{self, setup};
use super::solved::{Loaded, in_pool, solve_options};
use crate::compare::{
    CompareOptions, Comparison, Disagreement, Question, Referee, ReplayError, ReplayFile, Replayed, Standing,
    ask, candidates, compare, difference_picture, distance_to_change, write_replay,
};
use crate::hierarchy::Hierarchy;
use crate::image::picture::Picture;
use crate::image::tone::Exposure;
use crate::image::write::{OutputError, check_destination, png_bytes, write_picture};
use crate::image::{RenderOptions, View};
use crate::progress::Progress;
use crate::report::compare::{CompareReport, DescribedDisagreement, ReplayedRay};
use crate::report::html::{Shown, write_compare};
use crate::report::json::write_json;
use crate::report::setup::Setting;
use crate::report::text::{counted, times};
use crate::tracer::Tracer;

/// How much brighter the picture of the difference is.
const GAIN: f32 = 16.0;

/// Compares as configured; the answer goes to standard output.
///
/// # Errors
/// The first thing that goes wrong; when the tracers disagree, after everything has been written.
pub(super) fn run(config: &CompareConfig) -> Result<(), CliError> {
    for path in config.replay_file.iter().chain(&config.json).chain(&config.html) {
        check_destination(path)?;
    }
    if let Some(places) = &config.pictures {
        check_folder(&places.folder, &places.files)?;
    }
    in_pool(&config.run, |progress| match &config.replay {
        Some(file) => replay(config, file, progress),
        None => run_in_pool(config, progress),
    })
}

fn run_in_pool(config: &CompareConfig, progress: &dyn Progress) -> Result<(), CliError> {
    let loaded = Loaded::load(&config.run, progress)?;
    let camera = choose_camera(&loaded.scene, config.camera.as_deref(), &config.view)?;
    let hierarchy = Hierarchy::build(&loaded.scene, config.run.solve.one_sided, progress);
    let built = both(config, &loaded, &hierarchy, progress)?;
    let options = CompareOptions {
        solve: solve_options(&config.run.solve),
        rays: config.rays as usize,
        repeats: config.repeats,
        solves: config.solves,
        camera,
        render: RenderOptions { samples: config.view.samples(config.run.solve.quality), view: View::Shaded },
        square_meters: hierarchy.square_meters_per_unit(loaded.scene.meters_per_unit),
    };
    let tracers = built.each_ref().map(|tracer| tracer.as_ref());
    let (found, pictures) = compare(&hierarchy, tracers, &options, progress);
    let names = tracers.map(|tracer| tracer.name());
    let threads = rayon::current_num_threads();
    let mut setup = setup(&config.run, &loaded, &hierarchy);
    setup.values.extend(setup::visibility(&config.run));
    setup.values.extend(setup::view(&options.camera, options.render.samples));
    setup.values.push(Setting::new("exposure", "chosen from the first picture"));
    setup.values.push(Setting::new("tracers", names.join(", ")));
    setup.values.push(Setting::new("rays made by rule", config.rays.to_string()));
    setup.values.push(Setting::new("rays timed", times(config.repeats)));
    setup.values.push(Setting::new("solved and rendered", times(config.solves)));
    let report = CompareReport::new(&loaded.scene.name, names, threads, &hierarchy, &found);
    answer(config, &hierarchy, &found, &CompareReport { setup, ..report }, &pictures)
}

/// Writes and prints what was found, whatever it is.
///
/// # Errors
/// When something cannot be written; when the tracers disagree, after all is written.
fn answer(
    config: &CompareConfig,
    hierarchy: &Hierarchy,
    found: &Comparison,
    report: &CompareReport,
    pictures: &[Picture; 2],
) -> Result<(), CliError> {
    if let Some(path) = &config.json {
        write_json(path, report)?;
    }
    if let Some(path) = &config.replay_file {
        let explain =
            |worst: &Disagreement| DescribedDisagreement::new(hierarchy, worst).line(&report.tracers);
        write_replay(path, &hierarchy.mesh, &found.rays.worst, &explain)?;
    }
    if let Some(places) = &config.pictures {
        write_pictures(places, pictures)?;
    }
    if let Some(path) = &config.html {
        write_compare(path, report, shown(path, pictures)?)?;
    }
    // Last: whoever reads it may have left.
    if !config.run.quiet {
        console::answer(&report.text())?;
    }
    verdict(report)
}

/// The error when the tracers disagree.
fn verdict(report: &CompareReport) -> Result<(), CliError> {
    match report.objection() {
        None => Ok(()),
        Some(objection) => Err(CliError::TracersDisagree(format!("{}: {objection}", report.scene))),
    }
}

/// Embree and the fallback over the mesh.
fn both(
    config: &CompareConfig,
    loaded: &Loaded,
    hierarchy: &Hierarchy,
    progress: &dyn Progress,
) -> Result<[Box<dyn Tracer>; 2], CliError> {
    progress.start("build", 0);
    let tracer = |kind| loaded.tracer(&config.run, kind, hierarchy);
    let tracers = tracer(TracerArg::Embree).and_then(|native| Ok([native, tracer(TracerArg::Fallback)?]));
    progress.finish();
    tracers
}

/// Both pictures and their difference, for the page at `path`.
fn shown(path: &Path, [native, other]: &[Picture; 2]) -> Result<Shown, OutputError> {
    let exposure = Exposure::Automatic.multiplier(native);
    let png = |picture: &Picture| {
        png_bytes(picture, Some(exposure))
            .map_err(|message| OutputError::Encode { path: path.to_owned(), message })
    };
    let files = [png(native)?, png(other)?, png(&difference_picture([native, other], GAIN))?];
    Ok(Shown { size: [native.width, native.height], files, gain: GAIN })
}

/// Both pictures with the exposure of the first, and their difference.
fn write_pictures(places: &Pictures, [native, other]: &[Picture; 2]) -> Result<(), OutputError> {
    make_folder(&places.folder)?;
    let exposure = Exposure::Automatic.multiplier(native);
    let difference = difference_picture([native, other], GAIN);
    for (path, picture) in places.files.iter().zip([native, other, &difference]) {
        write_picture(path, picture, Some(exposure))?;
    }
    Ok(())
}

/// Traces the rays of a file one by one and tells everything about them.
fn replay(config: &CompareConfig, file: &Path, progress: &dyn Progress) -> Result<(), CliError> {
    // Looked at before the scene, which may take long to load.
    let recorded = ReplayFile::open(file).map_err(replay_failure)?;
    let loaded = Loaded::load(&config.run, progress)?;
    let hierarchy = Hierarchy::build(&loaded.scene, config.run.solve.one_sided, progress);
    let rays = recorded.rays(&hierarchy.mesh).map_err(replay_failure)?;
    let built = both(config, &loaded, &hierarchy, progress)?;
    let tracers = built.each_ref().map(|tracer| tracer.as_ref());
    let (referee, names) = (Referee::new(&hierarchy.mesh), tracers.map(|tracer| tracer.name()));
    let count = counted(rays.len() as u64, "ray");
    let mut text = format!(
        "{}: {count} of {}, each asked twice in one packet and alone; its neighbours in the packet of the solution are not kept\n",
        loaded.scene.name,
        file.display()
    );
    let mut wrong = 0;
    for (number, ray) in (1..).zip(rays) {
        let replayed = replayed(&hierarchy, &referee, tracers, ray);
        wrong += u64::from(replayed.standing() == Standing::Wrong);
        text += &format!("\n{number}. {}", replayed.text(&hierarchy, names));
    }
    if !config.run.quiet {
        console::answer(&text)?;
    }
    let is = if wrong == 1 { "is" } else { "are" };
    match wrong {
        0 => Ok(()),
        _ => Err(CliError::TracersDisagree(format!(
            "{}: {} {is} wrong",
            file.display(),
            counted(wrong, "ray")
        ))),
    }
}

/// A ray twice in one packet, and alone: the two are traced in different ways. Its neighbours in the packet of the solution
/// are not known any more.
fn replayed(
    hierarchy: &Hierarchy,
    referee: &Referee<'_>,
    tracers: [&dyn Tracer; 2],
    Replayed { kind, question, within }: Replayed,
) -> ReplayedRay {
    let expected = match question {
        Question::Segment(segment) => referee
            .blockers(&segment, candidates(&within))
            .into_iter()
            .map(|facet| (facet, distance_to_change(&hierarchy.mesh, facet, &segment)))
            .collect(),
        Question::Ray(ray) => referee
            .first_hit(&ray)
            .map(|hit| (hit.facet, referee.distance_from_outline(&ray, hit.facet)))
            .into_iter()
            .collect(),
    };
    let [in_packet, alone] = [2, 1].map(|times| {
        let (answers, rulings) = ask(question, candidates(&within), times, tracers, referee);
        Disagreement { kind: kind.clone(), question, within: within.clone(), answers, rulings }
    });
    ReplayedRay { in_packet, alone, expected }
}

/// What an unusable replay file means for the caller.
fn replay_failure(error: ReplayError) -> CliError {
    let message = error.to_string();
    match error {
        ReplayError::Unreadable { .. } => CliError::Unreadable(message),
        ReplayError::TooLarge { .. }
        | ReplayError::Malformed { .. }
        | ReplayError::OtherVersion { .. }
        | ReplayError::NotAsWritten { .. }
        | ReplayError::OtherGeometry { .. } => CliError::Malformed(message),
    }
}

#[cfg(test)]
mod tests;
