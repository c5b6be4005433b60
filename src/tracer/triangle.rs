//! The ray–triangle test of the two Rust tracers: signed volumes in double precision, in the manner
//! of [WBW13]. An edge gives the same volume, with the other sign, to both its triangles, so no ray
//! slips between neighbours.

use glam::{DVec3, Vec3};

/// A ray prepared for many triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    origin: DVec3,
    direction: DVec3,
}

impl Probe {
    pub(super) fn new(origin: Vec3, direction: Vec3) -> Probe {
        Probe { origin: origin.as_dvec3(), direction: direction.as_dvec3() }
    }

    /// Where the line meets a triangle, in units of the direction; either side counts, edges and
    /// corners too.
    #[inline]
    pub(super) fn meet(&self, corners: &[Vec3; 3]) -> Option<f64> {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3() - self.origin);
        let u = self.direction.dot(c.cross(b));
        let v = self.direction.dot(a.cross(c));
        let w = self.direction.dot(b.cross(a));
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None;
        }
        let normal = (b - a).cross(c - a);
        let facing = normal.dot(self.direction);
        (facing != 0.0).then(|| normal.dot(a) / facing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_through_a_shared_edge_are_stopped() {
        let corners =
            [Vec3::ZERO, Vec3::new(0.7, 0.1, 0.0), Vec3::new(0.9, 1.1, 0.2), Vec3::new(0.1, 0.8, 0.0)];
        let triangles = [[0, 1, 2], [0, 2, 3]].map(|triangle| triangle.map(|v: usize| corners[v]));
        for i in 1..1000 {
            let on_edge = corners[2] * (i as f32 / 1000.0);
            let from = Vec3::new(0.31, 0.17, 3.0);
            let probe = Probe::new(from, on_edge - from);
            assert!(triangles.iter().any(|t| probe.meet(t).is_some()), "slipped through at {i}");
        }
    }

    #[test]
    fn distance_is_in_units_of_the_direction() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let probe = Probe::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z * 4.0);
        assert_eq!(probe.meet(&triangle), Some(0.25));
        assert_eq!(Probe::new(Vec3::new(0.2, 0.2, 1.0), Vec3::X).meet(&triangle), None);
    }
}
