//! Looking for what may hide two nodes from each other: large facets on the way between their middles.

use crate::hierarchy::{Hierarchy, NodeKind};
use crate::math::Aabb;
use glam::DVec3;

/// Most facets that are named.
pub const MOST_FOUND: usize = 4;

/// The largest of the facets on a segment whose boxes have at least this radius, by area, and how many there are.
pub fn large_facets_on(
    hierarchy: &Hierarchy,
    [from, to]: [DVec3; 2],
    least_radius: f64,
) -> ([u32; MOST_FOUND], usize) {
    let along = to - from;
    let inverse = along.recip();
    let (mut found, mut areas, mut count) = ([0; MOST_FOUND], [0.0; MOST_FOUND], 0);
    let mut stack = vec![0u32];
    while let Some(index) = stack.pop() {
        let node = &hierarchy.nodes[index as usize];
        if node.bounds.radius() < least_radius || !is_on(&node.bounds, from, inverse) {
            continue;
        }
        match node.kind(index) {
            NodeKind::Cluster([first, second]) => stack.extend([second, first]),
            NodeKind::Leaf(facet) => {
                let plane = &hierarchy.facets[facet as usize].plane;
                let (above, below) = (plane.distance(from), -plane.distance(to));
                if above * below <= 0.0 {
                    continue;
                }
                let at = from + along * (above / (above + below));
                if hierarchy.polygon(facet).outside_distance(at, plane.normal) > 0.0 {
                    continue;
                }
                let place = areas[..count].iter().position(|&area| node.area > area).unwrap_or(count);
                if place < MOST_FOUND {
                    count = (count + 1).min(MOST_FOUND);
                    found[place..count].rotate_right(1);
                    areas[place..count].rotate_right(1);
                    (found[place], areas[place]) = (facet, node.area);
                }
            }
        }
    }
    (found, count)
}

/// Whether some part of a segment is in a box; `inverse` is one over the way from its start to its end.
fn is_on(bounds: &Aabb, from: DVec3, inverse: DVec3) -> bool {
    let sides = [bounds.min, bounds.max].map(|side| ((side.as_dvec3() - from) * inverse).to_array());
    let (mut enters, mut leaves) = (0.0f64, 1.0f64);
    for (a, b) in sides[0].into_iter().zip(sides[1]) {
        // Where the segment runs in a side of the box, 0 × ∞ is no number: that side is no bound.
        if !a.is_nan() && !b.is_nan() {
            enters = enters.max(a.min(b));
            leaves = leaves.min(a.max(b));
        }
    }
    enters <= leaves
}
