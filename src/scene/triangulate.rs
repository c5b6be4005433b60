//! Polygons to triangles: quads along their better diagonal, convex polygons as a fan, everything else
//! by ear clipping in the plane the polygon is closest to.

use earcut::Earcut;
use glam::{DVec2, DVec3};

/// Splits polygons; keeps its buffers between calls.
pub(super) struct Triangulator {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    ears: Vec<u32>,
}

impl Triangulator {
    pub(super) fn new() -> Self {
        Self { earcut: Earcut::new(), flat: Vec::new(), ears: Vec::new() }
    }

    /// Appends the triangles of one polygon to `triangles` as indices into `corners`, wound like the
    /// polygon. At most `corners.len() − 2`: ear clipping leaves out ears without area.
    pub(super) fn split(&mut self, corners: &[DVec3], triangles: &mut Vec<[u32; 3]>) {
        match corners.len() {
            0..=2 => {}
            3 => triangles.push([0, 1, 2]),
            4 => triangles.extend(split_quad([corners[0], corners[1], corners[2], corners[3]])),
            _ => self.split_polygon(corners, triangles),
        }
    }

    fn split_polygon(&mut self, corners: &[DVec3], triangles: &mut Vec<[u32; 3]>) {
        self.flatten(corners);
        let count = corners.len() as u32;
        if let Some(apex) = self.fan_apex() {
            triangles.extend((1..count - 1).map(|i| [apex, (apex + i) % count, (apex + i + 1) % count]));
            return;
        }
        self.earcut.earcut_slice(&self.flat, &[], &mut self.ears);
        let flat = &self.flat;
        let point = |i: u32| DVec2::from(flat[i as usize]);
        triangles.extend(self.ears.as_chunks::<3>().0.iter().map(|&[a, b, c]| {
            let is_reversed = (point(b) - point(a)).perp_dot(point(c) - point(a)) < 0.0;
            if is_reversed { [a, c, b] } else { [a, b, c] }
        }));
    }

    /// Drops the axis that the Newell normal is longest along, so that the polygon turns left.
    fn flatten(&mut self, corners: &[DVec3]) {
        let origin = corners[0];
        let normal = newell_normal(corners);
        let size = normal.abs();
        let (u, v, w) = if size.x >= size.y && size.x >= size.z {
            (1, 2, 0)
        } else if size.y >= size.z {
            (2, 0, 1)
        } else {
            (0, 1, 2)
        };
        let (u, v) = if normal[w] < 0.0 { (v, u) } else { (u, v) };
        self.flat.clear();
        self.flat.extend(corners.iter().map(|&corner| {
            let local = corner - origin;
            [local[u], local[v]]
        }));
    }

    /// A corner whose fan covers a convex polygon without flat triangles, if there is one.
    fn fan_apex(&self) -> Option<u32> {
        let count = self.flat.len();
        let point = |i: usize| DVec2::from(self.flat[i % count]);
        let mut direction_changes = 0;
        let mut last_sign = 0.0;
        let mut first_sign = 0.0;
        for i in 0..count {
            let edge = point(i + 1) - point(i);
            if edge.perp_dot(point(i + 2) - point(i + 1)) < 0.0 {
                return None;
            }
            // A convex outline goes left and right only once; a star turns left all the way round too.
            let sign = if edge.x != 0.0 { edge.x.signum() } else { 0.0 };
            if sign != 0.0 {
                if first_sign == 0.0 {
                    first_sign = sign;
                } else if sign != last_sign {
                    direction_changes += 1;
                }
                last_sign = sign;
            }
        }
        direction_changes += usize::from(last_sign != first_sign);
        if direction_changes > 2 {
            return None;
        }
        // Trying every apex of a large polygon would be quadratic; one of the first few does.
        (0..count.min(8))
            .find(|&apex| {
                (1..count - 1).all(|i| {
                    let (a, b, c) = (point(apex), point(apex + i), point(apex + i + 1));
                    let (ab, ac) = (b - a, c - a);
                    ab.perp_dot(ac) > 1e-12 * ab.length() * ac.length()
                })
            })
            .map(|apex| apex as u32)
    }
}

/// Two triangles that share a diagonal and are wound like the quad.
fn split_quad([a, b, c, d]: [DVec3; 4]) -> [[u32; 3]; 2] {
    let normal = newell_normal(&[a, b, c, d]);
    let faces_front = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p).dot(normal) > 0.0;
    let along_ac = faces_front(a, b, c) && faces_front(a, c, d);
    let along_bd = faces_front(a, b, d) && faces_front(b, c, d);
    // Where both fit, the shorter diagonal gives the rounder triangles; rectangles take the first.
    let is_bd_shorter = (d - b).length_squared() < (c - a).length_squared() * (1.0 - 1e-9);
    if along_bd && (!along_ac || is_bd_shorter) { [[0, 1, 3], [1, 2, 3]] } else { [[0, 1, 2], [0, 2, 3]] }
}

/// Twice the area vector of a polygon, planar or not, independent of the origin.
pub(super) fn newell_normal(corners: &[DVec3]) -> DVec3 {
    let origin = corners[0];
    corners.windows(2).map(|pair| (pair[0] - origin).cross(pair[1] - origin)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area vector of the triangles and the number of them that face away from `normal`.
    fn covered(corners: &[DVec3]) -> (DVec3, usize, usize) {
        let mut triangles = Vec::new();
        Triangulator::new().split(corners, &mut triangles);
        let normal = newell_normal(corners);
        let mut total = DVec3::ZERO;
        let mut away = 0;
        for [a, b, c] in &triangles {
            let [a, b, c] = [a, b, c].map(|&i| corners[i as usize]);
            let area = (b - a).cross(c - a);
            away += usize::from(area.dot(normal) <= 0.0);
            total += area;
        }
        (total, away, triangles.len())
    }

    fn flat(points: &[(f64, f64)]) -> Vec<DVec3> {
        points.iter().map(|&(x, y)| DVec3::new(x, y, 0.25 * x)).collect()
    }

    #[test]
    fn every_kind_of_polygon_is_covered_once_and_keeps_its_winding() {
        let shapes: [(&str, Vec<DVec3>); 8] = [
            ("square", flat(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)])),
            ("arrowhead", flat(&[(0., 0.), (2., 1.), (0., 2.), (0.5, 1.)])),
            ("arrowhead from its notch", flat(&[(0.5, 1.), (0., 0.), (2., 1.), (0., 2.)])),
            ("hexagon", flat(&[(1., 0.), (2., 0.), (3., 1.), (2., 2.), (1., 2.), (0., 1.)])),
            ("L", flat(&[(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)])),
            ("collinear", flat(&[(0., 0.), (1., 0.), (2., 0.), (2., 1.), (0., 1.)])),
            ("clockwise L", flat(&[(0., 2.), (1., 2.), (1., 1.), (2., 1.), (2., 0.), (0., 0.)])),
            ("comb", flat(&[(0., 0.), (5., 0.), (5., 3.), (4., 3.), (4., 1.), (3., 1.), (3., 3.), (0., 3.)])),
        ];
        for (name, corners) in &shapes {
            let (total, away, count) = covered(corners);
            let error = (total - newell_normal(corners)).length();
            assert!(error < 1e-12, "{name}: area is off by {error}");
            assert_eq!(away, 0, "{name}: a triangle faces the wrong way");
            assert!(count <= corners.len() - 2, "{name}: too many triangles");
        }
    }

    #[test]
    fn a_star_is_not_taken_for_convex() {
        let star: Vec<DVec3> = (0..5)
            .map(|i| {
                let angle = f64::from(i) * 2.0 * std::f64::consts::TAU / 5.0;
                DVec3::new(angle.cos(), angle.sin(), 0.0)
            })
            .collect();
        let mut triangulator = Triangulator::new();
        triangulator.flatten(&star);
        assert_eq!(triangulator.fan_apex(), None);
    }

    #[test]
    fn polygons_without_area_do_not_panic() {
        for count in 0..9 {
            let mut triangles = Vec::new();
            Triangulator::new().split(&vec![DVec3::ONE; count], &mut triangles);
            assert!(triangles.len() <= count.saturating_sub(2));
            let line: Vec<DVec3> = (0..count).map(|i| DVec3::X * i as f64).collect();
            triangles.clear();
            Triangulator::new().split(&line, &mut triangles);
            assert!(triangles.len() <= count.saturating_sub(2));
        }
    }

    #[test]
    fn a_quad_far_from_the_origin_keeps_its_area() {
        let far = DVec3::splat(1e6);
        let corners: Vec<DVec3> =
            flat(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)]).iter().map(|&p| p + far).collect();
        let (total, away, count) = covered(&corners);
        assert_eq!((away, count), (0, 2));
        assert!((total.length() - 2.0 * 1.0625f64.sqrt()).abs() < 1e-9);
    }
}
