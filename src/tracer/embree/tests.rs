//! Embree itself, on small scenes whose answers are known. Without Embree each test says that it is
//! skipped; with `LIGHTSHAFT_REQUIRE_EMBREE=1` it fails instead.

use std::{fs, io::Write, path::Path, sync::Arc};

use embree4_sys as raw;
use glam::Vec3;

use super::{
    Attempt, EmbreeError, EmbreeLibrary, EmbreeOptions, EmbreeReport, EmbreeTracer, Origin, Refusal,
    search::Surroundings,
    selftest::{GuardedQuery, guard_holds, two_triangles},
};
use crate::tracer::{
    Candidates, END_MARGIN, FilterAudit, Interval, NO_FACET, PACKET, Ray, Segment, TraceMesh, Tracer,
};

fn embree() -> Option<Arc<EmbreeLibrary>> {
    match EmbreeLibrary::find(None) {
        Ok(library) => Some(library),
        Err(error) => {
            let is_required = std::env::var_os("LIGHTSHAFT_REQUIRE_EMBREE").is_some_and(|v| v == "1");
            assert!(!is_required, "LIGHTSHAFT_REQUIRE_EMBREE is set, but {error}");
            // A right library that fails a self-test is our fault rather than an absent Embree.
            let EmbreeError::NotFound { tried } = &error else { panic!("{error}") };
            let is_ours = |attempt: &Attempt| matches!(attempt.refusal, Refusal::SelfTest { .. });
            assert!(!tried.iter().any(is_ours), "{error}");
            // Past the test harness, which keeps what passing tests print to itself.
            let name = std::thread::current().name().unwrap_or("a test").to_owned();
            let _ = writeln!(std::io::stderr(), "skipped {name}: no usable Embree");
            None
        }
    }
}

/// Facets 0, 1, 2, … are squares of side 2 across the z axis at z = 1, 2, 3, …
fn stack(squares: u32) -> TraceMesh {
    let mut mesh = TraceMesh { first_triangle: vec![0], ..TraceMesh::default() };
    for facet in 0..squares {
        let z = facet as f32 + 1.0;
        let base = mesh.positions.len() as u32;
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        mesh.positions.extend(corners.map(|(x, y)| Vec3::new(x, y, z)));
        mesh.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
        mesh.facet_of_triangle.extend([facet, facet]);
        mesh.first_triangle.push(mesh.triangles.len() as u32);
    }
    mesh
}

fn tracer(mesh: &TraceMesh) -> Option<EmbreeTracer> {
    let library = embree()?;
    Some(EmbreeTracer::new(&library, mesh, EmbreeOptions::default()).expect("a valid mesh"))
}

/// Parallel to the z axis, off the squares' diagonals.
fn along_z(from: f32, to: f32, skip: [u32; 2]) -> Segment {
    Segment { from: Vec3::new(0.3, 0.1, from), to: Vec3::new(0.3, 0.1, to), skip }
}

fn ask(tracer: &EmbreeTracer, segments: &[Segment], candidates: Candidates<'_>) -> (Vec<u32>, FilterAudit) {
    let mut blockers = vec![7777; segments.len()];
    let mut audit = FilterAudit::default();
    tracer.blockers(segments, candidates, &mut blockers, &mut audit);
    (blockers, audit)
}

const FREE: [u32; 2] = [NO_FACET; 2];

#[test]
fn a_segment_is_blocked_by_the_facet_between_its_ends() {
    let Some(tracer) = tracer(&stack(3)) else { return };
    let aside = Segment { from: Vec3::new(5.0, 0.0, 0.0), to: Vec3::new(5.0, 0.0, 9.0), skip: FREE };
    let segments = [along_z(0.5, 1.5, FREE), along_z(2.5, 1.5, FREE), along_z(1.2, 1.8, FREE), aside];
    let (blockers, audit) = ask(&tracer, &segments, Candidates::All);
    assert_eq!(blockers, [0, 1, NO_FACET, NO_FACET]);
    assert_eq!(audit, FilterAudit { calls: 2, ..FilterAudit::default() });
    // One segment alone takes another function of Embree.
    for (segment, expected) in segments.iter().zip(blockers) {
        assert_eq!(ask(&tracer, &[*segment], Candidates::All).0, [expected]);
    }
}

#[test]
fn skipped_facets_do_not_block_but_those_behind_them_do() {
    let Some(tracer) = tracer(&stack(3)) else { return };
    let segments = [
        along_z(0.5, 1.5, [0, NO_FACET]),
        along_z(0.5, 2.5, [NO_FACET, 0]),
        along_z(0.5, 2.5, [0, 1]),
        along_z(0.5, 3.5, [0, 1]),
    ];
    let (blockers, audit) = ask(&tracer, &segments, Candidates::All);
    assert_eq!(blockers, [NO_FACET, 1, NO_FACET, 2]);
    assert!(audit.rejects >= 3 && audit.outsiders == 0, "skipped facets are no outsiders: {audit:?}");
    for (segment, expected) in segments.iter().zip(blockers) {
        assert_eq!(ask(&tracer, &[*segment], Candidates::All).0, [expected]);
    }
}

#[test]
fn a_hit_outside_the_candidates_does_not_count_and_is_reported() {
    let Some(tracer) = tracer(&stack(4)) else { return };
    let segments = [along_z(0.5, 4.5, FREE), along_z(1.5, 2.5, FREE), along_z(3.2, 3.8, FREE)];
    let only = [Interval { start: 0, end: 1 }, Interval { start: 3, end: 4 }];
    let (blockers, audit) = ask(&tracer, &segments, Candidates::Only(&only));
    assert!(blockers[0] == 0 || blockers[0] == 3, "{blockers:?}");
    assert_eq!(blockers[1..], [NO_FACET, NO_FACET]);
    assert!(
        audit.outsiders >= 1 && audit.named.facets().iter().all(|facet| [1, 2].contains(facet)),
        "{audit:?}"
    );
    let (blockers, audit) = ask(&tracer, &segments[..1], Candidates::Only(&[]));
    assert_eq!(blockers, [NO_FACET]);
    assert_eq!((audit.calls, audit.rejects, audit.outsiders), (4, 4, 4));
    let mut named = audit.named.facets().to_vec();
    named.sort_unstable();
    assert_eq!(named, [0, 1, 2, 3], "all of them are named");
}

#[test]
fn facets_at_the_ends_do_not_block() {
    let Some(tracer) = tracer(&stack(2)) else { return };
    let e = END_MARGIN;
    // All have length 1, so that an offset of the start is a fraction of it: the squares at z = 1 and
    // z = 2 lie on both ends, then within the closed parts, then just inside the open part.
    let at = |offset: f32| along_z(1.0 + offset, 2.0 + offset, FREE);
    let segments = [at(0.0), at(-0.5 * e), at(0.5 * e), at(-2.0 * e), at(2.0 * e)];
    let expected = [NO_FACET, NO_FACET, NO_FACET, 0, 1];
    assert_eq!(ask(&tracer, &segments, Candidates::All).0, expected);
    for (segment, expected) in segments.iter().zip(expected) {
        assert_eq!(ask(&tracer, &[*segment], Candidates::All).0, [expected]);
    }
}

#[test]
fn any_number_of_segments_up_to_a_packet_is_answered() {
    let Some(tracer) = tracer(&stack(PACKET as u32)) else { return };
    for count in 0..=PACKET {
        let segments: Vec<Segment> =
            (0..count).map(|i| along_z(i as f32 + 0.5, i as f32 + 1.5, FREE)).collect();
        let (blockers, _) = ask(&tracer, &segments, Candidates::All);
        assert_eq!(blockers, (0..count as u32).collect::<Vec<_>>());
    }
}

#[test]
fn rays_hit_the_first_facet_and_name_its_triangle() {
    let mesh = stack(3);
    let Some(tracer) = tracer(&mesh) else { return };
    let ray = |z: f32, dz: f32| Ray { origin: Vec3::new(0.3, 0.1, z), direction: Vec3::new(0.0, 0.0, dz) };
    for count in 1..=PACKET {
        let all = [ray(0.0, 2.0), ray(2.5, -1.0), ray(2.5, 1.0), ray(3.5, 1.0)];
        let rays: Vec<Ray> = all.iter().copied().cycle().take(count).collect();
        let mut hits = vec![None; count];
        tracer.first_hits(&rays, &mut hits);
        for (i, hit) in hits.iter().enumerate() {
            let expected = [Some((0, 0.5)), Some((1, 0.5)), Some((2, 0.5)), None][i % 4];
            assert_eq!(hit.map(|hit| hit.facet), expected.map(|(facet, _)| facet));
            // Embree's code for some processors divides with the last bit wrong.
            let off = hit.zip(expected).map_or(0.0, |(hit, (_, t))| (hit.t - t).abs());
            assert!(off <= f32::EPSILON, "off by {off}");
            // (0.3, 0.1) is on the first triangle of each square.
            assert!(hit.is_none_or(|hit| hit.triangle == 2 * hit.facet));
        }
    }
}

#[test]
fn what_cannot_be_traced_hits_nothing() {
    let Some(tracer) = tracer(&stack(2)) else { return };
    let bad = [f32::NAN, f32::INFINITY, f32::MAX];
    let mut segments: Vec<Segment> = bad.iter().map(|&z| along_z(0.5, z, FREE)).collect();
    segments.extend([along_z(1.0, 1.0, FREE), along_z(0.5, 1.5, FREE)]);
    segments[2].from.z = -f32::MAX; // the difference overflows
    let (blockers, _) = ask(&tracer, &segments, Candidates::All);
    assert_eq!(blockers, [NO_FACET, NO_FACET, NO_FACET, NO_FACET, 0]);
    assert_eq!(ask(&tracer, &segments[..1], Candidates::All).0, [NO_FACET]);
    let rays =
        [Ray { origin: Vec3::ZERO, direction: Vec3::ZERO }, Ray { origin: Vec3::NAN, direction: Vec3::Z }];
    let mut hits = [None; 2];
    tracer.first_hits(&rays, &mut hits);
    assert_eq!(hits, [None; 2]);
}

#[test]
fn an_empty_mesh_blocks_nothing() {
    let Some(tracer) = tracer(&TraceMesh { first_triangle: vec![0], ..TraceMesh::default() }) else { return };
    assert_eq!(ask(&tracer, &[along_z(0.0, 1.0, FREE); 3], Candidates::All).0, [NO_FACET; 3]);
}

#[test]
fn a_mesh_with_wrong_ids_is_refused() {
    let Some(library) = embree() else { return };
    let mut mesh = stack(2);
    mesh.triangles[3][1] = 8;
    let error = EmbreeTracer::new(&library, &mesh, EmbreeOptions::default()).expect_err("vertex 8 of 8");
    assert!(matches!(error, EmbreeError::Mesh(_)));
    assert!(error.to_string().contains("triangle 3"), "{error}");
    let mut mesh = stack(2);
    mesh.facet_of_triangle.pop();
    assert!(EmbreeTracer::new(&library, &mesh, EmbreeOptions::default()).is_err());
}

/// Many small triangles, in which one thread and several, or another packet, must not matter.
#[test]
fn answers_do_not_depend_on_build_threads_options_or_packets() {
    let Some(library) = embree() else { return };
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f32 / 16777216.0
    };
    let mut point = || Vec3::new(random(), random(), random());
    let mut mesh = TraceMesh::default();
    for facet in 0..40_000 {
        let corner = point();
        mesh.positions.extend([corner, corner + 0.02 * point(), corner + 0.02 * point()]);
        mesh.triangles.push([0, 1, 2].map(|i| 3 * facet + i));
        mesh.facet_of_triangle.push(facet);
    }
    mesh.first_triangle = (0..=40_000).collect();
    let segments: Vec<Segment> =
        (0..4096).map(|_| Segment { from: point(), to: point(), skip: FREE }).collect();
    let answers = |threads, compact, packet| {
        let options = EmbreeOptions { threads, compact, ..EmbreeOptions::default() };
        let tracer = EmbreeTracer::new(&library, &mesh, options).expect("a valid mesh");
        let chunks = segments.chunks(packet);
        chunks.flat_map(|chunk| ask(&tracer, chunk, Candidates::All).0).collect::<Vec<u32>>()
    };
    let reference = answers(1, false, PACKET);
    let blocked = reference.iter().filter(|&&facet| facet != NO_FACET).count();
    assert!(blocked > 400 && blocked < 4000, "{blocked} of 4096: the scene tests nothing");
    assert!(answers(2, false, PACKET) == reference, "build threads change a blocker");
    assert!(answers(1, false, 1) == reference, "the packet changes a blocker");
    assert!(answers(1, false, 5) == reference, "the packet changes a blocker");
    let is_blocked = |answers: Vec<u32>| answers.iter().map(|&f| f != NO_FACET).collect::<Vec<_>>();
    assert!(is_blocked(answers(1, true, PACKET)) == is_blocked(reference), "`compact` changes an answer");
}

#[test]
fn a_tracer_is_shared_between_threads() {
    let Some(tracer) = tracer(&stack(3)) else { return };
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..1000 {
                    let (blockers, _) = ask(&tracer, &[along_z(0.5, 1.5, FREE); 16], Candidates::All);
                    assert_eq!(blockers, [0; 16]);
                }
            });
        }
    });
    // It is also dropped on another thread than the one that built it.
    std::thread::spawn(move || drop(tracer)).join().expect("no panic");
}

/// The layout of Embree 4.2, before instance arrays: what a library of today writes into it lands in
/// the guard bytes. When this fails, the check at start would let memory be corrupted.
#[test]
fn the_guard_catches_the_struct_of_embree_4_2() {
    let Some(library) = embree() else { return };
    let scene = two_triangles(library.api()).expect("passed at start");
    const RAY_HIT_4_2: usize = 80;
    const RAY_HIT_16_4_2: usize = 1280;
    for (query, small, ours) in [
        (GuardedQuery::One, RAY_HIT_4_2, size_of::<raw::RTCRayHit>()),
        (GuardedQuery::Sixteen, RAY_HIT_16_4_2, size_of::<raw::RTCRayHit16>()),
    ] {
        let caught = guard_holds(&scene, query, small).expect_err("the struct is too small");
        assert!(caught.contains(&format!("past the end of the struct of {small} bytes")), "{caught}");
        guard_holds(&scene, query, ours).expect("the struct is large enough");
    }
}

fn refusal_of(path: &Path) -> String {
    let error = EmbreeLibrary::find(Some(path)).expect_err("not Embree");
    let EmbreeError::NotFound { tried } = &error else { panic!("{error}") };
    assert_eq!(tried.len(), 1, "nothing else is tried in place of a library named outright");
    assert_eq!(tried[0].origin, Origin::Option);
    assert!(matches!(tried[0].refusal, Refusal::NotLoadable(_)));
    error.to_string()
}

#[test]
fn a_text_file_is_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("libembree4.so.4");
    fs::write(&path, "I am not a library\n".repeat(100)).expect("temporary file");
    let message = refusal_of(&path);
    assert!(message.contains("--embree-lib") && message.contains("cannot be loaded"), "{message}");
    assert!(message.contains("libembree4.so.4"), "{message}");
}

#[test]
fn a_missing_file_is_refused() {
    let message = refusal_of(Path::new("/nowhere/libembree4.so.4"));
    assert!(message.contains("/nowhere/libembree4.so.4"), "{message}");
}

#[cfg(target_os = "linux")]
#[test]
fn another_library_is_refused() {
    let message = refusal_of(Path::new("libm.so.6"));
    assert!(message.contains("is not Embree 4") && message.contains("rtcNewDevice"), "{message}");
}

#[test]
fn a_wrong_library_in_a_searched_place_is_passed_over() {
    let Some(library) = embree() else { return };
    let folder = tempfile::tempdir().expect("temporary folder");
    let wrong = folder.path().join("lib/libembree4.so");
    fs::create_dir_all(folder.path().join("lib")).expect("temporary folder");
    fs::write(&wrong, "not a library").expect("temporary file");
    let surroundings = Surroundings {
        embree_dir: Some(folder.path().to_owned()),
        provisioned: Some(library.path().to_owned()),
        ..Surroundings::default()
    };
    if !cfg!(target_os = "linux") {
        return; // the name of the planted file
    }
    let found = EmbreeLibrary::find_in(&surroundings).expect("the second one fits");
    assert_eq!(found.origin(), Origin::Provisioned);
    assert_eq!(found.refused()[0].origin, Origin::EmbreeDir);
    assert!(matches!(found.refused()[0].refusal, Refusal::NotLoadable(_)));
}

#[test]
fn the_report_says_what_was_found() {
    let Some(library) = embree() else { return };
    let report = EmbreeReport::new(None);
    assert!(report.is_usable());
    let text = report.to_string();
    for part in [library.version().to_string(), library.path().display().to_string()] {
        assert!(text.contains(&part), "{text}");
    }
    assert_eq!(text.matches("passed").count(), library.self_tests().len());
    assert!(library.version().major == 4 && library.version().minor >= 3);
    let none = EmbreeReport::new(Some(Path::new("/nowhere/libembree4.so.4")));
    assert!(!none.is_usable() && none.to_string().contains("/nowhere"));
}
