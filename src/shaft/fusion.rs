//! Several occluders that hide two nodes from each other together: facets in one plane, such as the parts of a
//! wall around a door.
//!
//! If a plane has one node on one side and the other on the other, every segment between them crosses it
//! inside the convex hull of where the segments between their corners do: seen from a point, the image of a
//! convex set on a plane is convex. Where facets in the plane cover that hull without a gap, nothing gets through.

use super::blocker::all_crossings;
use crate::hierarchy::{Hierarchy, NodeKind, TOLERANCE};
use crate::math::{Aabb, Axes, FlatPolygon, FlatRegion, Plane};
use glam::{DVec2, DVec3};

/// Most nodes of the hierarchy looked at for one pair.
const MOST_NODES: u32 = 512;

/// Facets smaller than this do not help, by their radius and that of what has to be covered.
const LEAST_RADIUS: f64 = 0.1;

/// Most pieces that are left uncovered at a time.
const MOST_PIECES: usize = 32;

/// Whether the facets in the plane of `facet` together block every segment from a corner of the receiver to a
/// corner of the source.
pub fn blocks_together(hierarchy: &Hierarchy, facet: u32, receiver: &[DVec3], source: &[DVec3]) -> bool {
    let plane = &hierarchy.facets[facet as usize].plane;
    let outline = hierarchy.polygon(facet);
    let axes = Axes::along(&outline, plane);
    let Some(hull) = hull_of_crossings(plane, &axes, receiver, source) else { return false };
    let bounds = Aabb::around(hull.corners().iter().map(|&corner| axes.point(corner).as_vec3()));
    let least_radius = LEAST_RADIUS * bounds.radius();
    let mut gaps = FlatRegion::new(hull, TOLERANCE);
    if outline.bounds().radius() >= least_radius && !gaps.remove(&axes.outline(&outline)) {
        return true;
    }
    let mut stack = vec![0u32];
    let mut looked_at = 0;
    while let Some(index) = stack.pop() {
        looked_at += 1;
        if looked_at > MOST_NODES || gaps.pieces.len() > MOST_PIECES {
            return false;
        }
        let node = &hierarchy.nodes[index as usize];
        if node.bounds.radius() < least_radius || !node.touches(bounds, plane) {
            continue;
        }
        match node.kind(index) {
            NodeKind::Cluster(children) => stack.extend(children),
            NodeKind::Leaf(other) if other != facet => {
                let polygon = hierarchy.polygon(other);
                let is_flat = polygon.vertices().iter().all(|&v| plane.distance(v).abs() <= 0.5 * TOLERANCE);
                if is_flat && !gaps.remove(&axes.outline(&polygon)) {
                    return true;
                }
            }
            NodeKind::Leaf(_) => {}
        }
    }
    false
}

/// Where segments cross the plane between two nodes: a piece around all of it, or `None` when some segment does
/// not.
fn hull_of_crossings(
    plane: &Plane,
    axes: &Axes,
    receiver: &[DVec3],
    source: &[DVec3],
) -> Option<FlatPolygon> {
    // The octagon around all crossings, along the axes and between them: no smaller than their hull.
    let directions = [DVec2::X, DVec2::Y, DVec2::new(1.0, 1.0), DVec2::new(1.0, -1.0)];
    let mut ranges = [[f64::MAX, f64::MIN]; 4];
    let is_crossed = all_crossings(plane, receiver, source, |crossing| {
        let crossing = axes.flat(crossing);
        for ([low, high], direction) in ranges.iter_mut().zip(directions) {
            let at = direction.dot(crossing);
            (*low, *high) = (low.min(at), high.max(at));
        }
        true
    });
    if !is_crossed {
        return None;
    }
    // What is as narrow as rounding would pass for covered.
    if ranges.iter().any(|[low, high]| high - low < 4.0 * TOLERANCE) {
        return None;
    }
    let [[left, right], [bottom, top], ..] = ranges;
    let corners = [(left, bottom), (right, bottom), (right, top), (left, top)].map(DVec2::from);
    let mut hull = FlatPolygon::new(&corners);
    for ([low, high], direction) in ranges.into_iter().zip(directions).skip(2) {
        hull = hull.beyond(direction, low, TOLERANCE).unwrap_or(hull);
        hull = hull.beyond(-direction, -high, TOLERANCE).unwrap_or(hull);
    }
    Some(hull)
}
