//! The light of two solutions of one scene, place by place.

use crate::hierarchy::Hierarchy;
use crate::radiosity::{Piece, Solution, place};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// Differences of less than this share of what is reflected where light falls are not counted by area.
const NOTICED: f64 = 0.01;

/// Difference of exitance, W/m²; of three channels the one where it is largest, means over the area.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ExitanceDifference {
    /// Mean of what surfaces reflect in the first solution: what the mean difference is relative to.
    pub mean_reflected: f64,
    /// Root mean square of what they reflect: what that of the difference is relative to.
    pub rms_reflected: f64,
    /// Mean of what they reflect over the light that is reflected, not over the area: what a single place is relative
    /// to. A dark ground that is far larger than the rooms on it hardly counts.
    pub lit_reflected: f64,
    /// What all light is scaled by in each solution, so that none is lost.
    pub factors: [f64; 2],
    /// Mean: relative to what is reflected, the share of the light that lands elsewhere.
    pub mean: f64,
    /// Root of the mean square.
    pub rms: f64,
    /// Mean of second minus first, over channels too.
    pub bias: f64,
    /// The largest.
    pub max: f64,
    /// Share of the area, from 0 to 1, where the difference is more than 1 % of `lit_reflected`.
    pub noticed_area: f64,
    /// Where the largest is; empty when there is none.
    pub worst: String,
}

impl ExitanceDifference {
    /// A mean difference relative to what is reflected in the mean.
    pub fn relative(&self, difference: f64) -> f64 {
        difference / self.mean_reflected.max(f64::MIN_POSITIVE)
    }

    /// The root mean square of the difference, relative to that of what is reflected.
    pub fn relative_rms(&self) -> f64 {
        self.rms / self.rms_reflected.max(f64::MIN_POSITIVE)
    }

    /// The largest difference, relative to what is reflected where light falls.
    pub fn relative_max(&self) -> f64 {
        self.max / self.lit_reflected.max(f64::MIN_POSITIVE)
    }

    /// Compares the leaves of both forests; where one is finer it is compared leaf by leaf.
    pub fn between(hierarchy: &Hierarchy, [first, second]: [&Solution; 2]) -> ExitanceDifference {
        let reflected = Reflected::of(hierarchy, first);
        let sides: Vec<Sums> = (0..first.forest.side_count())
            .into_par_iter()
            .map(|side| {
                let roots = [first, second].map(|solution| solution.forest.root(hierarchy, side));
                let mut sums = Sums { noticed: NOTICED * reflected.lit, ..Sums::default() };
                sums.descend([first, second], roots);
                sums
            })
            .collect();
        // In order, so that the sums do not depend on the threads.
        let mut all = Sums::default();
        sides.iter().for_each(|sums| all.add(sums));
        let area = all.area.max(f64::MIN_POSITIVE);
        ExitanceDifference {
            mean_reflected: reflected.mean,
            rms_reflected: reflected.rms,
            lit_reflected: reflected.lit,
            factors: [first, second].map(|solution| f64::from(solution.factor)),
            mean: all.sum / area,
            rms: (all.squares / area).sqrt(),
            bias: all.signed / area,
            max: all.max,
            noticed_area: all.above / area,
            worst: all.worst.map_or_else(String::new, |element| {
                place(hierarchy, &first.forest, hierarchy.nodes.len() as u32 + element)
            }),
        }
    }
}

/// What surfaces reflect in one solution, of the brightest channel.
struct Reflected {
    /// Mean over the area.
    mean: f64,
    /// Root mean square over the area.
    rms: f64,
    /// Mean over the light.
    lit: f64,
}

impl Reflected {
    fn of(hierarchy: &Hierarchy, solution: &Solution) -> Reflected {
        let (forest, exitance) = (&solution.forest, &solution.light.exitance);
        let (mut power, mut sum, mut squares, mut area) = (DVec3::ZERO, 0.0, 0.0, 0.0);
        for side in 0..forest.side_count() {
            let emitted = hierarchy.emitted(forest.side(side));
            let elements = forest.elements_of(side);
            for element in elements.filter(|&element| forest.second[element] == 0) {
                let reflected = (exitance[element] - emitted).as_dvec3();
                let (own, most) = (f64::from(forest.area[element]), reflected.max_element());
                power += reflected * own;
                sum += most * own;
                squares += most * most * own;
                area += own;
            }
        }
        let over = |whole: f64, part: f64| whole / part.max(f64::MIN_POSITIVE);
        Reflected {
            mean: over(power.max_element(), area),
            rms: over(squares, area).sqrt(),
            lit: over(squares, sum),
        }
    }
}

#[derive(Default)]
struct Sums {
    /// A difference of more than this is counted by area.
    noticed: f64,
    area: f64,
    sum: f64,
    squares: f64,
    signed: f64,
    above: f64,
    max: f64,
    /// Element of the first solution with the largest difference.
    worst: Option<u32>,
}

impl Sums {
    /// Both pieces, or one of the two and what is above it in the other solution.
    fn descend(&mut self, solutions: [&Solution; 2], pieces: [Piece; 2]) {
        let is_split = [0, 1].map(|i| solutions[i].forest.second[pieces[i].id as usize] != 0);
        let [a, b] = &pieces;
        match is_split {
            [true, true] => {
                let [a1, a2] = a.halves(&solutions[0].forest);
                let [b1, b2] = b.halves(&solutions[1].forest);
                self.descend(solutions, [a1, b1]);
                self.descend(solutions, [a2, b2]);
            }
            [false, false] => {
                let area = solutions[0].forest.area[a.id as usize];
                self.count(solutions, [a.id, b.id], area);
            }
            _ => {
                let finer = usize::from(is_split[1]);
                let forest = &solutions[finer].forest;
                let mut stack = vec![pieces[finer].id];
                while let Some(element) = stack.pop() {
                    match forest.second[element as usize] {
                        0 => {
                            let mut ids = [a.id, b.id];
                            ids[finer] = element;
                            self.count(solutions, ids, forest.area[element as usize]);
                        }
                        second => stack.extend([second, element + 1]),
                    }
                }
            }
        }
    }

    fn count(&mut self, solutions: [&Solution; 2], ids: [u32; 2], area: f32) {
        let [first, second] = [0, 1].map(|i| solutions[i].light.exitance[ids[i] as usize]);
        let difference = second - first;
        let (largest, area) = (difference.abs().max_element() as f64, area as f64);
        self.area += area;
        self.sum += largest * area;
        self.squares += largest * largest * area;
        self.signed += difference.element_sum() as f64 / 3.0 * area;
        self.above += if largest > self.noticed { area } else { 0.0 };
        if largest > self.max {
            (self.max, self.worst) = (largest, Some(ids[0]));
        }
    }

    fn add(&mut self, other: &Sums) {
        self.area += other.area;
        self.sum += other.sum;
        self.squares += other.squares;
        self.signed += other.signed;
        self.above += other.above;
        if other.max > self.max {
            (self.max, self.worst) = (other.max, other.worst);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use crate::radiosity::{Record, SolveOptions, solve};
    use crate::scene;
    use crate::tracer::FallbackTracer;
    use crate::visibility::{Strategy, VisibilityOptions};
    use std::path::Path;

    fn hierarchy() -> Hierarchy {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box/scene.toml");
        let scene = scene::load(&path, &Default::default(), &Silent).expect("a scene of the project");
        Hierarchy::build(&scene, false, &Silent)
    }

    fn solution(hierarchy: &Hierarchy, epsilon: f64) -> Solution {
        let visibility = VisibilityOptions { strategy: Strategy::Adaptive, rays: 4, certify: false };
        let (contrast, min_size, resolution, iterations) = (0.8, None, 32.0, 200);
        let options = SolveOptions {
            epsilon,
            contrast,
            min_size,
            resolution,
            iterations,
            visibility,
            record: Record::Nothing,
        };
        solve(hierarchy, &FallbackTracer::new(&hierarchy.mesh), &options, 1.0, &Silent)
    }

    /// Area and mean exitance of the leaves.
    fn mean(solution: &Solution) -> (f64, f64) {
        let forest = &solution.forest;
        let (area, power) = forest.leaves().fold((0.0, 0.0), |(area, power), element| {
            let own = forest.area[element] as f64;
            (area + own, power + own * solution.light.exitance[element].element_sum() as f64 / 3.0)
        });
        (area, power / area)
    }

    #[test]
    fn one_element_that_differs_is_found_and_named() {
        let hierarchy = hierarchy();
        let (first, mut second) = (solution(&hierarchy, 2e-2), solution(&hierarchy, 2e-2));
        let same = ExitanceDifference::between(&hierarchy, [&first, &second]);
        assert_eq!((same.rms, same.max, same.worst.as_str()), (0.0, 0.0, ""));
        let leaf = (0..first.forest.len()).rfind(|&e| first.forest.second[e] == 0).expect("a leaf");
        second.light.exitance[leaf].y -= 3.0;
        let found = ExitanceDifference::between(&hierarchy, [&first, &second]);
        let share = first.forest.area[leaf] as f64 / mean(&first).0;
        assert!((found.max - 3.0).abs() < 1e-5 && (found.noticed_area - share).abs() < 1e-9, "{found:?}");
        assert!((found.rms - 3.0 * share.sqrt()).abs() < 1e-5, "{found:?}");
        assert!((found.mean - 3.0 * share).abs() < 1e-5, "{found:?}");
        assert!((found.bias + share).abs() < 1e-5, "{found:?}");
        assert_eq!(found.worst, place(&hierarchy, &first.forest, (hierarchy.nodes.len() + leaf) as u32));
    }

    /// A ground that is a hundred times as large as all else, and dark, changes neither of the two.
    #[test]
    fn a_dark_ground_makes_no_difference_look_larger() {
        let hierarchy = hierarchy();
        let (first, mut second) = (solution(&hierarchy, 2e-2), solution(&hierarchy, 2e-2));
        let is_lamp = |element: usize| {
            let side = first.forest.side(first.forest.side_of(element as u32));
            hierarchy.emitted(side) != glam::Vec3::ZERO
        };
        let light = |element: usize| first.light.exitance[element].max_element();
        let reflecting = first.forest.leaves().filter(|&element| !is_lamp(element));
        let leaf = reflecting.max_by(|&a, &b| light(a).total_cmp(&light(b))).expect("a leaf");
        second.light.exitance[leaf] *= 2.0;
        let of = |pair: [&Solution; 2]| {
            let found = ExitanceDifference::between(&hierarchy, pair);
            (found.relative(found.max), found.relative_rms(), found.relative_max())
        };
        let (_, rms, max) = of([&first, &second]);
        let side = (0..first.forest.side_count())
            .find(|&side| {
                let element = first.forest.first_element[side] as usize;
                first.forest.side_of(leaf as u32) != side && !is_lamp(element)
            })
            .expect("another side");
        let [first, second] = [first, second].map(|mut solution| {
            let elements = solution.forest.elements_of(side);
            solution.light.exitance[elements.clone()].fill(glam::Vec3::ZERO);
            solution.forest.area[elements].iter_mut().for_each(|area| *area *= 1000.0);
            solution
        });
        let (naive, dark_rms, dark_max) = of([&first, &second]);
        assert!(
            dark_max < 2.0 * max && dark_rms < 2.0 * rms && naive > 20.0 * dark_max,
            "{naive} {dark_max} {max}"
        );
    }

    #[test]
    fn where_one_solution_is_finer_all_of_it_counts() {
        let hierarchy = hierarchy();
        let [coarse, fine] = [5e-2, 5e-4].map(|epsilon| solution(&hierarchy, epsilon));
        assert!(fine.forest.len() > 2 * coarse.forest.len());
        let expected = mean(&fine).1 - mean(&coarse).1;
        for (pair, sign) in [([&coarse, &fine], 1.0), ([&fine, &coarse], -1.0)] {
            let found = ExitanceDifference::between(&hierarchy, pair);
            assert!((found.bias - sign * expected).abs() < 1e-4 * mean(&fine).1, "{found:?}, {expected}");
            assert!(found.rms > found.bias.abs() && found.max > found.rms, "{found:?}");
        }
    }
}
