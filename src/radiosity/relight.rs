//! Other light for a scene that is solved already: materials have changed, geometry has not, so links and what is
//! known of visibility stay.
//!
//! Links were divided for the light that there was. Where there is other light now, some are coarser than it would have
//! them; how much light comes over such links is measured. Pairs that rays found blocked where little light went are given
//! up, and nothing remembers them; how much light falls where there was little before says whether that may matter. Links
//! from what was dark were never tested: where something
//! shines now that did not, links are refined with the new light, as when a scene is solved.

use super::flight::rooms;
use super::forest::Forest;
use super::links::{Link, LinkClass, LinkSet};
use super::refine::Refiner;
use super::solve::{Beginning, Record, Solution, SolveOptions, final_thresholds, iterate};
use super::transport::Light;
use crate::hierarchy::Hierarchy;
use crate::progress::{Progress, Silent};
use crate::tracer::Tracer;
use crate::visibility::Tester;
use rayon::prelude::*;
use std::cell::Cell;
use std::time::Instant;

/// What becomes so many times brighter, relative to all light, was dark before. Of a source: then links from it that
/// were not tested are tested, since the little that it sent was none that mattered.
const RISEN: f64 = 4.0;

/// Iterations are as many as the light needs, at most so many.
const ITERATIONS: u32 = 4000;

/// What becomes of the links of a solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reuse {
    /// They stay as they are, unless something shines now that was dark.
    Links,
    /// Those are divided further that are too coarse for the new light.
    Refined,
}

/// A solution with other light.
#[derive(Debug)]
pub struct Relit {
    /// The solution. Its counters go on from those of the one before; its seconds are those of this light.
    pub solution: Solution,
    /// Links that were not tested because their source was dark, and it is not any more. If there are any, links are
    /// refined.
    pub untested: u64,
    /// Share of the light that comes over links which the new light would have divided further.
    pub coarse: f64,
    /// Share of the light that falls where there was little before: on sides of facets that receive several times as much
    /// now, in proportion to all light.
    pub moved: f64,
}

/// The light of `solved` with the materials that the hierarchy has now; its geometry is the one that was solved, and
/// `options` are those of that time. `square_meters` is the area of one local unit of area.
pub fn relight(
    hierarchy: &Hierarchy,
    tracer: &dyn Tracer,
    solved: Solution,
    options: &SolveOptions,
    reuse: Reuse,
    square_meters: f64,
    progress: &dyn Progress,
) -> Relit {
    let begun = Instant::now();
    let Solution { mut forest, light: before, links, openness, factor, counters, min_size, .. } = solved;
    let options =
        SolveOptions { iterations: options.iterations.max(ITERATIONS), record: Record::Nothing, ..*options };
    let (bright_before, sent_before) = (brightness(&before), before.sent(&forest));
    let received_before = received(hierarchy, &before, &forest);
    drop(before);
    forest.change_materials(hierarchy);
    let untested = Cell::new(0);
    let is_refined = |forest: &Forest, links: &LinkSet, light: &Light| {
        let (bright, scale) = (brightness(light), RISEN * light.sent(forest) / sent_before);
        let has_risen = |source: usize| {
            let (now, most) = (f64::from(bright[source]), scale * f64::from(bright_before[source]));
            // Of nothing before, nothing is the most, whatever the scale.
            now > 0.0 && !(most.is_finite() && now <= most)
        };
        let count = links
            .links
            .iter()
            .filter(|link| link.class == LinkClass::Untested && has_risen(link.source as usize));
        untested.set(count.count() as u64);
        reuse == Reuse::Refined || untested.get() > 0
    };
    let beginning = Beginning {
        begun,
        forest,
        links,
        openness,
        factor,
        counters,
        min_size: Some(min_size),
        is_refined: Some(&is_refined),
    };
    let solution = iterate(hierarchy, tracer, beginning, &options, square_meters, progress);
    let coarse = coarse_share(hierarchy, tracer, &solution, &options);
    let moved = moved_share(&received_before, &received(hierarchy, &solution.light, &solution.forest));
    Relit { solution, untested: untested.get(), coarse, moved }
}

/// Power that each side of a facet receives, largest channel, local areas. Elements have other numbers when links are
/// refined.
fn received(hierarchy: &Hierarchy, light: &Light, forest: &Forest) -> Vec<f64> {
    let roots = (0..forest.side_count()).map(|side| forest.root(hierarchy, side).cell as usize);
    roots.map(|e| f64::from(light.irradiance[e].max_element() * forest.area[e])).collect()
}

/// Share of the power now that is received where there was little, see [`RISEN`].
fn moved_share(before: &[f64], now: &[f64]) -> f64 {
    let all: f64 = now.iter().sum();
    let scale = RISEN * all / before.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let risen = before.iter().zip(now).filter(|&(before, now)| *now > scale * before);
    risen.fold(0.0, |sum, (_, now)| sum + now) / all.max(f64::MIN_POSITIVE)
}

/// What each node sends out, by its id in links: power of clusters, exitance of elements, largest channel.
fn brightness(light: &Light) -> Vec<f32> {
    let elements = light.exitance.iter().map(|exitance| exitance.max_element());
    light.power.iter().copied().chain(elements).collect()
}

/// Share of the light that comes over links which refinement with this light would divide.
fn coarse_share(
    hierarchy: &Hierarchy,
    tracer: &dyn Tracer,
    solution: &Solution,
    options: &SolveOptions,
) -> f64 {
    let Solution { forest, light, links, .. } = solution;
    let wall_area = rooms(hierarchy, forest, light, tracer).wall_area;
    let Some(thresholds) = final_thresholds(hierarchy, forest, light, wall_area, options) else { return 0.0 };
    let tester = Tester::new(hierarchy, tracer, options.visibility);
    let refiner = Refiner {
        hierarchy,
        forest,
        light,
        tester: &tester,
        thresholds,
        record: Record::Nothing,
        progress: &Silent,
    };
    let clusters = hierarchy.nodes.len();
    let power = |link: &Link| {
        let receiver = link.receiver as usize;
        let area = receiver
            .checked_sub(clusters)
            .map_or_else(|| hierarchy.nodes[receiver].area, |element| forest.area[element]);
        f64::from(light.carried(hierarchy, forest, link).max_element() * area)
    };
    let sums: Vec<[f64; 2]> = links
        .links
        .par_chunks(4096)
        .map(|chunk| {
            chunk.iter().fold([0.0; 2], |[all, coarse], link| {
                let power = power(link);
                let is_coarse = power > 0.0 && refiner.is_coarse(link);
                [all + power, if is_coarse { coarse + power } else { coarse }]
            })
        })
        .collect();
    let [all, coarse] = sums.iter().fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
    coarse / all.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_has_moved_where_it_falls_on_what_was_dark() {
        assert!(moved_share(&[10.0, 0.1], &[0.1, 10.0]) > 0.98);
        assert_eq!(moved_share(&[10.0, 0.0], &[10.0, 10.0]), 0.5);
        for now in [[100.0, 1.0], [0.1, 0.001], [10.0, 0.3], [0.0, 0.0]] {
            assert_eq!(moved_share(&[10.0, 0.1], &now), 0.0);
        }
    }
}
