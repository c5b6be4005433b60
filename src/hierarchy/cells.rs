//! Cells: the convex regions that walls and floors bound, one for each room. What is in one is seen from elsewhere
//! through the openings of its walls only.

use super::gaps::Effort;
use super::rooms::IN_PLANE;
use super::{Hierarchy, Node, NodeKind, TOLERANCE};
use crate::math::{Axes, FlatPolygon, Plane};
use glam::DVec3;
use rayon::prelude::*;

/// Points this far outside a cell are in it: less than what is forgotten at the border of a gap.
const SLACK: f64 = 0.5 * TOLERANCE;

/// Walls that meet at a smaller angle do not bound each other.
const LEAST_STEEPNESS: f64 = 1e-3;

/// Once for a wall.
const EFFORT: Effort = Effort { nodes: 1 << 16, pieces: 64, least_radius: 0.01 };

/// The planes around a room, before it is known what they leave open.
#[derive(Clone, Debug)]
pub(super) struct Enclosure {
    /// The cluster of what is in the room.
    pub(super) node: u32,
    /// One for each direction in which the room was parted from others; the front of each is outside.
    pub(super) planes: Vec<Plane>,
}

/// A room and the walls around it.
#[derive(Clone, Debug)]
pub struct Cell {
    /// The cluster of what is in the room; some of it may reach out of the cell.
    pub node: u32,
    /// One for each direction in which the room was parted from others.
    pub walls: Vec<Wall>,
}

/// A plane around a cell.
#[derive(Clone, Debug)]
pub struct Wall {
    /// Its front is outside.
    pub plane: Plane,
    /// Two axes in it.
    pub axes: Axes,
    /// What no facet covers of its part behind the other walls.
    pub openings: Vec<FlatPolygon>,
}

impl Wall {
    /// One of the planes around a room.
    fn of(hierarchy: &Hierarchy, planes: &[Plane], index: usize) -> Wall {
        let plane = planes[index];
        let axes = Axes::of(&plane);
        // All of the scene is nearer to the origin of the axes.
        let reach = 4.0 * (hierarchy.nodes[0].bounds.radius() + hierarchy.nodes[0].bounds.center().length());
        let square = [(-reach, -reach), (reach, -reach), (reach, reach), (-reach, reach)];
        let mut part = Some(FlatPolygon::new(&square.map(From::from)));
        for other in planes[..index].iter().chain(&planes[index + 1..]) {
            let (across, offset) = axes.trace(other);
            let steepness = across.length();
            if steepness > LEAST_STEEPNESS {
                let (inward, least) = (-across / steepness, (offset - SLACK) / steepness);
                part = part.and_then(|part| part.beyond(inward, least, TOLERANCE));
            }
        }
        let openings =
            part.map_or_else(Vec::new, |part| hierarchy.gaps_in(&plane, &axes, part, None, EFFORT));
        Wall { plane, axes, openings }
    }
}

impl Hierarchy {
    /// The cell that a node belongs to, if it belongs to one.
    pub fn cell(&self, node: u32) -> Option<&Cell> {
        let at = self.cells.partition_point(|cell| cell.node <= node).checked_sub(1)?;
        let (cell, Node { end, .. }) = (&self.cells[at], self.nodes[node as usize]);
        (end <= self.nodes[cell.node as usize].end).then_some(cell)
    }

    /// Whether all of a node is behind the walls of its cell, and nothing of it sees out of one's front.
    pub fn is_within_cell(&self, node: u32) -> bool {
        self.within[node as usize]
    }

    /// Finds out what the walls of rooms leave open, and what is behind them.
    pub(super) fn measure_cells(&mut self, enclosures: &[Enclosure]) {
        let cell = |enclosure: &Enclosure| {
            let walls = 0..enclosure.planes.len();
            let walls = walls.map(|index| Wall::of(self, &enclosure.planes, index)).collect();
            Cell { node: enclosure.node, walls }
        };
        self.cells = enclosures.par_iter().map(cell).collect();
        let within: Vec<Vec<bool>> = self.cells.par_iter().map(|cell| self.nodes_within(cell)).collect();
        self.within = vec![false; self.nodes.len()];
        for (cell, within) in self.cells.iter().zip(within) {
            let first = cell.node as usize;
            self.within[first..first + within.len()].copy_from_slice(&within);
        }
    }

    /// For each node of a cell's tree, see [`Hierarchy::is_within_cell`].
    fn nodes_within(&self, cell: &Cell) -> Vec<bool> {
        let Node { first, end, .. } = self.nodes[cell.node as usize];
        let mut within = vec![false; 2 * (end - first) as usize - 1];
        for at in (0..within.len()).rev() {
            let index = cell.node + at as u32;
            let node = &self.nodes[index as usize];
            within[at] = match node.kind(index) {
                NodeKind::Leaf(facet) => cell.walls.iter().all(|wall| self.keeps_behind(facet, &wall.plane)),
                NodeKind::Cluster(children) => {
                    children.iter().all(|child| within[(child - cell.node) as usize])
                        && cell.walls.iter().all(|w| w.plane.distance_range(&node.bounds).1 <= TOLERANCE)
                }
            };
        }
        within
    }

    /// Whether a facet is behind a wall, and exchanges no light in front of it.
    fn keeps_behind(&self, facet: u32, wall: &Plane) -> bool {
        let front = self.one_sided.then_some(self.facets[facet as usize].plane.normal);
        is_behind(self.polygon(facet).vertices(), front, wall)
    }
}

/// Whether a surface with these corners is behind a wall; one that lies in it has to exchange light on its `front` only,
/// and to face in.
pub(crate) fn is_behind(corners: &[DVec3], front: Option<DVec3>, wall: &Plane) -> bool {
    let distances = || corners.iter().map(|&corner| wall.distance(corner));
    distances().all(|distance| distance <= TOLERANCE)
        && (front.is_some_and(|normal| normal.dot(wall.normal) < -0.5)
            || distances().any(|distance| distance < -IN_PLANE))
}
