//! Power that is emitted in a closed scene is absorbed there. A failure means that light is made or
//! lost, or that the balance in the statistics cannot be trusted.

use crate::solving::{Case, OWN_SCENES, normal};

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
