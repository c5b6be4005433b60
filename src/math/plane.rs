//! Oriented planes.

use super::Aabb;
use glam::DVec3;

/// The plane `normal · x = offset`; its front is where `normal · x > offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal.
    pub normal: DVec3,
    /// Distance of the origin, along the normal.
    pub offset: f64,
}

impl Plane {
    /// The plane through `point` with unit `normal`.
    pub fn through(point: DVec3, normal: DVec3) -> Plane {
        Plane { normal, offset: normal.dot(point) }
    }

    /// Signed distance of `point`; positive in front.
    #[inline]
    pub fn distance(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// The same plane seen from behind.
    pub fn flipped(self) -> Plane {
        Plane { normal: -self.normal, offset: -self.offset }
    }

    /// Smallest and largest signed distance of the points of a box.
    #[inline]
    pub fn distance_range(&self, bounds: &Aabb) -> (f64, f64) {
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let middle = self.distance((min + max) * 0.5);
        let reach = self.normal.abs().dot((max - min) * 0.5);
        (middle - reach, middle + reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn range_of_a_box_is_that_of_its_corners() {
        let plane = Plane::through(DVec3::new(0.1, 0.2, 0.3), DVec3::new(1.0, -2.0, 0.5).normalize());
        let bounds = Aabb { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(1.0, 3.0, 5.0) };
        let (lo, hi) = plane.distance_range(&bounds);
        let corners = (0..8).map(|i| plane.distance(bounds.corner(i)));
        assert!((corners.clone().fold(f64::MAX, f64::min) - lo).abs() < 1e-12);
        assert!((corners.fold(f64::MIN, f64::max) - hi).abs() < 1e-12);
    }
}
