//! Irradiance at a point: straight from the emitters, and by way of other surfaces.

use super::direct::{direct, emitters};
use super::hemisphere::reflected;
use super::parts::Spotlit;
use crate::hierarchy::{Hierarchy, NodeKind, Side};
use crate::math::{PairSequence, hash_pair};
use crate::radiosity::{Piece, Solution};
use crate::tracer::{NO_FACET, Tracer};
use glam::DVec3;

/// Rays for a point, when nothing else is asked for: the edges of a shadow are then right to 1 % of the light
/// that is there.
pub const SAMPLES: u32 = 4096;

/// A point this near to a facet lies on it, local length: the digits of a text file.
const NEAR: f64 = 2e-5;

/// Of several facets a point lies on, those whose normals are this near to its own come first, as a cosine.
const ALIGNED: f64 = 0.95;

/// A point whose normal lies as good as in the plane of a facet is on neither side of it, as a cosine.
const ACROSS: f64 = 0.1;

/// Irradiance at a point, W/m², linear RGB.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Irradiance {
    /// All light.
    pub total: DVec3,
    /// Straight from emitters.
    pub direct: DVec3,
}

/// Gathers light at points.
pub struct Gatherer<'a> {
    hierarchy: &'a Hierarchy,
    tracer: &'a dyn Tracer,
    solution: &'a Solution,
    emitters: Vec<Piece>,
    samples: u32,
}

impl<'a> Gatherer<'a> {
    /// Gathers with about `samples` rays for the light of the emitters and as many for what is reflected.
    pub fn new(
        hierarchy: &'a Hierarchy,
        tracer: &'a dyn Tracer,
        solution: &'a Solution,
        samples: u32,
    ) -> Gatherer<'a> {
        Gatherer { hierarchy, tracer, solution, emitters: emitters(hierarchy, &solution.forest), samples }
    }

    /// Irradiance at `point` on a surface with unit `normal`, in scene coordinates. The samples depend on nothing
    /// but the two.
    pub fn irradiance(&self, point: DVec3, normal: DVec3) -> Irradiance {
        let sequence = PairSequence::new(seed(point, normal));
        let point = self.hierarchy.frame.local_from_scene(point).as_dvec3();
        let at = self.placed(point, normal);
        let direct = direct(self.hierarchy, &self.emitters, self.tracer, at, self.samples, &sequence);
        let reflected = reflected(self.hierarchy, self.solution, self.tracer, at, self.samples, &sequence);
        Irradiance { total: direct + reflected, direct }
    }

    /// A point on a facet is put just above it.
    fn placed(&self, point: DVec3, normal: DVec3) -> Spotlit {
        match self.side_at(point, normal) {
            Some(side) => Spotlit { normal, ..Spotlit::on(self.hierarchy, side, point) },
            None => Spotlit { point, normal, surface: normal, facet: NO_FACET },
        }
    }

    /// The side that a point with this normal lies on.
    fn side_at(&self, point: DVec3, normal: DVec3) -> Option<Side> {
        // The nearest of those with its normal, otherwise the one whose normal comes nearest.
        let mut best: Option<((bool, f64), Side)> = None;
        let mut stack = vec![0u32];
        while let Some(index) = stack.pop() {
            let node = &self.hierarchy.nodes[index as usize];
            if !node.bounds.contains(point, NEAR) {
                continue;
            }
            match node.kind(index) {
                NodeKind::Cluster(children) => stack.extend(children),
                NodeKind::Leaf(facet) => {
                    let plane = self.hierarchy.facets[facet as usize].plane;
                    let polygon = self.hierarchy.polygon(facet);
                    let off = plane.distance(point).abs();
                    let out = polygon.outside_distance(point, plane.normal);
                    let cosine = plane.normal.dot(normal);
                    let distance = off.max(out);
                    let is_tilted = cosine.abs() <= ALIGNED;
                    let rank = (is_tilted, if is_tilted { -cosine.abs() } else { distance });
                    if distance <= NEAR && cosine.abs() > ACROSS && best.is_none_or(|(b, _)| rank < b) {
                        best = Some((rank, Side { facet, back: cosine < 0.0 }));
                    }
                }
            }
        }
        best.map(|(_, side)| side)
    }
}

/// A seed from what is asked. The normal counts in single precision: its last digits depend on the length that it
/// was given with.
fn seed(point: DVec3, normal: DVec3) -> u64 {
    let normal = normal.as_vec3().as_dvec3();
    // Adding 0 makes -0 the same place as 0.
    let numbers = point.to_array().into_iter().chain(normal.to_array()).map(|x| (x + 0.0).to_bits());
    numbers.fold(0x70_72_6f_62_65, hash_pair)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_differ_where_points_or_normals_do() {
        let point = DVec3::new(0.1, 0.0, 3.0);
        let all = [
            (point, DVec3::Y),
            (point, -DVec3::Y),
            (DVec3::new(point.z, point.x, point.y), DVec3::Y),
            (point + DVec3::X * 1e-9, DVec3::Y),
            (DVec3::ZERO, DVec3::Y),
        ];
        let seeds: std::collections::BTreeSet<u64> = all.iter().map(|&(p, n)| seed(p, n)).collect();
        assert_eq!(seeds.len(), all.len());
        assert_eq!(seed(DVec3::ZERO, DVec3::Y), seed(-DVec3::ZERO, DVec3::new(-0.0, 1.0, -0.0)));
        let (long, longer) = (DVec3::new(0.1, 0.7, 0.3), DVec3::new(0.3, 2.1, 0.9));
        assert_eq!(seed(point, long.normalize()), seed(point, longer.normalize()));
    }
}
