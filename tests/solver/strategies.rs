//! `all`, `root` and `shaft` find occluders in different ways and give the same links; so does every
//! strategy on both tracers. A failure means that a picture depends on how visibility was computed.

use crate::embree_or_skip::embree;
use crate::faulty_tracers::Blind;
use crate::second_opinion::SecondOpinion;
use crate::segments::most_frequent_blocker;
use crate::solving::{Case, OWN_SCENES, STRATEGIES, links_only, options, rough};
use lightshaft::compare::{LinkDifferences, NamedLinks};
use lightshaft::radiosity::{Solution, SolveOptions};
use lightshaft::tracer::Tracer;
use lightshaft::visibility::Strategy;

/// Share of the links that rays may decide differently because two tracers round differently. One such
/// ray changes a fraction, then the light, then whatever stood at a threshold of the refinement.
const BY_ROUNDING: f64 = 1e-3;

/// Options for a strategy.
type Settings = fn(Strategy) -> SolveOptions;

const SETTINGS: [(&str, Settings); 2] = [("rough", rough), ("finer", options)];

fn solved(case: &Case, tracer: &dyn Tracer, options: &SolveOptions) -> Solution {
    let solution = case.solve(tracer, options);
    let anomalies = solution.counters.visibility.culling_anomalies;
    let what = format!("{} {} with {}", case.scene.name, options.visibility.strategy.name(), tracer.name());
    assert_eq!(anomalies, 0, "{what}: hits on facets that were culled from the shaft they are in");
    solution
}

fn differences(case: &Case, [a, b]: [&Solution; 2]) -> LinkDifferences {
    NamedLinks::of(&case.hierarchy, a).compare(&NamedLinks::of(&case.hierarchy, b))
}

fn report(what: &str, differences: &LinkDifferences) {
    println!("{what}: {differences}");
    assert!(differences.links[0].max(differences.links[1]) > 50, "{what}: too few links to compare");
    assert!(differences.share() <= BY_ROUNDING, "{what}: {differences}");
    assert!(differences.share_of_invisible() <= BY_ROUNDING, "{what}: {differences}");
}

/// The strategies that differ only in how occluders are found, compared with one tracer.
fn compare_strategies(case: &Case, tracer: &dyn Tracer) {
    for (settings, options) in SETTINGS {
        let root = solved(case, tracer, &links_only(options(Strategy::Root)));
        for strategy in [Strategy::All, Strategy::Shaft] {
            let differences =
                differences(case, [&root, &solved(case, tracer, &links_only(options(strategy)))]);
            let name = &case.scene.name;
            let what = format!("{name}, {settings}, {}: root and {}", tracer.name(), strategy.name());
            report(&what, &differences);
        }
    }
}

#[test]
fn all_root_and_shaft_give_the_same_links() {
    for name in OWN_SCENES {
        let case = Case::load(name);
        compare_strategies(&case, &case.fallback());
    }
}

#[test]
fn all_root_and_shaft_give_the_same_links_on_embree() {
    for name in OWN_SCENES {
        let case = Case::load(name);
        let Some(tracer) = embree(&case.hierarchy.mesh) else { return };
        compare_strategies(&case, &tracer);
    }
}

#[test]
fn each_strategy_gives_the_same_links_on_both_tracers() {
    for name in OWN_SCENES {
        let case = Case::load(name);
        let Some(embree) = embree(&case.hierarchy.mesh) else { return };
        let fallback = case.fallback();
        // `all` has a list of its own and asks no tracer.
        for strategy in STRATEGIES.into_iter().filter(|&s| s != Strategy::All) {
            // Links that have been weighed again when the light has settled, too.
            for (settings, options) in SETTINGS {
                let asked = SecondOpinion::new(&embree, &fallback);
                let both = [&asked as &dyn Tracer, &fallback]
                    .map(|tracer| solved(&case, tracer, &options(strategy)));
                let differences = differences(&case, both.each_ref());
                let (rays, differing) = asked.counts();
                println!("  {differing} of {rays} rays differ by rounding");
                report(
                    &format!("{name}, {settings}, {}: embree and fallback", strategy.name()),
                    &differences,
                );
                assert!(differing * 50_000 <= rays, "{differing} of {rays} rays differ");
            }
        }
    }
}

/// The comparison itself: a tracer that does not see one facet has to be found out.
#[test]
fn a_tracer_blind_to_one_facet_is_noticed() {
    let case = Case::load("cornell-box");
    let tracer = case.fallback();
    let right = solved(&case, &tracer, &options(Strategy::Root));
    let blind = Blind::to(&tracer, most_frequent_blocker(&case));
    for strategy in [Strategy::Root, Strategy::Shaft] {
        let differences = differences(&case, [&right, &solved(&case, &blind, &options(strategy))]);
        println!("blind with {}: {differences}", strategy.name());
        assert!(differences.share() > 10.0 * BY_ROUNDING, "{}: {differences}", strategy.name());
    }
}
