//! Where other surfaces stand on a large facet, as a wall on a floor that runs on behind it, or where those end that lie
//! close over it, as a picture that hangs on a wall. Light differs on both sides of such a line however finely the facet is
//! divided elsewhere. \[LTG93\] call it a discontinuity of degree 0.

use super::{Hierarchy, NodeKind, Side, TOLERANCE};
use crate::math::{Plane, Polygon};
use crate::progress::Progress;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Facets smaller than this have no contacts, local extent.
const SMALLEST: f64 = 0.02;

/// Shorter contacts are not looked for, local length.
const SHORTEST: f64 = 0.02;

/// Surfaces that lean less than this towards the facet (sine of the angle) lie on it, not stand.
const LEANING: f64 = 0.1;

/// What lies over a facet covers it if the gap between them is no wider than this share of the width of either: hardly any
/// light gets far into it.
const GAP: f64 = 1.0 / 32.0;

/// A line on a facet, local coordinates.
pub type Contact = [DVec3; 2];

/// The contacts of all facets.
#[derive(Clone, Debug, Default)]
pub struct Contacts {
    /// Where the contacts of each facet begin: those of what stands on it, of what lies over its front, and over its back;
    /// with the total number at the end.
    first: Vec<u32>,
    contacts: Vec<Contact>,
}

impl Contacts {
    /// Looks for what stands on the facets, and for what covers them.
    pub(super) fn of(hierarchy: &Hierarchy, progress: &dyn Progress) -> Contacts {
        progress.start("contacts", hierarchy.facets.len() as u64);
        let found: Vec<[Vec<Contact>; 3]> = (0..hierarchy.facets.len() as u32)
            .into_par_iter()
            .map(|facet| {
                let contacts = on_facet(hierarchy, facet);
                progress.advance(1);
                contacts
            })
            .collect();
        let mut all = Contacts { first: vec![0], contacts: Vec::new() };
        for contacts in found.into_iter().flatten() {
            all.contacts.extend(contacts);
            all.first.push(all.contacts.len() as u32);
        }
        all
    }

    /// The contacts of one facet.
    pub fn on(&self, facet: u32) -> &[Contact] {
        self.of_kinds(facet, 0..3)
    }

    /// Those on one side of it between which light differs: where something stands, on whichever side that is, and the
    /// outlines of what covers this side.
    pub fn on_side(&self, side: Side) -> impl Iterator<Item = &Contact> {
        let own = if side.back { 2 } else { 1 };
        self.of_kinds(side.facet, 0..1).iter().chain(self.of_kinds(side.facet, own..own + 1))
    }

    fn of_kinds(&self, facet: u32, kinds: Range<usize>) -> &[Contact] {
        let [first, end] =
            [kinds.start, kinds.end].map(|kind| self.first[3 * facet as usize + kind] as usize);
        &self.contacts[first..end]
    }
}

/// Of what stands on a facet, and of what covers its front and its back.
fn on_facet(hierarchy: &Hierarchy, facet: u32) -> [Vec<Contact>; 3] {
    let polygon = hierarchy.polygon(facet);
    if polygon.extent() < SMALLEST {
        return Default::default();
    }
    let (mut standing, mut covers) = (Vec::new(), [Vec::new(), Vec::new()]);
    let plane = hierarchy.facets[facet as usize].plane;
    let bounds = polygon.bounds();
    let widest = (GAP * polygon.width()).max(TOLERANCE);
    let mut stack = vec![0u32];
    while let Some(index) = stack.pop() {
        let node = &hierarchy.nodes[index as usize];
        if 2.0 * node.bounds.radius() < SHORTEST || !node.is_near(bounds, &plane, widest) {
            continue;
        }
        match node.kind(index) {
            NodeKind::Cluster(children) => stack.extend(children.iter().rev()),
            NodeKind::Leaf(other) if other != facet => {
                let leaning = hierarchy.facets[other as usize].plane.normal.cross(plane.normal).length();
                let other = hierarchy.polygon(other);
                if leaning > LEANING {
                    standing.extend(meeting_line(&other, &plane));
                } else if let Some(cover) = Cover::of(&other, &plane, widest) {
                    covers[usize::from(cover.low < 0.0)].push(cover);
                }
            }
            NodeKind::Leaf(_) => {}
        }
    }
    if hierarchy.one_sided {
        covers[1].clear();
    }
    let [front, back] = covers.map(|covers| outlines(&covers));
    [standing, front, back].map(|lines| {
        let inside = lines.into_iter().filter_map(|line| within(line, &polygon, &plane));
        inside.map(|(line, _)| line).collect()
    })
}

/// A polygon that lies over a part of a plane, close to it.
struct Cover {
    /// What it covers.
    shadow: Polygon,
    /// Unit normal of that, where its outline is counter-clockwise.
    normal: DVec3,
    /// Heights above the plane, of one sign, the first nearer to the plane.
    low: f64,
    high: f64,
}

impl Cover {
    /// `None` if it touches the plane, or the gap is wider than `widest` or than its own width allows.
    fn of(polygon: &Polygon, plane: &Plane, widest: f64) -> Option<Cover> {
        let heights = || polygon.vertices().iter().map(|&v| plane.distance(v));
        let low = heights().min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        let high = heights().max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        let covers = low.abs() > TOLERANCE
            && high.abs() <= widest.min(GAP * polygon.width())
            && heights().all(|height| (height < 0.0) == (low < 0.0));
        covers.then(|| {
            let corners: Vec<DVec3> =
                polygon.vertices().iter().map(|&v| v - plane.normal * plane.distance(v)).collect();
            let shadow = Polygon::new(&corners);
            let is_turned = shadow.area_vector().dot(plane.normal) < 0.0;
            Cover { shadow, normal: if is_turned { -plane.normal } else { plane.normal }, low, high }
        })
    }

    /// Whether an edge of `other` with this middle is no border of what both cover: this one goes on where the other ends,
    /// being as near to the plane or nearer, or lies over both sides of the edge.
    fn hides(&self, other: &Cover, middle: DVec3) -> bool {
        let is_further = self.low.abs() > other.high.abs() + TOLERANCE;
        self.shadow.outside_distance(middle, self.normal) < if is_further { -TOLERANCE } else { TOLERANCE }
    }
}

/// The borders of what all covers together cover.
fn outlines(covers: &[Cover]) -> Vec<Contact> {
    let mut lines = Vec::new();
    for (index, cover) in covers.iter().enumerate() {
        for (a, b) in cover.shadow.edges() {
            let mut others = covers.iter().enumerate().filter(|(other, _)| *other != index);
            if !others.any(|(_, other)| other.hides(cover, (a + b) * 0.5)) {
                lines.push([a, b]);
            }
        }
    }
    lines
}

/// The line in which a polygon meets a plane, or stands on it.
fn meeting_line(polygon: &Polygon, plane: &Plane) -> Option<Contact> {
    let mut ends: Option<Contact> = None;
    let mut add = |point: DVec3| {
        ends = Some(match ends {
            None => [point; 2],
            // Of three points on a line the two that are furthest apart.
            Some([a, b]) => {
                let pairs = [[a, b], [a, point], [b, point]];
                let longest = pairs
                    .into_iter()
                    .max_by(|p, q| p[0].distance_squared(p[1]).total_cmp(&q[0].distance_squared(q[1])));
                longest.unwrap_or([a, b])
            }
        });
    };
    for (a, b) in polygon.edges() {
        let (da, db) = (plane.distance(a), plane.distance(b));
        if da.abs() <= TOLERANCE {
            add(a - plane.normal * da);
        } else if db.abs() > TOLERANCE && (da < 0.0) != (db < 0.0) {
            add(a.lerp(b, da / (da - db)));
        }
    }
    ends
}

/// The part of a contact inside a polygon and off its border, with the length of the line across the polygon
/// that it lies on; `None` when too little of it is inside.
pub(crate) fn within(line: Contact, polygon: &Polygon, plane: &Plane) -> Option<(Contact, f64)> {
    let [a, b] = line;
    let along = (b - a).try_normalize()?;
    // The line is inside for positions along it between these, and beyond its ends.
    let (mut enters, mut leaves) = (f64::NEG_INFINITY, f64::INFINITY);
    for (from, to) in polygon.edges() {
        let outward = (to - from).cross(plane.normal).normalize_or_zero();
        let (out, slope) = ((a - from).dot(outward) + 4.0 * TOLERANCE, along.dot(outward));
        if slope.abs() < 1e-9 {
            if out > 0.0 {
                return None;
            }
        } else if slope > 0.0 {
            leaves = leaves.min(-out / slope);
        } else {
            enters = enters.max(-out / slope);
        }
    }
    let (first, last) = (enters.max(0.0), leaves.min(a.distance(b)));
    (last - first >= SHORTEST).then(|| ([a + along * first, a + along * last], leaves - enters))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floor() -> (Polygon, Plane) {
        let corners =
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        (Polygon::new(&corners), Plane::through(DVec3::ZERO, DVec3::Z))
    }

    fn wall(x: f64, low: f64, half: f64) -> Polygon {
        Polygon::new(
            &[(-half, low), (half, low), (half, 1.0), (-half, 1.0)].map(|(y, z)| DVec3::new(x, y, z)),
        )
    }

    fn contact(wall: &Polygon) -> Option<Contact> {
        let (polygon, plane) = floor();
        meeting_line(wall, &plane).and_then(|line| within(line, &polygon, &plane)).map(|(line, _)| line)
    }

    #[test]
    fn a_wall_that_stands_on_the_floor_or_goes_through_it_touches_it() {
        for low in [0.0, -0.5] {
            let [a, b] = contact(&wall(0.25, low, 3.0)).expect("a contact");
            assert!((a.distance(b) - 2.0).abs() < 1e-4 && (a.x - 0.25).abs() < 1e-9, "{a} {b}");
        }
    }

    /// The outlines of rugs over the floor, each from corner to corner at a height.
    fn outlines_over(rugs: &[([f64; 2], [f64; 2], f64)]) -> Vec<Contact> {
        let (polygon, plane) = floor();
        let cover = |&([x0, y0], [x1, y1], height): &([f64; 2], [f64; 2], f64)| {
            let corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)];
            let rug = Polygon::new(&corners.map(|(x, y)| DVec3::new(x, y, height)));
            Cover::of(&rug, &plane, GAP * polygon.width())
        };
        let covers: Vec<Cover> = rugs.iter().filter_map(cover).collect();
        let lines = outlines(&covers).into_iter();
        lines.filter_map(|line| within(line, &polygon, &plane)).map(|(line, _)| line).collect()
    }

    #[test]
    fn what_lies_close_over_the_floor_has_its_outline_on_it() {
        for height in [0.01, -0.01] {
            let outline = outlines_over(&[([-0.5; 2], [0.5; 2], height)]);
            assert_eq!(outline.len(), 4);
            assert!(outline.iter().flatten().all(|p| p.z == 0.0 && p.x.abs() == 0.5 && p.y.abs() == 0.5));
        }
        // It lies on the floor, is too high for its width, or ends where the floor does.
        for (size, height) in [(0.5, 0.0), (0.5, 0.1), (0.1, 0.01), (1.0, 0.01)] {
            let outline = outlines_over(&[([-size; 2], [size; 2], height)]);
            assert!(outline.is_empty(), "{size} {height}");
        }
    }

    #[test]
    fn several_covers_have_one_outline() {
        // Two tiles side by side.
        let outline = outlines_over(&[([-0.5; 2], [0.0, 0.5], 0.01), ([0.0, -0.5], [0.5; 2], 0.01)]);
        assert_eq!(outline.len(), 6);
        assert!(outline.iter().all(|[a, b]| a.x != 0.0 || b.x != 0.0), "{outline:?}");
        // The bottom of a box and its top; a plate that stands out over another; one that lies on a larger one.
        let box_of = |x: f64, top: f64, low: f64| [([-0.5; 2], [0.5; 2], low), ([-x; 2], [x; 2], top)];
        assert_eq!(outlines_over(&box_of(0.5, 0.012, 0.01)).len(), 4);
        let wider = outlines_over(&box_of(0.8, 0.012, 0.01));
        assert!(wider.len() == 4 && wider.iter().flatten().all(|p| p.x.abs() == 0.8), "{wider:?}");
        let smaller = outlines_over(&box_of(0.3, 0.012, 0.01));
        assert!(smaller.len() == 4 && smaller.iter().flatten().all(|p| p.x.abs() == 0.5), "{smaller:?}");
    }

    #[test]
    fn a_wall_at_the_border_above_the_floor_or_too_short_does_not() {
        for other in [wall(1.0, 0.0, 1.0), wall(0.0, 0.1, 1.0), wall(0.0, 0.0, 0.009), wall(1.5, 0.0, 1.0)] {
            assert!(contact(&other).is_none(), "{other:?}");
        }
    }
}
