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

    /// Adds `weight` for light from each direction as it counts over part of a hemisphere.
    pub fn add_part(&mut self, part: &LobeWeights, weight: Vec3) {
        for ((c, part), band) in self.coefficients.iter_mut().zip(part.0).zip(BANDS) {
            *c += weight * (part / band);
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

/// What a band of coefficients counts when a cosine lobe is taken of it.
const BANDS: [f32; 9] = {
    use std::f32::consts::PI;
    let (first, second) = (PI * 2.0 / 3.0, PI / 4.0);
    [PI, first, first, first, second, second, second, second, second]
};

/// What each coefficient counts for the light over a hemisphere, weighted by the cosine.
#[derive(Clone, Copy, Debug)]
pub struct LobeWeights([f32; 9]);

impl LobeWeights {
    /// About unit direction `x`.
    pub fn toward(x: Vec3) -> LobeWeights {
        let y = basis(x);
        LobeWeights(std::array::from_fn(|i| y[i] * BANDS[i]))
    }
}

/// The part of a hemisphere in which some of its rays lie: up to the first order by where they go, beyond it by their
/// number.
#[derive(Clone, Copy, Debug)]
pub struct HemispherePart([f32; 4]);

impl HemispherePart {
    /// The part of `rays`, unit directions, out of `count` that are spread by the cosine.
    pub fn of(rays: impl Iterator<Item = Vec3>, count: usize) -> HemispherePart {
        let mut part = [0.0; 4];
        for ray in rays {
            let y = basis(ray);
            part.iter_mut().zip(y).for_each(|(sum, y)| *sum += y * BANDS[0] / count as f32);
        }
        HemispherePart(part)
    }

    /// What each coefficient counts in this part of the hemisphere that has `whole`.
    pub fn weights(&self, whole: &LobeWeights) -> LobeWeights {
        let share = self.0[0] / whole.0[0];
        LobeWeights(std::array::from_fn(|i| if i < 4 { self.0[i] } else { share * whole.0[i] }))
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

    /// All rays together are the hemisphere, and light from where rays go counts for more than from elsewhere.
    #[test]
    fn parts_of_a_hemisphere_add_up_to_it() {
        let x = Vec3::new(0.3, -0.5, 0.8).normalize();
        let (u, v) = x.any_orthonormal_pair();
        let rays: Vec<Vec3> = (0..64)
            .map(|i| ((i / 8) as f32 + 0.5, (i % 8) as f32 * std::f32::consts::TAU / 8.0))
            .map(|(ring, turn)| (ring / 8.0, turn.sin_cos()))
            .map(|(t, (sin, cos))| (u * cos + v * sin) * t.sqrt() + x * (1.0 - t).sqrt())
            .collect();
        let whole = LobeWeights::toward(x);
        let all = HemispherePart::of(rays.iter().copied(), rays.len()).weights(&whole);
        for (sum, whole) in all.0.iter().zip(whole.0) {
            assert!((sum - whole).abs() < 0.01, "{all:?} for {whole:?}");
        }
        let left = |ray: &&Vec3| ray.dot(u) > 0.0;
        let half = HemispherePart::of(rays.iter().filter(left).copied(), rays.len()).weights(&whole);
        let light = |from: Vec3| {
            let mut lobes = CosineLobes::default();
            lobes.add(from, Vec3::ONE);
            lobes.evaluate_with(&half).x
        };
        let lit = [x + u, x - u].map(|from| light(from.normalize()));
        assert!(lit[0] > 1.5 * lit[1], "{lit:?}");
        let mut areas = CosineLobes::default();
        areas.add_part(&half, Vec3::ONE);
        let from = Vec3::new(0.6, 0.0, 0.8);
        assert!((areas.evaluate_signed(from).x - light(from)).abs() < 1e-5);
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
