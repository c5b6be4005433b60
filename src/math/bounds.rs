//! Axis-aligned boxes.

use glam::{DVec3, Vec3};

/// An axis-aligned box in single precision; exact for single-precision vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The box of nothing: the neutral element of [`Aabb::union`].
    pub const EMPTY: Aabb = Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around `points`.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Aabb {
        points.into_iter().fold(Aabb::EMPTY, |b, p| Aabb { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The smallest box around both.
    pub fn union(self, other: Aabb) -> Aabb {
        Aabb { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Middle of the box.
    pub fn center(self) -> DVec3 {
        (self.min.as_dvec3() + self.max.as_dvec3()) * 0.5
    }

    /// Half the length of the diagonal.
    pub fn radius(self) -> f64 {
        (self.max.as_dvec3() - self.min.as_dvec3()).length() * 0.5
    }

    /// Corner `index` in `0..8`: bit 0 chooses x, bit 1 y, bit 2 z; a set bit takes the maximum.
    pub fn corner(self, index: usize) -> DVec3 {
        let pick = |bit: usize, lo: f32, hi: f32| if index >> bit & 1 == 1 { hi } else { lo } as f64;
        DVec3::new(
            pick(0, self.min.x, self.max.x),
            pick(1, self.min.y, self.max.y),
            pick(2, self.min.z, self.max.z),
        )
    }

    /// Whether the boxes, grown by `margin`, share a point.
    pub fn overlaps(self, other: Aabb, margin: f32) -> bool {
        let margin = Vec3::splat(margin);
        (self.min - margin).cmple(other.max).all() && (other.min - margin).cmple(self.max).all()
    }

    /// Whether `point` lies in the box grown by `margin`.
    pub fn contains(self, point: DVec3, margin: f64) -> bool {
        let margin = DVec3::splat(margin);
        point.cmpge(self.min.as_dvec3() - margin).all() && point.cmple(self.max.as_dvec3() + margin).all()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_span_the_box() {
        let b = Aabb { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(1.0, 3.0, 5.0) };
        assert_eq!(Aabb::around((0..8).map(|i| b.corner(i).as_vec3())), b);
        assert!((b.radius() - (4.0f64 + 9.0 + 9.0).sqrt() / 2.0).abs() < 1e-12);
    }

    #[test]
    fn boxes_that_touch_overlap() {
        let a = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
        let b = Aabb { min: Vec3::new(1.0, 0.0, 0.0), max: Vec3::splat(2.0) };
        assert!(a.overlaps(b, 0.0));
        assert!(!a.overlaps(b, -1e-3));
    }
}
