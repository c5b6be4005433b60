//! Power that is emitted in a closed scene is absorbed there. A failure means that light is made or
//! lost, or that the balance in the statistics cannot be trusted.

use lightshaft::radiosity::SolveOptions;
use lightshaft::visibility::Strategy;

use crate::solving::{Case, options};

/// Finer than the quality `normal`, which still loses about 2 % of the power of `paper-1`.
fn fine() -> SolveOptions {
    SolveOptions { epsilon: 3e-6, contrast: 0.1, resolution: 200.0, ..options(Strategy::Adaptive) }
}

#[test]
fn all_that_a_closed_room_emits_is_absorbed() {
    let case = Case::load("paper-1");
    let energy = case.solve(&case.fallback(), &fine()).energy;
    println!("{energy:?}");
    let share = energy.absorbed / energy.emitted;
    assert!((share - 1.0).abs() < 0.01, "{share} of the power is absorbed");
}

#[test]
fn power_is_balanced() {
    for name in ["cornell-box", "paper-1"] {
        let case = Case::load(name);
        let energy = case.solve(&case.fallback(), &fine()).energy;
        println!("{name}: balance error {:.3} %, {energy:?}", 100.0 * energy.balance_error());
        assert!(energy.balance_error() < 0.01, "{name}: {energy:?}");
    }
}
