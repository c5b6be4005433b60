//! Sums of cosine lobes as second-order spherical harmonics.
//!
//! Both sides of a cluster have the same form: light from directions `d` gives a surface with
//! normal `n` the irradiance `Σ I·max(0, n·d)`, and surfaces with normals `n` send the intensity
//! `Σ (B·A/π)·max(0, n·ω)` towards `ω`. Nine coefficients a channel hold the sum
//! (Ramamoorthi & Hanrahan, An efficient representation for irradiance environment maps, 2001).

use glam::Vec3;
use std::ops::{Add, AddAssign, Mul};

/// A sum of clamped cosine lobes, with colour or without.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CosineLobes<T = Vec3> {
    coefficients: [T; 9],
}

/// What lobes are sums of.
pub trait Amount: Copy + Default + Add<Output = Self> + AddAssign + Mul<f32, Output = Self> {
    /// No less than nothing.
    fn positive(self) -> Self;
}

impl Amount for f32 {
    fn positive(self) -> f32 {
        self.max(0.0)
    }
}

impl Amount for Vec3 {
    fn positive(self) -> Vec3 {
        self.max(Vec3::ZERO)
    }
}

impl<T: Amount> CosineLobes<T> {
    /// Adds `weight·max(0, x·direction)`; the zero direction adds the mean over all directions.
    pub fn add(&mut self, direction: Vec3, weight: T) {
        let y = basis(direction);
        for (c, y) in self.coefficients.iter_mut().zip(y) {
            *c += weight * y;
        }
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: &CosineLobes<T>) {
        for (c, o) in self.coefficients.iter_mut().zip(&other.coefficients) {
            *c += *o;
        }
    }

    /// The sum at unit direction `x`, never negative.
    pub fn evaluate(&self, x: Vec3) -> T {
        self.evaluate_signed(x).positive()
    }

    /// The sum at unit direction `x`, which may be a little negative.
    pub fn evaluate_signed(&self, x: Vec3) -> T {
        let terms = self.coefficients.iter().zip(basis(x)).zip(BANDS);
        terms.fold(T::default(), |sum, ((coefficient, y), band)| sum + *coefficient * (y * band))
    }

    /// Mean over all directions.
    pub fn mean(&self) -> T {
        self.coefficients[0] * (basis(Vec3::ZERO)[0] * std::f32::consts::PI)
    }
}

/// What a band of coefficients counts when a cosine lobe is taken of it.
const BANDS: [f32; 9] = {
    use std::f32::consts::PI;
    let (first, second) = (PI * 2.0 / 3.0, PI / 4.0);
    [PI, first, first, first, second, second, second, second, second]
};

/// A direction as its parts along the axes: `[x, y, z]` from above 0, then from below; the zero direction as the mean
/// over all directions.
///
/// Light from `d` falls on a surface with normal `n` about as the sum of the products of their parts says: where either
/// lies along an axis, or both in one octant, that is `max(0, n·d)`, else up to 1/2 more; never less than nothing.
pub fn axial_parts(direction: Vec3) -> [f32; 6] {
    if direction == Vec3::ZERO {
        return [0.25; 6];
    }
    let (above, below) = (direction.max(Vec3::ZERO), (-direction).max(Vec3::ZERO));
    [above.x, above.y, above.z, below.x, below.y, below.z]
}

/// The nine real spherical harmonics up to second order; only the first is not zero at the origin.
fn basis(d: Vec3) -> [f32; 9] {
    let (x, y, z) = (d.x, d.y, d.z);
    let length_squared = d.length_squared();
    [
        0.282_094_8,
        0.488_602_5 * y,
        0.488_602_5 * z,
        0.488_602_5 * x,
        1.092_548_4 * x * y,
        1.092_548_4 * y * z,
        0.315_391_57 * (3.0 * z * z - length_squared),
        1.092_548_4 * x * z,
        0.546_274_2 * (x * x - y * y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_lobe_is_reproduced_within_a_tenth() {
        let d = Vec3::new(0.3, -0.5, 0.8).normalize();
        let mut lobes = CosineLobes::default();
        lobes.add(d, Vec3::ONE);
        for i in 0..100 {
            let t = i as f32 * 0.37;
            let x = Vec3::new(t.cos() * (t * 0.7).sin(), (t * 0.7).cos(), t.sin() * (t * 0.7).sin());
            let exact = x.dot(d).max(0.0);
            assert!((lobes.evaluate(x).x - exact).abs() < 0.1, "{x}: {} for {exact}", lobes.evaluate(x).x);
        }
    }

    #[test]
    fn parts_along_axes_are_the_cosine_where_one_direction_is_an_axis() {
        let light =
            |n: Vec3, d: Vec3| -> f32 { axial_parts(n).iter().zip(axial_parts(d)).map(|(n, d)| n * d).sum() };
        let direction = Vec3::new(0.3, -0.5, 0.8).normalize();
        for axis in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
            assert_eq!(light(axis, direction), axis.dot(direction).max(0.0));
            assert_eq!(light(axis, Vec3::ZERO), 0.25);
        }
        let same_octant = Vec3::new(0.7, -0.1, 0.2).normalize();
        assert!((light(direction, same_octant) - direction.dot(same_octant)).abs() < 1e-6);
        assert_eq!(light(direction, -same_octant), 0.0);
    }

    #[test]
    fn mean_of_a_lobe_is_a_quarter() {
        let mut lobes = CosineLobes::default();
        lobes.add(Vec3::X, Vec3::splat(2.0));
        assert!((lobes.mean().y - 0.5).abs() < 1e-5);
        let mut even = CosineLobes::default();
        even.add(Vec3::ZERO, Vec3::splat(2.0));
        assert!((even.evaluate(Vec3::Y).x - 0.5).abs() < 1e-5);
    }
}
