//! Coplanar neighbouring triangles of one material merged into convex facets: larger pieces to
//! subdivide, and larger occluders to prove "blocked" with.

use super::TOLERANCE;
use crate::math::{MAX_VERTICES, Plane, Polygon};
use crate::progress::Progress;
use crate::scene::Triangle;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Longest outline followed while merging; bounds the cost of merging finely tessellated planes.
const MAX_OUTLINE: usize = 64;

/// Edges between two reports of progress.
const ADVANCE: usize = 4096;

/// One side of a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Side {
    /// Facet id.
    pub facet: u32,
    /// Seen from behind.
    pub back: bool,
}

/// A convex planar polygon of one material.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// Its plane; the normal points to the front.
    pub plane: Plane,
    /// Index into the scene's materials.
    pub material: u32,
    pub(super) first_corner: u32,
    pub(super) corner_count: u32,
}

impl Facet {
    pub(super) fn new(merged: &MergedFacet, first_corner: u32, positions: &[Vec3]) -> Facet {
        let plane = merged.plane(positions);
        Facet { plane, material: merged.material, first_corner, corner_count: merged.corners.len() as u32 }
    }
}

/// A facet before it has its place in the tree.
#[derive(Debug)]
pub(super) struct MergedFacet {
    /// Ids of its triangles, ascending.
    pub(super) triangles: Vec<u32>,
    /// Corners in order, without vertices in the middle of an edge.
    pub(super) corners: Vec<u32>,
    pub(super) material: u32,
}

impl MergedFacet {
    pub(super) fn polygon(&self, positions: &[Vec3]) -> Polygon {
        let mut points = [DVec3::ZERO; MAX_VERTICES];
        for (point, &corner) in points.iter_mut().zip(&self.corners) {
            *point = positions[corner as usize].as_dvec3();
        }
        Polygon::new(&points[..self.corners.len()])
    }

    pub(super) fn plane(&self, positions: &[Vec3]) -> Plane {
        let polygon = self.polygon(positions);
        Plane::through(polygon.center(), polygon.area_vector().normalize_or(DVec3::Y))
    }
}

/// Merges greedily over shared edges, those inside an input polygon first.
pub(super) fn merge(positions: &[Vec3], triangles: &[Triangle], progress: &dyn Progress) -> Vec<MergedFacet> {
    let welded = weld(positions);
    let mut outlines: Vec<Vec<u32>> =
        triangles.iter().map(|t| t.vertices.iter().map(|&v| welded[v as usize]).collect()).collect();
    let mut members: Vec<Vec<u32>> = (0..triangles.len() as u32).map(|t| vec![t]).collect();
    let mut owner: Vec<u32> = (0..triangles.len() as u32).collect();

    let edges = shared_edges(&outlines, triangles);
    progress.start("facets", edges.len() as u64);
    for (index, (a, b)) in edges.into_iter().enumerate() {
        if index % ADVANCE == ADVANCE - 1 {
            progress.advance(ADVANCE as u64);
        }
        let (a, b) = (find(&mut owner, a), find(&mut owner, b));
        if a == b {
            continue;
        }
        let Some(outline) = joined(&outlines[a as usize], &outlines[b as usize]) else { continue };
        let turned = [a, b].map(|t| area_vector(&outlines[t as usize], positions));
        // Two that are folded onto each other face opposite ways.
        if turned[0].dot(turned[1]) <= 0.0 || !is_convex_and_planar(&outline, positions) {
            continue;
        }
        let (keep, gone) = (a.min(b) as usize, a.max(b) as usize);
        owner[gone] = keep as u32;
        outlines[keep] = outline;
        outlines[gone] = Vec::new();
        let moved = std::mem::take(&mut members[gone]);
        members[keep].extend(moved);
    }

    let mut merged = Vec::new();
    for t in 0..triangles.len() {
        if owner[t] as usize == t {
            let mut own = std::mem::take(&mut members[t]);
            own.sort_unstable();
            let corners = corners_of(&outlines[t], positions);
            // A sliver whose corners all look straight keeps its three vertices.
            let corners = if corners.len() < 3 { triangles[t].vertices.to_vec() } else { corners };
            merged.push(MergedFacet { triangles: own, corners, material: triangles[t].material });
        }
    }
    merged
}

/// For each vertex the first vertex at the very same place.
fn weld(positions: &[Vec3]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(positions.len());
    positions
        .iter()
        .enumerate()
        // Adding zero turns −0 into 0.
        .map(|(i, p)| *first.entry((*p + Vec3::ZERO).to_array().map(f32::to_bits)).or_insert(i as u32))
        .collect()
}

/// Pairs of triangles that share an edge in opposite directions, of one material; those of one patch
/// first, then by the edge's number.
fn shared_edges(outlines: &[Vec<u32>], triangles: &[Triangle]) -> Vec<(u32, u32)> {
    let mut by_edge: HashMap<(u32, u32), u32> = HashMap::with_capacity(outlines.len() * 3);
    let edges =
        |t: usize| (0..3).map(move |i| (i, (i + 1) % 3)).map(move |(i, j)| (outlines[t][i], outlines[t][j]));
    for t in 0..outlines.len() {
        for edge in edges(t) {
            by_edge.entry(edge).or_insert(t as u32);
        }
    }
    let mut inside = Vec::new();
    let mut between = Vec::new();
    for t in 0..outlines.len() {
        for (a, b) in edges(t) {
            let Some(&other) = by_edge.get(&(b, a)) else { continue };
            let (this, that) = (&triangles[t], &triangles[other as usize]);
            if other as usize <= t || this.material != that.material {
                continue;
            }
            if this.patch == that.patch { &mut inside } else { &mut between }.push((t as u32, other));
        }
    }
    inside.append(&mut between);
    inside
}

fn find(owner: &mut [u32], mut t: u32) -> u32 {
    while owner[t as usize] != t {
        owner[t as usize] = owner[owner[t as usize] as usize];
        t = owner[t as usize];
    }
    t
}

/// The outline of both together, when they meet along one unbroken run of edges.
fn joined(a: &[u32], b: &[u32]) -> Option<Vec<u32>> {
    if a.len() + b.len() > MAX_OUTLINE {
        return None;
    }
    // An edge of `a` that `b` walks the other way.
    let (i, j) = (0..a.len()).find_map(|i| {
        let next = a[(i + 1) % a.len()];
        (0..b.len()).find(|&j| b[j] == next && b[(j + 1) % b.len()] == a[i]).map(|j| (i, j))
    })?;
    let mut outline = Vec::with_capacity(a.len() + b.len() - 2);
    outline.extend((0..a.len()).map(|k| a[(i + 1 + k) % a.len()]));
    outline.extend((1..b.len() - 1).map(|k| b[(j + 1 + k) % b.len()]));
    // Further shared edges show as a vertex between two equal neighbours.
    loop {
        let n = outline.len();
        if n < 3 {
            return None;
        }
        let Some(k) = (0..n).find(|&k| outline[k] == outline[(k + 2) % n]) else { break };
        let (first, second) = ((k + 1) % n, (k + 2) % n);
        let (hi, lo) = (first.max(second), first.min(second));
        outline.remove(hi);
        outline.remove(lo);
    }
    let mut sorted = outline.clone();
    sorted.sort_unstable();
    sorted.windows(2).all(|w| w[0] != w[1]).then_some(outline)
}

/// The area of a planar outline, along its normal.
fn area_vector(outline: &[u32], positions: &[Vec3]) -> DVec3 {
    let at = |i: usize| positions[outline[i % outline.len()] as usize].as_dvec3();
    let start = at(0);
    (1..outline.len() - 1).map(|i| 0.5 * (at(i) - start).cross(at(i + 1) - start)).sum()
}

/// The outline without vertices in the middle of a straight edge: all that are left out between two corners lie on the
/// line that joins them.
pub(super) fn corners_of(outline: &[u32], positions: &[Vec3]) -> Vec<u32> {
    let at = |i: usize| positions[outline[i % outline.len()] as usize].as_dvec3();
    let n = outline.len();
    let middle = (0..n).map(at).sum::<DVec3>() / n as f64;
    let distance = |i: usize| at(i).distance_squared(middle);
    // What is furthest out is a corner.
    let start = (0..n).max_by(|&i, &j| distance(i).total_cmp(&distance(j))).unwrap_or(0);
    let mut corners = vec![start];
    for i in start + 1..start + n {
        let last = corners[corners.len() - 1];
        let base = at(i + 1) - at(last);
        let is_on = |k: usize| base.cross(at(k) - at(last)).length() <= TOLERANCE * 0.25 * base.length();
        if !(last + 1..=i).all(is_on) {
            corners.push(i);
        }
    }
    corners.sort_unstable_by_key(|i| i % n);
    corners.into_iter().map(|i| outline[i % n]).collect()
}

fn is_convex_and_planar(outline: &[u32], positions: &[Vec3]) -> bool {
    let corners = corners_of(outline, positions);
    if !(3..=MAX_VERTICES).contains(&corners.len()) {
        return false;
    }
    let points: Vec<DVec3> = corners.iter().map(|&c| positions[c as usize].as_dvec3()).collect();
    let polygon = Polygon::new(&points);
    let normal = polygon.area_vector().normalize_or_zero();
    let plane = Plane::through(polygon.center(), normal);
    let n = outline.len();
    let at = |i: usize| positions[outline[i % n] as usize].as_dvec3();
    let mut turning = 0.0;
    for i in 0..n {
        let (before, here, after) = (at(i + n - 1), at(i), at(i + 1));
        if plane.distance(here).abs() > TOLERANCE * 0.25 {
            return false;
        }
        let (into, out) = (here - before, after - here);
        let bend = into.cross(out).dot(normal);
        if bend < -TOLERANCE * 0.25 * (after - before).length() {
            return false;
        }
        turning += bend.atan2(into.dot(out));
    }
    // Once around and no more: an outline that winds twice is not convex.
    (turning - std::f64::consts::TAU).abs() < 0.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    fn grid(n: u32, height: impl Fn(u32, u32) -> f32) -> (Vec<Vec3>, Vec<Triangle>) {
        let positions = (0..=n)
            .flat_map(|y| (0..=n).map(move |x| (x, y)))
            .map(|(x, y)| Vec3::new(x as f32 / n as f32, y as f32 / n as f32, height(x, y)))
            .collect();
        let mut triangles = Vec::new();
        for y in 0..n {
            for x in 0..n {
                let v = |dx: u32, dy: u32| (y + dy) * (n + 1) + x + dx;
                let patch = y * n + x;
                triangles.push(Triangle { vertices: [v(0, 0), v(1, 0), v(1, 1)], material: 0, patch });
                triangles.push(Triangle { vertices: [v(0, 0), v(1, 1), v(0, 1)], material: 0, patch });
            }
        }
        (positions, triangles)
    }

    fn area(facets: &[MergedFacet], positions: &[Vec3]) -> f64 {
        facets
            .iter()
            .map(|f| {
                let points: Vec<DVec3> =
                    f.corners.iter().map(|&c| positions[c as usize].as_dvec3()).collect();
                Polygon::new(&points).area()
            })
            .sum()
    }

    #[test]
    fn a_flat_grid_becomes_a_few_rectangles_of_the_same_area() {
        let (positions, triangles) = grid(6, |_, _| 0.25);
        let facets = merge(&positions, &triangles, &Silent);
        assert!(facets.len() <= 6, "{} facets", facets.len());
        assert!((area(&facets, &positions) - 1.0).abs() < 1e-6);
        let mut all: Vec<u32> = facets.iter().flat_map(|f| f.triangles.clone()).collect();
        all.sort_unstable();
        assert_eq!(all, (0..72).collect::<Vec<_>>());
    }

    #[test]
    fn a_bumpy_grid_keeps_its_triangles_apart() {
        let (positions, triangles) = grid(4, |x, y| (x as f32 * 1.7 + (y * y) as f32).sin() * 0.05);
        assert_eq!(merge(&positions, &triangles, &Silent).len(), 32);
    }

    #[test]
    fn an_l_shape_is_not_merged_into_one() {
        let (positions, mut triangles) = grid(2, |_, _| 0.0);
        triangles.truncate(6);
        let facets = merge(&positions, &triangles, &Silent);
        assert_eq!(facets.len(), 2);
        assert!((area(&facets, &positions) - 0.75).abs() < 1e-6);
    }

    /// Each of two corners of its lower side is as good as on the line between its neighbours, but not on the one
    /// that is left without both.
    #[test]
    fn a_flat_corner_is_kept_when_its_neighbour_goes() {
        let points = [
            (0.019_746_562, -0.235_664_13),
            (0.214_916_32, -0.235_664_13),
            (0.215_231_5, -0.235_664_13),
            (0.578_027_07, -0.235_289_13),
            (0.019_431_312, -0.235_289_13),
        ];
        let positions = points.map(|(x, y)| Vec3::new(x, y, -0.308_331_13)).to_vec();
        let fan = (1..4).map(|i| Triangle { vertices: [0, i, i + 1], material: 0, patch: 0 });
        let facets = merge(&positions, &fan.collect::<Vec<_>>(), &Silent);
        let exact = 0.5 * area_vector(&[0, 1, 2, 3, 4], &positions).length() * 2.0;
        assert!((area(&facets, &positions) / exact - 1.0).abs() < 0.01, "{facets:?} for {exact}");
    }

    #[test]
    fn other_materials_and_turned_triangles_stay_apart() {
        let (positions, mut triangles) = grid(1, |_, _| 0.0);
        triangles[1].material = 1;
        assert_eq!(merge(&positions, &triangles, &Silent).len(), 2);
        triangles[1].material = 0;
        triangles[1].vertices.swap(0, 1);
        assert_eq!(merge(&positions, &triangles, &Silent).len(), 2);
    }

    /// Their common outline has no area, so it would pass for flat and convex.
    #[test]
    fn folded_triangles_stay_apart() {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let positions = corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec();
        let of = |vertices: [u32; 3]| Triangle { vertices, material: 0, patch: 0 };
        // A quadrilateral that crosses itself.
        assert_eq!(merge(&positions, &[of([0, 1, 3]), of([0, 3, 2])], &Silent).len(), 2);
        // A square and its back, divided along the other diagonal.
        let sheet = [of([0, 1, 2]), of([0, 2, 3]), of([0, 3, 1]), of([1, 3, 2])];
        let facets = merge(&positions, &sheet, &Silent);
        assert!(facets.len() == 2 && (area(&facets, &positions) - 2.0).abs() < 1e-6, "{}", facets.len());
    }
}
