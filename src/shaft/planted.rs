//! Shafts with one plane turned over: tests that find nothing here would find nothing anywhere.

use super::{End, Shaft};
use crate::hierarchy::TOLERANCE;
use crate::math::{Aabb, Plane, Polygon};
use glam::{DVec3, Vec3};

impl Shaft {
    /// The same shaft with plane `index` facing the other way.
    fn with_plane_flipped(&self, index: usize) -> Shaft {
        let mut shaft = self.clone();
        shaft.planes[index] = shaft.planes[index].flipped();
        shaft
    }

    /// Whether a point is inside all planes but for rounding: what a shaft has to say of all segments.
    fn holds(&self, point: DVec3) -> bool {
        self.planes().iter().all(|plane| plane.distance(point) > -TOLERANCE)
    }

    /// Whether a small triangle across a segment is a candidate: what a cull has to say of all of them.
    fn keeps_triangle_at(&self, point: DVec3, direction: DVec3) -> bool {
        let side = direction.any_orthonormal_vector();
        let other = direction.normalize().cross(side);
        let corners = [side, other - side, -other - side].map(|offset| point + offset * 1e-3);
        self.holds_part_of(&corners, TOLERANCE)
    }
}

fn front(polygon: &Polygon) -> Plane {
    Plane::through(polygon.center(), polygon.area_vector().normalize())
}

/// Two polygons that face each other, and two boxes.
fn shafts() -> [(Shaft, [[DVec3; 4]; 2]); 2] {
    let low = [(0.0, 0.0), (0.5, 0.1), (0.4, 0.6), (-0.1, 0.4)].map(|(x, y)| DVec3::new(x, y, 0.02 * x));
    let high = [(0.3, 0.2), (0.2, 0.7), (0.8, 0.9), (0.9, 0.1)].map(|(x, y)| DVec3::new(x, y, 0.8 - 0.1 * y));
    let high = if front(&Polygon::new(&high)).distance(low[0]) > 0.0 {
        high
    } else {
        [high[3], high[2], high[1], high[0]]
    };
    let (a, b) = (Polygon::new(&low), Polygon::new(&high));
    let polygons = Shaft::between(End::Polygon(&a, front(&a)), End::Polygon(&b, front(&b)));

    let [a, b] =
        [(Vec3::ZERO, 0.2), (Vec3::new(0.5, 0.4, 0.7), 0.3)].map(|(min, size)| Aabb { min, max: min + size });
    let boxes = Shaft::between(End::Box(a), End::Box(b));
    let some_corners = |bounds: Aabb, which: [usize; 4]| which.map(|i| bounds.corner(i));
    [(polygons, [low, high]), (boxes, [some_corners(a, [0, 3, 5, 6]), some_corners(b, [1, 2, 4, 7])])]
}

/// Points along segments between two ends, each a mean of some of the corners, with the direction.
fn points([a, b]: [[DVec3; 4]; 2]) -> Vec<(DVec3, DVec3)> {
    let inside = |corners: [DVec3; 4], i: usize| {
        let weights = [1 + i % 3, 1 + i % 5, 1 + i % 7, 1 + i % 2].map(|w| w as f64);
        let sum: f64 = weights.iter().sum();
        corners.iter().zip(weights).map(|(&c, w)| c * w).sum::<DVec3>() / sum
    };
    (0..200)
        .map(|i| {
            let (from, to) = (inside(a, i), inside(b, 3 * i + 1));
            (from.lerp(to, 0.1 + 0.8 * (i as f64 / 199.0)), to - from)
        })
        .collect()
}

/// Right shafts hold all points, and keep every triangle there; with any one plane turned over, segments
/// are outside and triangles on them are culled.
#[test]
fn one_flipped_plane_is_noticed() {
    for (shaft, ends) in shafts() {
        let points = points(ends);
        assert!(shaft.planes().len() >= 6);
        assert!(points.iter().all(|&(p, d)| shaft.holds(p) && shaft.keeps_triangle_at(p, d)));
        for index in 0..shaft.planes().len() {
            let faulty = shaft.with_plane_flipped(index);
            let outside = points.iter().filter(|(p, _)| !faulty.holds(*p)).count();
            let culled = points.iter().filter(|&&(p, d)| !faulty.keeps_triangle_at(p, d)).count();
            assert!(outside > 100 && culled > 100, "plane {index}: {outside} {culled} of {}", points.len());
        }
    }
}
