//! Random segments and rays. A failure means that a picture depends on which tracer made it.

use glam::Vec3;
use lightshaft::compare::random_segments;
use lightshaft::tracer::{
    BruteTracer, Candidates, FilterAudit, Interval, NO_FACET, Segment, TraceMesh, Tracer,
};

use crate::meshes::{add_facet, soup};
use crate::tracers;

fn blocked(tracer: &dyn Tracer, segments: &[Segment], candidates: Candidates<'_>) -> (Vec<u32>, FilterAudit) {
    let mut audit = FilterAudit::default();
    let mut all = Vec::new();
    for packet in segments.chunks(13) {
        let mut blockers = vec![0; packet.len()];
        tracer.blockers(packet, candidates, &mut blockers, &mut audit);
        all.extend(blockers);
    }
    (all, audit)
}

#[test]
fn segments_are_blocked_as_the_judge_says() {
    let mesh = soup(600, 1);
    let judge = BruteTracer::new(&mesh);
    let segments = random_segments(8000, 2);
    let (expected, _) = blocked(&judge, &segments, Candidates::All);
    assert!(expected.iter().filter(|&&b| b != NO_FACET).count() > 1000);
    for tracer in tracers(&mesh) {
        let (got, audit) = blocked(tracer.as_ref(), &segments, Candidates::All);
        let wrong =
            (0..segments.len()).filter(|&i| (got[i] == NO_FACET) != (expected[i] == NO_FACET)).count();
        println!("{}: {wrong} of {} segments differ by rounding", tracer.name(), segments.len());
        assert!(wrong <= 2, "{}: {wrong} differ", tracer.name());
        assert_eq!(audit.outsiders, 0);
    }
}

#[test]
fn named_blockers_do_block_and_skipped_facets_do_not() {
    let mesh = soup(300, 3);
    let judge = BruteTracer::new(&mesh);
    for tracer in tracers(&mesh) {
        for segment in random_segments(3000, 4) {
            let (named, _) = blocked(tracer.as_ref(), &[segment], Candidates::All);
            if named[0] == NO_FACET {
                continue;
            }
            let only = [Interval { start: named[0], end: named[0] + 1 }];
            let (alone, _) = blocked(&judge, &[segment], Candidates::Only(&only));
            assert_eq!(alone, named, "{} names a facet that does not block", tracer.name());
            let passing = Segment { skip: [named[0], NO_FACET], ..segment };
            assert_ne!(blocked(tracer.as_ref(), &[passing], Candidates::All).0, named);
        }
    }
}

#[test]
fn hits_outside_the_candidates_are_reported_and_do_not_block() {
    let mesh = soup(400, 5);
    let judge = BruteTracer::new(&mesh);
    let candidates = [Interval { start: 10, end: 60 }, Interval { start: 200, end: 333 }];
    let segments = random_segments(4000, 6);
    let (expected, _) = blocked(&judge, &segments, Candidates::Only(&candidates));
    for tracer in tracers(&mesh) {
        let (got, audit) = blocked(tracer.as_ref(), &segments, Candidates::Only(&candidates));
        let wrong =
            (0..segments.len()).filter(|&i| (got[i] == NO_FACET) != (expected[i] == NO_FACET)).count();
        assert!(wrong <= 2, "{}: {wrong} differ", tracer.name());
        assert!(got.iter().all(|&b| b == NO_FACET || (10..60).contains(&b) || (200..333).contains(&b)));
        assert!(audit.outsiders > 0 && audit.outsiders == audit.rejects && audit.calls > audit.rejects);
        let named = audit.named.facets();
        assert!(!named.is_empty());
        assert!(named.iter().all(|facet| !(10..60).contains(facet) && !(200..333).contains(facet)));
    }
}

#[test]
fn nothing_is_hit_at_the_ends_of_a_segment() {
    // Two walls; segments from one to the other, with and without naming them.
    let mut mesh = TraceMesh { first_triangle: vec![0], ..TraceMesh::default() };
    for x in [0.0f32, 0.5, 1.0] {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(y, z)| Vec3::new(x, y, z));
        add_facet(&mut mesh, &corners);
    }
    let (a, b) = (Vec3::new(0.0, 0.1, 0.2), Vec3::new(1.0, -0.3, 0.4));
    for tracer in tracers(&mesh).into_iter().chain([Box::new(BruteTracer::new(&mesh)) as Box<dyn Tracer>]) {
        let ask =
            |from, to, skip| blocked(tracer.as_ref(), &[Segment { from, to, skip }], Candidates::All).0[0];
        assert_eq!(ask(a, b, [NO_FACET; 2]), 1, "{}", tracer.name());
        assert_eq!(ask(a, b, [1, NO_FACET]), NO_FACET, "{}", tracer.name());
        assert_eq!(ask(a, b.with_x(0.5), [NO_FACET; 2]), NO_FACET, "{}", tracer.name());
    }
}
