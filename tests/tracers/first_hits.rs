//! What rays meet first. A failure means that light gathered at a point depends on which tracer found its way.

use glam::DVec3;
use lightshaft::compare::{FAMILIES, Family, distance_between, lies_in_plane, random_segments, segments};
use lightshaft::hierarchy::TOLERANCE;
use lightshaft::tracer::{BruteTracer, Hit, PACKET, Ray, Segment, TraceMesh, Tracer};

use crate::meshes::{shell, soup, tiny_and_huge};
use crate::tracers;

/// Further than anything in a mesh is from anything else.
const FAR: f64 = 10.0;

/// One rounding to single precision.
const ROUNDING: f64 = 1.2e-7;

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
    let expected = first_hits(&BruteTracer::new(mesh), rays);
    let mut hits = Hits::default();
    for ((ray, got), expected) in rays.iter().zip(first_hits(tracer, rays)).zip(expected) {
        hits.met += usize::from(expected.is_some());
        if got == expected {
            continue;
        }
        let is_edge_on = |hit: Hit| {
            let segment = Segment { from: ray.origin, to: ray.origin + ray.direction, skip: [hit.facet; 2] };
            lies_in_plane(mesh, hit.facet, &segment, ROUNDING)
        };
        if how_far_off(mesh, ray, got, expected) <= tolerance {
            hits.within_tolerance += usize::from(got.map(|hit| hit.facet) != expected.map(|hit| hit.facet));
        } else if got.is_some_and(is_edge_on) {
            hits.edge_on += 1;
        } else {
            hits.wrong += 1;
        }
    }
    hits
}

/// How far the ray, or what it meets, would have to be moved to make the answer right.
fn how_far_off(mesh: &TraceMesh, ray: &Ray, got: Option<Hit>, expected: Option<Hit>) -> f64 {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let ends = [origin, origin + direction.normalize_or_zero() * FAR];
    let to_outline = |hit: Hit| distance_between(mesh, hit.facet, ends);
    let to_plane = |of: Hit, at: Hit| distance_from_plane(mesh, of.facet, origin + direction * at.t as f64);
    match (got, expected) {
        (Some(g), Some(e)) if g.facet == e.facet => to_plane(e, g),
        // One is a false hit or the other was missed, unless they are met in the same place.
        (Some(g), Some(e)) => {
            let same_place =
                if is_met(mesh, g, ends) { to_plane(e, g).max(to_plane(g, e)) } else { f64::INFINITY };
            same_place.min(to_outline(if g.t < e.t { g } else { e }))
        }
        (Some(hit), None) | (None, Some(hit)) => to_outline(hit),
        (None, None) => 0.0,
    }
}

/// Whether the facet of a hit is met at all.
fn is_met(mesh: &TraceMesh, hit: Hit, [from, to]: [DVec3; 2]) -> bool {
    let alone = TraceMesh {
        positions: mesh.positions.clone(),
        triangles: mesh.triangles_of(hit.facet).to_vec(),
        first_triangle: vec![0, mesh.triangles_of(hit.facet).len() as u32],
        facet_of_triangle: vec![0; mesh.triangles_of(hit.facet).len()],
    };
    let ray = Ray { origin: from.as_vec3(), direction: (to - from).as_vec3() };
    first_hits(&BruteTracer::new(&alone), &[ray])[0].is_some()
}

fn distance_from_plane(mesh: &TraceMesh, facet: u32, point: DVec3) -> f64 {
    let distance = mesh.triangles_of(facet).iter().map(|t| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3());
        (b - a).cross(c - a).normalize_or_zero().dot(point - a).abs()
    });
    distance.fold(f64::INFINITY, f64::min)
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
