//! Clipping a convex polygon by several planes in turn (Sutherland & Hodgman).

use super::Plane;
use glam::DVec3;

/// Room for a facet clipped by every plane of a shaft and every face of its box.
const CAPACITY: usize = 48;

/// A convex polygon being clipped, in fixed storage for `N` vertices.
#[derive(Clone, Debug)]
pub struct Clip<const N: usize = CAPACITY> {
    count: usize,
    points: [DVec3; N],
    spare: [DVec3; N],
}

impl<const N: usize> Clip<N> {
    /// Starts with these vertices (at most 8).
    pub fn new(vertices: &[DVec3]) -> Self {
        let mut clip = Clip { count: vertices.len(), points: [DVec3::ZERO; N], spare: [DVec3::ZERO; N] };
        clip.points[..vertices.len()].copy_from_slice(vertices);
        clip
    }

    /// What is left, in order; empty when nothing is.
    pub fn vertices(&self) -> &[DVec3] {
        &self.points[..self.count]
    }

    /// Keeps what lies more than `margin` in front of the plane; says whether anything does.
    pub fn keep_front(&mut self, plane: &Plane, margin: f64) -> bool {
        let mut kept = 0;
        for i in 0..self.count {
            let (a, b) = (self.points[i], self.points[(i + 1) % self.count]);
            let (da, db) = (plane.distance(a) - margin, plane.distance(b) - margin);
            if da >= 0.0 && kept < N {
                self.spare[kept] = a;
                kept += 1;
            }
            if (da > 0.0 && db < 0.0 || da < 0.0 && db > 0.0) && kept < N {
                self.spare[kept] = a + (b - a) * (da / (da - db));
                kept += 1;
            }
        }
        if kept < 3 {
            kept = 0;
        }
        // Not swapped: few of the points are in use.
        self.points[..kept].copy_from_slice(&self.spare[..kept]);
        self.count = kept;
        kept > 0
    }

    /// Twice the area times the normal of what is left.
    pub fn area_vector(&self) -> DVec3 {
        let v = self.vertices();
        (1..v.len().saturating_sub(1)).map(|i| (v[i] - v[0]).cross(v[i + 1] - v[0])).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipping_a_square_by_four_planes_leaves_the_middle() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let mut clip: Clip = Clip::new(&square);
        for normal in [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y] {
            let middle = DVec3::new(0.5, 0.5, 0.0);
            assert!(clip.keep_front(&Plane::through(middle - normal * 0.25, normal), 0.0));
        }
        assert!((clip.area_vector().length() * 0.5 - 0.25).abs() < 1e-12);
        assert!(
            !clip.keep_front(&Plane::through(DVec3::new(0.75, 0.0, 0.0), DVec3::X), 1e-9),
            "only touches"
        );
        assert!(clip.vertices().is_empty());
    }
}
