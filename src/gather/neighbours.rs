//! Which leaf elements meet each leaf element of a side. The elements of the side are visited from the
//! whole to its parts, and what stays near is handed down, so that every neighbour is looked for once for
//! a part of the side rather than once for every element.

use super::reconstruct::SAME_POINT;
use crate::hierarchy::{Hierarchy, NodeKind};
use crate::math::{Aabb, MAX_VERTICES, Polygon};
use crate::radiosity::{Forest, Piece};
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Elements whose normals differ by less than about 35° are shaded as one smooth surface.
pub(super) const SMOOTH_COSINE: f64 = 0.82;

/// Elements whose normals differ by less than about a degree are parts of one plane.
const FLAT_COSINE: f64 = 0.9998;

/// What lies further than this from an element has no corner in common with it: a corner may be off the
/// element, and the neighbour off its own plane.
const APART: f64 = 3.0 * SAME_POINT;

/// A leaf element that meets another.
pub(super) struct Neighbour {
    pub(super) facet: u32,
    pub(super) polygon: Polygon,
    pub(super) center: DVec3,
    pub(super) irradiance: Vec3,
    /// How much it says about light at its corners: its area in squares of its extent. A sliver runs past so many places
    /// that its mean says little about any of them.
    pub(super) weight: f32,
    pub(super) normal: DVec3,
    /// Unit vectors out of its edges.
    outward: [DVec3; MAX_VERTICES],
}

/// What may hold neighbours of a piece.
#[derive(Clone)]
#[expect(clippy::large_enum_variant, reason = "most are pieces, and faster in place")]
enum Candidate {
    Node(u32),
    Piece(Piece),
}

/// A side whose neighbours are looked for.
pub(super) struct Neighbourhood<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) forest: &'a Forest,
    /// By element.
    pub(super) values: &'a [Vec3],
    /// Of the angle between the normals of neighbours.
    least_cosine: f64,
    /// Handed down from the piece that is visited and those above it.
    candidates: Vec<Candidate>,
    /// How often something was compared with an element: the measure of the work.
    pub(super) compared: u64,
}

impl Neighbour {
    fn new(piece: &Piece, values: &[Vec3]) -> Neighbour {
        let normal = piece.plane.normal;
        let mut outward = [DVec3::ZERO; MAX_VERTICES];
        for (edge, (a, b)) in outward.iter_mut().zip(piece.polygon.edges()) {
            *edge = (b - a).cross(normal).normalize_or_zero();
        }
        Neighbour {
            facet: piece.side.facet,
            polygon: piece.polygon,
            center: piece.polygon.center(),
            irradiance: values[piece.id as usize],
            weight: (piece.polygon.area() / piece.polygon.extent().powi(2).max(f64::MIN_POSITIVE)) as f32,
            normal,
            outward,
        }
    }

    /// Whether a corner lies on the element.
    pub(super) fn meets(&self, corner: DVec3) -> bool {
        let mut edges = self.polygon.vertices().iter().zip(&self.outward);
        (corner - self.center).dot(self.normal).abs() <= SAME_POINT
            && edges.all(|(&a, &outward)| (corner - a).dot(outward) <= SAME_POINT)
    }

    /// Whether one of its edges parts it from a polygon.
    fn is_apart(&self, polygon: &Polygon) -> bool {
        let mut edges = self.polygon.vertices().iter().zip(&self.outward);
        edges.any(|(&a, &outward)| polygon.vertices().iter().all(|&v| (v - a).dot(outward) > APART))
    }
}

impl<'a> Neighbourhood<'a> {
    /// Of what continues a surface smoothly.
    pub(super) fn new(hierarchy: &'a Hierarchy, forest: &'a Forest, values: &'a [Vec3]) -> Neighbourhood<'a> {
        Neighbourhood {
            hierarchy,
            forest,
            values,
            least_cosine: SMOOTH_COSINE,
            candidates: Vec::new(),
            compared: 0,
        }
    }

    /// Of what continues a surface in its plane.
    pub(super) fn in_plane(self) -> Neighbourhood<'a> {
        Neighbourhood { least_cosine: FLAT_COSINE, ..self }
    }

    /// Of everything, at whatever angle it stands.
    pub(super) fn at_any_angle(self) -> Neighbourhood<'a> {
        Neighbourhood { least_cosine: f64::NEG_INFINITY, ..self }
    }

    /// Visits all elements of a side in order; leaves come with all leaf elements that touch their box and
    /// continue their surface, themselves included.
    pub(super) fn visit(&mut self, side: usize, mut element: impl FnMut(&Piece, Option<&[Neighbour]>)) {
        let forest = self.forest;
        self.candidates.clear();
        self.candidates.push(Candidate::Node(0));
        let mut near = Vec::new();
        let mut stack = vec![(forest.root(self.hierarchy, side), 0..1)];
        while let Some((piece, given)) = stack.pop() {
            self.candidates.truncate(given.end);
            if forest.second[piece.id as usize] != 0 {
                element(&piece, None);
                self.hand_down(&piece, given.clone());
                let own = given.end..self.candidates.len();
                let [a, b] = piece.halves(forest);
                stack.push((b, own.clone()));
                stack.push((a, own));
            } else {
                near.clear();
                self.meeting(&piece, given, &mut near);
                element(&piece, Some(&near));
            }
        }
    }

    /// Adds what of the given candidates is near an element, in parts no larger than it.
    fn hand_down(&mut self, piece: &Piece, given: Range<usize>) {
        let bounds = piece.polygon.bounds();
        let radius = bounds.radius();
        let mut stack = Vec::new();
        for index in given {
            self.compared += 1;
            if !self.candidates[index].is_near(piece, &bounds, self.hierarchy) {
                continue;
            }
            stack.push(self.candidates[index].clone());
            while let Some(candidate) = stack.pop() {
                if candidate.bounds(self.hierarchy).radius() <= radius
                    || !self.divide(&candidate, piece, &bounds, &mut stack)
                {
                    self.candidates.push(candidate);
                }
            }
        }
    }

    /// All leaf elements among the given candidates that meet a leaf element.
    fn meeting(&mut self, piece: &Piece, given: Range<usize>, near: &mut Vec<Neighbour>) {
        let bounds = piece.polygon.bounds();
        let mut stack = Vec::new();
        for index in given {
            self.compared += 1;
            if !self.candidates[index].is_near(piece, &bounds, self.hierarchy) {
                continue;
            }
            stack.push(self.candidates[index].clone());
            while let Some(candidate) = stack.pop() {
                if self.divide(&candidate, piece, &bounds, &mut stack) {
                    continue;
                }
                if let Candidate::Piece(other) = &candidate {
                    let neighbour = Neighbour::new(other, self.values);
                    if !neighbour.is_apart(&piece.polygon) {
                        near.push(neighbour);
                    }
                }
            }
        }
    }

    /// Puts the parts of a candidate that are near an element and may continue its surface on the stack,
    /// the first on top; false for a leaf element.
    fn divide(
        &mut self,
        candidate: &Candidate,
        piece: &Piece,
        bounds: &Aabb,
        stack: &mut Vec<Candidate>,
    ) -> bool {
        let (hierarchy, forest, least_cosine) = (self.hierarchy, self.forest, self.least_cosine);
        let mut push = |part: Candidate| {
            self.compared += 1;
            if part.is_near(piece, bounds, hierarchy) {
                stack.push(part);
            }
        };
        match candidate {
            &Candidate::Node(index) => match hierarchy.nodes[index as usize].kind(index) {
                NodeKind::Cluster([a, b]) => [b, a].map(Candidate::Node).into_iter().for_each(push),
                NodeKind::Leaf(facet) => {
                    let roots = forest.sides_of(facet).rev().map(|side| forest.root(hierarchy, side));
                    roots
                        .filter(|root| root.plane.normal.dot(piece.plane.normal) > least_cosine)
                        .map(Candidate::Piece)
                        .for_each(push);
                }
            },
            Candidate::Piece(other) if forest.second[other.id as usize] != 0 => {
                let [a, b] = other.halves(forest);
                push(Candidate::Piece(b));
                push(Candidate::Piece(a));
            }
            Candidate::Piece(_) => return false,
        }
        true
    }
}

impl Candidate {
    /// Whether it may touch an element in this box.
    fn is_near(&self, piece: &Piece, bounds: &Aabb, hierarchy: &Hierarchy) -> bool {
        if !self.bounds(hierarchy).overlaps(*bounds, SAME_POINT as f32) {
            return false;
        }
        let Candidate::Piece(other) = self else { return true };
        let distances = piece.polygon.vertices().iter().map(|&v| other.plane.distance(v));
        let (low, high) =
            distances.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
        low <= APART && high >= -APART
    }

    fn bounds(&self, hierarchy: &Hierarchy) -> Aabb {
        match self {
            &Candidate::Node(index) => hierarchy.nodes[index as usize].bounds,
            Candidate::Piece(piece) => piece.polygon.bounds(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use crate::radiosity::{self, Record, SolveOptions};
    use crate::scene::{ImportCounts, Material, Scene, Triangle};
    use crate::tracer::FallbackTracer;
    use crate::visibility::{Strategy, VisibilityOptions};

    /// The pages of a book that stands open, and a lamp above.
    fn book(pages: u32) -> Scene {
        let mut positions = vec![DVec3::ZERO, DVec3::Z];
        positions.extend((0..pages).map(|i| {
            let (sin, cos) = (f64::from(i) / f64::from(pages) * std::f64::consts::TAU).sin_cos();
            DVec3::new(cos, sin, 0.5)
        }));
        let mut triangles: Vec<Triangle> =
            (0..pages).map(|i| Triangle { vertices: [0, 1, i + 2], material: 0, patch: i }).collect();
        let lamp = positions.len() as u32;
        positions.extend([(-0.3, -0.3), (0.0, 0.3), (0.3, -0.3)].map(|(x, y)| DVec3::new(x, y, 1.5)));
        triangles.push(Triangle { vertices: [lamp, lamp + 1, lamp + 2], material: 1, patch: pages });
        let grey = |reflectance: f32, radiance: f32| Material {
            name: String::new(),
            reflectance: [reflectance; 3],
            radiance: [radiance; 3],
            painting: None,
        };
        Scene {
            name: "book".to_owned(),
            positions,
            triangles,
            materials: vec![grey(0.5, 0.0), grey(0.0, 5.0)],
            rectangles: Vec::new(),
            cameras: Vec::new(),
            meters_per_unit: 1.0,
            patch_count: pages + 1,
            counts: ImportCounts::default(),
            files: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// Elements compared, neighbours that hold a corner of the other, and leaf elements, over all sides of a book.
    fn work(pages: u32) -> [f64; 3] {
        let hierarchy = Hierarchy::build(&book(pages), false, &crate::progress::Silent);
        let options = SolveOptions {
            epsilon: 1e-3,
            contrast: 0.4,
            min_size: Some(0.2),
            resolution: 48.0,
            iterations: 3,
            visibility: VisibilityOptions { strategy: Strategy::Adaptive, rays: 4, certify: false },
            record: Record::Nothing,
        };
        let tracer = FallbackTracer::new(&hierarchy.mesh);
        let solution = radiosity::solve(&hierarchy, &tracer, &options, 1.0, &Silent);
        let (mut found, mut leaves) = (0, 0);
        let mut around = Neighbourhood::new(&hierarchy, &solution.forest, &solution.light.irradiance);
        for side in 0..solution.forest.side_count() {
            around.visit(side, |piece, near| {
                let Some(near) = near else { return };
                let corners = piece.polygon.vertices();
                found += near.iter().filter(|other| corners.iter().any(|&c| other.meets(c))).count();
                leaves += 1;
            });
        }
        [around.compared as f64, found as f64, leaves as f64]
    }

    /// However many surfaces meet at an edge, the work is in proportion to what meets: an element is not
    /// compared with whatever else its box happens to overlap.
    #[test]
    fn work_is_in_proportion_to_what_meets() {
        let [compared, found, leaves] = work(64);
        assert!(leaves > 1000.0, "too coarse to tell: {leaves} elements");
        assert!(compared < 8.5 * found, "{compared} compared for {found} that meet");
    }
}
