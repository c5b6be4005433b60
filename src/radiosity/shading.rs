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

/// The exitance of one source.
pub(super) struct Shading<'a> {
    pub(super) source: &'a Party<'a>,
    pub(super) forest: &'a Forest,
    pub(super) light: &'a Light,
}

impl Shading<'_> {
    /// Sum over the channels, so that the mean of a source is the mean of its parts.
    fn of(&self, element: usize) -> f64 {
        self.light.exitance[element].element_sum() as f64
    }
}

impl Brightness for Shading<'_> {
    fn at(&self, facet: u32, front: bool, point: DVec3) -> f64 {
        let forest = self.forest;
        let (mut id, mut polygon, mut cut) = match self.source {
            Party::Element { piece, .. } => (piece.id() as usize, piece.polygon, piece.cut),
            Party::Cluster(_) => {
                let Some(side) = forest.side_index(Side { facet, back: !front }) else { return 0.0 };
                return self.of(forest.first_element[side] as usize);
            }
        };
        let normal = polygon.area_vector();
        while let Some(&second) = forest.second.get(id).filter(|&&second| second != 0) {
            let division = forest.divide(&polygon, cut);
            let half = usize::from(!division.is_in_first(point, normal));
            id = [id + 1, second as usize][half];
            (polygon, cut) = (division.parts[half], division.cuts[half]);
        }
        self.of(id)
    }

    fn mean(&self) -> Option<f64> {
        match self.source {
            Party::Element { piece, .. } => Some(self.of(piece.id() as usize)),
            Party::Cluster(_) => None,
        }
    }
}
