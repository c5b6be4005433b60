//! Faults planted in a tracer: the exit code is 9 and the place is named.

#[path = "../../../tests/coarse_comparison/mod.rs"]
mod coarse_comparison;
#[path = "../../../tests/faulty_tracers/mod.rs"]
mod faulty_tracers;

use super::super::args::{Arguments, Verb};
use super::super::errors::ExitKind;
use super::*;
use crate::progress::Silent;
use crate::scene;
use crate::tracer::{Candidates, FallbackTracer, FilterAudit, Hit, NO_FACET, Ray, Segment};
use crate::visibility::Strategy;
use clap::Parser;
use coarse_comparison::{BOX_SIDE, coarse};
use faulty_tracers::Blind;
use std::path::PathBuf;

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
type Fault<'f> = &'f dyn for<'a> Fn(&'a FallbackTracer) -> Box<dyn Tracer + 'a>;

/// The answer for the Cornell box with a tracer and a faulty one.
fn answer_for(fault: Fault<'_>, config: &CompareConfig) -> (Result<(), CliError>, CompareReport) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box/scene.toml");
    answer_in(&scene, Strategy::Adaptive, fault, config)
}

fn answer_in(
    path: &Path,
    strategy: Strategy,
    fault: Fault<'_>,
    config: &CompareConfig,
) -> (Result<(), CliError>, CompareReport) {
    let scene = scene::load(path, &Default::default(), &Silent).expect("a scene of the project");
    let hierarchy = Hierarchy::build(&scene, false, &Silent);
    let tracer = FallbackTracer::new(&hierarchy.mesh);
    let options = coarse(&scene, strategy, 8);
    let faulty = fault(&tracer);
    let (found, pictures) = compare(&hierarchy, [&tracer, faulty.as_ref()], &options, &Silent);
    let report = CompareReport::new(&scene.name, ["fallback", faulty.name()], 1, &hierarchy, &found);
    let answered = answer(config, &hierarchy, &found, &report, &pictures);
    (answered, report)
}

/// Facets of the Cornell box with a flag, and which of them that is.
const FACETS: u32 = 18;
const FLAG: u32 = 4;

/// The Cornell box with a flag as wide as a hundredth of the room, in the middle under the lamp.
fn with_flag(folder: &Path) -> PathBuf {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box");
    for name in ["cornell-box.obj", "cornell-box.mtl"] {
        std::fs::copy(scenes.join(name), folder.join(name)).expect("copied");
    }
    let scene = std::fs::read_to_string(scenes.join("scene.toml")).expect("a scene of the project");
    let flag = "\n[[quad]]\nname = \"flag\"\ncorners = [[275, 400, 275], [281, 400, 275], [281, 400, 281], [275, 400, 281]]\n";
    let path = folder.join("flag.toml");
    std::fs::write(&path, scene + flag).expect("written");
    path
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
    let (same, report) = answer_for(&|tracer| Box::new(Blind::to(tracer, NO_FACET)), &config);
    assert!(page().contains("The tracers agree."));
    assert!(same.is_ok() && report.agree, "{}", report.text());
    assert_eq!((report.links.share(), report.exitance.max, report.picture.max), (0.0, 0.0, 0.0));
    assert_eq!(report.picture.worst, None, "there is no place where nothing differs");

    // Facets of the two boxes, the last but for the walls.
    let (different, report) = answer_for(&|tracer| Box::new(Blind::to(tracer, BOX_SIDE)), &config);
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
    // The worst rays are in the file, and fit the scene.
    let replay = std::fs::read_to_string(folder.path().join("a.replay")).expect("a replay file");
    assert!(replay.contains(&format!("facet {BOX_SIDE} at (")), "{replay}");
}

/// As if the cull had dropped the facet: only lists of candidates lack it. Each facet in turn, also a flag as wide as a
/// hundredth of the room. Either that is found and named, or nothing came of it.
#[test]
fn one_dropped_candidate_ends_with_code_9_and_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (config, scene) = (config(folder.path()), with_flag(folder.path()));
    for strategy in [Strategy::Shaft, Strategy::Adaptive] {
        let mut found = Vec::new();
        for facet in 0..FACETS {
            let (answered, report) = answer_in(
                &scene,
                strategy,
                &|tracer| Box::new(Blind { tracer, facet, only_in_lists: true }),
                &config,
            );
            let shadow_rays = &report.rays[0];
            let name = report.worst.first().map(|worst| worst.answers[0].clone()).unwrap_or_default();
            println!(
                "{}, facet {facet}: {} of {} shadow rays wrong, {} links differ, light {:.1e} in the mean, {:.1e} rms; {name}",
                strategy.name(),
                shadow_rays.wrong[1],
                shadow_rays.traced,
                report.links.count_of_all(),
                report.exitance.relative(report.exitance.mean),
                report.exitance.relative_rms()
            );
            assert!(!report.unexplained_links, "{}", report.text());
            if answered.is_ok() {
                // It was in no list of these solutions, or in none where it blocks.
                assert!(report.links.are_same() && report.exitance.max == 0.0, "{facet}: {}", report.text());
                continue;
            }
            let message = answered.expect_err("an objection").to_string();
            for part in
                [" wrong in blind", &format!("facet {facet} at ("), "candidate", "blind: clear (WRONG"]
            {
                assert!(message.contains(part), "{part} is missing: {message}");
            }
            assert!(facet != FLAG || message.contains("material flag"), "{message}");
            if shadow_rays.wrong[1] > 0 {
                found.push(facet);
            }
        }
        assert!(found.len() > 4 && found.contains(&FLAG), "{}: {found:?}", strategy.name());
    }
}

#[test]
fn a_tracer_whose_rays_begin_too_late_ends_with_code_9_and_the_place() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (different, report) = answer_for(&|tracer| Box::new(Late(tracer)), &config(folder.path()));
    let error = different.expect_err("the tracers disagree");
    assert_eq!(error.kind().code(), 9);
    let message = error.to_string();
    for part in ["rays are wrong in late", "worst: ", "facet ", "late: "] {
        assert!(message.contains(part), "{part} is missing: {message}");
    }
    let shadow_rays = &report.rays[0];
    assert!(shadow_rays.wrong[1] > 0 && shadow_rays.wrong[0] == 0, "{}", report.text());
}
