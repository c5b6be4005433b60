//! Where other surfaces stand on a large facet, as a wall on a floor that runs on behind it, or where those end that lie
//! close over it, as a picture that hangs on a wall. Light differs on both sides of such a line however finely the facet is
//! divided elsewhere. \[LTG93\] call it a discontinuity of degree 0.

use super::{Hierarchy, NodeKind, TOLERANCE};
use crate::math::{Plane, Polygon};
use crate::progress::Progress;
use glam::DVec3;
use rayon::prelude::*;

/// Facets smaller than this have no contacts, local extent.
const SMALLEST: f64 = 0.02;

/// Shorter contacts are not looked for, local length.
const SHORTEST: f64 = 0.02;

/// Surfaces that lean less than this towards the facet (sine of the angle) lie on it, not stand.
const LEANING: f64 = 0.1;

/// What lies on a facet covers it if the gap between them is no wider than this share of its own width, and of how far
/// the facet extends: hardly any light gets far into it.
const GAP: f64 = 1.0 / 32.0;

/// A line on a facet, local coordinates.
pub type Contact = [DVec3; 2];

/// The contacts of all facets.
#[derive(Clone, Debug, Default)]
pub struct Contacts {
    /// First contact of each facet, with the total number at the end.
    first: Vec<u32>,
    contacts: Vec<Contact>,
}

impl Contacts {
    /// Looks for what stands on the facets.
    pub(super) fn of(hierarchy: &Hierarchy, progress: &dyn Progress) -> Contacts {
        progress.start("contacts", hierarchy.facets.len() as u64);
        let found: Vec<Vec<Contact>> = (0..hierarchy.facets.len() as u32)
            .into_par_iter()
            .map(|facet| {
                let contacts = on_facet(hierarchy, facet);
                progress.advance(1);
                contacts
            })
            .collect();
        let mut all = Contacts { first: vec![0], contacts: Vec::new() };
        for contacts in found {
            all.contacts.extend(contacts);
            all.first.push(all.contacts.len() as u32);
        }
        all
    }

    /// The contacts of one facet.
    pub fn on(&self, facet: u32) -> &[Contact] {
        &self.contacts[self.first[facet as usize] as usize..self.first[facet as usize + 1] as usize]
    }
}

fn on_facet(hierarchy: &Hierarchy, facet: u32) -> Vec<Contact> {
    let polygon = hierarchy.polygon(facet);
    let mut contacts = Vec::new();
    if polygon.extent() < SMALLEST {
        return contacts;
    }
    let plane = hierarchy.facets[facet as usize].plane;
    let bounds = polygon.bounds();
    let widest = (GAP * polygon.extent()).max(TOLERANCE);
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
                let lines = if leaning > LEANING {
                    Vec::from_iter(meeting_line(&other, &plane))
                } else {
                    outline_over(&other, &plane, widest)
                };
                let inside = lines.into_iter().filter_map(|line| within(line, &polygon, &plane));
                contacts.extend(inside.map(|(line, _)| line));
            }
            NodeKind::Leaf(_) => {}
        }
    }
    contacts
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

/// The outline of a polygon that covers what is below it in a plane, or above, with a gap no wider than `widest`; nothing of
/// one that touches the plane, or is further away.
fn outline_over(polygon: &Polygon, plane: &Plane, widest: f64) -> Vec<Contact> {
    let heights = polygon.vertices().iter().map(|&v| plane.distance(v));
    let (low, high) = heights.fold((f64::MAX, f64::MIN), |(low, high), h| (low.min(h), high.max(h)));
    let gap = widest.min(GAP * polygon.area() / polygon.extent());
    let covers = low > TOLERANCE && high <= gap || high < -TOLERANCE && low >= -gap;
    let onto = |point: DVec3| point - plane.normal * plane.distance(point);
    if covers { polygon.edges().map(|(a, b)| [onto(a), onto(b)]).collect() } else { Vec::new() }
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

    #[test]
    fn what_lies_close_over_the_floor_has_its_outline_on_it() {
        let (polygon, plane) = floor();
        let lines = |size: f64, height: f64| {
            let corners = [(-size, -size), (size, -size), (size, size), (-size, size)];
            let rug = Polygon::new(&corners.map(|(x, y)| DVec3::new(x, y, height)));
            let outline = outline_over(&rug, &plane, GAP * polygon.extent()).into_iter();
            outline
                .filter_map(|line| within(line, &polygon, &plane))
                .map(|(line, _)| line)
                .collect::<Vec<_>>()
        };
        for height in [0.01, -0.01] {
            let outline = lines(0.5, height);
            assert_eq!(outline.len(), 4);
            assert!(outline.iter().flatten().all(|p| p.z == 0.0 && p.x.abs() == 0.5 && p.y.abs() == 0.5));
        }
        // It lies on the floor, is too high for its width, or ends where the floor does.
        for (size, height) in [(0.5, 0.0), (0.5, 0.1), (0.1, 0.01), (1.0, 0.01)] {
            assert!(lines(size, height).is_empty(), "{size} {height}");
        }
    }

    #[test]
    fn a_wall_at_the_border_above_the_floor_or_too_short_does_not() {
        for other in [wall(1.0, 0.0, 1.0), wall(0.0, 0.1, 1.0), wall(0.0, 0.0, 0.009), wall(1.5, 0.0, 1.0)] {
            assert!(contact(&other).is_none(), "{other:?}");
        }
    }
}
