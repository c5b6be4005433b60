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
    let (plane, outline) = (&hierarchy.facets[facet as usize].plane, hierarchy.polygon(facet));
    // Without an area its plane is any.
    if outline.area() <= 0.0 {
        return false;
    }
    let axes = Axes::along(&outline, plane);
    let mut hull = Octagon::EMPTY;
    let is_crossed = all_crossings(plane, receiver, source, |crossing| {
        hull.add(axes.flat(crossing));
        true
    });
    let hull = if is_crossed { hull.polygon() } else { None };
    let gaps = hull.and_then(|hull| gaps_in(hierarchy, plane, &axes, hull, Some(facet)));
    gaps.is_some_and(|gaps| gaps.is_empty())
}

/// What no facet in a plane covers of a polygon in it; `None` where that takes too long to tell. `first` is a facet to
/// begin with.
pub(super) fn gaps_in(
    hierarchy: &Hierarchy,
    plane: &Plane,
    axes: &Axes,
    polygon: FlatPolygon,
    first: Option<u32>,
) -> Option<Vec<FlatPolygon>> {
    let bounds = Aabb::around(polygon.corners().iter().map(|&corner| axes.point(corner).as_vec3()));
    let least_radius = LEAST_RADIUS * bounds.radius();
    let mut gaps = FlatRegion::new(polygon, TOLERANCE);
    if let Some(outline) = first.map(|facet| hierarchy.polygon(facet))
        && outline.bounds().radius() >= least_radius
        && !gaps.remove(&axes.outline(&outline))
    {
        return Some(gaps.pieces);
    }
    let mut stack = vec![0u32];
    let mut looked_at = 0;
    while let Some(index) = stack.pop() {
        looked_at += 1;
        if looked_at > MOST_NODES || gaps.pieces.len() > MOST_PIECES {
            return None;
        }
        let node = &hierarchy.nodes[index as usize];
        if node.bounds.radius() < least_radius || !node.touches(bounds, plane) {
            continue;
        }
        match node.kind(index) {
            NodeKind::Cluster(children) => stack.extend(children),
            NodeKind::Leaf(other) if Some(other) != first => {
                let polygon = hierarchy.polygon(other);
                let is_flat = polygon.vertices().iter().all(|&v| plane.distance(v).abs() <= 0.5 * TOLERANCE);
                if is_flat && !gaps.remove(&axes.outline(&polygon)) {
                    break;
                }
            }
            NodeKind::Leaf(_) => {}
        }
    }
    Some(gaps.pieces)
}

/// The octagon around points in a plane, along the axes and between them: no smaller than their hull.
pub(super) struct Octagon {
    ranges: [[f64; 2]; 4],
}

impl Octagon {
    /// Around nothing.
    pub(super) const EMPTY: Octagon = Octagon { ranges: [[f64::MAX, f64::MIN]; 4] };

    const DIRECTIONS: [DVec2; 4] = [DVec2::X, DVec2::Y, DVec2::new(1.0, 1.0), DVec2::new(1.0, -1.0)];

    /// Takes in a point.
    pub(super) fn add(&mut self, point: DVec2) {
        for ([low, high], direction) in self.ranges.iter_mut().zip(Octagon::DIRECTIONS) {
            let at = direction.dot(point);
            (*low, *high) = (low.min(at), high.max(at));
        }
    }

    /// Its outline; `None` where it is as narrow as rounding, which would pass for covered.
    pub(super) fn polygon(&self) -> Option<FlatPolygon> {
        let is_wide = self.ranges.iter().all(|[low, high]| high - low >= 4.0 * TOLERANCE);
        is_wide.then(|| self.outline())
    }

    /// Its outline, made wider on all sides so that it never passes for covered.
    pub(super) fn widened(&self) -> FlatPolygon {
        let by = [1.0, 1.0, 2.0, 2.0].map(|times| times * 2.0 * TOLERANCE);
        let ranges = std::array::from_fn(|i| [self.ranges[i][0] - by[i], self.ranges[i][1] + by[i]]);
        Octagon { ranges }.outline()
    }

    fn outline(&self) -> FlatPolygon {
        let [[left, right], [bottom, top], ..] = self.ranges;
        let corners = [(left, bottom), (right, bottom), (right, top), (left, top)].map(DVec2::from);
        let mut outline = FlatPolygon::new(&corners);
        for ([low, high], direction) in self.ranges.into_iter().zip(Octagon::DIRECTIONS).skip(2) {
            outline = outline.beyond(direction, low, TOLERANCE).unwrap_or(outline);
            outline = outline.beyond(-direction, -high, TOLERANCE).unwrap_or(outline);
        }
        outline
    }
}
