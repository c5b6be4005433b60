//! A scene far from the origin is traced like the same scene at the origin. A failure means that models in
//! geographic coordinates get holes.

use glam::DVec3;
use lightshaft::compare::{FAMILIES, Family, distance_to_change, segments};
use lightshaft::hierarchy::{Hierarchy, TOLERANCE};
use lightshaft::progress::Silent;
use lightshaft::scene::{Camera, ImportCounts, Material, Scene, Triangle};
use lightshaft::tracer::{BruteTracer, Candidates, NO_FACET, Segment, TraceMesh};

use crate::meshes::soup;
use crate::tracers;
use crate::verdict::{blockers, compare};

/// The mesh as a scene of its own, moved by `shift`.
fn scene(mesh: &TraceMesh, shift: DVec3) -> Scene {
    let camera = Camera {
        name: "main".to_owned(),
        eye: shift,
        target: shift + DVec3::X,
        up: DVec3::Z,
        vfov_deg: 60.0,
        width: 8,
        height: 8,
    };
    let triangles = mesh.triangles.iter().zip(&mesh.facet_of_triangle);
    Scene {
        rectangles: Vec::new(),
        name: "soup".to_owned(),
        positions: mesh.positions.iter().map(|p| p.as_dvec3() + shift).collect(),
        triangles: triangles.map(|(&vertices, &patch)| Triangle { vertices, material: 0, patch }).collect(),
        materials: vec![Material {
            name: "grey".to_owned(),
            reflectance: [0.5; 3],
            radiance: [0.0; 3],
            painting: None,
        }],
        cameras: vec![camera],
        meters_per_unit: 1.0,
        patch_count: mesh.first_triangle.len() as u32 - 1,
        counts: ImportCounts::default(),
        files: Vec::new(),
        warnings: Vec::new(),
    }
}

/// At 10⁶ times its size the scene keeps about 10 digits of its own in double precision, more than single
/// precision has: nothing but the rounding to single precision may differ, so the tolerance is the same as
/// beside the origin.
#[test]
fn a_scene_far_from_the_origin_is_traced_like_one_at_it() {
    let mesh = soup(300, 21);
    let shift = DVec3::new(1e6 + 1.0 / 3.0, -2e6, 5e5 / 3.0);
    let near = Hierarchy::build(&scene(&mesh, DVec3::ZERO), false, &Silent);
    let far = Hierarchy::build(&scene(&mesh, shift), false, &Silent);
    let (near_judge, far_judge) = (BruteTracer::new(&near.mesh), BruteTracer::new(&far.mesh));
    let (mut differing, mut farthest, mut all) = (0, 0.0f64, 0);
    for (index, family) in FAMILIES.into_iter().enumerate() {
        let at_origin: Vec<Segment> = segments(&near.mesh, family, 1500, 300 + index as u64)
            .into_iter()
            .map(|segment| Segment { skip: [NO_FACET; 2], ..segment })
            .collect();
        let moved =
            |p: glam::Vec3| far.frame.local_from_scene(near.frame.scene_from_local(p.as_dvec3()) + shift);
        let far_away: Vec<Segment> = at_origin
            .iter()
            .map(|s| Segment { from: moved(s.from), to: moved(s.to), skip: s.skip })
            .collect();
        for tracer in tracers(&far.mesh) {
            let verdicts = compare(&far.mesh, tracer.as_ref(), &far_away);
            println!("{family:?}, {}: {verdicts}", tracer.name());
            assert_eq!(verdicts.wrong, 0, "{family:?}, {}: {verdicts}", tracer.name());
            assert!(verdicts.edge_on == 0 || family == Family::InPlane, "{family:?}: {verdicts}");
        }
        let expected = blockers(&near_judge, &at_origin, Candidates::All);
        let found = blockers(&far_judge, &far_away, Candidates::All);
        for ((segment, e), f) in at_origin.iter().zip(expected).zip(found) {
            all += 1;
            if (e == NO_FACET) != (f == NO_FACET) {
                // Facets may be numbered differently there: the nearest one is what decides.
                let facets = 0..near.facets.len() as u32;
                let distance = facets
                    .map(|facet| distance_to_change(&near.mesh, facet, segment))
                    .fold(f64::INFINITY, f64::min);
                differing += 1;
                farthest = farthest.max(distance);
                assert!(distance <= TOLERANCE, "{family:?}: {segment:?} is {distance:e} from any edge");
            }
        }
    }
    println!("{differing} of {all} segments differ from those at the origin, within {farthest:.1e}");
}

/// The check itself: in single precision without recentring the same scene falls to pieces.
#[test]
fn without_recentring_the_difference_is_noticed() {
    let mesh = soup(300, 21);
    let shift = DVec3::new(1e6 + 1.0 / 3.0, -2e6, 5e5 / 3.0);
    let rounded = |p: glam::Vec3| ((p.as_dvec3() + shift).as_vec3().as_dvec3() - shift).as_vec3();
    let coarse =
        TraceMesh { positions: mesh.positions.iter().map(|&p| rounded(p)).collect(), ..mesh.clone() };
    let [family, ..] = FAMILIES;
    let segments = segments(&mesh, family, 1500, 300);
    let verdicts = compare(&mesh, &BruteTracer::new(&coarse), &segments);
    println!("without recentring: {verdicts}");
    assert!(verdicts.wrong > 100, "{verdicts}");
}
