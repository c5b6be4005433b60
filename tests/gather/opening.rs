//! A point in a black room with a small opening into a room of uniform exitance receives that exitance
//! times the form factor of the opening: see `tests/solver/two_rooms.rs`. A failure means that light
//! through doors and windows is wrong.

use std::f64::consts::PI;

use glam::DVec3;
use lightshaft::visibility::Strategy;

use crate::asking::{Point, gather, tracers};
use crate::lambert;
use crate::solving::{Case, rough};
use crate::two_rooms::{OPENING, RADIANCE, two_rooms};

fn exact((point, normal): Point) -> f64 {
    let [low, high] = OPENING;
    let opening = [(low, low), (high, low), (high, high), (low, high)].map(|(y, z)| DVec3::new(0.0, y, z));
    PI * RADIANCE * lambert::polygon(point, normal, &opening)
}

/// On the far wall opposite the opening and in its corner, on floor, side wall and ceiling, in the air.
fn points() -> [Point; 7] {
    [
        (DVec3::new(2.0, 1.0, 1.0), -DVec3::X),
        (DVec3::new(2.0, 0.1, 1.9), -DVec3::X),
        (DVec3::new(1.0, 1.0, 0.0), DVec3::Z),
        (DVec3::new(0.3, 1.1, 0.0), DVec3::Z),
        (DVec3::new(1.2, 0.0, 0.9), DVec3::Y),
        (DVec3::new(1.9, 1.7, 2.0), -DVec3::Z),
        (DVec3::new(0.2, 1.0, 1.0), -DVec3::X),
    ]
}

/// Relative. Rays go to all walls that shine and few of them through the opening: of 65 536 some 2000 do
/// from the far wall, about 200 of the parts they stand for are cut by the frame, and each is decided as a
/// whole: 0.3 % at random, with three times that as the largest of fourteen.
const TOLERANCE: f64 = 0.01;
const SAMPLES: u32 = 65_536;

#[test]
fn a_room_is_lit_through_a_small_opening() {
    let case = Case::of(two_rooms(0.0).finish(), false);
    let points = points();
    let mut worst = 0.0f64;
    for tracer in tracers(&case) {
        let found = gather(&case, tracer.as_ref(), &rough(Strategy::Adaptive), SAMPLES, &points);
        for (&point, [total, direct]) in points.iter().zip(found) {
            let error = direct / exact(point) - 1.0;
            println!("{}, {}: {direct:.5} ({:+.3} %)", tracer.name(), point.0, 100.0 * error);
            worst = worst.max(error.abs());
            assert!(error.abs() < TOLERANCE, "{}, {point:?}: {direct} for {}", tracer.name(), exact(point));
            assert_eq!(total, direct, "black walls reflect nothing");
        }
    }
    println!("largest relative error {worst:.2e}");
}

/// A surface keeps light from behind off the points on it, whichever way their normals are tilted. The first
/// room is behind the wall between the two, and the opening lies in the plane of that wall.
#[test]
fn no_light_from_behind_a_wall_reaches_a_tilted_normal_on_it() {
    let case = Case::of(two_rooms(0.0).finish(), false);
    let tilted =
        [DVec3::X, DVec3::new(0.9, 0.435, 0.0), DVec3::new(0.6, -0.8, 0.0), DVec3::new(0.28, 0.0, 0.96)];
    let points = tilted.map(|normal| (DVec3::new(0.0, 1.6, 0.5), normal.normalize()));
    let found = gather(&case, &case.fallback(), &rough(Strategy::Adaptive), 256, &points);
    assert!(found.iter().all(|&light| light == [0.0; 2]), "{found:?}");
    // The same from the other side sees the walls that shine.
    let back = points.map(|(point, normal)| (point, -normal));
    let found = gather(&case, &case.fallback(), &rough(Strategy::Adaptive), 256, &back);
    assert!(found.iter().all(|&[_, direct]| direct > 1.0), "{found:?}");
}

/// The check itself: a shutter over a tenth of the opening has to be noticed.
#[test]
fn a_shutter_is_noticed() {
    let case = Case::of(two_rooms(0.1).finish(), false);
    let points = points();
    let found = gather(&case, &case.fallback(), &rough(Strategy::Adaptive), SAMPLES, &points);
    for (&point, [_, direct]) in points.iter().zip(found) {
        assert!(direct / exact(point) - 1.0 < -TOLERANCE, "{point:?}: {direct} for {}", exact(point));
    }
}
