//! Walls in several planes that hide what is in a room from what is elsewhere.
//!
//! A segment that leaves a convex cell does so through one of its walls, at a point that is in the cell. On each wall
//! those points lie in the hull of where segments from the corners cross its plane, cut to the cell. If facets in the
//! plane cover that on all walls, nothing gets out. What they leave open are gaps, such as doors: the segments go on
//! from there, and have to be hidden from where they end by a single plane, or by the walls of the room in which they
//! end.

use super::blocker::has_facet_in;
use super::fusion::{Octagon, blocks_together};
use super::search::large_facets_on;
use crate::hierarchy::{Cell, Hierarchy, TOLERANCE, is_behind};
use crate::math::{Axes, Plane};
use glam::DVec3;

/// Most gaps that are looked through.
const MOST_GAPS: usize = 8;

/// A node, as the walls of rooms see it.
#[derive(Clone, Copy)]
pub struct Occupant<'a> {
    /// Around all of it.
    pub corners: &'a [DVec3],
    /// The node: of an element the leaf of its facet.
    pub node: u32,
    /// The plane of an element; its front exchanges light.
    pub side: Option<Plane>,
}

/// Whether the walls of the rooms that two nodes are in hide them from each other.
pub fn walls_hide(hierarchy: &Hierarchy, ends: [Occupant<'_>; 2]) -> bool {
    let cells = ends.map(|end| hierarchy.cell(end.node));
    let gaps = [0, 1].map(|i| {
        let cell = cells[i].filter(|cell| cells[1 - i].is_none_or(|other| other.node != cell.node))?;
        gaps_around(hierarchy, cell, &ends[i], &Goal::Node(ends[1 - i]))
    });
    if gaps.iter().flatten().any(|gaps| gaps.is_empty()) {
        return true;
    }
    let Some(near) = gaps.iter().position(Option::is_some) else { return false };
    let far = &ends[1 - near];
    gaps[near].iter().flatten().all(|gap| {
        let rest = cells[1 - near].and_then(|cell| gaps_around(hierarchy, cell, far, &Goal::Gap(gap)));
        match rest {
            Some(rest) => rest.iter().all(|other| plane_hides(hierarchy, gap, &Goal::Gap(other))),
            None => plane_hides(hierarchy, gap, &Goal::Node(*far)),
        }
    })
}

/// Where segments end.
enum Goal<'a> {
    Node(Occupant<'a>),
    /// They go on from there.
    Gap(&'a [DVec3]),
}

impl Goal<'_> {
    fn corners(&self) -> &[DVec3] {
        match self {
            Goal::Node(node) => node.corners,
            Goal::Gap(corners) => corners,
        }
    }

    /// Whether a surface at which segments end lies in a plane.
    fn has_facet_in(&self, hierarchy: &Hierarchy, plane: &Plane) -> bool {
        match self {
            Goal::Node(node) => node.has_facet_in(hierarchy, plane),
            Goal::Gap(_) => false,
        }
    }
}

impl Occupant<'_> {
    /// Whether all of it is behind the walls of its cell, and nothing of it sees out of one's front.
    fn is_within(&self, hierarchy: &Hierarchy, cell: &Cell) -> bool {
        let Some(side) = self.side else { return hierarchy.is_within_cell(self.node) };
        cell.walls.iter().all(|wall| is_behind(self.corners, Some(side.normal), &wall.plane))
    }

    fn has_facet_in(&self, hierarchy: &Hierarchy, plane: &Plane) -> bool {
        match self.side {
            Some(_) => self.corners.iter().all(|&corner| plane.distance(corner).abs() <= TOLERANCE),
            None => has_facet_in(hierarchy, self.node, plane),
        }
    }
}

/// What the walls of a cell leave open between what is in it and a goal outside; `None` where that cannot be told, or
/// there is too much of it.
///
/// All of the goal lies beyond one of the walls, so that every segment is out of the cell before it ends: surfaces of
/// the goal in the planes of other walls are out of the cell, too, and see no more for it.
fn gaps_around(
    hierarchy: &Hierarchy,
    cell: &Cell,
    inner: &Occupant<'_>,
    outer: &Goal<'_>,
) -> Option<Vec<Vec<DVec3>>> {
    if !inner.is_within(hierarchy, cell)
        || !cell.walls.iter().any(|wall| is_beyond(hierarchy, outer, &wall.plane))
    {
        return None;
    }
    let mut found = Vec::new();
    for wall in &cell.walls {
        // An element in a wall itself faces in, and sends nothing through it.
        if wall.openings.is_empty()
            || outer.corners().iter().all(|&corner| wall.plane.distance(corner) <= TOLERANCE)
            || inner.side.is_some() && inner.has_facet_in(hierarchy, &wall.plane)
        {
            continue;
        }
        let crossed = crossed_part(&wall.plane, &wall.axes, inner.corners, outer.corners()).widened();
        let gaps = wall.openings.iter().filter_map(|opening| crossed.part_of(opening));
        for gap in gaps {
            if found.len() == MOST_GAPS {
                return None;
            }
            found.push(gap.corners().iter().map(|&at| wall.axes.point(at)).collect());
        }
    }
    Some(found)
}

/// Whether all of a goal lies in front of a wall, and no surface of it in the wall.
fn is_beyond(hierarchy: &Hierarchy, outer: &Goal<'_>, wall: &Plane) -> bool {
    let distances = outer.corners().iter().map(|&corner| wall.distance(corner));
    let (least, most) = distances.fold((f64::MAX, f64::MIN), |(a, b), d| (a.min(d), b.max(d)));
    least > TOLERANCE || least >= -TOLERANCE && most > TOLERANCE && !outer.has_facet_in(hierarchy, wall)
}

/// Around where segments from corners in a cell cross the plane of a wall.
fn crossed_part(wall: &Plane, axes: &Axes, inner: &[DVec3], outer: &[DVec3]) -> Octagon {
    let mut hull = Octagon::EMPTY;
    for &to in outer {
        let beyond = wall.distance(to);
        if beyond <= 0.0 {
            continue;
        }
        // The goal itself may reach through the plane.
        let behind = outer.iter().filter(|&&corner| wall.distance(corner) <= 0.0);
        for &from in inner.iter().chain(behind) {
            let before = (-wall.distance(from)).max(0.0);
            hull.add(axes.flat(from + (to - from) * (before / (before + beyond))));
        }
    }
    hull
}

/// Whether a single plane between a gap and a goal hides them from each other.
fn plane_hides(hierarchy: &Hierarchy, gap: &[DVec3], goal: &Goal<'_>) -> bool {
    let corners = goal.corners();
    let middles = [gap, corners].map(|corners| corners.iter().sum::<DVec3>() / corners.len() as f64);
    let (found, count) = large_facets_on(hierarchy, middles, 0.0);
    found[..count].iter().any(|&facet| {
        let plane = &hierarchy.facets[facet as usize].plane;
        blocks_together(hierarchy, facet, gap, corners) && !goal.has_facet_in(hierarchy, plane)
    })
}
