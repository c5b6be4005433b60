//! What rays meet first. A failure means that light gathered at a point depends on which tracer found its way.

use lightshaft::compare::{FAMILIES, Family, Referee, Ruling, Standing, random_segments, segments};
use lightshaft::hierarchy::TOLERANCE;
use lightshaft::tracer::{BruteTracer, Hit, PACKET, Ray, Segment, TraceMesh, Tracer};

use crate::meshes::{shell, soup, tiny_and_huge};
use crate::tracers;

/// What came of a comparison.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hits {
    /// Rays that the judge says meet something.
    pub(crate) met: usize,
    /// Answers that name another facet than the judge, or none, within the tolerance of what decides.
    pub(crate) within_tolerance: usize,
    /// On a facet that the ray passes in its plane, but for the last digit of single precision.
    pub(crate) edge_on: usize,
    /// All other answers that are not the judge's but for rounding.
    pub(crate) wrong: usize,
}

/// The ray from the first end of a segment to the other; distances are in lengths of the segment.
pub(crate) fn ray_along(segment: &Segment) -> Ray {
    Ray { origin: segment.from, direction: segment.to - segment.from }
}

/// The first hit of each ray.
pub(crate) fn first_hits(tracer: &dyn Tracer, rays: &[Ray]) -> Vec<Option<Hit>> {
    let mut all = vec![None; rays.len()];
    for (packet, hits) in rays.chunks(PACKET).zip(all.chunks_mut(PACKET)) {
        tracer.first_hits(packet, hits);
    }
    all
}

/// Compares a tracer with the exhaustive one; the tolerance is a local length.
pub(crate) fn compare_hits(tolerance: f64, mesh: &TraceMesh, tracer: &dyn Tracer, rays: &[Ray]) -> Hits {
    let referee = Referee::new(mesh);
    let expected = first_hits(&BruteTracer::new(mesh), rays);
    let mut hits = Hits::default();
    for ((ray, got), expected) in rays.iter().zip(first_hits(tracer, rays)).zip(expected) {
        hits.met += usize::from(expected.is_some());
        let [ruling, of_the_judge] = referee.rule_hits(ray, [got, expected], tolerance);
        assert_eq!(of_the_judge, Ruling::RIGHT);
        match ruling.standing {
            Standing::Right => {}
            Standing::Tolerance => hits.within_tolerance += 1,
            Standing::EdgeOn => hits.edge_on += 1,
            Standing::Wrong => hits.wrong += 1,
        }
    }
    hits
}

const COUNT: usize = 4000;

#[test]
fn first_hits_are_the_judges() {
    let mesh = soup(500, 8);
    let rays: Vec<Ray> = random_segments(COUNT, 9).iter().map(ray_along).collect();
    for tracer in tracers(&mesh) {
        let hits = compare_hits(TOLERANCE, &mesh, tracer.as_ref(), &rays);
        println!("{}: {hits:?} of {COUNT}", tracer.name());
        assert!(hits.wrong == 0 && hits.edge_on == 0 && hits.met > COUNT / 4, "{}: {hits:?}", tracer.name());
    }
}

/// Rays that are hard to decide. Those in the plane of a facet may be stopped by it in Embree though they pass
/// beside it, as segments are.
#[test]
fn hard_rays_meet_what_the_judge_says_but_for_rounding() {
    let meshes = [
        ("soup", soup(300, 31)),
        ("tiny and huge", tiny_and_huge(400, 32)),
        ("box", shell(true)),
        ("ball", shell(false)),
    ];
    for (name, mesh) in meshes {
        for (tracer, (index, family)) in tracers(&mesh)
            .iter()
            .flat_map(|tracer| FAMILIES.into_iter().enumerate().map(move |f| (tracer, f)))
        {
            let segments = segments(&mesh, family, COUNT, 400 + index as u64);
            let rays: Vec<Ray> = segments.iter().map(ray_along).collect();
            let hits = compare_hits(TOLERANCE, &mesh, tracer.as_ref(), &rays);
            let what = format!("{name}, {family:?}, {}: {hits:?}", tracer.name());
            println!("{what}");
            let is_exempt = family == Family::InPlane && tracer.name() == "embree";
            assert!(hits.edge_on <= if is_exempt { COUNT / 25 } else { 0 }, "{what}");
            assert!(hits.wrong == 0 && hits.met > 10, "{what}");
        }
    }
}

/// Rays that leave a closed box or ball from inside, as good as along an axis or a plane through two of them: the
/// smallest numbers have a sign, and an inverse that is as good as infinite.
#[test]
fn directions_with_the_smallest_numbers_lead_somewhere() {
    for (name, mesh) in [("box", shell(true)), ("ball", shell(false)), ("soup", soup(300, 33))] {
        for tracer in tracers(&mesh) {
            let (mut rays, origins) = (Vec::new(), random_segments(COUNT / 8, 34));
            for (i, origin) in origins.iter().enumerate() {
                let tiny = 10f32.powi(-(12 + i as i32 % 26)) * if i % 2 == 0 { 1.0 } else { -1.0 };
                let mut direction = [1.0f32, 0.3, -0.2];
                direction[i % 3] = tiny;
                if i % 5 == 0 {
                    direction[(i + 1) % 3] = -tiny;
                }
                rays.push(Ray { origin: origin.from * 0.3, direction: glam::Vec3::from(direction) });
            }
            let hits = compare_hits(TOLERANCE, &mesh, tracer.as_ref(), &rays);
            let what = format!("{name}, {}: {hits:?}", tracer.name());
            println!("{what}");
            assert!(hits.wrong == 0 && hits.edge_on == 0, "{what}");
            assert!(if name == "soup" { hits.met > 10 } else { hits.met == rays.len() }, "{what}");
        }
    }
}
