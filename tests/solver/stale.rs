//! Links remember how bright what they see was when they were made. A failure means that light grows
//! without end where a source has since become uniform.

use lightshaft::radiosity::Quarters;
use lightshaft::visibility::Strategy;

use crate::solving::{Case, options};

#[test]
fn no_link_brings_more_than_the_brightest_part_of_its_source() {
    let case = Case::load("paper-1");
    let mut solution = case.solve(&case.fallback(), &options(Strategy::Adaptive));
    let clusters = case.hierarchy.nodes.len() as u32;
    // As if each source had been dark but for the one spot that is seen.
    let links = solution.links.links.iter_mut();
    for link in links.filter(|link| link.source >= clusters && link.quarters == Quarters::UNIFORM) {
        link.visibility = 100.0;
    }
    let light = &solution.light;
    let mut compared = 0;
    for node in clusters..clusters + solution.forest.len() as u32 {
        let links = solution.links.of(node);
        if links.is_empty() || links.iter().any(|link| link.source < clusters) {
            continue;
        }
        let most: f32 = links
            .iter()
            .map(|link| {
                let source = (link.source - clusters) as usize;
                link.factor * (light.exitance[source].max_element() + light.variation[source])
            })
            .sum();
        let found: f32 = solution.irradiance_by_class(&case.hierarchy, node).iter().sum();
        assert!(found <= most * 1.001, "{found} of {most}");
        compared += 1;
    }
    assert!(compared > 1000, "{compared}");
}
