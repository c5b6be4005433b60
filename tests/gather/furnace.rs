//! The furnace, point by point: where every surface has reflectance ρ and radiance L, every point of a
//! closed scene receives πL directly and πL/(1 − ρ) altogether, whatever stands in it and whichever way
//! it faces. A failure means that light gathered at points is lost or made.

use std::f64::consts::PI;

use glam::DVec3;
use lightshaft::visibility::Strategy;

use crate::asking::{Point, SAMPLES, gather};
use crate::boxes::Rectangles;
use crate::solving::{Case, options};

const RADIANCE: f64 = 2.0;

/// A room of 4 × 3 × 2.5 with a box that stands clear of all walls.
fn furnace(reflectance: f32) -> Case {
    let mut room = Rectangles::new("furnace");
    let grey = room.material(reflectance, RADIANCE as f32);
    room.closed_box([0.0; 3], [4.0, 3.0, 2.5], true, grey);
    room.closed_box([1.2, 1.0, 0.7], [2.6, 1.9, 1.6], false, grey);
    Case::of(room.finish(), false)
}

/// In the middle of walls, near edges and corners and right on them, on the box, under it, and in the air.
fn points() -> [Point; 11] {
    [
        (DVec3::new(0.0, 1.5, 0.0), DVec3::Z),
        (DVec3::ZERO, DVec3::Z),
        (DVec3::new(4.0, 3.0, 1.1), -DVec3::X),
        (DVec3::new(2.0, 0.3, 0.0), DVec3::Z),
        (DVec3::new(0.01, 0.02, 0.0), DVec3::Z),
        (DVec3::new(4.0, 1.5, 1.2), -DVec3::X),
        (DVec3::new(4.0, 2.99, 2.49), -DVec3::X),
        (DVec3::new(1.9, 1.4, 1.6), DVec3::Z),
        (DVec3::new(1.9, 1.4, 0.7), -DVec3::Z),
        (DVec3::new(1.8, 1.3, 0.0), DVec3::Z),
        (DVec3::new(3.1, 0.9, 1.1), DVec3::new(0.48, -0.6, 0.64)),
    ]
}

/// Relative, for direct light: of the parts of walls that the box cuts in two, each is decided as a whole,
/// some 0.1 % at random with 4096 rays.
const DIRECT: f64 = 0.005;

/// Relative, for the light that a point finds reflected: what the solver may get wrong of an element, as
/// `tests/solver/furnace.rs` has it. A point in a corner sees mostly a few elements beside it.
const REFLECTED: f64 = 0.03;

#[test]
fn every_point_of_a_furnace_is_lit_alike() {
    for reflectance in [0.2, 0.5, 0.8] {
        let case = furnace(reflectance);
        let points = points();
        let exact = PI * RADIANCE / (1.0 - reflectance as f64);
        let found = gather(&case, &case.fallback(), &options(Strategy::Adaptive), SAMPLES, &points);
        for (point, [total, direct]) in points.iter().zip(found) {
            let errors = [total / exact - 1.0, direct / (PI * RADIANCE) - 1.0].map(|e| 100.0 * e);
            let what = format!("reflectance {reflectance}, {point:?}: {errors:+.3?} %");
            println!("{what}");
            assert!(errors[1].abs() < 100.0 * DIRECT, "{what}: {direct} direct");
            let most = 100.0 * (DIRECT + reflectance as f64 * REFLECTED);
            assert!(errors[0].abs() < most, "{what}: {total} for {exact}");
        }
    }
}

/// The check itself: light that gets out through a missing wall has to be noticed, even by points that
/// do not see where it was.
#[test]
fn a_missing_wall_is_noticed() {
    let mut scene = furnace(0.5).scene;
    scene.triangles.drain(..2);
    let case = Case::of(scene, false);
    let exact = PI * RADIANCE / 0.5;
    let found = gather(&case, &case.fallback(), &options(Strategy::Adaptive), SAMPLES, &points());
    let dark = found.iter().filter(|[total, _]| total / exact - 1.0 < -(DIRECT + 0.5 * REFLECTED));
    assert!(dark.count() >= 6, "{found:?} for {exact}");
}
