//! Building the planes of a shaft between two ends.

use crate::hierarchy::TOLERANCE;
use crate::math::{Aabb, Plane, Polygon};
use glam::DVec3;

/// Room for the planes of the largest shaft; planes beyond it are left out, which only widens it.
const MAX_PLANES: usize = 32;

/// One end of a shaft.
#[derive(Clone, Copy, Debug)]
pub enum End<'a> {
    /// A planar node that sees and is seen on the front of `plane`.
    Polygon(&'a Polygon, Plane),
    /// A cluster.
    Box(Aabb),
}

impl End<'_> {
    fn bounds(&self) -> Aabb {
        match self {
            End::Polygon(polygon, _) => polygon.bounds(),
            End::Box(bounds) => *bounds,
        }
    }

    /// The corners whose convex hull is the end.
    pub fn corners(&self, room: &mut [DVec3; 8]) -> usize {
        match self {
            End::Polygon(polygon, _) => {
                let v = polygon.vertices();
                room[..v.len()].copy_from_slice(v);
                v.len()
            }
            End::Box(bounds) => {
                *room = std::array::from_fn(|i| bounds.corner(i));
                8
            }
        }
    }
}

/// A convex region; every plane's front is inside.
#[derive(Clone, Debug)]
pub struct Shaft {
    pub(super) count: usize,
    pub(super) planes: [Plane; MAX_PLANES],
    pub(super) bounds: Aabb,
}

impl Shaft {
    /// The shaft between two ends: the tight one when both are polygons, the one around their boxes
    /// otherwise.
    pub fn between(receiver: End<'_>, source: End<'_>) -> Shaft {
        let bounds = receiver.bounds().union(source.bounds());
        let nothing = Plane { normal: DVec3::ZERO, offset: 0.0 };
        let mut shaft = Shaft { count: 0, planes: [nothing; MAX_PLANES], bounds };
        for end in [receiver, source] {
            if let End::Polygon(_, plane) = end {
                shaft.push(plane);
            }
        }
        match (receiver, source) {
            (End::Polygon(a, _), End::Polygon(b, _)) => {
                shaft.join_edges(a, b);
                shaft.join_edges(b, a);
            }
            _ => shaft.join_boxes(receiver.bounds(), source.bounds()),
        }
        shaft
    }

    /// Its planes, without the box around both ends.
    pub fn planes(&self) -> &[Plane] {
        &self.planes[..self.count]
    }

    /// The box around both ends.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Adds every plane through an edge of `a` and a vertex of `b` that has both on one side.
    fn join_edges(&mut self, a: &Polygon, b: &Polygon) {
        for (start, end) in a.edges() {
            let along = end - start;
            for &vertex in b.vertices() {
                let normal = along.cross(vertex - start);
                let length = normal.length();
                // An edge that points at the vertex spans no plane.
                if length < 1e-9 * along.length() {
                    continue;
                }
                let plane = Plane::through(start, normal / length);
                let distances = || a.vertices().iter().chain(b.vertices()).map(|&p| plane.distance(p));
                let slack = TOLERANCE * 1e-3;
                if distances().all(|d| d >= -slack) {
                    self.push(plane);
                } else if distances().all(|d| d <= slack) {
                    self.push(plane.flipped());
                }
            }
        }
    }

    /// Adds the planes that join an edge of one box to an edge of the other, at most 8: for each edge
    /// of the box around both whose two faces come from different boxes.
    fn join_boxes(&mut self, a: Aabb, b: Aabb) {
        let (lo, hi) = ([a.min.as_dvec3(), b.min.as_dvec3()], [a.max.as_dvec3(), b.max.as_dvec3()]);
        for (u, v) in [(0, 1), (1, 2), (2, 0)] {
            for (from_high_u, from_high_v) in [(false, false), (false, true), (true, false), (true, true)] {
                let face = |axis: usize, high: bool, which: usize| {
                    if high { hi[which][axis] } else { lo[which][axis] }
                };
                let leads = |axis: usize, high: bool| {
                    let (x, y) = (face(axis, high, 0), face(axis, high, 1));
                    // Which box defines the face of the common box, if only one does.
                    match (x == y, (x > y) == high) {
                        (true, _) => None,
                        (false, true) => Some(0),
                        (false, false) => Some(1),
                    }
                };
                let (Some(leader_u), Some(leader_v)) = (leads(u, from_high_u), leads(v, from_high_v)) else {
                    continue;
                };
                if leader_u == leader_v {
                    continue;
                }
                let corner = |which: usize| (face(u, from_high_u, which), face(v, from_high_v, which));
                let (p, q) = (corner(leader_u), corner(leader_v));
                // Outward means further along u for p's side and along v for q's.
                let outward_u = (q.1 - p.1).abs() * if from_high_u { 1.0 } else { -1.0 };
                let outward_v = (q.0 - p.0).abs() * if from_high_v { 1.0 } else { -1.0 };
                let mut normal = DVec3::ZERO;
                normal[u] = -outward_u;
                normal[v] = -outward_v;
                let mut point = DVec3::ZERO;
                point[u] = p.0;
                point[v] = p.1;
                self.push(Plane::through(point, normal.normalize_or_zero()));
            }
        }
    }

    fn push(&mut self, plane: Plane) {
        let same = |other: &Plane| {
            other.normal.dot(plane.normal) > 1.0 - 1e-12
                && (other.offset - plane.offset).abs() < TOLERANCE * 1e-3
        };
        if self.count < MAX_PLANES && !self.planes().iter().any(same) {
            self.planes[self.count] = plane;
            self.count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use proptest::prelude::*;

    fn coordinates() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    fn triangle() -> impl Strategy<Value = Polygon> {
        (coordinates(), coordinates(), coordinates())
            .prop_map(|(a, b, c)| Polygon::new(&[a, b, c]))
            .prop_filter("a sliver has no plane", |p| p.area() > 1e-3)
    }

    fn front(polygon: &Polygon) -> Plane {
        Plane::through(polygon.center(), polygon.area_vector().normalize())
    }

    fn aabb() -> impl Strategy<Value = Aabb> {
        (coordinates(), coordinates()).prop_map(|(a, b)| Aabb::around([a.as_vec3(), b.as_vec3()]))
    }

    proptest! {
        /// A failure means that something outside the shaft could block: no proof would hold.
        #[test]
        fn polygon_shaft_holds_every_segment(
            a in triangle(), b in triangle(), s in 0.0..1.0f64, t in 0.0..1.0f64, u in 0.0..1.0f64, v in 0.0..1.0f64, k in 0.0..1.0f64
        ) {
            let (pa, pb) = (front(&a), front(&b));
            let (x, y) = (a.point_at(s, t), b.point_at(u, v));
            // Only segments in front of both ends carry light.
            prop_assume!(pa.distance(y) > 0.0 && pb.distance(x) > 0.0);
            let shaft = Shaft::between(End::Polygon(&a, pa), End::Polygon(&b, pb));
            let p = x.lerp(y, k);
            prop_assert!(shaft.planes().iter().all(|plane| plane.distance(p) > -TOLERANCE));
        }

        #[test]
        fn box_shaft_holds_every_segment(a in aabb(), b in aabb(), s in 0usize..8, t in 0usize..8, k in 0.0..1.0f64) {
            let shaft = Shaft::between(End::Box(a), End::Box(b));
            let p = a.corner(s).lerp(b.corner(t), k);
            prop_assert!(shaft.planes().iter().all(|plane| plane.distance(p) > -TOLERANCE), "{:?}", shaft.planes());
            prop_assert!(shaft.planes().len() <= 8);
        }

        #[test]
        fn shaft_of_a_polygon_and_a_box_holds_every_segment(
            a in triangle(), b in aabb(), s in 0.0..1.0f64, t in 0.0..1.0f64, x in 0.0..1.0f64, y in 0.0..1.0f64, z in 0.0..1.0f64, k in 0.0..1.0f64
        ) {
            let plane = front(&a);
            let (min, max) = (b.min.as_dvec3(), b.max.as_dvec3());
            let from = a.point_at(s, t);
            let to = min + (max - min) * DVec3::new(x, y, z);
            prop_assume!(plane.distance(to) > 0.0);
            let p = from.lerp(to, k);
            for shaft in [
                Shaft::between(End::Polygon(&a, plane), End::Box(b)),
                Shaft::between(End::Box(b), End::Polygon(&a, plane)),
            ] {
                prop_assert!(shaft.planes().iter().all(|plane| plane.distance(p) > -TOLERANCE));
                prop_assert!(shaft.bounds().contains(p, TOLERANCE));
            }
        }
    }

    #[test]
    fn boxes_apart_on_a_diagonal_leave_out_the_corner() {
        let a = Aabb { min: Vec3::ZERO, max: Vec3::splat(0.1) };
        let b = Aabb { min: Vec3::splat(0.9), max: Vec3::ONE };
        let shaft = Shaft::between(End::Box(a), End::Box(b));
        let corner = DVec3::new(0.9, 0.1, 0.5);
        assert!(shaft.planes().iter().any(|p| p.distance(corner) < -0.1));
    }
}
