//! How bright a source is point by point, from the light of the last iteration.
//!
//! What is lit is often what is seen, since lamps hang where viewers look from: a shaded part of a source
//! is hidden more often than a bright one, and a share of clear rays that does not know of it loses
//! light.

use super::estimate::Party;
use super::forest::Forest;
use super::transport::Light;
use crate::hierarchy::Side;
use crate::visibility::Brightness;
use glam::DVec3;

/// A source whose exitance differs by less than this share counts as uniform: rays differ by far more.
const EVEN: f32 = 0.05;

/// The exitance of one source.
pub(super) struct Shading<'a> {
    pub(super) source: &'a Party<'a>,
    pub(super) forest: &'a Forest,
    pub(super) light: &'a Light,
}

impl Shading<'_> {
    /// Sum over the channels, so that the mean of a source is the mean of its parts.
    fn of(&self, element: u32) -> f64 {
        self.light.exitance[element as usize].element_sum() as f64
    }

    /// Whether the exitance differs so little below an element that no ray's weight does.
    fn is_even(&self, element: u32) -> bool {
        let element = element as usize;
        self.light.variation[element] <= EVEN * self.light.exitance[element].max_element()
    }
}

impl Brightness for Shading<'_> {
    fn at(&self, facet: u32, front: bool, point: DVec3) -> f64 {
        let forest = self.forest;
        match self.source {
            Party::Element { piece, .. } => self.of(forest.element_in(piece, point, |id| self.is_even(id))),
            Party::Cluster(_) => {
                let Some(side) = forest.side_index(Side { facet, back: !front }) else { return 0.0 };
                self.of(forest.first_element[side])
            }
        }
    }

    fn mean(&self) -> Option<f64> {
        match self.source {
            Party::Element { piece, .. } => Some(self.of(piece.id())),
            Party::Cluster(_) => None,
        }
    }
}
