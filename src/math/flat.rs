//! Taking convex polygons in one plane away from each other.

use super::{MAX_VERTICES, Plane, Polygon};
use glam::{DVec2, DVec3};

/// Room for the corners of a [`FlatPolygon`].
const MOST_CORNERS: usize = 24;

/// Corners nearer to each other are one: some roundings in double precision.
const SAME: f64 = 1e-12;

/// Two axes in a plane.
#[derive(Clone, Copy, Debug)]
pub struct Axes {
    origin: DVec3,
    axes: [DVec3; 2],
}

impl Axes {
    /// The first axis runs along the first edge of a polygon in the plane; the second is on its left, seen from
    /// the front.
    pub fn along(polygon: &Polygon, plane: &Plane) -> Axes {
        let v = polygon.vertices();
        let along = (v[1] - v[0]).normalize_or(plane.normal.any_orthonormal_vector());
        Axes { origin: v[0], axes: [along, plane.normal.cross(along)] }
    }

    /// Any two axes in a plane.
    pub fn of(plane: &Plane) -> Axes {
        let (along, across) = plane.normal.any_orthonormal_pair();
        Axes { origin: plane.normal * plane.offset, axes: [along, across] }
    }

    /// How another plane shows in this one: its distance from the point at `p` is `a · p + b` with the `(a, b)`
    /// returned.
    pub fn trace(&self, other: &Plane) -> (DVec2, f64) {
        (DVec2::from(self.axes.map(|axis| other.normal.dot(axis))), other.distance(self.origin))
    }

    /// Coordinates of a point.
    pub fn flat(&self, point: DVec3) -> DVec2 {
        let from_origin = point - self.origin;
        DVec2::new(from_origin.dot(self.axes[0]), from_origin.dot(self.axes[1]))
    }

    /// The point in the plane with these coordinates.
    pub fn point(&self, flat: DVec2) -> DVec3 {
        self.origin + self.axes[0] * flat.x + self.axes[1] * flat.y
    }

    /// A polygon in the plane, whichever way it faces.
    pub fn outline(&self, polygon: &Polygon) -> FlatPolygon {
        let mut room = [DVec2::ZERO; MAX_VERTICES];
        let corners = &mut room[..polygon.vertices().len()];
        for (corner, &vertex) in corners.iter_mut().zip(polygon.vertices()) {
            *corner = self.flat(vertex);
        }
        let twice_area: f64 =
            (0..corners.len()).map(|i| corners[i].perp_dot(corners[(i + 1) % corners.len()])).sum();
        if twice_area < 0.0 {
            corners.reverse();
        }
        FlatPolygon::new(corners)
    }
}

/// A convex polygon in a plane, counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub struct FlatPolygon {
    count: usize,
    corners: [DVec2; MOST_CORNERS],
}

impl FlatPolygon {
    /// The polygon with these corners.
    ///
    /// # Panics
    /// With more than 24 corners.
    pub fn new(corners: &[DVec2]) -> FlatPolygon {
        let mut polygon = FlatPolygon { count: corners.len(), corners: [DVec2::ZERO; MOST_CORNERS] };
        polygon.corners[..corners.len()].copy_from_slice(corners);
        polygon
    }

    /// Its corners.
    pub fn corners(&self) -> &[DVec2] {
        &self.corners[..self.count]
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        0.5 * self.edges().map(|(a, b)| a.perp_dot(b)).sum::<f64>()
    }

    fn edges(&self) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
        let corners = self.corners();
        (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]))
    }

    /// The part where `normal · p ≥ offset`; `None` when it reaches no further than `least`.
    pub fn beyond(&self, normal: DVec2, offset: f64, least: f64) -> Option<FlatPolygon> {
        let mut part = FlatPolygon { count: 0, corners: [DVec2::ZERO; MOST_CORNERS] };
        let mut deepest = 0.0f64;
        for (a, b) in self.edges() {
            let (da, db) = (normal.dot(a) - offset, normal.dot(b) - offset);
            deepest = deepest.max(da);
            // All of it is more than the part: nothing is taken away that should not be.
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
        if part.count > 1 && part.corners[0].distance_squared(part.corners[part.count - 1]) < SAME * SAME {
            part.count -= 1;
        }
        (deepest > least && part.count >= 3).then_some(part)
    }

    /// Adds a corner, unless it is the last one: where a cut passes through a corner there would be two.
    fn push(&mut self, corner: DVec2) {
        if self.count == 0 || corner.distance_squared(self.corners[self.count - 1]) >= SAME * SAME {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// Whether no edge of either has the other outside, or less than `depth` inside.
    pub fn overlaps(&self, other: &FlatPolygon, depth: f64) -> bool {
        let is_inside_all = |this: &FlatPolygon, that: &FlatPolygon| {
            this.edges().all(|(a, b)| {
                let outward = (a - b).perp();
                let depth = depth * outward.length();
                // An edge without length has no sides.
                outward.length_squared() < SAME * SAME
                    || that.corners().iter().any(|&corner| outward.dot(corner - a) < -depth)
            })
        };
        is_inside_all(self, other) && is_inside_all(other, self)
    }
}

/// Polygons that are taken away from piece by piece.
#[derive(Clone, Debug)]
pub struct FlatRegion {
    /// What is left.
    pub pieces: Vec<FlatPolygon>,
    next: Vec<FlatPolygon>,
    least: f64,
}

impl FlatRegion {
    /// All of `polygon`; parts that reach no further than `least` over a cut are forgotten.
    pub fn new(polygon: FlatPolygon, least: f64) -> FlatRegion {
        FlatRegion { pieces: vec![polygon], next: Vec::new(), least }
    }

    /// Takes a polygon away; whether anything is left. A polygon without area takes nothing.
    ///
    /// What reaches no further than the least over the line of an edge is forgotten along with it.
    pub fn remove(&mut self, polygon: &FlatPolygon) -> bool {
        if polygon.area() < SAME * SAME {
            return !self.pieces.is_empty();
        }
        self.next.clear();
        for piece in &self.pieces {
            if !polygon.overlaps(piece, 0.0) {
                self.next.push(*piece);
                continue;
            }
            let mut rest = Some(*piece);
            let sides = polygon.edges().filter(|(a, b)| a.distance_squared(*b) >= SAME * SAME);
            for (a, b) in sides {
                let Some(inner) = rest else { break };
                let outward = (a - b).perp().normalize_or_zero();
                self.next.extend(inner.beyond(outward, outward.dot(a), self.least));
                rest = inner.beyond(-outward, -outward.dot(a), self.least);
            }
        }
        std::mem::swap(&mut self.pieces, &mut self.next);
        !self.pieces.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What stands across the plane, or has two corners in one place, has edges without length. It covers nothing.
    #[test]
    fn edges_without_length_take_nothing_away() {
        let square = [(-0.5, 0.0), (0.5, 0.0), (0.5, 0.6), (-0.5, 0.6)].map(DVec2::from);
        let plate = [(-0.2, 0.1), (0.3, 0.1), (0.3, 0.1), (-0.2, 0.1)].map(DVec2::from);
        let sliver = [(0.1, 0.1), (0.1, 0.1), (0.3, 0.4)].map(DVec2::from);
        let mut triangle = [(0.1, 0.1), (0.1, 0.1), (0.3, 0.4), (0.1, 0.4)].map(DVec2::from);
        for _ in 0..4 {
            for (outline, area) in [(&plate[..], 0.6), (&sliver[..], 0.6), (&triangle[..], 0.57)] {
                let mut region = FlatRegion::new(FlatPolygon::new(&square), 2e-6);
                assert!(region.remove(&FlatPolygon::new(outline)));
                let left: f64 = region.pieces.iter().map(FlatPolygon::area).sum();
                assert!((left - area).abs() < 1e-9, "{outline:?}: {left}");
            }
            triangle.rotate_left(1);
        }
    }
}
