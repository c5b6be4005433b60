//! The lines along which elements are divided, by themselves: all it takes to find the element at a point.

use crate::math::Plane;
use glam::{DVec2, DVec3};

/// A line for each element that is divided, in the order of their ids.
#[derive(Debug, Default)]
pub(super) struct Lines {
    /// `(a, b, c)`: flat points with `a·x + b·y + c ≥ 0` are in the first half.
    lines: Vec<[f32; 3]>,
}

/// A point in a plane with this normal as two of its coordinates, without the one nearest to the normal. What lies off the
/// plane counts as the point of it along that axis.
pub(super) fn flat(normal: DVec3, point: DVec3) -> DVec2 {
    let [_, i, j] = axes(normal);
    DVec2::new(point[i], point[j])
}

/// The axis nearest to a normal, and the others.
fn axes(normal: DVec3) -> [usize; 3] {
    let [x, y, z] = normal.abs().to_array();
    if x >= y && x >= z {
        [0, 1, 2]
    } else if y >= z {
        [1, 2, 0]
    } else {
        [2, 0, 1]
    }
}

impl Lines {
    pub(super) fn with_capacity(count: usize) -> Lines {
        Lines { lines: Vec::with_capacity(count) }
    }

    /// Adds the line along which `across` divides an element in the plane `of`; its first half lies in front. Neither
    /// normal need have length 1.
    pub(super) fn push(&mut self, across: &Plane, of: &Plane) {
        let [k, i, j] = axes(of.normal);
        // In the plane the third coordinate follows from the others.
        let slope = across.normal[k] / of.normal[k];
        let a = across.normal[i] - slope * of.normal[i];
        let b = across.normal[j] - slope * of.normal[j];
        let c = slope * of.offset - across.offset;
        let scale = 1.0 / a.abs().max(b.abs()).max(f64::MIN_POSITIVE);
        self.lines.push([a, b, c].map(|x| (x * scale) as f32));
    }

    pub(super) fn bytes(&self) -> u64 {
        size_of_val(&self.lines[..]) as u64
    }

    /// In which half of the element with this line a flat point lies.
    pub(super) fn half(&self, line: u32, point: DVec2) -> usize {
        let [a, b, c] = self.lines[line as usize].map(f64::from);
        usize::from(a * point.x + b * point.y + c < 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Polygon;

    #[test]
    fn a_point_is_in_the_half_on_its_side_of_the_line() {
        let tilts = [DVec3::Z, -DVec3::Y, DVec3::new(0.3, -0.8, 0.5), DVec3::new(-0.9, 0.1, 0.42)];
        for normal in tilts.map(DVec3::normalize) {
            let (u, v) = normal.any_orthonormal_pair();
            let corner = |i: u32| {
                let (s, c) = (f64::from(i) * std::f64::consts::TAU / 7.0).sin_cos();
                DVec3::new(0.1, -0.2, 0.3) + u * c + v * s
            };
            for count in 3..=7 {
                let corners: Vec<DVec3> = (0..count).map(corner).collect();
                let mut polygon = Polygon::new(&corners);
                let plane = Plane::through(corners[0], normal);
                for step in 0..8 {
                    let mut lines = Lines::default();
                    lines.push(&polygon.cut_plane(normal), &plane);
                    let halves = polygon.bisect();
                    for (i, half) in halves.iter().enumerate() {
                        let center = flat(normal, half.center());
                        assert_eq!(lines.half(0, center), i, "{normal} {count} {step}");
                        for &corner in half.vertices() {
                            let near = flat(normal, corner.lerp(half.center(), 1e-3));
                            assert_eq!(lines.half(0, near), i, "{normal} {count} {step}");
                        }
                    }
                    polygon = halves[step % 2];
                }
            }
        }
    }
}
