//! How near a segment is to where the answer for a facet changes: its outline, or an end of the segment.

use crate::tracer::{Segment, TraceMesh};
use glam::DVec3;

/// What rounding does to the moment of a line about an edge, as a share of what it does to a point: some ten roundings
/// of single precision.
const MOMENT: f64 = 0.25;

/// Whether rounding may decide on which side of the edges of a facet a line passes that sees it nearly edge-on.
/// `rounding` is a local length.
///
/// A tracer tells the sides by the moment of the line about each edge: how far the line is from that of the edge, times
/// the sine of their angle. Rounding changes it by less than it moves a point, but for a line along an edge that is
/// worth a greater distance. True where the line passes no further than `rounding` from the lines through all edges of
/// a triangle, as seen along it; and where some triangle would be met with no moment changed by more than rounding
/// does, and not be met with one on the outline changed by as much.
pub(super) fn is_edge_on(
    mesh: &TraceMesh,
    facet: u32,
    origin: DVec3,
    direction: DVec3,
    rounding: f64,
) -> bool {
    let direction = direction.normalize_or_zero();
    let at = |v: u32| mesh.positions[v as usize].as_dvec3();
    let triangles = mesh.triangles_of(facet);
    triangles.iter().any(|&[a, b, c]| {
        let edges = [(a, b), (b, c), (c, a)];
        let moments = edges.map(|(from, to)| {
            let edge = (at(to) - at(from)).normalize_or_zero();
            edge.cross(direction).dot(at(from) - origin)
        });
        let change = MOMENT * rounding;
        let may_meet = moments.iter().all(|&m| m >= -change) || moments.iter().all(|&m| m <= change);
        let may_pass = (0..3).any(|i| moments[i].abs() <= change && is_on_outline(triangles, edges[i]));
        may_meet && may_pass || moments.iter().all(|m| m.abs() <= rounding)
    })
}

/// Whether no other triangle of a facet goes along an edge the other way.
fn is_on_outline(triangles: &[[u32; 3]], (a, b): (u32, u32)) -> bool {
    !triangles.iter().any(|&[u, v, w]| [(u, v), (v, w), (w, u)].contains(&(b, a)))
}

/// How far a segment is from where the answer for one facet changes: from the outline of the facet, and its
/// ends, less what is left out there, from the facet itself. A local length.
pub fn distance_to_change(mesh: &TraceMesh, facet: u32, segment: &Segment) -> f64 {
    let (from, to) = (segment.from.as_dvec3(), segment.to.as_dvec3());
    distance_between(mesh, facet, segment.open_part().map(|share| from.lerp(to, share as f64)))
}

/// How far a line between two ends is from the outline of a facet, and its ends from the facet itself.
pub(super) fn distance_between(mesh: &TraceMesh, facet: u32, ends: [DVec3; 2]) -> f64 {
    let triangles = mesh.triangles_of(facet);
    let at = |v: u32| mesh.positions[v as usize].as_dvec3();
    let from_ends =
        ends.into_iter().flat_map(|end| triangles.iter().map(move |t| to_triangle(end, t.map(at))));
    let edges = || triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let outline = edges().filter(|&edge| is_on_outline(triangles, edge));
    let from_outline = outline.map(|(a, b)| between_segments(ends, [at(a), at(b)]));
    from_outline.chain(from_ends).fold(f64::INFINITY, f64::min)
}

/// How far a point is from the plane of a facet.
pub(super) fn distance_from_plane(mesh: &TraceMesh, facet: u32, point: DVec3) -> f64 {
    let distances = mesh.triangles_of(facet).iter().map(|t| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3());
        (b - a).cross(c - a).normalize_or_zero().dot(point - a).abs()
    });
    distances.fold(f64::INFINITY, f64::min)
}

/// Distance of two segments.
pub fn between_segments([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> f64 {
    let (u, v) = (b - a, d - c);
    let normal = u.cross(v);
    let ends = [to_segment(a, [c, d]), to_segment(b, [c, d]), to_segment(c, [a, b]), to_segment(d, [a, b])];
    let nearest_end = ends.into_iter().fold(f64::INFINITY, f64::min);
    let square = normal.length_squared();
    if square <= 0.0 {
        return nearest_end;
    }
    // Where the lines come nearest to each other, if that is on both segments.
    let s = (c - a).cross(v).dot(normal) / square;
    let t = (c - a).cross(u).dot(normal) / square;
    let is_inside = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    if is_inside { nearest_end.min((c - a).dot(normal).abs() / square.sqrt()) } else { nearest_end }
}

fn to_segment(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(a + along * t)
}

fn to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let is_over = |start: DVec3, end: DVec3| normal.dot((end - start).cross(p - start)) >= 0.0;
    let from_edges = [[a, b], [b, c], [c, a]].map(|edge| to_segment(p, edge));
    let nearest_edge = from_edges.into_iter().fold(f64::INFINITY, f64::min);
    let is_inside = normal != DVec3::ZERO && is_over(a, b) && is_over(b, c) && is_over(c, a);
    if is_inside { nearest_edge.min((p - a).dot(normal).abs()) } else { nearest_edge }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The distances by which everything here is judged, on figures that can be checked by hand.
    #[test]
    fn distances_are_what_they_are_by_hand() {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        assert_eq!(between_segments([-x, x], [z - y, z + y]), 1.0);
        assert_eq!(between_segments([-x, x], [x * 3.0 + z, x * 3.0 - z]), 2.0);
        assert_eq!(between_segments([-x, x], [y - x, y + x]), 1.0, "parallel");
        assert_eq!(between_segments([-x, x], [DVec3::ZERO, y]), 0.0, "touching");
        let triangle = [DVec3::ZERO, x * 2.0, y * 2.0];
        assert_eq!(to_triangle(DVec3::new(0.5, 0.5, -3.0), triangle), 3.0);
        assert_eq!(to_triangle(DVec3::new(-4.0, -3.0, 0.0), triangle), 5.0);
    }
}
