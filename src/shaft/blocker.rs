//! The single-blocker test: does one convex facet hide two nodes from each other completely?
//!
//! If every segment between a corner of one node and a corner of the other meets the convex facet,
//! so does every segment between the nodes: for a fixed point, the points a convex set hides from it
//! form a convex set, so the corners of one node decide for all of it, and then the same argument
//! holds for the other node.
//!
//! Nodes may touch the facet, as a floor touches the wall that stands on it; what lies in its plane sees past
//! it and is not hidden.

use crate::hierarchy::{Hierarchy, NodeKind, TOLERANCE};
use crate::math::{MAX_VERTICES, Plane, Polygon};
use glam::DVec3;

/// Crossings this far off the facet are on it: less than what counts as outside a shaft.
const SLACK: f64 = 0.5 * TOLERANCE;

/// Most nodes of an end looked at for facets in a plane.
const MOST_NODES: u32 = 64;

/// Whether the facet blocks every segment from a corner of the receiver to a corner of the source.
pub fn blocks_all(facet: &Polygon, plane: &Plane, receiver: &[DVec3], source: &[DVec3]) -> bool {
    let mut outward = [DVec3::ZERO; MAX_VERTICES];
    for (outward, (start, end)) in outward.iter_mut().zip(facet.edges()) {
        *outward = (end - start).cross(plane.normal).normalize_or_zero();
    }
    let sides = facet.vertices().iter().zip(&outward);
    all_crossings(plane, receiver, source, |at| {
        sides.clone().all(|(&start, outward)| outward.dot(at - start) <= SLACK)
    })
}

/// Whether something is true of every point in which a segment from a corner of the receiver to a corner of the
/// source crosses a plane; `false` when the plane does not part them.
pub(super) fn all_crossings(
    plane: &Plane,
    receiver: &[DVec3],
    source: &[DVec3],
    mut is_true: impl FnMut(DVec3) -> bool,
) -> bool {
    // Heights of the receiver above the plane, of the source below it.
    let farthest = receiver.iter().map(|&p| plane.distance(p)).max_by(|a, b| a.abs().total_cmp(&b.abs()));
    let side = farthest.unwrap_or(0.0).signum();
    let above = |p: DVec3| plane.distance(p) * side;
    let below = |p: DVec3| -plane.distance(p) * side;
    let parts = receiver.iter().all(|&p| above(p) >= -TOLERANCE)
        && source.iter().all(|&p| below(p) >= -TOLERANCE)
        && receiver.iter().any(|&p| above(p) > TOLERANCE)
        && source.iter().any(|&p| below(p) > TOLERANCE);
    parts
        && receiver.iter().all(|&a| {
            let height = above(a).max(0.0);
            source.iter().all(|&b| {
                let whole = height + below(b).max(0.0);
                if whole > TOLERANCE {
                    is_true(a + (b - a) * (height / whole))
                } else {
                    is_true(a) && is_true(b)
                }
            })
        })
}

/// Whether some facet below a node lies in a plane, or may.
pub fn has_facet_in(hierarchy: &Hierarchy, node: u32, plane: &Plane) -> bool {
    let mut stack = vec![node];
    let mut looked_at = 0;
    while let Some(index) = stack.pop() {
        looked_at += 1;
        if looked_at > MOST_NODES {
            return true;
        }
        let node = &hierarchy.nodes[index as usize];
        let (low, high) = plane.distance_range(&node.bounds);
        if low > TOLERANCE || high < -TOLERANCE {
            continue;
        }
        match node.kind(index) {
            NodeKind::Cluster(children) => stack.extend(children),
            NodeKind::Leaf(facet) => {
                let polygon = hierarchy.polygon(facet);
                if polygon.vertices().iter().all(|&v| plane.distance(v).abs() <= TOLERANCE) {
                    return true;
                }
            }
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn square(center: DVec3, half: f64) -> Polygon {
        Polygon::new(
            &[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| center + DVec3::new(x, y, 0.0) * half),
        )
    }

    fn front(p: &Polygon) -> Plane {
        Plane::through(p.center(), p.area_vector().normalize())
    }

    #[test]
    fn a_board_between_blocks_and_a_smaller_one_does_not() {
        let (a, b) = (square(DVec3::ZERO, 0.2), square(DVec3::new(0.0, 0.0, 1.0), 0.2));
        for (half, expected) in [(0.25, true), (0.15, false)] {
            for board in
                [square(DVec3::new(0.0, 0.0, 0.5), half), square(DVec3::new(0.0, 0.0, 0.5), half).flipped()]
            {
                assert_eq!(blocks_all(&board, &front(&board), a.vertices(), b.vertices()), expected);
            }
        }
        let beside = square(DVec3::new(0.3, 0.0, 0.5), 0.25);
        assert!(!blocks_all(&beside, &front(&beside), a.vertices(), b.vertices()));
        let behind = square(DVec3::new(0.0, 0.0, 1.5), 5.0);
        assert!(!blocks_all(&behind, &front(&behind), a.vertices(), b.vertices()));
    }

    proptest! {
        /// A failure means that light is thrown away.
        #[test]
        fn what_is_proved_blocked_is_blocked_everywhere(
            x in -0.4..0.4f64, y in -0.4..0.4f64, half in 0.05..0.6f64, z in 0.1..0.9f64,
            s in 0.0..1.0f64, t in 0.0..1.0f64, u in 0.0..1.0f64, v in 0.0..1.0f64
        ) {
            let (a, b) = (square(DVec3::ZERO, 0.2), square(DVec3::new(0.1, 0.0, 1.0), 0.1));
            let board = square(DVec3::new(x, y, z), half);
            prop_assume!(blocks_all(&board, &front(&board), a.vertices(), b.vertices()));
            let (p, q) = (a.point_at(s, t), b.point_at(u, v));
            let at = p.lerp(q, (z - p.z) / (q.z - p.z));
            prop_assert!(board.outside_distance(at, DVec3::Z) < 1e-9);
        }
    }
}
