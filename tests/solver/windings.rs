//! Which way round faces are wound: without `--one-sided` it does not matter, with it backs stay
//! black. A failure means black rooms, or light on the wrong side.

use lightshaft::hierarchy::Side;
use lightshaft::radiosity::Solution;
use lightshaft::scene::Scene;
use lightshaft::visibility::Strategy;

use crate::boxes::Rectangles;
use crate::solving::{Case, options};

const CENTER: glam::DVec3 = glam::DVec3::new(2.0, 1.5, 1.25);

/// A closed room with a lamp under the ceiling; its fronts look inwards, or at random.
fn room(mixed: bool) -> Scene {
    let mut room = Rectangles::new("room");
    let lamp = room.material(0.0, 10.0);
    let grey = room.material(0.5, 0.0);
    room.closed_box([0.0; 3], [4.0, 3.0, 2.5], true, grey);
    room.quad([[1.5, 1.0, 2.4], [1.5, 2.0, 2.4], [2.5, 2.0, 2.4], [2.5, 1.0, 2.4]], lamp);
    if mixed {
        room.turn_every_other_triangle(lamp);
    }
    room.finish()
}

/// Light on the inner sides of the walls.
struct Walls {
    /// Mean irradiance of each wall: −x, +x, −y, +y, −z, +z.
    mean: [f64; 6],
    darkest: f64,
}

fn light_inside(case: &Case, solution: &Solution) -> Walls {
    let forest = &solution.forest;
    let center = case.hierarchy.frame.local_from_scene(CENTER).as_dvec3();
    let (mut power, mut area, mut darkest) = ([0.0; 6], [0.0; 6], f64::MAX);
    for (facet, shape) in case.hierarchy.facets.iter().enumerate() {
        if case.hierarchy.materials[shape.material as usize].is_emitter() {
            continue;
        }
        let back = shape.plane.distance(center) < 0.0;
        let inwards = if back { -shape.plane.normal } else { shape.plane.normal };
        let axis = (0..3).find(|&i| inwards[i].abs() > 0.9).expect("walls stand along the axes");
        let wall = 2 * axis + usize::from(inwards[axis] < 0.0);
        let Some(side) = forest.side_index(Side { facet: facet as u32, back }) else {
            // One-sided, and turned away: it receives nothing.
            area[wall] += case.hierarchy.polygon(facet as u32).area();
            darkest = 0.0;
            continue;
        };
        for e in forest.elements_of(side) {
            if forest.second[e] == 0 {
                let irradiance = solution.light.irradiance[e].x as f64;
                power[wall] += irradiance * forest.area[e] as f64;
                area[wall] += forest.area[e] as f64;
                darkest = darkest.min(irradiance);
            }
        }
    }
    Walls { mean: std::array::from_fn(|i| power[i] / area[i]), darkest }
}

fn solve(mixed: bool, one_sided: bool) -> Walls {
    let case = Case::of(room(mixed), one_sided);
    let solution = case.solve(&case.fallback(), &options(Strategy::Adaptive));
    println!(
        "mixed {mixed}, one-sided {one_sided}: {} elements, balance error {:.3} %",
        solution.forest.len(),
        100.0 * solution.energy.balance_error()
    );
    light_inside(&case, &solution)
}

/// Largest relative difference of the means of the walls.
fn difference(a: &Walls, b: &Walls) -> f64 {
    let largest = (0..6).map(|i| (a.mean[i] / b.mean[i] - 1.0).abs()).fold(0.0, f64::max);
    println!("  {:?} against {:?}: {:.3} %", a.mean, b.mean, 100.0 * largest);
    largest
}

#[test]
fn a_room_of_mixed_windings_is_lit_like_a_proper_one() {
    let (proper, mixed) = (solve(false, false), solve(true, false));
    assert!(difference(&mixed, &proper) < 0.02, "{:?} for {:?}", mixed.mean, proper.mean);
    assert!(mixed.darkest > 0.5 * proper.darkest && proper.darkest > 0.0, "a black piece of wall");
}

#[test]
fn a_proper_room_is_lit_the_same_on_one_side() {
    let (two, one) = (solve(false, false), solve(false, true));
    assert!(difference(&one, &two) < 0.02, "{:?} for {:?}", one.mean, two.mean);
    assert!(one.darkest > 0.5 * two.darkest, "a black piece of wall");
}

/// The check itself: on one side, faces that are turned away are black, and it sees that.
#[test]
fn one_sided_faces_that_are_turned_away_stay_black() {
    let (proper, mixed) = (solve(false, true), solve(true, true));
    assert!(difference(&mixed, &proper) > 0.3);
    assert_eq!(mixed.darkest, 0.0);
}
