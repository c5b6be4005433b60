//! One coloured bounce: a lamp of known colour over a coloured floor that sees nothing else. What the floor sends
//! to a point is an integral over it of Lambert's formula, summed here midpoint by midpoint. A failure means that
//! rays find the wrong surface, leave in the wrong directions, or that channels are mixed up.

use std::f64::consts::PI;

use glam::DVec3;
use lightshaft::gather::Gatherer;
use lightshaft::scene::Scene;

use crate::asking::{Point, tracers};
use crate::boxes::Rectangles;
use crate::lambert;
use crate::solving::{Case, normal};

const RADIANCE: [f32; 3] = [1.0, 2.0, 4.0];
const REFLECTANCE: [f32; 3] = [0.8, 0.4, 0.1];
const FLOOR: f64 = 1.0;
const LAMP: [(f64, f64); 4] = [(-0.6, -0.2), (-0.6, 0.4), (0.2, 0.4), (0.2, -0.2)];
const HEIGHT: f64 = 1.5;

/// Relative, of reflected light: 16 384 rays of which a tenth to a half meet the floor leave 0.5 % at random
/// where its light varies most, elements at `normal` some 0.1 %.
const TOLERANCE: f64 = 0.01;
const SAMPLES: u32 = 16_384;

fn scene() -> Scene {
    let mut scene = Rectangles::new("a coloured bounce");
    let (floor, lamp) = (scene.material(0.5, 0.0), scene.material(0.0, 1.0));
    let f = FLOOR;
    scene.quad([[-f, -f, 0.0], [f, -f, 0.0], [f, f, 0.0], [-f, f, 0.0]], floor);
    scene.quad(LAMP.map(|(x, y)| [x, y, HEIGHT]), lamp);
    let mut scene = scene.finish();
    scene.materials[floor as usize].reflectance = REFLECTANCE;
    scene.materials[lamp as usize].radiance = RADIANCE;
    scene
}

/// Over the floor, beside it, and upright.
fn points() -> [Point; 5] {
    [
        (DVec3::new(-0.2, 0.1, 1.0), -DVec3::Z),
        (DVec3::new(0.9, -0.8, 0.3), -DVec3::Z),
        (DVec3::new(1.6, 0.2, 0.8), -DVec3::Z),
        (DVec3::new(1.8, 0.3, 0.6), -DVec3::X),
        (DVec3::new(-0.3, 1.2, 0.5), DVec3::new(0.0, -0.8, -0.6)),
    ]
}

/// What the floor sends to a point, for unit radiance and reflectance 1.
fn exact((point, normal): Point) -> f64 {
    const PARTS: usize = 200;
    let lamp = LAMP.map(|(x, y)| DVec3::new(x, y, HEIGHT));
    let side = 2.0 * FLOOR / PARTS as f64;
    let at = |i: usize| -FLOOR + (i as f64 + 0.5) * side;
    let mut sum = 0.0;
    for from in (0..PARTS * PARTS).map(|i| DVec3::new(at(i / PARTS), at(i % PARTS), 0.0)) {
        let to_floor = from - point;
        let cosines = (normal.dot(to_floor)).max(0.0) * point.z;
        let exitance = PI * lambert::polygon(from, DVec3::Z, &lamp);
        sum += exitance * cosines / (PI * to_floor.length_squared().powi(2)) * side * side;
    }
    sum
}

/// Largest relative error over points and channels, on each tracer.
fn errors(case: &Case) -> Vec<f64> {
    let error = |gatherer: &Gatherer<'_>, point: Point| {
        let found = gatherer.irradiance(point.0, point.1);
        let wanted =
            exact(point) * DVec3::from_array([0, 1, 2].map(|c| (RADIANCE[c] * REFLECTANCE[c]) as f64));
        ((found.total - found.direct) / wanted - 1.0).abs().max_element()
    };
    tracers(case)
        .iter()
        .map(|tracer| {
            let solution = case.solve(tracer.as_ref(), &normal());
            let gatherer = Gatherer::new(&case.hierarchy, tracer.as_ref(), &solution, SAMPLES);
            points().map(|point| error(&gatherer, point)).into_iter().fold(0.0, f64::max)
        })
        .collect()
}

#[test]
fn one_bounce_off_a_coloured_floor_is_the_integral_over_it() {
    for error in errors(&Case::of(scene(), false)) {
        println!("largest relative error {error:.2e}");
        assert!(error < TOLERANCE, "{error}");
    }
}

/// The check itself: two channels of the floor that are swapped have to be noticed, and a floor that is moved by
/// a twentieth of its size.
#[test]
fn swapped_channels_and_a_shifted_floor_are_noticed() {
    let mut swapped = scene();
    swapped.materials[0].reflectance.swap(0, 1);
    let mut shifted = scene();
    shifted.positions[..4].iter_mut().for_each(|corner| corner.x += 0.1);
    for scene in [swapped, shifted] {
        assert!(errors(&Case::of(scene, false)).iter().all(|&error| error > TOLERANCE));
    }
}
