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
    Ask, CompareOptions, Comparison, Disagreement, Question, Referee, ReplayError, ReplayFile, Standing,
    compare, difference_picture, distance_to_change, write_replay,
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
    let tracers = both(config, &loaded, &hierarchy, progress)?;
    let options = CompareOptions {
        solve: solve_options(&config.run.solve),
        rays: config.rays as usize,
        repeats: config.repeats,
        camera,
        render: RenderOptions { samples: config.view.samples(config.run.solve.quality), view: View::Shaded },
        square_meters: hierarchy.square_meters_per_unit(loaded.scene.meters_per_unit),
    };
    let tracers = tracers.each_ref().map(AsRef::as_ref);
    let (found, pictures) = compare(&hierarchy, tracers, &options, progress);
    let names = tracers.map(|tracer| tracer.name());
    let threads = rayon::current_num_threads();
    let mut setup = setup(&config.run, &loaded, &hierarchy);
    setup.values.extend(setup::visibility(&config.run));
    setup.values.extend(setup::view(&options.camera, options.render.samples));
    setup.values.push(Setting::new("rays made by rule", config.rays.to_string()));
    setup.values.push(Setting::new("rays timed", times(config.repeats)));
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
    let tracers = both(config, &loaded, &hierarchy, progress)?;
    let tracers = tracers.each_ref().map(AsRef::as_ref);
    let (referee, names) = (Referee::new(&hierarchy.mesh), tracers.map(|tracer| tracer.name()));
    let count = counted(rays.len() as u64, "ray");
    let mut text = format!("{}: {count} of {}\n", loaded.scene.name, file.display());
    let mut wrong = 0;
    for (number, ray) in (1..).zip(rays) {
        let replayed = match ray.question {
            Question::Segment(segment) => {
                let to_change = |facet| (facet, distance_to_change(&hierarchy.mesh, facet, &segment));
                let expected = referee.blockers(&segment).into_iter().map(to_change).collect();
                replayed(&referee, tracers, ray.kind, segment, expected)
            }
            Question::Ray(asked) => {
                let first = referee.first_hit(&asked).map(|hit| hit.facet);
                let to_change = |facet| (facet, referee.distance_from_outline(&asked, facet));
                replayed(&referee, tracers, ray.kind, asked, first.map(to_change).into_iter().collect())
            }
        };
        wrong += u64::from(replayed.in_packet.severity().0 == Standing::Wrong);
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

fn replayed<T: Ask>(
    referee: &Referee<'_>,
    tracers: [&dyn Tracer; 2],
    kind: String,
    asked: T,
    expected: Vec<(u32, f64)>,
) -> ReplayedRay {
    // A packet of one is traced in another way than one of several.
    let (answers, rulings) = T::ask(&[asked; 2], tracers, referee)[0];
    let (alone, _) = T::ask(&[asked], tracers, referee)[0];
    let in_packet = Disagreement { kind, question: asked.question(), answers, rulings };
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
        | ReplayError::OtherGeometry { .. } => CliError::Malformed(message),
    }
}

#[cfg(test)]
mod tests {
    use super::super::args::{Arguments, Verb};
    use super::super::errors::ExitKind;
    use super::*;
    use crate::progress::Silent;
    use crate::radiosity::{Record, SolveOptions};
    use crate::scene;
    use crate::tracer::{Candidates, FallbackTracer, FilterAudit, Hit, Interval, NO_FACET, Ray, Segment};
    use crate::visibility::{Strategy, VisibilityOptions};
    use clap::Parser;

    /// A side of the short box that throws a shadow.
    const BOX_SIDE: u32 = 14;

    /// Does not see one facet, whoever asks.
    struct Blind<'a>(&'a FallbackTracer, u32);

    impl Tracer for Blind<'_> {
        fn name(&self) -> &'static str {
            "blind"
        }

        fn blockers(
            &self,
            segments: &[Segment],
            candidates: Candidates<'_>,
            blockers: &mut [u32],
            audit: &mut FilterAudit,
        ) {
            let everything = [Interval { start: 0, end: u32::MAX }];
            let seen = match candidates {
                Candidates::All => &everything,
                Candidates::Only(list) => list,
            };
            let parts =
                |i: &Interval| [(i.start, i.end.min(self.1)), (i.start.max(self.1.saturating_add(1)), i.end)];
            let parts = seen.iter().flat_map(parts).filter(|(start, end)| start < end);
            let left: Vec<Interval> = parts.map(|(start, end)| Interval { start, end }).collect();
            self.0.blockers(segments, Candidates::Only(&left), blockers, audit);
        }

        fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
            self.0.first_hits(rays, hits);
        }
    }

    /// Looks only from a twentieth of the way on.
    struct Late<'a>(&'a FallbackTracer);

    impl Tracer for Late<'_> {
        fn name(&self) -> &'static str {
            "late"
        }

        fn blockers(
            &self,
            segments: &[Segment],
            candidates: Candidates<'_>,
            blockers: &mut [u32],
            audit: &mut FilterAudit,
        ) {
            let late = |s: &Segment| Segment { from: s.from.lerp(s.to, 0.05), ..*s };
            let shifted: Vec<Segment> = segments.iter().map(late).collect();
            self.0.blockers(&shifted, candidates, blockers, audit);
        }

        fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
            self.0.first_hits(rays, hits);
        }
    }

    /// Puts a fault before a tracer.
    type Fault = for<'a> fn(&'a FallbackTracer) -> Box<dyn Tracer + 'a>;

    /// The answer for the Cornell box with a tracer and a faulty one.
    fn answer_for(fault: Fault, config: &CompareConfig) -> (Result<(), CliError>, CompareReport) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box/scene.toml");
        let scene = scene::load(&path, &Default::default(), &Silent).expect("a scene of the project");
        let hierarchy = Hierarchy::build(&scene, false, &Silent);
        let tracer = FallbackTracer::new(&hierarchy.mesh);
        let options = CompareOptions {
            solve: SolveOptions {
                epsilon: 2e-2,
                contrast: 0.8,
                min_size: None,
                resolution: 16.0,
                iterations: 200,
                visibility: VisibilityOptions { strategy: Strategy::Adaptive, rays: 4, certify: false },
                record: Record::Nothing,
            },
            rays: 2000,
            repeats: 1,
            camera: scene::Camera { width: 8, height: 8, ..scene.cameras[0].clone() },
            render: RenderOptions { samples: 1, view: View::Shaded },
            square_meters: 1.0,
        };
        let faulty = fault(&tracer);
        let (found, pictures) = compare(&hierarchy, [&tracer, faulty.as_ref()], &options, &Silent);
        let report = CompareReport::new(&scene.name, ["fallback", faulty.name()], 1, &hierarchy, &found);
        let answered = answer(config, &hierarchy, &found, &report, &pictures);
        (answered, report)
    }

    /// Everything that is written, into this folder.
    fn config(folder: &Path) -> CompareConfig {
        let file = |name: &str| folder.join(name).to_string_lossy().into_owned();
        let files = [file("a.json"), file("a.replay"), file("a.html"), file("pictures")];
        let options = ["--json", "--replay-file", "--html", "-o"];
        let options = options.iter().zip(&files).flat_map(|(option, file)| [*option, file.as_str()]);
        let typed =
            Arguments::try_parse_from(["lightshaft", "compare", "a.toml", "-q"].into_iter().chain(options));
        match typed.expect("the grammar accepts this").verb {
            Verb::Compare(typed) => CompareConfig::check(*typed).expect("options that fit each other"),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_tracer_that_is_blind_to_one_facet_ends_with_code_9_and_the_place() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let config = config(folder.path());
        let page = || std::fs::read_to_string(folder.path().join("a.html")).expect("a page");
        let (same, report) = answer_for(|tracer| Box::new(Blind(tracer, NO_FACET)), &config);
        assert!(page().contains("The tracers agree."));
        assert!(same.is_ok() && report.agree, "{}", report.text());
        assert_eq!((report.links.share(), report.exitance.max, report.picture.max), (0.0, 0.0, 0.0));

        // Facets of the two boxes, the last but for the walls.
        let (different, report) = answer_for(|tracer| Box::new(Blind(tracer, BOX_SIDE)), &config);
        for name in ["a.json", "a.replay", "pictures/difference.png"] {
            assert!(folder.path().join(name).is_file(), "{name} is written all the same");
        }
        assert!(page().contains("The tracers disagree: ") && page().contains("WRONG"));
        let error = different.expect_err("the tracers disagree");
        assert_eq!((error.kind(), error.kind().code()), (ExitKind::TracersDisagree, 9));
        let message = error.to_string();
        for part in ["rays are wrong in blind", "worst: ", &format!("facet {BOX_SIDE} at ("), "blind: "] {
            assert!(message.contains(part), "{part} is missing: {message}");
        }
        assert!(report.links.share() > 0.0 && report.exitance.max > 0.0, "{}", report.text());
        let shadow_rays = &report.rays[0];
        assert!(shadow_rays.wrong[1] > 0 && shadow_rays.wrong[0] == 0, "{}", report.text());
    }

    #[test]
    fn a_tracer_whose_rays_begin_too_late_ends_with_code_9_and_the_place() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (different, report) = answer_for(|tracer| Box::new(Late(tracer)), &config(folder.path()));
        let error = different.expect_err("the tracers disagree");
        assert_eq!(error.kind().code(), 9);
        let message = error.to_string();
        for part in ["rays are wrong in late", "worst: ", "facet ", "late: "] {
            assert!(message.contains(part), "{part} is missing: {message}");
        }
        let shadow_rays = &report.rays[0];
        assert!(shadow_rays.wrong[1] > 0 && shadow_rays.wrong[0] == 0, "{}", report.text());
    }
}
