//! How the parts of a source share in its form factor: near parts count for more, and it is them that
//! the receiver lights back, so a source taken as uniform loses light.

use super::forest::{Forest, Piece};
use super::form_factor::PolygonSource;
use glam::Vec3;

/// A source that looks smaller than this (extent over distance) has no near and far parts.
const SMALL: f64 = 0.2;

/// Weights of the four quarters of a source (the halves of its halves, depth-first), in 255ths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quarters([u8; 4]);

impl Quarters {
    /// The source counts as uniform.
    pub const UNIFORM: Quarters = Quarters([0; 4]);

    /// The weights as they are stored.
    pub fn to_bytes(self) -> [u8; 4] {
        self.0
    }

    /// The weights that were stored.
    pub fn from_bytes(bytes: [u8; 4]) -> Quarters {
        Quarters(bytes)
    }

    /// The weights; they add up to 1, or are all 0 for a source that counts as uniform.
    pub fn weights(&self) -> [f64; 4] {
        self.0.map(|weight| weight as f64 / 255.0)
    }

    /// The weights for light from `source` to `receiver`. The larger of the two counts in full, the
    /// smaller by its middle, or that of each quarter.
    pub(super) fn of(receiver: &Piece, source: &Piece, forest: &Forest) -> Quarters {
        let (center, extent) = (receiver.polygon.center(), source.polygon.extent());
        if extent < SMALL * center.distance(source.polygon.center()) {
            return Quarters::UNIFORM;
        }
        let quarters = source.quarters(forest);
        let sent = if extent > receiver.polygon.extent() {
            quarters.map(|quarter| {
                PolygonSource::new(&quarter, source.plane).form_factor(center, receiver.plane.normal)
            })
        } else {
            let back = PolygonSource::new(&receiver.polygon, receiver.plane);
            quarters.map(|quarter| quarter.area() * back.form_factor(quarter.center(), source.plane.normal))
        };
        let total: f64 = sent.iter().sum();
        if total <= 0.0 {
            return Quarters::UNIFORM;
        }
        // Rounding the running sum keeps the total at 255.
        let (mut sum, mut before) = (0.0, 0);
        Quarters(sent.map(|part| {
            sum += part;
            let upto = (255.0 * sum / total).round() as u8;
            let weight = upto - before;
            before = upto;
            weight
        }))
    }

    /// Exitance of an element as the receiver sees it, from the exitances of all elements.
    #[inline]
    pub fn weigh(&self, forest: &Forest, exitance: &[Vec3], element: u32) -> Vec3 {
        let halves = |element: u32| match forest.second[element as usize] {
            0 => [element; 2],
            second => [element + 1, second],
        };
        let mean = exitance[element as usize];
        if *self == Quarters::UNIFORM || forest.second[element as usize] == 0 {
            return mean;
        }
        let [first, second] = halves(element).map(halves);
        let quarters = [first[0], first[1], second[0], second[1]];
        // Quarters that are alike give exactly the mean.
        let above =
            quarters.iter().zip(self.0).map(|(&q, weight)| (exitance[q as usize] - mean) * weight as f32);
        mean + above.sum::<Vec3>() / 255.0
    }
}
