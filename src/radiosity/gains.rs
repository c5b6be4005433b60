//! What elements receive over what links bring them.

use super::forest::Forest;
use super::transport::Light;
use glam::Vec3;

/// A factor for each element; those of inner elements mean nothing.
#[derive(Clone, Debug)]
pub struct Gains(Vec<f32>);

impl Gains {
    /// All elements receive what links bring.
    pub(super) fn none(elements: usize) -> Gains {
        Gains(vec![1.0; elements])
    }

    /// The factors of all elements, in order.
    pub fn from_factors(factors: Vec<f32>) -> Gains {
        Gains(factors)
    }

    /// The factors of all elements.
    pub fn factors(&self) -> &[f32] {
        &self.0
    }

    /// The factor of one element.
    #[inline]
    pub fn of(&self, element: u32) -> f32 {
        self.0[element as usize]
    }
}

/// What elements receive more than links bring, while light flows. It is an amount, not a factor: light that goes to and
/// fro between two surfaces would otherwise grow from bounce to bounce.
#[derive(Clone, Debug, Default)]
pub(super) struct Surplus(Vec<f32>);

impl Surplus {
    /// No element receives more.
    pub(super) fn none() -> &'static Surplus {
        static NONE: Surplus = Surplus(Vec::new());
        &NONE
    }

    /// Irradiance of each element, summed over channels.
    pub(super) fn of_elements(amounts: Vec<f32>) -> Surplus {
        Surplus(amounts)
    }

    fn of(&self, element: u32) -> f32 {
        self.0.get(element as usize).copied().unwrap_or(0.0)
    }

    /// Irradiance of an element with its surplus, which has the colour of the rest.
    #[inline]
    pub(super) fn added(&self, element: u32, irradiance: Vec3) -> Vec3 {
        let (surplus, sum) = (self.of(element), irradiance.element_sum());
        if surplus > 0.0 && sum > 0.0 { irradiance * (1.0 + surplus / sum) } else { irradiance }
    }

    /// The factor that an element has in `gains`, and with its surplus, if it receives so much with both.
    pub(super) fn gain(&self, element: u32, gains: &Gains, irradiance: Vec3) -> f32 {
        let (surplus, sum) = (self.of(element), irradiance.element_sum());
        let gain = gains.of(element);
        if surplus > 0.0 && surplus < sum { gain * (sum / (sum - surplus)) } else { gain }
    }

    /// All of it as factors of leaf elements, for this light and no other, over what links bring before each takes the
    /// `share` of it that is damped: what makes up for that is no gain.
    pub(super) fn as_gains(
        &self,
        gains: &Gains,
        forest: &Forest,
        light: &Light,
        share: impl Fn(usize) -> f32,
    ) -> Gains {
        let mut factors = vec![1.0; forest.len()];
        for leaf in forest.leaves() {
            let factor = gains.of(leaf as u32);
            factors[leaf] = (self.gain(leaf as u32, gains, light.irradiance[leaf]) * share(leaf)).max(factor);
        }
        Gains(factors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surplus_is_an_amount_and_reads_as_a_factor() {
        let gains = Gains::from_factors(vec![1.0, 0.5]);
        let surplus = Surplus::of_elements(vec![3.0, 0.0]);
        let brought = Vec3::new(1.0, 2.0, 3.0);
        let all = surplus.added(0, brought);
        assert!((all - brought * 1.5).length() < 1e-6);
        assert!((surplus.gain(0, &gains, all) - 1.5).abs() < 1e-6);
        // Twice the light has the same surplus.
        assert!((surplus.added(0, brought * 2.0).element_sum() - 15.0).abs() < 1e-5);
        assert_eq!((surplus.added(1, brought), surplus.gain(1, &gains, brought)), (brought, 0.5));
        assert_eq!(surplus.added(0, Vec3::ZERO), Vec3::ZERO);
        assert_eq!(Surplus::default().added(7, brought), brought);
    }
}
