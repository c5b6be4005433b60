//! Deterministic low-discrepancy points for a pair of nodes.
//!
//! The four-dimensional sequence of Sobol', with the direction numbers of Joe & Kuo (2008): any power of two of its
//! points, and any number from the first on, fill both nodes evenly. A hash of the pair scrambles it as Owen (1995)
//! does, by the method of Burley (Practical Hash-based Owen Scrambling, JCGT 9(4), 2020), in one of [`SCRAMBLINGS`]
//! ways, and shifts the digits, so that neighbouring pairs do not share their error, and a mean of n points of a smooth
//! function errs less than with shifts alone. Nothing depends on time, threads or the tracer.

use glam::{DVec3, Vec3};
use std::f64::consts::TAU;
use std::sync::LazyLock;

/// Of each dimension but the first the degree of its primitive polynomial, its inner coefficients, and the first
/// numbers.
const POLYNOMIALS: [(usize, u32, [u32; 3]); 3] = [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

/// The points for the values of each byte of an index, bits in reverse order.
static POINTS: [[[u32; 4]; 256]; 4] = points();

/// Direction numbers of one dimension, first bit highest.
const fn directions(dimension: usize) -> [u32; 32] {
    let mut v = [0; 32];
    let mut i = 0;
    while i < 32 {
        v[i] = if dimension == 0 {
            1 << (31 - i)
        } else {
            let (degree, inner, first) = POLYNOMIALS[dimension - 1];
            if i < degree {
                first[i] << (31 - i)
            } else {
                let mut value = v[i - degree] ^ (v[i - degree] >> degree);
                let mut k = 1;
                while k < degree {
                    value ^= ((inner >> (degree - 1 - k)) & 1) * v[i - k];
                    k += 1;
                }
                value
            }
        };
        i += 1;
    }
    v
}

const fn points() -> [[[u32; 4]; 256]; 4] {
    let mut points = [[[0; 4]; 256]; 4];
    let mut dimension = 0;
    while dimension < 4 {
        let directions = directions(dimension);
        let mut bit = 0;
        while bit < 32 {
            let reversed = directions[bit].reverse_bits();
            let mut value = 0;
            while value < 256 {
                if value >> (bit % 8) & 1 == 1 {
                    points[bit / 8][value][dimension] ^= reversed;
                }
                value += 1;
            }
            bit += 1;
        }
        dimension += 1;
    }
    points
}

/// A number that looks random and depends on both ids and their order (SplitMix64 finaliser).
#[inline]
pub fn hash_pair(receiver: u64, source: u64) -> u64 {
    let mut z = receiver.wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ source.wrapping_mul(0xC2B2_AE3D_27D4_EB4F).rotate_left(31);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Scramblings that pairs share; what tells them apart further is a shift.
const SCRAMBLINGS: usize = 32;

/// Points of each scrambling that are kept.
const KEPT: usize = 256;

/// The first points of all scramblings, as fractions of 2³².
static SCRAMBLED: LazyLock<Vec<[[u32; 4]; KEPT]>> = LazyLock::new(|| {
    let scrambling = |index: usize| {
        let numbers = scrambling_of(index);
        std::array::from_fn(|point| scrambled(point as u32, numbers))
    };
    (0..SCRAMBLINGS).map(scrambling).collect()
});

/// The numbers that one of the scramblings follows from.
fn scrambling_of(index: usize) -> [u32; 4] {
    halves([1, 2].map(|half| hash_pair(index as u64, half)))
}

fn halves([a, b]: [u64; 2]) -> [u32; 4] {
    [a as u32, (a >> 32) as u32, b as u32, (b >> 32) as u32]
}

fn scrambled(index: u32, numbers: [u32; 4]) -> [u32; 4] {
    let bytes = index.to_le_bytes();
    std::array::from_fn(|k| {
        // Bits in reverse order, so that products carry from the high bits of the coordinate to the low ones.
        let mut x = (0..4).fold(0, |x, byte| x ^ POINTS[byte][bytes[byte] as usize][k]);
        x = x.wrapping_add(numbers[k]);
        for factor in [0x6C50_B47C, 0xB82F_1E52, 0xC7AF_E638, 0x8D22_F6E6u32] {
            x ^= x.wrapping_mul(factor);
        }
        x.reverse_bits()
    })
}

/// The sample points of one pair: each is two coordinates on the receiver and two on the source.
#[derive(Clone, Copy, Debug)]
pub struct PairSequence {
    first: &'static [[u32; 4]; KEPT],
    scrambling: usize,
    shift: [u32; 4],
}

impl PairSequence {
    /// The sequence belonging to `seed`, such as [`hash_pair`].
    pub fn new(seed: u64) -> PairSequence {
        let scrambling = (hash_pair(seed, 3) % SCRAMBLINGS as u64) as usize;
        let shift = halves([1, 2].map(|half| hash_pair(seed, half)));
        PairSequence { first: &SCRAMBLED[scrambling], scrambling, shift }
    }

    /// Point `index`: `[receiver u, receiver v, source u, source v]`, each in `[0, 1)`.
    #[inline]
    pub fn point(&self, index: u32) -> [f64; 4] {
        let point = match self.first.get(index as usize) {
            Some(point) => *point,
            None => scrambled(index, scrambling_of(self.scrambling)),
        };
        std::array::from_fn(|k| f64::from(point[k] ^ self.shift[k]) / (1u64 << 32) as f64)
    }
}

/// A direction about `normal` with probability proportional to its cosine, for a point of the unit square.
pub fn cosine_direction(normal: DVec3, s: f64, t: f64) -> Vec3 {
    let (x, y) = normal.any_orthonormal_pair();
    let (sin, cos) = (s * TAU).sin_cos();
    let radius = t.sqrt();
    (x * (radius * cos) + y * (radius * sin) + normal * (1.0 - t).sqrt()).as_vec3()
}

/// The fraction of a multiple of the golden ratio: those of successive multiples are spread evenly over [0, 1), whatever
/// their number.
pub fn golden_fraction(multiple: usize) -> f64 {
    (multiple as f64 * 0.618_033_988_749_895).fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of sixteen points each coordinate has one in each sixteenth, and the first two have one in each of sixteen squares.
    #[test]
    fn every_coordinate_of_a_block_is_stratified() {
        for seed in 0..50 {
            let sequence = PairSequence::new(hash_pair(seed, 3));
            for first in [0, 16, 48, 256, 65_536] {
                let points: Vec<[f64; 4]> = (first..first + 16).map(|i| sequence.point(i)).collect();
                for k in 0..4 {
                    let mut cells: Vec<usize> = points.iter().map(|p| (p[k] * 16.0) as usize).collect();
                    cells.sort_unstable();
                    assert!(cells.iter().enumerate().all(|(i, &cell)| i == cell), "{seed} {k}: {cells:?}");
                }
            }
            // The first two coordinates are a net in base 2: one point in each of 4 x 4 squares.
            let mut squares: Vec<usize> = (0..16)
                .map(|i| sequence.point(i))
                .map(|p| (p[0] * 4.0) as usize * 4 + (p[1] * 4.0) as usize)
                .collect();
            squares.sort_unstable();
            assert!(squares.iter().enumerate().all(|(i, &square)| i == square), "{seed}: {squares:?}");
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
