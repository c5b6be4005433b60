//! The picture of the mesh: element edges, and colours for the classes of links.

use super::descent::handed_down;
use crate::gather::Spot;
use crate::hierarchy::Hierarchy;
use crate::radiosity::Solution;
use glam::{DVec3, Vec3};

/// Linear colours by link class: untested (grey), visible (blue), certified visible (green), partial
/// (orange).
const CLASS_COLORS: [Vec3; 4] = [
    Vec3::new(0.3, 0.3, 0.3),
    Vec3::new(0.10, 0.25, 0.80),
    Vec3::new(0.10, 0.55, 0.15),
    Vec3::new(0.90, 0.35, 0.05),
];

/// Colours leaf elements by the links that light them.
pub(super) struct MeshView<'a> {
    hierarchy: &'a Hierarchy,
    /// For each node, what it and the nodes above it receive by class.
    classes: Vec<[f32; 4]>,
    /// Radiance that is shown at full brightness.
    white: f32,
}

impl<'a> MeshView<'a> {
    pub(super) fn new(hierarchy: &'a Hierarchy, solution: &Solution) -> MeshView<'a> {
        let (forest, classes) = (&solution.forest, light_by_class(hierarchy, solution));
        let mean =
            solution.light.irradiance.iter().map(|e| e.max_element()).sum::<f32>() / forest.len() as f32;
        MeshView { hierarchy, classes, white: mean.max(f32::MIN_POSITIVE) }
    }

    /// Colour at a point; `pixel` is the width of a pixel there.
    pub(super) fn color(&self, solution: &Solution, spot: &Spot, point: DVec3, pixel: f32) -> Vec3 {
        let classes = &self.classes[self.hierarchy.nodes.len() + spot.element as usize];
        let total: f32 = classes.iter().sum();
        let color = if total > 0.0 {
            classes.iter().zip(CLASS_COLORS).map(|(&share, color)| color * (share / total)).sum()
        } else {
            CLASS_COLORS[0] * 0.3
        };
        let ink = 0.8 * edge(spot, point, pixel);
        let brightness = 0.35
            + 0.65 * (solution.light.irradiance[spot.element as usize].max_element() / self.white).min(1.0);
        color * brightness * (1.0 - ink)
    }
}

/// For each node, by its id as links have it, the irradiance that it and the nodes above it receive over links of each
/// class.
pub(super) fn light_by_class(hierarchy: &Hierarchy, solution: &Solution) -> Vec<[f32; 4]> {
    let nodes = hierarchy.nodes.len() + solution.forest.len();
    let own = (0..nodes).map(|node| solution.irradiance_by_class(hierarchy, node as u32)).collect();
    handed_down(hierarchy, &solution.forest, own, |sum: &mut [f32; 4], above| {
        sum.iter_mut().zip(above).for_each(|(sum, above)| *sum += above);
    })
}

/// 1 on an edge of an element, 0 a pixel away from it.
pub(super) fn edge(spot: &Spot, point: DVec3, pixel: f32) -> f32 {
    let normal = spot.polygon.area_vector().normalize_or_zero();
    let to_edge = -spot.polygon.outside_distance(point, normal);
    (1.0 - to_edge.abs() as f32 / (0.7 * pixel)).clamp(0.0, 1.0)
}
