//! Finer elements for pictures, with light that no link brings them.

use super::forest::Forest;
use glam::Vec3;

/// The elements of a solution and what they were divided into, to show light by interpolation. \[LTG93\]
#[derive(Debug)]
pub struct DisplayMesh {
    /// Its elements.
    pub forest: Forest,
    /// Irradiance of each leaf element, by element id, W/m²; of no meaning in others.
    pub irradiance: Vec<Vec3>,
    /// For each of its elements the one that links have: the same, or the leaf it is a part of.
    pub linked: Vec<u32>,
}

impl DisplayMesh {
    /// Elements with light, which is as many numbers; `None` if they do not divide all that the `solution` divides.
    pub fn new(forest: Forest, irradiance: Vec<Vec3>, solution: &Forest) -> Option<DisplayMesh> {
        let mut linked = Vec::with_capacity(forest.len());
        let mut stack = Vec::new();
        for side in 0..forest.side_count() {
            stack.push((forest.first_element[side], solution.first_element[side]));
            while let Some((own, element)) = stack.pop() {
                linked.push(element);
                match [forest.second[own as usize], solution.second[element as usize]] {
                    [0, 0] => {}
                    [0, _] => return None,
                    [second, 0] => stack.extend([(second, element), (own + 1, element)]),
                    [second, theirs] => stack.extend([(second, theirs), (own + 1, element + 1)]),
                }
            }
        }
        Some(DisplayMesh { forest, irradiance, linked })
    }

    /// Bytes it takes.
    pub fn bytes(&self) -> u64 {
        let elements = size_of_val(&self.irradiance[..]) + size_of_val(&self.linked[..]);
        self.forest.bytes() + elements as u64
    }
}
