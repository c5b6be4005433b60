//! Deterministic low-discrepancy points for a pair of nodes.
//!
//! The four-dimensional additive recurrence with the generalised golden ratio (Roberts, 2018) fills
//! both nodes evenly for any number of points; a hash of the pair shifts it, so that neighbouring
//! pairs do not share their error. Nothing depends on time, threads or the tracer.

use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

/// 1/g, 1/g², … for the root g of x⁵ = x + 1.
const ALPHA: [f64; 4] = [0.8566748838545029, 0.733891856627126, 0.6287067210378086, 0.53859725722361];

/// A number that looks random and depends on both ids and their order (SplitMix64 finaliser).
#[inline]
pub fn hash_pair(receiver: u64, source: u64) -> u64 {
    let mut z = receiver.wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ source.wrapping_mul(0xC2B2_AE3D_27D4_EB4F).rotate_left(31);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The sample points of one pair: each is two coordinates on the receiver and two on the source.
#[derive(Clone, Copy, Debug)]
pub struct PairSequence {
    shift: [f64; 4],
}

impl PairSequence {
    /// The sequence belonging to `seed`, such as [`hash_pair`].
    pub fn new(seed: u64) -> PairSequence {
        let mut state = seed;
        let shift = std::array::from_fn(|_| {
            state = hash_pair(state, 0x5851_F42D_4C95_7F2D);
            (state >> 11) as f64 / (1u64 << 53) as f64
        });
        PairSequence { shift }
    }

    /// Point `index`: `[receiver u, receiver v, source u, source v]`, each in `[0, 1)`.
    #[inline]
    pub fn point(&self, index: u32) -> [f64; 4] {
        std::array::from_fn(|k| {
            let x = self.shift[k] + ALPHA[k] * (index as f64 + 1.0);
            // Not below 0: truncation is the floor, and takes no call on processors of any age.
            x - (x as i64) as f64
        })
    }
}

/// A direction about `normal` with probability proportional to its cosine, for a point of the unit square.
pub fn cosine_direction(normal: DVec3, s: f64, t: f64) -> Vec3 {
    let (x, y) = normal.any_orthonormal_pair();
    let (sin, cos) = (s * TAU).sin_cos();
    let radius = t.sqrt();
    (x * (radius * cos) + y * (radius * sin) + normal * (1.0 - t).sqrt()).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_solve_the_equation() {
        let g = 1.0 / ALPHA[0];
        assert!((g.powi(5) - g - 1.0).abs() < 1e-12);
        for (k, a) in ALPHA.iter().enumerate() {
            assert!((a - g.powi(-(k as i32 + 1))).abs() < 1e-12);
        }
    }

    #[test]
    fn sixteen_points_are_more_even_than_chance() {
        // Variance of the mean of u over many pairs: random points would give 1/(12·16).
        let mut squares = 0.0;
        for seed in 0..2000 {
            let s = PairSequence::new(hash_pair(seed, 7));
            let mean = (0..16).map(|i| s.point(i)[2]).sum::<f64>() / 16.0;
            squares += (mean - 0.5f64).powi(2);
        }
        assert!(squares / 2000.0 < 0.2 / (12.0 * 16.0), "variance {}", squares / 2000.0);
    }

    #[test]
    fn order_of_the_pair_matters() {
        assert_ne!(hash_pair(1, 2), hash_pair(2, 1));
    }
}
