//! Several occluders that hide two nodes from each other together: facets in one plane, such as the parts of a
//! wall around a door.
//!
//! If a plane has one node on one side and the other on the other, every segment between them crosses it
//! inside the convex hull of where the segments between their corners do: seen from a point, the image of a
//! convex set on a plane is convex. Where facets in the plane cover that hull without a gap, nothing gets through.

use super::blocker::all_crossings;
use crate::hierarchy::{Effort, Hierarchy, TOLERANCE};
use crate::math::{Axes, FlatPolygon};
use glam::{DVec2, DVec3};

/// For one pair.
const EFFORT: Effort = Effort { nodes: 512, pieces: 32, least_radius: 0.1 };

/// The facet is one of the largest in the way. Where it is smaller than this share of what has to be covered, it is
/// seldom one of as many as that takes.
const LEAST_SHARE: f64 = 1.0 / 16.0;

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
    let hull = hull.filter(|hull| outline.area() >= LEAST_SHARE * hull.area());
    hull.is_some_and(|hull| hierarchy.gaps_in(plane, &axes, hull, Some(facet), EFFORT).is_empty())
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

    /// The same, made wider on all sides: what is crossed of an opening has an area.
    pub(super) fn widened(&self) -> Octagon {
        let by = [1.0, 1.0, 2.0, 2.0].map(|times| times * 2.0 * TOLERANCE);
        Octagon { ranges: std::array::from_fn(|i| [self.ranges[i][0] - by[i], self.ranges[i][1] + by[i]]) }
    }

    /// The part of a polygon within; `None` if they have nothing in common.
    pub(super) fn part_of(&self, polygon: &FlatPolygon) -> Option<FlatPolygon> {
        let sides = || self.ranges.into_iter().zip(Octagon::DIRECTIONS);
        let is_apart = sides().any(|([low, high], direction)| {
            let at = polygon.corners().iter().map(|&corner| direction.dot(corner));
            let (least, most) = at.fold((f64::MAX, f64::MIN), |(a, b), at| (a.min(at), b.max(at)));
            most < low || least > high
        });
        if is_apart {
            return None;
        }
        let mut part = *polygon;
        for ([low, high], direction) in sides() {
            part = part.beyond(direction, low, 0.0)?.beyond(-direction, -high, 0.0)?;
        }
        Some(part)
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
