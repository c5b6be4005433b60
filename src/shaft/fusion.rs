//! Several occluders that hide two nodes from each other together: facets in one plane, such as the parts of a
//! wall around a door.
//!
//! If a plane has one node on one side and the other on the other, every segment between them crosses it
//! inside the convex hull of where the segments between their corners do: seen from a point, the image of a
//! convex set on a plane is convex. Where facets in the plane cover that hull without a gap, nothing gets through.

use super::blocker::all_crossings;
use crate::hierarchy::{Hierarchy, NodeKind, TOLERANCE};
use crate::math::{Aabb, MAX_VERTICES, Plane, Polygon};
use glam::{DVec2, DVec3};

/// Most nodes of the hierarchy looked at for one pair.
const MOST_NODES: u32 = 512;

/// Facets smaller than this do not help, by their radius and that of what has to be covered.
const LEAST_RADIUS: f64 = 0.1;

/// Most pieces that are left uncovered at a time.
const MOST_PIECES: usize = 32;

/// Room for the corners of a piece: the hull has 8, and every cut adds at most one.
const MOST_CORNERS: usize = 24;

/// Whether the facets in the plane of `facet` together block every segment from a corner of the receiver to a
/// corner of the source.
pub fn blocks_together(hierarchy: &Hierarchy, facet: u32, receiver: &[DVec3], source: &[DVec3]) -> bool {
    let plane = &hierarchy.facets[facet as usize].plane;
    let outline = hierarchy.polygon(facet);
    let view = View::of(&outline, plane);
    let Some(hull) = hull_of_crossings(plane, &view, receiver, source) else { return false };
    let bounds = Aabb::around(hull.corners().iter().map(|&corner| view.point(corner).as_vec3()));
    let least_radius = LEAST_RADIUS * bounds.radius();
    let mut gaps = Gaps { pieces: vec![hull], next: Vec::new() };
    if outline.bounds().radius() >= least_radius && !gaps.cover(&view, &outline) {
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
        if node.bounds.radius() < least_radius || !node.bounds.overlaps(bounds, TOLERANCE as f32) {
            continue;
        }
        let (low, high) = plane.distance_range(&node.bounds);
        if low > TOLERANCE || high < -TOLERANCE {
            continue;
        }
        match node.kind(index) {
            NodeKind::Cluster(children) => stack.extend(children),
            NodeKind::Leaf(other) if other != facet => {
                let polygon = hierarchy.polygon(other);
                let is_flat = polygon.vertices().iter().all(|&v| plane.distance(v).abs() <= 0.5 * TOLERANCE);
                if is_flat && !gaps.cover(&view, &polygon) {
                    return true;
                }
            }
            NodeKind::Leaf(_) => {}
        }
    }
    false
}

/// Two axes in a plane.
struct View {
    origin: DVec3,
    axes: [DVec3; 2],
}

impl View {
    /// The first axis runs along the first edge of a polygon in the plane.
    fn of(polygon: &Polygon, plane: &Plane) -> View {
        let v = polygon.vertices();
        let along = (v[1] - v[0]).normalize_or(plane.normal.any_orthonormal_vector());
        View { origin: v[0], axes: [along, plane.normal.cross(along)] }
    }

    fn flat(&self, point: DVec3) -> DVec2 {
        let from_origin = point - self.origin;
        DVec2::new(from_origin.dot(self.axes[0]), from_origin.dot(self.axes[1]))
    }

    fn point(&self, flat: DVec2) -> DVec3 {
        self.origin + self.axes[0] * flat.x + self.axes[1] * flat.y
    }
}

/// A convex polygon in a plane, counter-clockwise.
#[derive(Clone, Copy)]
struct Piece {
    count: usize,
    corners: [DVec2; MOST_CORNERS],
}

impl Piece {
    fn new(corners: &[DVec2]) -> Piece {
        let mut piece = Piece { count: corners.len(), corners: [DVec2::ZERO; MOST_CORNERS] };
        piece.corners[..corners.len()].copy_from_slice(corners);
        piece
    }

    fn corners(&self) -> &[DVec2] {
        &self.corners[..self.count]
    }

    /// The part where `normal · p ≥ offset`; `None` when it reaches no further than rounding.
    fn beyond(&self, normal: DVec2, offset: f64) -> Option<Piece> {
        let mut part = Piece { count: 0, corners: [DVec2::ZERO; MOST_CORNERS] };
        let mut deepest = 0.0f64;
        let corners = self.corners();
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let (da, db) = (normal.dot(a) - offset, normal.dot(b) - offset);
            deepest = deepest.max(da);
            // All of it is more than the part: nothing is taken for covered that is not.
            if part.count + 2 > MOST_CORNERS {
                return Some(*self);
            }
            if da >= 0.0 {
                part.push(a);
            }
            if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
                part.push(a.lerp(b, da / (da - db)));
            }
        }
        (deepest > TOLERANCE && part.count >= 3).then_some(part)
    }

    fn push(&mut self, corner: DVec2) {
        self.corners[self.count] = corner;
        self.count += 1;
    }
}

/// Where segments cross the plane between two nodes: a piece around all of it, or `None` when some segment does
/// not.
fn hull_of_crossings(plane: &Plane, view: &View, receiver: &[DVec3], source: &[DVec3]) -> Option<Piece> {
    // The octagon around all crossings, along the axes and between them: no smaller than their hull.
    let directions = [DVec2::X, DVec2::Y, DVec2::new(1.0, 1.0), DVec2::new(1.0, -1.0)];
    let mut ranges = [[f64::MAX, f64::MIN]; 4];
    let is_crossed = all_crossings(plane, receiver, source, |crossing| {
        let crossing = view.flat(crossing);
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
    let mut hull = Piece::new(&corners);
    for ([low, high], direction) in ranges.into_iter().zip(directions).skip(2) {
        hull = hull.beyond(direction, low).unwrap_or(hull);
        hull = hull.beyond(-direction, -high).unwrap_or(hull);
    }
    Some(hull)
}

/// What is not covered yet.
struct Gaps {
    pieces: Vec<Piece>,
    next: Vec<Piece>,
}

impl Gaps {
    /// Takes a polygon away from all pieces; whether anything is left.
    fn cover(&mut self, view: &View, polygon: &Polygon) -> bool {
        let mut room = [DVec2::ZERO; MAX_VERTICES];
        let corners = &mut room[..polygon.vertices().len()];
        for (corner, &vertex) in corners.iter_mut().zip(polygon.vertices()) {
            *corner = view.flat(vertex);
        }
        let twice_area: f64 =
            (0..corners.len()).map(|i| corners[i].perp_dot(corners[(i + 1) % corners.len()])).sum();
        if twice_area < 0.0 {
            corners.reverse();
        }
        self.next.clear();
        for piece in &self.pieces {
            if !overlap(piece, corners) {
                self.next.push(*piece);
                continue;
            }
            let mut rest = Some(*piece);
            for i in 0..corners.len() {
                let Some(inner) = rest else { break };
                let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
                let outward = (a - b).perp().normalize_or_zero();
                self.next.extend(inner.beyond(outward, outward.dot(a)));
                rest = inner.beyond(-outward, -outward.dot(a));
            }
        }
        std::mem::swap(&mut self.pieces, &mut self.next);
        !self.pieces.is_empty()
    }
}

/// Whether no edge of a convex polygon has all of a piece outside.
fn overlap(piece: &Piece, corners: &[DVec2]) -> bool {
    (0..corners.len()).all(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let outward = (a - b).perp();
        piece.corners().iter().any(|&corner| outward.dot(corner - a) < 0.0)
    })
}
