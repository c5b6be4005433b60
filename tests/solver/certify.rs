//! With `--certify` only proofs are inherited. A failure means that a guess was passed on as one.

use lightshaft::radiosity::{LinkClass, Solution, SolveOptions};
use lightshaft::visibility::{Strategy, VisibilityOptions};

use crate::boxes::Rectangles;
use crate::solving::{Case, options};

fn solve(case: &Case, strategy: Strategy, certify: bool) -> Solution {
    let visibility = VisibilityOptions { strategy, rays: 16, certify };
    case.solve(&case.fallback(), &SolveOptions { visibility, ..options(strategy) })
}

/// Inherited links: all, and those that are not proved.
fn inherited(solution: &Solution) -> [usize; 2] {
    let inherited = || solution.links.links.iter().filter(|l| l.is_inherited());
    [inherited().count(), inherited().filter(|l| l.class != LinkClass::CertifiedVisible).count()]
}

fn cases() -> [Case; 2] {
    let mut furnace = Rectangles::new("furnace");
    let grey = furnace.material(0.5, 1.0);
    furnace.closed_box([0.0; 3], [4.0, 3.0, 2.5], true, grey);
    furnace.closed_box([1.2, 1.0, 0.7], [2.6, 1.9, 1.6], false, grey);
    [Case::of(furnace.finish(), false), Case::load("cornell-box")]
}

#[test]
fn only_proved_classes_are_inherited() {
    for case in cases() {
        for strategy in [Strategy::Shaft, Strategy::Adaptive] {
            let [all, sampled] = inherited(&solve(&case, strategy, true));
            println!("{} {}: {all} links inherited, {sampled} not proved", case.scene.name, strategy.name());
            assert_eq!(sampled, 0, "{} {}", case.scene.name, strategy.name());
            assert!(all > 0, "{} {}: nothing inherited", case.scene.name, strategy.name());
        }
    }
}

/// The check itself: without `--certify` sampled classes are inherited, and it sees that.
#[test]
fn without_certify_sampled_classes_are_inherited() {
    for case in cases() {
        let [_, sampled] = inherited(&solve(&case, Strategy::Root, false));
        assert!(sampled > 0, "{}", case.scene.name);
    }
}
