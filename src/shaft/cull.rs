//! Culling hierarchy nodes against a shaft.

use super::Shaft;
use crate::hierarchy::{Hierarchy, Interval, TOLERANCE};
use crate::math::{Aabb, Clip, Plane};
use glam::DVec3;

/// Where a node lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// No part of it, or only its border, is in the shaft.
    Outside,
    /// Some part may be in the shaft.
    Crossing,
    /// All of it is in the shaft.
    Inside,
}

/// What a cull found and cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Culled {
    /// Nodes tested.
    pub nodes_tested: u64,
    /// Facets in the nodes that are left.
    pub facets: u64,
    /// The allowance was used up: the list is right, but not as short as it could be.
    pub cut_short: bool,
}

impl Shaft {
    /// Where a box lies. Touching the border from outside counts as outside.
    #[inline]
    pub fn place(&self, bounds: &Aabb) -> Placement {
        if !self.bounds.overlaps(*bounds, 0.0) {
            return Placement::Outside;
        }
        let mut inside = true;
        for plane in self.planes() {
            let (lo, hi) = plane.distance_range(bounds);
            if hi <= TOLERANCE {
                return Placement::Outside;
            }
            inside &= lo >= TOLERANCE;
        }
        if inside && contains(&self.bounds, bounds) { Placement::Inside } else { Placement::Crossing }
    }

    /// Whether any part of a convex outline is in the shaft by more than `margin`.
    pub fn holds_part_of(&self, vertices: &[DVec3], margin: f64) -> bool {
        // Most outlines lie behind some plane, and of the others most planes cut nothing off.
        let faces = self.faces();
        let planes = || faces.iter().chain(self.planes()).enumerate();
        let mut cutting = 0u64;
        for (index, plane) in planes() {
            match vertices.iter().filter(|&&v| plane.distance(v) >= margin).count() {
                0 => return false,
                inside if inside < vertices.len() => cutting |= 1 << index,
                _ => {}
            }
        }
        if cutting == 0 {
            return true;
        }
        let mut piece: Clip = Clip::new(vertices);
        planes().all(|(index, plane)| cutting & 1 << index == 0 || piece.keep_front(plane, margin))
    }

    /// The faces of the box around both ends.
    fn faces(&self) -> [Plane; 6] {
        let corners = [(self.bounds.min.as_dvec3(), 1.0), (self.bounds.max.as_dvec3(), -1.0)];
        let [low, high] =
            corners.map(|(corner, sign)| DVec3::AXES.map(|axis| Plane::through(corner, axis * sign)));
        [low[0], low[1], low[2], high[0], high[1], high[2]]
    }

    /// Narrows `nodes` (ascending node ids) down to what may block inside the shaft.
    ///
    /// Nodes entirely inside stay closed. After `allowance` tests the rest is taken over untested.
    pub fn cull(&self, hierarchy: &Hierarchy, nodes: &[u32], allowance: u64, left: &mut Vec<u32>) -> Culled {
        let mut culled = Culled::default();
        let mut stack: Vec<u32> = nodes.iter().rev().copied().collect();
        while let Some(index) = stack.pop() {
            let node = &hierarchy.nodes[index as usize];
            let keep = if culled.nodes_tested >= allowance {
                culled.cut_short = true;
                true
            } else {
                culled.nodes_tested += 1;
                match self.place(&node.bounds) {
                    Placement::Outside => false,
                    Placement::Inside => true,
                    Placement::Crossing if node.is_leaf() => {
                        self.holds_part_of(hierarchy.polygon(node.first).vertices(), TOLERANCE)
                    }
                    Placement::Crossing => {
                        let [first, second] = node.children(index);
                        stack.push(second);
                        stack.push(first);
                        false
                    }
                }
            };
            if keep {
                left.push(index);
                culled.facets += u64::from(node.end - node.first);
            }
        }
        culled
    }
}

fn contains(outer: &Aabb, inner: &Aabb) -> bool {
    outer.min.cmple(inner.min).all() && inner.max.cmple(outer.max).all()
}

/// Ascending nodes as the facet intervals they stand for, neighbours joined.
pub fn intervals_of(hierarchy: &Hierarchy, nodes: &[u32], intervals: &mut Vec<Interval>) {
    for &index in nodes {
        let node = &hierarchy.nodes[index as usize];
        match intervals.last_mut() {
            Some(last) if last.end == node.first => last.end = node.end,
            _ => intervals.push(Interval { start: node.first, end: node.end }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Polygon;
    use crate::shaft::End;

    fn facing_squares() -> (Polygon, Polygon) {
        let square =
            |z: f64| [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)].map(|(x, y)| DVec3::new(x, y, z));
        (Polygon::new(&square(0.0)), Polygon::new(&square(0.5)).flipped())
    }

    fn shaft() -> Shaft {
        let (a, b) = facing_squares();
        let front = |p: &Polygon| Plane::through(p.center(), p.area_vector().normalize());
        Shaft::between(End::Polygon(&a, front(&a)), End::Polygon(&b, front(&b)))
    }

    fn aabb(min: [f32; 3], max: [f32; 3]) -> Aabb {
        Aabb { min: min.into(), max: max.into() }
    }

    #[test]
    fn touching_neighbours_are_outside_and_intruders_are_not() {
        let shaft = shaft();
        assert_eq!(shaft.place(&aabb([0.5, 0.0, 0.0], [0.5, 0.5, 0.5])), Placement::Outside, "side wall");
        assert_eq!(
            shaft.place(&aabb([-1.0, -1.0, 0.0], [1.0, 1.0, 0.0])),
            Placement::Outside,
            "coplanar floor"
        );
        assert_eq!(shaft.place(&aabb([0.49, 0.0, 0.0], [0.6, 0.5, 0.5])), Placement::Crossing);
        assert_eq!(shaft.place(&aabb([0.1, 0.1, 0.1], [0.2, 0.2, 0.2])), Placement::Inside);
        assert_eq!(shaft.place(&aabb([0.1, 0.1, 0.2], [0.2, 0.2, 0.2])), Placement::Inside, "a flat one too");
    }

    #[test]
    fn a_facet_that_only_touches_is_clipped_away() {
        let shaft = shaft();
        let wall = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5)].map(|(y, z)| DVec3::new(0.5, y, z));
        assert!(!shaft.holds_part_of(&wall, TOLERANCE));
        let leaning = wall.map(|p| p - DVec3::X * (p.z * 0.2));
        assert!(shaft.holds_part_of(&leaning, TOLERANCE));
    }

    #[test]
    fn a_shaft_ends_with_the_box_around_both_ends() {
        let shaft = Shaft::between(
            End::Box(aabb([0.0; 3], [0.5, 0.5, 0.1])),
            End::Box(aabb([0.0, 0.0, 0.4], [0.5; 3])),
        );
        let board = |z: f64| [(0.1, 0.1), (0.4, 0.1), (0.1, 0.4)].map(|(x, y)| DVec3::new(x, y, z));
        assert!(!shaft.holds_part_of(&board(0.0), TOLERANCE));
        assert!(shaft.holds_part_of(&board(0.2), TOLERANCE));
        assert!(!shaft.holds_part_of(&board(0.6), TOLERANCE));
    }
}
