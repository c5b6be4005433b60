//! Local coordinates: recentred and scaled, so that single precision is spent on the scene and not
//! on where it lies.

use glam::{DVec3, Vec3};

/// The map between scene units and local coordinates, in which the scene spans at most −1 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    center: DVec3,
    /// Local units in one scene unit, a power of two so that scaling is exact.
    scale: f64,
}

impl Frame {
    /// The frame that centres these points.
    pub fn around(points: &[DVec3]) -> Frame {
        let (min, max) =
            points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        if points.is_empty() {
            return Frame { center: DVec3::ZERO, scale: 1.0 };
        }
        let half = ((max - min) * 0.5).max_element().max(f64::MIN_POSITIVE);
        Frame { center: (min + max) * 0.5, scale: (-half.log2().ceil()).exp2() }
    }

    /// A scene point in local coordinates.
    pub fn local_from_scene(&self, point: DVec3) -> Vec3 {
        ((point - self.center) * self.scale).as_vec3()
    }

    /// A local point in scene units.
    pub fn scene_from_local(&self, point: DVec3) -> DVec3 {
        point / self.scale + self.center
    }

    /// The numbers it is made of.
    pub(super) fn numbers(&self) -> [f64; 4] {
        let [x, y, z] = self.center.to_array();
        [x, y, z, self.scale]
    }

    /// A length in scene units as a local length.
    pub fn local_length(&self, length: f64) -> f64 {
        length * self.scale
    }

    /// Scene units in one local unit.
    pub fn scene_units_per_local(&self) -> f64 {
        1.0 / self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_room_far_away_keeps_its_digits() {
        let far = DVec3::new(1e7, -2e7, 5e6);
        let points = [far, far + DVec3::new(3.0, 0.001, 2.0)];
        let frame = Frame::around(&points);
        let local = points.map(|p| frame.local_from_scene(p));
        assert!(local.iter().all(|p| p.abs().max_element() <= 1.0));
        assert!(frame.scene_from_local(local[1].as_dvec3()).distance(points[1]) < 1e-6);
        assert!(local[0].y != local[1].y);
    }
}
