//! Final gather: light at visible points over the links of a coarse solution, against closed forms, against rays over the
//! whole hemisphere, and behind a thin wall. A failure means that pictures by final gather show shadows in the wrong
//! place, too much or too little light, or light where none comes.

use glam::DVec3;
use lightshaft::gather::{FinalGather, Gatherer, Reconstruction, VisiblePoint};
use lightshaft::hierarchy::Side;
use lightshaft::image::{self, RenderOptions, View};
use lightshaft::progress::Silent;
use lightshaft::radiosity::Solution;
use lightshaft::scene::Camera;
use lightshaft::tracer::{Ray, Tracer};
use lightshaft::visibility::Strategy;
use rayon::ThreadPoolBuilder;

use crate::asking::Point;
use crate::boxes::Rectangles;
use crate::penumbra::{self, BOARDS};
use crate::solving::{Case, rough};

const RAYS: u32 = 256;

/// The side at each point, and the point in local coordinates.
pub(crate) fn sides(case: &Case, tracer: &dyn Tracer, points: &[Point]) -> Vec<(Side, DVec3)> {
    let local = |point: DVec3| case.hierarchy.frame.local_from_scene(point);
    let side = |&(point, normal): &Point| {
        let from = local(point + 1e-3 * normal);
        let ray = Ray { origin: from, direction: local(point) - from };
        let mut hit = [None];
        tracer.first_hits(&[ray], &mut hit);
        let hit = hit[0].expect("a surface at the point");
        (case.hierarchy.side_met(hit.facet, ray.direction), local(point).as_dvec3())
    };
    points.iter().map(side).collect()
}

/// Irradiance by final gather, and as interpolated: first channel.
fn both(case: &Case, tracer: &dyn Tracer, solution: &Solution, points: &[Point]) -> Vec<[f64; 2]> {
    let gather = FinalGather::new(&case.hierarchy, tracer, solution, RAYS, &Silent);
    let reconstruction = Reconstruction::new(&case.hierarchy, solution);
    let sides = sides(case, tracer, points);
    let visible: Vec<VisiblePoint> = (0..)
        .zip(&sides)
        .map(|(seed, &(side, point))| {
            let element = gather.element_at(side, point).expect("a side that takes part");
            VisiblePoint { side, point, element, seed }
        })
        .collect();
    let gathered = gather.irradiance(&visible);
    gathered
        .iter()
        .zip(&sides)
        .map(|(gathered, &(side, point))| {
            let spot = reconstruction.look_up(side, point).expect("a side that takes part");
            [gathered.x as f64, spot.irradiance.x as f64]
        })
        .collect()
}

fn rms(errors: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = errors.fold((0.0, 0.0), |(sum, count), error| (sum + error * error, count + 1.0));
    f64::sqrt(sum / count)
}

/// How far one of both values at points is from the half shadow of a board, over what there is without it.
pub(crate) fn off_shadow(board: penumbra::Board, points: &[Point], found: &[[f64; 2]], which: usize) -> f64 {
    rms(points.iter().zip(found).map(|((point, _), found)| {
        let (unblocked, exact, _) = penumbra::exact(board, point.x, point.y);
        (found[which] - exact) / unblocked
    }))
}

/// How far one of both values at points is from what rays over the hemisphere find, over the mean of that.
pub(crate) fn off_rays(
    case: &Case,
    tracer: &dyn Tracer,
    solution: &Solution,
    points: &[Point],
    found: &[[f64; 2]],
) -> [f64; 2] {
    let gatherer = Gatherer::new(&case.hierarchy, tracer, solution, 4096);
    let expected: Vec<f64> =
        points.iter().map(|&(point, normal)| gatherer.irradiance(point, normal).total.x).collect();
    let mean = expected.iter().sum::<f64>() / expected.len() as f64;
    [0, 1].map(|which| rms(found.iter().zip(&expected).map(|(f, e)| (f[which] - e) / mean)))
}

/// A coarse solution knows the half shadow of a board by a few elements: gathered it is sharp where it is sharp.
#[test]
fn shadows_are_exact_where_interpolation_blurs_them() {
    for board in BOARDS {
        let case = penumbra::scene(board);
        let points = penumbra::points(board);
        let tracer = case.fallback();
        let solution = case.solve(&tracer, &rough(Strategy::Adaptive));
        let found = both(&case, &tracer, &solution, &points);
        let error = |which: usize, shift: f64| {
            off_shadow(penumbra::Board { edge: board.edge + shift, ..board }, &points, &found, which)
        };
        let [gathered, interpolated, shifted] = [error(0, 0.0), error(1, 0.0), error(0, 0.05)];
        println!("{board:?}: gathered {gathered:.4}, interpolated {interpolated:.4}, shifted {shifted:.4}");
        assert!(gathered < 0.01, "{board:?}: {gathered}");
        assert!(gathered < 0.25 * interpolated, "{board:?}: {gathered}, interpolated {interpolated}");
        // The check itself: an edge that is off by a twentieth of the lamp.
        assert!(shifted > 0.02, "{board:?}: {shifted}");
    }
}

/// Points that a picture of the scene shows, with their normals.
pub(crate) fn seen(case: &Case, tracer: &dyn Tracer) -> Vec<Point> {
    let camera = &case.scene.cameras[0];
    let forward = (camera.target - camera.eye).normalize();
    let right = forward.cross(camera.up).normalize();
    let up = right.cross(forward);
    let half = (0.5 * camera.vfov_deg.to_radians()).tan();
    let mut points = Vec::new();
    for (i, j) in (0..12).flat_map(|i| (0..12).map(move |j| (i, j))) {
        let at = |k: i32| (f64::from(k) - 5.5) / 6.5 * half;
        let direction = forward + right * at(i) + up * at(j);
        let origin = case.hierarchy.frame.local_from_scene(camera.eye);
        let ray = Ray { origin, direction: direction.as_vec3() };
        let mut hit = [None];
        tracer.first_hits(&[ray], &mut hit);
        let Some(hit) = hit[0] else { continue };
        if case.hierarchy.material(hit.facet).is_emitter() {
            continue;
        }
        let normal = case.hierarchy.side_normal(case.hierarchy.side_met(hit.facet, ray.direction));
        let local = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(hit.t);
        points.push((case.hierarchy.frame.scene_from_local(local), normal));
    }
    points
}

/// Both ask the same coarse solution how bright surfaces are; final gather knows it a little better.
#[test]
fn light_agrees_with_rays_over_the_hemisphere() {
    let case = Case::load("cornell-box");
    let tracer = case.fallback();
    let solution = case.solve(&tracer, &rough(Strategy::Adaptive));
    let points = seen(&case, &tracer);
    assert!(points.len() > 100, "{}", points.len());
    let found = both(&case, &tracer, &solution, &points);
    let [gathered, interpolated] = off_rays(&case, &tracer, &solution, &points, &found);
    println!("gathered {gathered:.4}, interpolated {interpolated:.4}");
    assert!(gathered < 0.03, "{gathered}");
    assert!(gathered < 0.5 * interpolated, "{gathered} interpolated {interpolated}");
}

/// A room of 4 × 3 × 2.5 that a wall without thickness divides, open by `gap` at the top, with a lamp in one half.
fn divided(gap: f64) -> Case {
    let mut room = Rectangles::new("divided");
    let (grey, lamp) = (room.material(0.6, 0.0), room.material(0.0, 20.0));
    room.closed_box([0.0; 3], [4.0, 3.0, 2.5], true, grey);
    let top = 2.5 - gap;
    room.quad([[2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [2.0, 3.0, top], [2.0, 0.0, top]], grey);
    room.quad([[0.5, 1.0, 2.4], [0.5, 2.0, 2.4], [1.5, 2.0, 2.4], [1.5, 1.0, 2.4]], lamp);
    Case::of(room.finish(), false)
}

/// The brightest of the points behind the wall, relative to the mean before it.
fn behind(case: &Case) -> f64 {
    let tracer = case.fallback();
    let solution = case.solve(&tracer, &rough(Strategy::Adaptive));
    let distances = [0.002, 0.02, 0.06, 0.15, 0.4, 1.0];
    let on_floor = |side: f64| {
        let points = distances.iter().flat_map(move |d| [0.3, 1.1, 1.9, 2.7].map(|y| (d, y)));
        points.map(move |(d, y)| (DVec3::new(2.0 + side * d, y, 0.0), DVec3::Z)).collect::<Vec<Point>>()
    };
    let light = |points: &[Point]| both(case, &tracer, &solution, points).into_iter().map(|f| f[0]).collect();
    let (before, behind): (Vec<f64>, Vec<f64>) = (light(&on_floor(-1.0)), light(&on_floor(1.0)));
    behind.iter().copied().fold(0.0, f64::max) / (before.iter().sum::<f64>() / before.len() as f64)
}

#[test]
fn no_light_comes_through_a_wall_without_thickness() {
    let closed = behind(&divided(0.0));
    assert!(closed < 1e-3, "{closed}");
    // The check itself.
    let open = behind(&divided(0.3));
    assert!(open > 0.01, "{open}");
}

#[test]
fn the_picture_is_the_same_for_any_number_of_threads() {
    let case = Case::load("cornell-box");
    let tracer = case.fallback();
    let solution = case.solve(&tracer, &rough(Strategy::Adaptive));
    let camera = Camera { width: 61, height: 47, ..case.scene.cameras[0].clone() };
    let picture = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let options = RenderOptions { samples: 3, view: View::Gathered(64) };
        pool.install(|| image::render(&case.hierarchy, &tracer, &solution, &camera, options, &Silent))
    };
    let one = picture(1);
    assert!(one.pixels.iter().filter(|pixel| pixel[0] > 0.0).count() > 2000, "a black picture shows nothing");
    for threads in [2, 5] {
        assert!(picture(threads) == one, "{threads} threads");
    }
}
