//! What part of the light on elements comes from some of the sides, and how much depends on each side: for a closer
//! look at those that matter most.

use super::flight::rooms;
use super::gains::Gains;
use super::solve::Solution;
use super::transport::{Damping, Light, Materials, Receiving};
use crate::hierarchy::Hierarchy;
use crate::tracer::Tracer;
use glam::Vec3;
use rayon::prelude::*;

/// Share of what elements receive over what links bring that is light of the sides that are left out. Rays find that it
/// arrives, not where it comes from.
const THEIRS: f32 = 0.5;

impl Solution {
    /// Irradiance of each leaf element without what it receives over links from the sides that `is_left_out` says,
    /// W/m²; in inner elements there is nothing.
    ///
    /// What the solution corrects without knowing which links are wrong is a factor on all of it; of what elements receive
    /// over what links bring half counts as theirs, and half as light that comes otherwise.
    pub fn irradiance_without(&self, hierarchy: &Hierarchy, is_left_out: &[bool]) -> Vec<Vec3> {
        let forest = &self.forest;
        let (damping, gains) = (Damping::none(forest.len()), Gains::none(forest.len()));
        let receiving = Receiving::of_links(&damping, &self.openness, &gains);
        let materials = Materials { hierarchy, forest };
        let received = |light: &Light| {
            let dark = Light::dark(forest.len());
            light.iterate(hierarchy, forest, &self.links, &materials, receiving, dark).irradiance
        };
        let (part, all) =
            (received(&self.light.only_of(hierarchy, forest, is_left_out)), received(&self.light));
        let rest = |element: usize| {
            let over = (self.gains.of(element as u32) - 1.0).max(0.0);
            let linked = all[element] * (1.0 + (1.0 - THEIRS) * over);
            let share = part[element] / linked.max(Vec3::splat(f32::MIN_POSITIVE));
            self.light.irradiance[element] * (Vec3::ONE - share).clamp(Vec3::ZERO, Vec3::ONE)
        };
        (0..forest.len())
            .into_par_iter()
            .with_min_len(4096)
            .map(|element| if forest.second[element] == 0 { rest(element) } else { Vec3::ZERO })
            .collect()
    }

    /// How much surface each side lights: area times the share it has in the light there, summed over all that it lights
    /// by itself, not as a part of a cluster. In walls: 1 is as much surface as a wall of the rooms has.
    pub fn walls_lit(&self, hierarchy: &Hierarchy, tracer: &dyn Tracer) -> Vec<f64> {
        let forest = &self.forest;
        let clusters = hierarchy.nodes.len() as u32;
        let wall_area = rooms(hierarchy, forest, &self.light, tracer).wall_area;
        let lit: Vec<f32> = self
            .links
            .links
            .par_iter()
            .with_min_len(4096)
            .map(|link| {
                let (irradiance, area) = match link.receiver.checked_sub(clusters) {
                    Some(element) => {
                        let element = element as usize;
                        (self.light.irradiance[element].max_element(), forest.area[element])
                    }
                    None => {
                        let node = link.receiver as usize;
                        (self.light.lit[node], hierarchy.nodes[node].area * hierarchy.sides() as f32)
                    }
                };
                if link.source < clusters || irradiance <= 0.0 {
                    return 0.0;
                }
                let carried = self.light.carried(hierarchy, forest, link).max_element();
                (carried / irradiance).min(1.0) * area
            })
            .collect();
        let mut walls = vec![0.0; forest.side_count()];
        for (link, lit) in self.links.links.iter().zip(lit).filter(|(_, lit)| *lit > 0.0) {
            walls[forest.side_of(link.source - clusters)] += f64::from(lit) / wall_area;
        }
        walls
    }
}
