//! Sums of cosine lobes as second-order spherical harmonics.
//!
//! Both sides of a cluster have the same form: light from directions `d` gives a surface with
//! normal `n` the irradiance `Σ I·max(0, n·d)`, and surfaces with normals `n` send the intensity
//! `Σ (B·A/π)·max(0, n·ω)` towards `ω`. Nine coefficients a channel hold the sum
//! (Ramamoorthi & Hanrahan, An efficient representation for irradiance environment maps, 2001).

use glam::Vec3;

/// A sum of clamped cosine lobes with colour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CosineLobes {
    coefficients: [Vec3; 9],
}

impl CosineLobes {
    /// Adds `weight·max(0, x·direction)`; the zero direction adds the mean over all directions.
    pub fn add(&mut self, direction: Vec3, weight: Vec3) {
        let y = basis(direction);
        for (c, y) in self.coefficients.iter_mut().zip(y) {
            *c += weight * y;
        }
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: &CosineLobes) {
        for (c, o) in self.coefficients.iter_mut().zip(&other.coefficients) {
            *c += *o;
        }
    }

    /// The sum at unit direction `x`, never negative.
    pub fn evaluate(&self, x: Vec3) -> Vec3 {
        self.evaluate_signed(x).max(Vec3::ZERO)
    }

    /// The sum at unit direction `x`, which may be a little negative.
    pub fn evaluate_signed(&self, x: Vec3) -> Vec3 {
        self.evaluate_with(&LobeWeights::toward(x))
    }

    /// The same, for many sums at one direction.
    #[inline]
    pub fn evaluate_with(&self, weights: &LobeWeights) -> Vec3 {
        let terms = self.coefficients.iter().zip(weights.0);
        terms.fold(Vec3::ZERO, |sum, (coefficient, weight)| sum + *coefficient * weight)
    }

    /// Mean over all directions.
    pub fn mean(&self) -> Vec3 {
        self.coefficients[0] * (basis(Vec3::ZERO)[0] * std::f32::consts::PI)
    }
}

/// What each coefficient counts at one direction.
#[derive(Clone, Copy, Debug)]
pub struct LobeWeights([f32; 9]);

impl LobeWeights {
    /// At unit direction `x`.
    pub fn toward(x: Vec3) -> LobeWeights {
        let y = basis(x);
        LobeWeights(std::array::from_fn(|i| match i {
            0 => y[0] * std::f32::consts::PI,
            1..=3 => y[i] * (std::f32::consts::PI * 2.0 / 3.0),
            _ => y[i] * (std::f32::consts::PI / 4.0),
        }))
    }
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
    fn mean_of_a_lobe_is_a_quarter() {
        let mut lobes = CosineLobes::default();
        lobes.add(Vec3::X, Vec3::splat(2.0));
        assert!((lobes.mean().y - 0.5).abs() < 1e-5);
        let mut even = CosineLobes::default();
        even.add(Vec3::ZERO, Vec3::splat(2.0));
        assert!((even.evaluate(Vec3::Y).x - 0.5).abs() < 1e-5);
    }
}
