//! `culling_anomalies` counts hits on facets that should have been candidates. A failure means that a
//! bug of the culling would stay hidden.

use lightshaft::hierarchy::Interval;
use lightshaft::tracer::{Candidates, Tracer};
use lightshaft::visibility::Strategy;

use crate::embree_or_skip::embree;
use crate::faulty_tracers::{Blind, without};
use crate::solving::{Case, links_only, rough};

#[test]
fn one_facet_is_taken_out_of_the_candidates() {
    let list = [(2, 5), (7, 8)].map(|(start, end)| Interval { start, end });
    let ends = |facet| -> Vec<(u32, u32)> {
        without(Candidates::Only(&list), facet).iter().map(|i| (i.start, i.end)).collect()
    };
    assert_eq!(ends(3), [(2, 3), (4, 5), (7, 8)]);
    assert_eq!(ends(2), [(3, 5), (7, 8)]);
    assert_eq!(ends(7), [(2, 5)]);
    assert_eq!(ends(6), [(2, 5), (7, 8)]);
}

/// Anomalies when one facet after the other is missing, and the number of facets that were noticed.
fn anomalies_of_wrong_culls(case: &Case, tracer: &dyn Tracer, strategy: Strategy) -> (u64, usize) {
    let facets = 0..case.hierarchy.facets.len() as u32;
    let counts: Vec<u64> = facets
        .map(|facet| {
            let miscull = Blind { tracer, facet, only_in_lists: true };
            case.solve(&miscull, &links_only(rough(strategy))).counters.visibility.culling_anomalies
        })
        .collect();
    (counts.iter().sum(), counts.iter().filter(|&&count| count > 0).count())
}

fn check_that_a_wrong_cull_is_counted(case: &Case, tracer: &dyn Tracer) {
    for strategy in [Strategy::Shaft, Strategy::Adaptive] {
        let right = case.solve(tracer, &links_only(rough(strategy))).counters.visibility;
        let (anomalies, noticed) = anomalies_of_wrong_culls(case, tracer, strategy);
        println!(
            "{} with {}: {} anomalies and {} border hits; {noticed} of {} missing facets are noticed by {anomalies}",
            strategy.name(),
            tracer.name(),
            right.culling_anomalies,
            right.border_hits,
            case.hierarchy.facets.len()
        );
        assert_eq!(right.culling_anomalies, 0, "{}", strategy.name());
        assert!(noticed > 0, "{}: missing facets are not noticed", strategy.name());
    }
}

#[test]
fn a_facet_missing_from_the_candidates_is_counted() {
    let case = Case::load("cornell-box");
    check_that_a_wrong_cull_is_counted(&case, &case.fallback());
}

#[test]
fn a_facet_missing_from_the_candidates_is_counted_on_embree() {
    let case = Case::load("cornell-box");
    let Some(tracer) = embree(&case.hierarchy.mesh) else { return };
    check_that_a_wrong_cull_is_counted(&case, &tracer);
}
