//! The picture of the mesh: element edges, and colours for the classes of links.

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
        let clusters = hierarchy.nodes.len();
        let forest = &solution.forest;
        let mut classes: Vec<[f32; 4]> =
            (0..clusters + forest.len()).map(|n| solution.irradiance_by_class(hierarchy, n as u32)).collect();
        let pass_down = |classes: &mut Vec<[f32; 4]>, from: usize, to: usize| {
            let above = classes[from];
            classes[to].iter_mut().zip(above).for_each(|(c, a)| *c += a);
        };
        for (index, node) in hierarchy.nodes.iter().enumerate() {
            if node.is_leaf() {
                for side in forest.sides_of(node.first) {
                    pass_down(&mut classes, index, clusters + forest.first_element[side] as usize);
                }
            } else {
                for child in node.children(index as u32) {
                    pass_down(&mut classes, index, child as usize);
                }
            }
        }
        for element in 0..forest.len() {
            let second = forest.second[element] as usize;
            if second != 0 {
                pass_down(&mut classes, clusters + element, clusters + element + 1);
                pass_down(&mut classes, clusters + element, clusters + second);
            }
        }
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
        let normal = spot.polygon.area_vector().normalize_or_zero();
        let to_edge = -spot.polygon.outside_distance(point, normal);
        let ink = (1.0 - to_edge.abs() as f32 / (0.7 * pixel)).clamp(0.0, 1.0) * 0.8;
        let brightness = 0.35
            + 0.65 * (solution.light.irradiance[spot.element as usize].max_element() / self.white).min(1.0);
        color * brightness * (1.0 - ink)
    }
}
