//! Power that is emitted in a closed scene is absorbed there. A failure means that light is made or
//! lost, or that the balance in the statistics cannot be trusted.

use glam::DVec3;
use lightshaft::radiosity::SolveOptions;
use lightshaft::visibility::Strategy;

use crate::boxes::Rectangles;
use crate::solving::{Case, OWN_SCENES, normal, options};

#[test]
fn all_that_a_closed_room_emits_is_absorbed() {
    let case = Case::load("paper-1");
    let energy = case.solve(&case.fallback(), &normal()).energy;
    println!("{energy:?}");
    let share = energy.absorbed / energy.emitted;
    assert!((share - 1.0).abs() < 0.01, "{share} of the power is absorbed");
}

#[test]
fn power_is_balanced() {
    for name in OWN_SCENES {
        let case = Case::load(name);
        let energy = case.solve(&case.fallback(), &normal()).energy;
        println!("{name}: balance error {:.3} %, {energy:?}", 100.0 * energy.balance_error());
        assert!(energy.balance_error() < 0.01, "{name}: {energy:?}");
    }
}

/// Two congruent triangles at a right angle, near to each other but not alike: of two that are equally large neither is
/// the one to integrate over, so both ways have to choose the same.
#[test]
fn equals_exchange_the_same_both_ways() {
    let mut scene = Rectangles::new("equals");
    let lamp = scene.material(0.5, 1.0);
    let first = [[0.25, 0.0, 0.0], [2.25, 0.0, 0.0], [0.25, 1.0, 0.0]];
    let turned = first.map(|[x, y, z]| [z, x, y + 0.25]);
    for corners in [first, turned] {
        scene.triangles([corners.map(DVec3::from_array)], lamp);
    }
    let case = Case::of(scene.finish(), true);
    let whole = SolveOptions { min_size: Some(8.0), ..options(Strategy::Adaptive) };
    let solution = case.solve(&case.fallback(), &whole);
    let clusters = case.hierarchy.nodes.len() as u32;
    let between_elements = solution.links.links.iter().filter(|l| l.receiver.min(l.source) >= clusters);
    let all: Vec<f64> = between_elements
        .map(|l| (l.factor * solution.forest.area[(l.receiver - clusters) as usize]) as f64)
        .collect();
    let [to, fro] = all[..] else { panic!("two links, not {all:?}") };
    assert!(to > 0.01 && (to / fro - 1.0).abs() < 1e-6, "{to} and {fro}");
}
