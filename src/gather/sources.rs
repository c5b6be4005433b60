//! How bright the sources of a final gather are: as a gather at themselves finds them. A picture then does not show what
//! coarse elements get wrong of their light.

use super::final_gather::{FinalGather, VisiblePoint};
use crate::hierarchy::Hierarchy;
use crate::math::{PairSequence, hash_pair};
use crate::radiosity::{Light, Piece, Solution};
use glam::Vec3;

/// Sources are divided into cells of about this part of them all.
const CELLS: f64 = 2048.0;

/// Points of a cell at which light is gathered.
const POINTS: u32 = 4;

/// No cell is lit more than this times as much as in the solution, or as little.
const MOST: f32 = 4.0;

/// The light of the solution, on the sides that are gathered from as a gather finds it: in cells, each brighter or darker
/// as a whole.
pub(super) fn gathered_light(gather: &FinalGather<'_>) -> Light {
    let FinalGather { hierarchy, solution, .. } = *gather;
    let cells = cells(hierarchy, solution, &gather.sources);
    let mut points = Vec::new();
    for (index, cell) in cells.iter().enumerate() {
        let sequence = PairSequence::new(cell.key);
        for i in 0..POINTS {
            let [u, v, ..] = sequence.point(i);
            let point = cell.polygon.point_at(u, v);
            let Some(element) = gather.element_at(cell.side, point) else { continue };
            let seed = hash_pair(cell.key, u64::from(i));
            points.push((VisiblePoint { side: cell.side, point, element, seed }, index));
        }
    }
    points.sort_by_key(|(point, _)| point.element);
    let visible: Vec<VisiblePoint> = points.iter().map(|(point, _)| *point).collect();
    let mut sums = vec![[Vec3::ZERO; 2]; cells.len()];
    for ((point, cell), found) in points.iter().zip(gather.irradiance(&visible)) {
        sums[*cell][0] += found;
        sums[*cell][1] += solution.light.irradiance[point.element as usize];
    }
    let forest = &solution.forest;
    let mut irradiance = solution.light.irradiance.clone();
    for (cell, [found, known]) in cells.iter().zip(sums) {
        let gain = found / known.max(Vec3::splat(f32::MIN_POSITIVE));
        let gain = gain.clamp(Vec3::splat(1.0 / MOST), Vec3::splat(MOST));
        let mut stack = vec![cell.id];
        while let Some(element) = stack.pop() {
            irradiance[element as usize] *= gain;
            let second = forest.second[element as usize];
            if second != 0 {
                stack.extend([element + 1, second]);
            }
        }
    }
    let leaves: Vec<Vec3> = forest.leaves().map(|element| irradiance[element]).collect();
    Light::from_leaves(hierarchy, forest, &leaves)
}

/// The elements of the sources that are leaves, or no larger than a cell.
fn cells(hierarchy: &Hierarchy, solution: &Solution, sources: &[usize]) -> Vec<Piece> {
    let forest = &solution.forest;
    let area = |element: u32| f64::from(forest.area[element as usize]);
    let all: f64 = sources.iter().map(|&side| area(forest.first_element[side])).sum();
    let mut cells = Vec::new();
    for &side in sources {
        let mut stack = vec![forest.root(hierarchy, side)];
        while let Some(piece) = stack.pop() {
            if forest.second[piece.id as usize] != 0 && area(piece.id) > all / CELLS {
                let [a, b] = piece.halves(forest);
                stack.extend([b, a]);
            } else {
                cells.push(piece);
            }
        }
    }
    cells
}
