//! Scenes with sizes far apart. A failure means that refinement never ends, or ends too early.

use std::f64::consts::PI;

use lightshaft::radiosity::Solution;

use crate::boxes::Rectangles;
use crate::solving::{Case, normal};

/// Far more elements than any of these scenes needs.
const MOST_ELEMENTS: usize = 200_000;

/// A horizontal square around the middle of the scene; its front is above or below.
fn level(half: f64, height: f64, faces_up: bool) -> [[f64; 3]; 4] {
    let mut corners =
        [[-half, -half, height], [half, -half, height], [half, half, height], [-half, half, height]];
    if !faces_up {
        corners.reverse();
    }
    corners
}

fn solve(case: &Case) -> Solution {
    let solution = case.solve(&case.fallback(), &normal());
    let (elements, energy) = (solution.forest.len(), solution.energy);
    println!("{}: {elements} elements, {} links, {energy:?}", case.scene.name, solution.links.links.len());
    assert!(elements < MOST_ELEMENTS, "{}: {elements} elements", case.scene.name);
    solution
}

/// Between plates that almost touch, light goes to and fro as between endless ones: with reflectance ½
/// on both and exitance π from one, it has 4π/3 and the other receives that.
#[test]
fn a_narrow_gap_fills_with_light() {
    let mut scene = Rectangles::new("narrow gap");
    let (dark, bright) = (scene.material(0.5, 0.0), scene.material(0.5, 1.0));
    scene.quad(level(2.0, 0.0, true), dark);
    scene.quad(level(2.0, 0.0005, false), bright);
    let case = Case::of(scene.finish(), false);
    let found = case.mean_irradiance(&solve(&case), dark) / (4.0 * PI / 3.0);
    assert!((found - 1.0).abs() < 0.01, "{found} of what endless plates have");
}

/// All the light of a lamp just above the ground falls on it, though that be 10 km wide.
#[test]
fn a_lamp_lights_a_wide_ground() {
    let mut scene = Rectangles::new("wide ground");
    let (ground, lamp) = (scene.material(0.5, 0.0), scene.material(0.0, 10.0));
    scene.quad(level(5000.0, 0.0, true), ground);
    scene.quad(level(0.5, 3.0, false), lamp);
    let case = Case::of(scene.finish(), false);
    let found = case.mean_irradiance(&solve(&case), ground) * 10_000.0 * 10_000.0 / (10.0 * PI);
    assert!((found - 1.0).abs() < 0.01, "{found} of the light arrives");
}

/// A one-sided screen turns its black back to the lamp: all that the lamp sends ends there, and the
/// ground stays dark.
#[test]
fn a_black_back_ends_the_light() {
    let mut scene = Rectangles::new("black back");
    let (ground, screen, lamp) =
        (scene.material(0.5, 0.0), scene.material(0.5, 0.0), scene.material(0.0, 10.0));
    scene.quad(level(1.0, 0.0, true), ground);
    scene.quad(level(2.0, 1.0, false), screen);
    scene.quad(level(0.5, 2.0, false), lamp);
    let case = Case::of(scene.finish(), true);
    let solution = solve(&case);
    assert_eq!(case.mean_irradiance(&solution, ground), 0.0);
    assert_eq!(case.mean_irradiance(&solution, screen), 0.0);
    assert!(solution.energy.balance_error() < 0.01, "{:?}", solution.energy);
}
