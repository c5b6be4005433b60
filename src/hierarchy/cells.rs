//! Cells: the convex regions that walls and floors bound, one for each room. What is in one is seen from elsewhere
//! through the gaps of its walls only.

use super::{Hierarchy, Node};
use crate::math::Plane;

/// A room and the planes of the walls around it.
#[derive(Clone, Debug)]
pub struct Cell {
    /// The cluster of what is in the room; some of it may reach out of the cell.
    pub node: u32,
    /// One for each direction in which the room was parted from others; the front of each is outside.
    pub walls: Vec<Plane>,
}

impl Hierarchy {
    /// The cell that a node belongs to, if it belongs to one.
    pub fn cell(&self, node: u32) -> Option<&Cell> {
        let at = self.cells.partition_point(|cell| cell.node <= node).checked_sub(1)?;
        let (cell, Node { end, .. }) = (&self.cells[at], self.nodes[node as usize]);
        (end <= self.nodes[cell.node as usize].end).then_some(cell)
    }
}
