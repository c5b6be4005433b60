//! What the facets in a plane leave open.

use super::{Hierarchy, NodeKind, TOLERANCE};
use crate::math::{Aabb, Axes, FlatPolygon, FlatRegion, Plane};

/// Facets narrower than this do not help: something is forgotten at each of their edges.
const LEAST_WIDTH: f64 = 16.0 * TOLERANCE;

/// How closely is looked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Most nodes of the hierarchy looked at.
    pub(crate) nodes: u32,
    /// Most pieces that are left uncovered at a time.
    pub(crate) pieces: usize,
    /// Facets smaller than this do not help, by their radius and that of what has to be covered, or of the scene.
    pub(crate) least_radius: f64,
}

impl Hierarchy {
    /// What no facet in a plane covers of a polygon in it, or more where that takes too long to tell. `first` is a
    /// facet to begin with.
    pub(crate) fn gaps_in(
        &self,
        plane: &Plane,
        axes: &Axes,
        polygon: FlatPolygon,
        first: Option<u32>,
        effort: Effort,
    ) -> Vec<FlatPolygon> {
        let bounds = Aabb::around(polygon.corners().iter().map(|&corner| axes.point(corner).as_vec3()));
        let least_radius = effort.least_radius * bounds.radius().min(self.nodes[0].bounds.radius());
        let mut gaps = FlatRegion::new(polygon, TOLERANCE);
        if let Some(outline) = first.map(|facet| self.polygon(facet))
            && outline.bounds().radius() >= least_radius
            && !gaps.remove(&axes.outline(&outline))
        {
            return gaps.pieces;
        }
        let mut stack = vec![0u32];
        let mut looked_at = 0;
        while let Some(index) = stack.pop() {
            looked_at += 1;
            if looked_at > effort.nodes || gaps.pieces.len() > effort.pieces {
                break;
            }
            let node = &self.nodes[index as usize];
            if node.bounds.radius() < least_radius || !node.is_near(bounds, plane, TOLERANCE) {
                continue;
            }
            match node.kind(index) {
                NodeKind::Cluster(children) => stack.extend(children),
                NodeKind::Leaf(other) if Some(other) != first => {
                    let polygon = self.polygon(other);
                    let is_wide = polygon.area() >= LEAST_WIDTH * polygon.extent();
                    let is_flat = is_wide
                        && polygon.vertices().iter().all(|&v| plane.distance(v).abs() <= 0.5 * TOLERANCE);
                    if is_flat && !gaps.remove(&axes.outline(&polygon)) {
                        break;
                    }
                }
                NodeKind::Leaf(_) => {}
            }
        }
        gaps.pieces
    }
}
