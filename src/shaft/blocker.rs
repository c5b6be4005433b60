//! The single-blocker test: does one convex facet hide two nodes from each other completely?
//!
//! If every segment between a corner of one node and a corner of the other meets the convex facet,
//! so does every segment between the nodes: for a fixed point, the points a convex set hides from it
//! form a convex set, so the corners of one node decide for all of it, and then the same argument
//! holds for the other node.

use crate::hierarchy::TOLERANCE;
use crate::math::{Plane, Polygon};
use glam::DVec3;

/// Crossings nearer than this to an end of a segment, relative to its length, do not block: rays
/// leave out a little less at both ends, so that a proof never contradicts them.
pub(super) const END_MARGIN: f64 = 2e-4;

/// Whether the facet blocks every segment from a corner of the receiver to a corner of the source.
pub fn blocks_all(facet: &Polygon, plane: &Plane, receiver: &[DVec3], source: &[DVec3]) -> bool {
    // All of one node on one side and all of the other on the other, by more than rounding.
    let side = plane.distance(receiver[0]);
    let separated = receiver.iter().all(|&p| plane.distance(p) * side.signum() > TOLERANCE)
        && source.iter().all(|&p| plane.distance(p) * side.signum() < -TOLERANCE);
    if !separated {
        return false;
    }
    receiver.iter().all(|&a| {
        let da = plane.distance(a);
        source.iter().all(|&b| {
            let t = da / (da - plane.distance(b));
            let at = a + (b - a) * t;
            (END_MARGIN..=1.0 - END_MARGIN).contains(&t)
                && facet.edges().all(|(start, end)| plane.normal.dot((end - start).cross(at - start)) >= 0.0)
        })
    })
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
