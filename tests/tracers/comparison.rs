//! What `compare` says of two tracers, with faults planted in one: a failure means that it would call tracers
//! alike that are not, or name the wrong one or the wrong place.

use glam::Vec3;
use lightshaft::compare::{
    Batch, Disagreement, Question, RayComparison, Referee, Standing, compare_rays, made_batches,
};
use lightshaft::tracer::{
    BruteTracer, Candidates, FallbackTracer, FilterAudit, Hit, PACKET, Ray, Segment, TraceMesh, Tracer,
};

use crate::faulty_tracers::Blind;
use crate::meshes::{shell, soup};
use crate::tracers;

/// Traces segments that end beside where they should, those that begin on one side of the origin.
struct Shifting<'a>(&'a dyn Tracer, Vec3);

impl Tracer for Shifting<'_> {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn blockers(
        &self,
        segments: &[Segment],
        candidates: Candidates<'_>,
        blockers: &mut [u32],
        audit: &mut FilterAudit,
    ) {
        let shifted = |s: &Segment| if s.from.x < 0.0 { Segment { to: s.to + self.1, ..*s } } else { *s };
        let shifted: Vec<Segment> = segments.iter().map(shifted).collect();
        self.0.blockers(&shifted, candidates, blockers, audit);
    }

    fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.0.first_hits(rays, hits);
    }
}

const COUNT: usize = 20_000;

fn compared(mesh: &TraceMesh, tracers: [&dyn Tracer; 2]) -> RayComparison {
    compare_rays(&Referee::new(mesh), tracers, &made_batches(mesh, COUNT), &|_| {})
}

fn segment(disagreement: &Disagreement) -> Segment {
    match disagreement.question {
        Question::Segment(segment) => segment,
        Question::Ray(ray) => panic!("{ray:?}"),
    }
}

#[test]
fn no_ray_of_a_right_tracer_is_wrong() {
    for mesh in [soup(300, 71), shell(true), shell(false)] {
        let judge = BruteTracer::new(&mesh);
        for tracer in tracers(&mesh) {
            let total = compared(&mesh, [tracer.as_ref(), &judge]).total();
            println!("{}: {total:?}", tracer.name());
            assert_eq!(total.wrong, [0, 0], "{}", tracer.name());
            assert_eq!((total.tolerance[1], total.edge_on[1]), (0, 0), "the referee agrees with itself");
            assert!(total.traced >= COUNT as u64 && total.blocked > 1000, "{total:?}");
        }
    }
}

#[test]
fn a_dropped_facet_is_found_and_named() {
    let mesh = soup(60, 72);
    let tracer = FallbackTracer::new(&mesh);
    for dropped in (0..60).step_by(7) {
        let found = compared(&mesh, [&tracer, &Blind::to(&tracer, dropped)]);
        let total = found.total();
        assert!(total.wrong[1] > 0 && total.wrong[0] == 0, "facet {dropped}: {total:?}");
        let [right, wrong] = found.worst[0].rulings;
        assert_eq!(
            (right.standing, wrong.standing, wrong.facet),
            (Standing::Right, Standing::Wrong, dropped)
        );
        // The worst come first.
        let severities: Vec<_> = found.worst.iter().map(|worst| worst.severity()).collect();
        assert!(severities.is_sorted_by(|a, b| a >= b), "{severities:?}");
    }
}

#[test]
fn a_shifted_end_is_found_on_the_side_where_it_is() {
    let mesh = soup(300, 73);
    let tracer = FallbackTracer::new(&mesh);
    let faulty = Shifting(&tracer, Vec3::new(1e-3, -1e-3, 1e-3));
    let found = compared(&mesh, [&faulty, &tracer]);
    let total = found.total();
    println!("{total:?}");
    assert!(total.wrong[0] > 10 && total.wrong[1] == 0, "{total:?}");
    for worst in found.worst.iter().filter(|worst| worst.severity().0 == Standing::Wrong) {
        assert!(segment(worst).from.x < 0.0, "{worst:?}");
    }
}

/// One segment of many, in a place of its own.
#[test]
fn one_wrong_segment_of_many_is_found() {
    let mesh = soup(300, 74);
    let tracer = FallbackTracer::new(&mesh);
    let found = compared(&mesh, [&tracer, &tracer]);
    assert_eq!(found.worst, []);
    let dropped = (0..300).find_map(|facet| {
        let corners = mesh.triangles_of(facet)[0].map(|v| mesh.positions[v as usize]);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let across =
            Segment { from: middle - normal * 1e-2, to: middle + normal * 1e-2, skip: [u32::MAX; 2] };
        let is_alone = BruteTracer::new(&mesh).all_blockers(&across) == [facet];
        is_alone.then_some((facet, across))
    });
    let (facet, across) = dropped.expect("a facet with nothing near it");
    let mut segments = vec![Segment { from: Vec3::splat(5.0), to: Vec3::splat(6.0), ..across }; 10 * PACKET];
    segments[77] = across;
    let packets = segments.chunks(PACKET).map(<[Segment]>::to_vec).collect();
    let batch = Batch { name: "one", packets, within: None };
    let faulty = Blind::to(&tracer, facet);
    let found = compare_rays(&Referee::new(&mesh), [&tracer, &faulty], &[batch], &|_| {});
    assert_eq!((found.total().differing, found.total().wrong), (1, [0, 1]));
    assert_eq!(segment(&found.worst[0]), across);
}
