//! How far the visibility that links hold is from what very many rays say.

use super::estimate::Party;
use super::links::{Link, LinkClass};
use super::shading::Shading;
use super::solve::Solution;
use crate::hierarchy::Hierarchy;
use crate::math::hash_pair;
use crate::tracer::{NO_FACET, Tracer};
use crate::visibility::{CandidateSet, Inheritance, Pair, Strategy, Tester, VisibilityOptions, Worker};
use rayon::prelude::*;
use serde::Serialize;

/// Rays that decide for each link.
const RAYS: u32 = 256;

/// Most links that are looked at, spread evenly over all.
const MOST_LINKS: usize = 100_000;

/// Keeps the rays apart from those that the links were made with.
const OTHER_RAYS: u64 = 0x5eed_0f07_4e7a_2757;

/// Difference between the visibility of links and the share of many rays that are clear.
///
/// Links count by the power that they would carry unobstructed: form factor × exitance × area. (By form factor and
/// area alone, a single link between clusters inside each other, from surfaces that are as good as dark, can
/// outweigh all others.) The rays have noise of their own, up to 0.03 of a link that is half visible.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct VisibilityError {
    /// Links looked at.
    pub links: u64,
    /// Weighted mean of the absolute difference.
    pub mean: f64,
    /// The difference that links with 0.1 % of the weight exceed.
    pub percentile_999: f64,
}

impl VisibilityError {
    /// Casts 256 other rays for each of up to 100 000 links of a solution that was found with `strategy`.
    pub fn of(
        solution: &Solution,
        hierarchy: &Hierarchy,
        tracer: &dyn Tracer,
        strategy: Strategy,
    ) -> VisibilityError {
        let options = VisibilityOptions { strategy: Strategy::Root, rays: RAYS, certify: false };
        let tester = Tester::new(hierarchy, tracer, options);
        let links: Vec<&Link> =
            solution.links.links.iter().filter(|link| link.class != LinkClass::Untested).collect();
        let step = links.len().div_ceil(MOST_LINKS).max(1);
        let some: Vec<&Link> = links.into_iter().step_by(step).collect();
        let differences = some
            .par_chunks(256)
            .flat_map_iter(|chunk| {
                let mut worker = Worker::default();
                let of_one =
                    |link: &&Link| difference(solution, hierarchy, &tester, strategy, &mut worker, link);
                chunk.iter().filter_map(of_one).collect::<Vec<_>>()
            })
            .collect();
        VisibilityError::summed(differences)
    }

    /// From weights and differences.
    fn summed(mut differences: Vec<(f64, f64)>) -> VisibilityError {
        differences.sort_by(|a, b| b.1.total_cmp(&a.1));
        let weight: f64 = differences.iter().map(|(weight, _)| weight).sum();
        let mut above = 0.0;
        let exceeds = |(part, _): &&(f64, f64)| {
            above += part;
            above > 1e-3 * weight
        };
        VisibilityError {
            links: differences.len() as u64,
            mean: differences.iter().fold(0.0, |sum, (part, difference)| sum + part * difference)
                / weight.max(f64::MIN_POSITIVE),
            percentile_999: differences.iter().find(exceeds).map_or(0.0, |&(_, difference)| difference),
        }
    }
}

/// The weight of a link and how far its visibility is off; `None` for one that carries nothing.
fn difference(
    solution: &Solution,
    hierarchy: &Hierarchy,
    tester: &Tester<'_>,
    strategy: Strategy,
    worker: &mut Worker,
    link: &Link,
) -> Option<(f64, f64)> {
    let (forest, light) = (&solution.forest, &solution.light);
    let [receiver, source] =
        [link.receiver, link.source].map(|id| Party::of_id(id, hierarchy, forest, light));
    let unobstructed = light.carried(hierarchy, forest, &Link { visibility: 1.0, ..*link });
    let power = unobstructed.element_sum() as f64 * receiver.area(hierarchy);
    if power.is_nan() || power <= 0.0 {
        return None;
    }
    let (lit, shining) = (receiver.part_facing(&source), source.part_facing(&receiver));
    let shading = Shading { source: &source, forest, light };
    let root = CandidateSet::root();
    let many = tester.weigh(
        worker,
        &Pair {
            receiver: &receiver.end(lit.as_ref()),
            source: &source.end(shining.as_ref()),
            seed: hash_pair(hash_pair(receiver.key(), source.key()), OTHER_RAYS),
            inherited: Inheritance { candidates: &root, blocker: NO_FACET },
            subdivided: false,
            importance: 0.0,
            prominence: 0.0,
            // What the fraction of a link means is up to the strategy.
            brightness: (strategy != Strategy::Sampled && !source.is_uniform()).then_some(&shading),
        },
    );
    Some((power, (many - link.visibility).abs() as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_weighted() {
        let mut differences = vec![(1.0, 0.0); 1996];
        differences.extend([(2.0, 0.5), (1.0, 1.0), (1.0, 0.25)]);
        let error = VisibilityError::summed(differences);
        assert_eq!((error.links, error.percentile_999), (1999, 0.5));
        assert!((error.mean - 2.25 / 2000.0).abs() < 1e-12);
        assert_eq!(VisibilityError::summed(Vec::new()), VisibilityError::default());
    }
}
