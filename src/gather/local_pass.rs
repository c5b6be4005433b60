//! The local pass: light is gathered once more at all leaf elements, as it is for the pixels of a picture, and those are
//! divided between whose corners interpolation does not show it. \[LTG93\]
//!
//! Elements are as fine as links need them: shadows of many weak sources lie in one place, and none of those is worth a
//! division by itself. Here all that reaches a point counts together.

use super::final_gather::{FinalGather, VisiblePoint};
use super::levels::Levels;
use super::reconstruct::{Reconstruction, ShownSide};
use crate::hierarchy::Hierarchy;
use crate::math::hash_pair;
use crate::progress::{Progress, Work};
use crate::radiosity::{DisplayMesh, Forest, MIN_LOCAL_SIZE, Piece, Solution, Way};
use crate::tracer::Tracer;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// An element is divided where interpolation is off by more than this share of its light, root mean square of its
/// quarters: more than the noise of the rays.
const OFF: f32 = 0.08;

/// So often it is looked for elements to be divided in four.
const ROUNDS: u32 = 3;

/// Elements no larger than this times the smallest that links are divided for are not divided.
const SMALLEST: f64 = 0.5;

/// Elements darker than this share of the typical irradiance are not divided: pictures show nothing of them.
const BLACK: f32 = 1e-3;

/// Elements that links bring less than this share of the typical irradiance keep what they bring. They lie inside of bodies
/// for the most part, where all rays are cast and none arrives.
const UNLIT: f32 = 2e-4;

/// A quarter that gets less than this share of what the brightest gets lies hidden, as in a body that stands on the
/// element, and says nothing about the others.
pub(super) const HIDDEN: f32 = 0.1;

/// Elements handed to a thread at a time.
const BLOCK: usize = 256;

/// What was found of a leaf element.
#[derive(Clone, Copy, Debug)]
struct Found {
    /// Irradiance at the middle of each quarter.
    quarters: [Vec3; 4],
    /// Of what is seen of the element.
    mean: Vec3,
}

impl Found {
    fn new(quarters: [Vec3; 4], areas: [f64; 4]) -> Found {
        let most = quarters.iter().fold(0.0, |most: f32, light| most.max(light.element_sum()));
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        for (light, part) in quarters.iter().zip(areas) {
            if light.element_sum() >= HIDDEN * most {
                sum += light.as_dvec3() * part;
                area += part;
            }
        }
        Found { quarters, mean: (sum / area.max(f64::MIN_POSITIVE)).as_vec3() }
    }
}

/// Gathers the light of all elements with about `rays` rays for each of four points. There always is a mesh: what divides the
/// elements of the solution further divides them.
pub fn local_pass(
    hierarchy: &Hierarchy,
    tracer: &dyn Tracer,
    solution: &Solution,
    rays: u32,
    progress: &dyn Progress,
) -> Option<DisplayMesh> {
    let gather = FinalGather::new(hierarchy, tracer, solution, rays, progress);
    let known = &solution.light.irradiance;
    let linked = solution.forest.leaves().map(|leaf| (known[leaf].element_sum(), solution.forest.area[leaf]));
    let typical = typical(linked);
    let pass = LocalPass { hierarchy, gather: &gather, known, typical, progress };
    let smallest = SMALLEST * hierarchy.frame.local_length(solution.min_size);
    // What is divided is divided in four.
    let smallest = smallest.max(2.0 * MIN_LOCAL_SIZE);
    let mut forest = solution.forest.divided(hierarchy, &[]);
    let mut found = pass.found(&forest, &leaves(&forest));
    for _ in 0..ROUNDS {
        let is_off = pass.off(&forest, &found, smallest);
        if !is_off.contains(&true) {
            break;
        }
        forest = forest.divided(hierarchy, &is_off);
        // What was divided is found anew.
        let known: Vec<Option<Found>> = found
            .iter()
            .zip(&is_off)
            .flat_map(|(found, &is_off)| {
                std::iter::repeat_n((!is_off).then_some(*found), if is_off { 4 } else { 1 })
            })
            .collect();
        let all = leaves(&forest);
        let new: Vec<u32> =
            all.iter().zip(&known).filter(|(_, known)| known.is_none()).map(|(&leaf, _)| leaf).collect();
        let mut fresh = pass.found(&forest, &new).into_iter();
        found = known.into_iter().filter_map(|known| known.or_else(|| fresh.next())).collect();
    }
    let irradiance = by_element(&forest, &found);
    DisplayMesh::new(forest, irradiance, &solution.forest)
}

/// The leaf elements, in order.
fn leaves(forest: &Forest) -> Vec<u32> {
    forest.leaves().map(|leaf| leaf as u32).collect()
}

/// The means of leaf elements, by element id.
fn by_element(forest: &Forest, found: &[Found]) -> Vec<Vec3> {
    let mut irradiance = vec![Vec3::ZERO; forest.len()];
    for (leaf, found) in forest.leaves().zip(found) {
        irradiance[leaf] = found.mean;
    }
    irradiance
}

/// The middles of the quarters of an element, and their areas.
fn quarters(piece: &Piece, forest: &Forest) -> [(DVec3, f64); 4] {
    piece.quarters(forest).map(|quarter| (quarter.center(), quarter.area()))
}

struct LocalPass<'p, 'a> {
    hierarchy: &'a Hierarchy,
    gather: &'p FinalGather<'a>,
    /// Irradiance of the elements that links have, W/m².
    known: &'p [Vec3],
    /// Mean of that, sum of the channels, weighted by the power it brings.
    typical: f32,
    progress: &'p dyn Progress,
}

impl LocalPass<'_, '_> {
    /// What reaches some leaf elements, in order.
    fn found(&self, forest: &Forest, leaves: &[u32]) -> Vec<Found> {
        const PHASE: &str = "local pass";
        self.progress.start(PHASE, leaves.len() as u64);
        let working = || {
            (Work::begin(self.progress, PHASE), Way::new(self.hierarchy, forest), Levels::new(self.gather))
        };
        let found = leaves
            .par_chunks(BLOCK)
            .map_init(working, |(_, way, levels), leaves| {
                let found: Vec<Found> =
                    leaves.iter().map(|&leaf| self.found_on(way.to(leaf), forest, levels)).collect();
                self.progress.advance(leaves.len() as u64);
                found
            })
            .flatten_iter()
            .collect();
        self.progress.finish();
        found
    }

    fn found_on(&self, piece: &Piece, forest: &Forest, levels: &mut Levels<'_, '_>) -> Found {
        let side = piece.side;
        let parts = quarters(piece, forest);
        let Some(element) = self.gather.element_at(side, piece.polygon.center()) else {
            return Found::new([Vec3::ZERO; 4], [1.0; 4]);
        };
        let known = self.known[element as usize];
        if known.element_sum() < UNLIT * self.typical {
            return Found::new([known; 4], [1.0; 4]);
        }
        let light = [0, 1, 2, 3].map(|i| {
            let seed = hash_pair(piece.key, i as u64);
            levels.irradiance(&VisiblePoint { side, point: parts[i].0, element, seed })
        });
        Found::new(light, parts.map(|part| part.1))
    }

    /// Which of the leaf elements, in order, are to be divided.
    fn off(&self, forest: &Forest, found: &[Found], smallest: f64) -> Vec<bool> {
        let irradiance = by_element(forest, found);
        let shown = Reconstruction::of_display(self.hierarchy, forest, &irradiance);
        let black = BLACK * self.typical;
        let mut first = 0;
        let of_sides: Vec<&[Found]> = (0..forest.side_count())
            .map(|side| {
                let count = forest.leaves_of(side).count();
                first += count;
                &found[first - count..first]
            })
            .collect();
        of_sides
            .into_par_iter()
            .enumerate()
            .map_init(
                || Way::new(self.hierarchy, forest),
                |way, (side, found)| {
                    let is_bright = |found: &Found| found.mean.element_sum() > black;
                    if !found.iter().any(is_bright) {
                        return vec![false; found.len()];
                    }
                    // Facets of a curved surface are smoothed over: no division would show each as it is lit.
                    let shown = shown.flat_side(side);
                    let is_off = |(leaf, found): (usize, &Found)| {
                        let piece = way.to(leaf as u32);
                        is_bright(found)
                            && piece.polygon.longest_edge() > smallest
                            && error(&shown, piece, forest, found) > OFF
                            && forest.may_be_divided(leaf as u32)
                    };
                    forest.leaves_of(side).zip(found).map(is_off).collect()
                },
            )
            .flatten_iter()
            .collect()
    }
}

/// By how much what is shown of an element is off, as a share of its light: root mean square of its quarters.
fn error(shown: &ShownSide, piece: &Piece, forest: &Forest, found: &Found) -> f32 {
    let mean = found.mean.element_sum();
    let square = |(light, (point, _)): (&Vec3, (DVec3, f64))| {
        let off = (shown.irradiance(piece.id, piece.plane.normal, point) - *light).abs();
        (off.element_sum() / mean).powi(2)
    };
    let squares: f32 = found.quarters.iter().zip(quarters(piece, forest)).map(square).sum();
    (0.25 * squares).sqrt()
}

/// Mean irradiance, weighted by the power it brings, of elements with so much on such an area.
fn typical(elements: impl Iterator<Item = (f32, f32)>) -> f32 {
    let (mut squares, mut power) = (0.0, 0.0);
    for (light, area) in elements.map(|(light, area)| (f64::from(light), f64::from(area))) {
        squares += light * light * area;
        power += light * area;
    }
    if power > 0.0 { (squares / power) as f32 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_quarters_say_nothing_about_the_others() {
        let light = [1.0, 0.5, 0.09, 0.0].map(Vec3::splat);
        let found = Found::new(light, [1.0, 3.0, 7.0, 7.0]);
        assert!((found.mean - Vec3::splat(2.5 / 4.0)).length() < 1e-6, "{found:?}");
        assert_eq!(Found::new([Vec3::ZERO; 4], [1.0; 4]).mean, Vec3::ZERO);
    }
}
