//! How bright a source is point by point, from the light of the last iteration.
//!
//! What is lit is often what is seen, since lamps hang where viewers look from: a shaded part of a source
//! is hidden more often than a bright one, and a share of clear rays that does not know of it loses
//! light.

use super::estimate::Party;
use super::forest::Forest;
use super::transport::Light;
use crate::hierarchy::Side;
use crate::visibility::{Brightness, Sighting};

/// The exitance of one source.
pub(super) struct Shading<'a> {
    pub(super) source: &'a Party,
    pub(super) forest: &'a Forest,
    pub(super) light: &'a Light,
}

impl Shading<'_> {
    /// Sum over the channels, so that the mean of a source is the mean of its parts.
    fn of(&self, element: u32) -> f64 {
        self.light.exitance[element as usize].element_sum() as f64
    }
}

impl Brightness for Shading<'_> {
    fn sum(&self, sightings: &mut [Sighting]) -> f64 {
        let forest = self.forest;
        match self.source {
            Party::Element { piece, .. } => {
                let mut sum = 0.0;
                let mut add = |element: u32, seen: &[Sighting]| {
                    sum += self.of(element) * seen.iter().map(|sighting| sighting.kernel).sum::<f64>();
                };
                let is_even = |element| self.light.is_even(element);
                forest.visit_elements_in(piece, sightings, &|s: &Sighting| s.point, &is_even, &mut add);
                sum
            }
            Party::Cluster(_) => sightings
                .iter()
                .filter_map(|s| Some((s, forest.side_index(Side { facet: s.facet, back: !s.front })?)))
                .map(|(s, side)| s.kernel * self.of(forest.first_element[side]))
                .sum(),
        }
    }

    fn mean(&self) -> Option<f64> {
        match self.source {
            Party::Element { piece, .. } => Some(self.of(piece.id)),
            Party::Cluster(_) => None,
        }
    }
}
