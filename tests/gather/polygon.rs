//! Point to polygon: the light of one lamp with nothing in between is Lambert's formula. A failure means
//! that direct light is wrong even where there is no shadow.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use lightshaft::visibility::Strategy;

use crate::asking::{Point, SAMPLES, gather, tracers};
use crate::boxes::Rectangles;
use crate::lambert;
use crate::solving::{Case, rough};

const RADIANCE: f64 = 3.0;

/// Relative. Every part of a lamp counts with its exact form factor, but parts too small to matter are
/// taken as points, with an error below 1 % that falls with the square of their size, and the smallest
/// share rays.
const TOLERANCE: f64 = 1e-3;

/// A regular polygon at height 2 around (0.3, −0.2), facing down.
fn regular(sides: usize, radius: f64) -> Vec<DVec3> {
    let corner = |i: usize| {
        let angle = -TAU * (i as f64 + 0.3) / sides as f64;
        DVec3::new(0.3 + radius * angle.cos(), -0.2 + radius * angle.sin(), 2.0)
    };
    (0..sides).map(corner).collect()
}

/// A black floor of 8 × 8 under a lamp.
fn scene(lamp: &[DVec3]) -> Case {
    let mut scene = Rectangles::new("a lamp over a floor");
    let (floor, shining) = (scene.material(0.0, 0.0), scene.material(0.0, RADIANCE as f32));
    scene.quad([[-4.0, -4.0, 0.0], [4.0, -4.0, 0.0], [4.0, 4.0, 0.0], [-4.0, 4.0, 0.0]], floor);
    let center = lamp.iter().sum::<DVec3>() / lamp.len() as f64;
    scene.fan(center, lamp, shining);
    Case::of(scene.finish(), false)
}

/// Under the lamp, off its axis, and in the air with normals that have part of it below their horizon.
fn points() -> Vec<Point> {
    let mut points = vec![
        (DVec3::new(0.3, -0.2, 0.0), DVec3::Z),
        (DVec3::new(0.8, 0.3, 0.0), DVec3::Z),
        (DVec3::new(3.9, 3.9, 0.0), DVec3::Z),
        (DVec3::new(-3.0, 0.4, 0.0), DVec3::Z),
        (DVec3::new(0.31, -0.22, 1.98), DVec3::Z),
        (DVec3::new(1.0, 0.0, 1.5), DVec3::Z),
    ];
    for degrees in [30.0f64, 60.0, 80.0, 90.0, 95.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        points.push((DVec3::new(-0.2, 0.1, 1.3), DVec3::new(sin, 0.0, cos)));
        points.push((DVec3::new(0.5, 0.6, 0.7), DVec3::new(0.6 * sin, -0.8 * sin, cos)));
    }
    points
}

#[test]
fn direct_light_of_a_polygon_is_lamberts() {
    let mut worst = 0.0f64;
    for (sides, radius) in [(3, 0.7), (4, 0.5), (4, 0.02), (6, 0.4), (8, 1.2)] {
        let lamp = regular(sides, radius);
        let case = scene(&lamp);
        let points = points();
        for tracer in tracers(&case) {
            let found = gather(&case, tracer.as_ref(), &rough(Strategy::Adaptive), SAMPLES, &points);
            for (&(point, normal), [_, direct]) in points.iter().zip(found) {
                let exact = PI * RADIANCE * lambert::polygon(point, normal, &lamp);
                assert!(exact > 0.0, "{point} does not see the lamp of {sides} sides");
                let error = direct / exact - 1.0;
                worst = worst.max(error.abs());
                let what = format!("{sides} sides of radius {radius}, {point}, {normal}");
                assert!(error.abs() < TOLERANCE, "{what}: {direct} for {exact} ({error:+.5})");
            }
        }
    }
    println!("largest relative error {worst:.2e}");
}

/// The same on scenes whose walls reflect nothing: all light is direct.
#[test]
fn between_black_surfaces_all_light_is_direct() {
    let case = scene(&regular(5, 0.5));
    let found = gather(&case, &case.fallback(), &rough(Strategy::Adaptive), 64, &points());
    assert!(found.iter().all(|[total, direct]| total == direct && *direct > 0.0), "{found:?}");
}

/// A lamp shines from its front only, and on what faces it only: exactly nothing anywhere else.
#[test]
fn behind_a_lamp_and_turned_away_from_it_is_no_light() {
    let case = scene(&regular(4, 0.5));
    let dark = [
        (DVec3::new(0.3, -0.2, 2.5), -DVec3::Z),
        (DVec3::new(0.3, -0.2, 2.5), DVec3::Z),
        (DVec3::new(0.3, -0.2, 0.5), -DVec3::Z),
        (DVec3::new(2.0, -0.2, 1.0), DVec3::X),
    ];
    let found = gather(&case, &case.fallback(), &rough(Strategy::Adaptive), 64, &dark);
    assert!(found.iter().all(|&values| values == [0.0; 2]), "{found:?}");
}

/// The check itself: a lamp a hundredth of its size away from where it is thought to be is noticed.
#[test]
fn a_shifted_lamp_is_noticed() {
    let lamp = regular(4, 0.5);
    let case = scene(&lamp.iter().map(|&p| p + DVec3::X * 0.01).collect::<Vec<_>>());
    let points = points();
    let found = gather(&case, &case.fallback(), &rough(Strategy::Adaptive), SAMPLES, &points);
    let off = points.iter().zip(found).filter(|((point, normal), [_, direct])| {
        let exact = PI * RADIANCE * lambert::polygon(*point, *normal, &lamp);
        (direct / exact - 1.0).abs() > TOLERANCE
    });
    assert!(off.count() > points.len() / 2);
}
