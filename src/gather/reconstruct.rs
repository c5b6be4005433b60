//! Smooth irradiance from piecewise constant elements: a value at every corner, averaged over the
//! elements that meet there by how compact they are, and interpolation in between. Corners of smaller
//! neighbours on an edge (T-vertices) become corners of the larger element too, so no crack shows.

use super::interpolate::mean_value;
use super::local_pass::HIDDEN;
use super::neighbours::{Neighbour, Neighbourhood, SMOOTH_COSINE};
use crate::hierarchy::{Hierarchy, Side, TOLERANCE};
use crate::math::Polygon;
use crate::radiosity::{Forest, Piece, Solution};
use glam::{DVec3, Vec3};
use std::borrow::Cow;
use std::sync::OnceLock;

/// How far apart two corners may lie and still be the same, local units.
pub(super) const SAME_POINT: f64 = 4.0 * TOLERANCE;

/// Outlines of one side's leaf elements with the irradiance at their corners.
#[derive(Debug, Default)]
struct SideMesh {
    /// First corner of each element of the side, leaves and others, with the total at the end.
    first: Vec<u32>,
    points: Vec<DVec3>,
    irradiance: Vec<Vec3>,
}

impl SideMesh {
    /// Irradiance at a point of an element, by its number on the side.
    fn irradiance(&self, local: u32, normal: DVec3, point: DVec3) -> Vec3 {
        let corners = self.first[local as usize] as usize..self.first[local as usize + 1] as usize;
        mean_value(point, normal, &self.points[corners.clone()], |i| self.irradiance[corners.start + i])
    }
}

/// One side as it is shown.
pub(super) struct ShownSide {
    mesh: SideMesh,
    first_element: u32,
}

impl ShownSide {
    /// Irradiance at a point of an element; `normal` is that of the side.
    pub(super) fn irradiance(&self, element: u32, normal: DVec3, point: DVec3) -> Vec3 {
        self.mesh.irradiance(element - self.first_element, normal, point)
    }
}

/// The leaf element at a visible point.
#[derive(Clone, Debug)]
pub struct Spot {
    /// Element id.
    pub element: u32,
    /// Outline of the element.
    pub polygon: Polygon,
    /// Interpolated irradiance, W/m².
    pub irradiance: Vec3,
    side: Side,
    /// The number of the side.
    index: usize,
    normal: DVec3,
}

impl Spot {
    /// Whether a point lies so far inside the element that no rounding gives it to another.
    fn holds(&self, side: Side, point: DVec3) -> bool {
        let is_inside = |(a, b): (DVec3, DVec3)| {
            let along = b - a;
            let area = along.cross(point - a).dot(self.normal);
            area > 0.0 && area * area > along.length_squared() * SAME_POINT * SAME_POINT
        };
        side == self.side && self.polygon.edges().all(is_inside)
    }
}

/// The leaf elements of a side, in the order of their ids, as what lies between corners with light.
#[derive(Debug)]
pub struct Outlines {
    mesh: SideMesh,
    first_element: u32,
}

/// A leaf element with the corners that it has and those that whatever touches it has on its edges.
#[derive(Clone, Copy, Debug)]
pub struct Outline<'a> {
    /// Its id.
    pub element: u32,
    /// Counter-clockwise seen from the side, local coordinates; at least 3.
    pub points: &'a [DVec3],
    /// At each of them, W/m².
    pub irradiance: &'a [Vec3],
}

impl Outlines {
    /// The elements.
    pub fn iter(&self) -> impl Iterator<Item = Outline<'_>> {
        let Outlines { mesh, first_element } = self;
        let ranges = mesh.first.windows(2).map(|ends| ends[0] as usize..ends[1] as usize);
        (*first_element..).zip(ranges).filter(|(_, corners)| !corners.is_empty()).map(|(element, corners)| {
            Outline { element, points: &mesh.points[corners.clone()], irradiance: &mesh.irradiance[corners] }
        })
    }
}

impl Outline<'_> {
    /// The mean of the corners, and the irradiance there, W/m². `normal` is that of the side.
    pub fn center(&self, normal: DVec3) -> (DVec3, Vec3) {
        let center = self.points.iter().sum::<DVec3>() / self.points.len() as f64;
        (center, mean_value(center, normal, self.points, |i| self.irradiance[i]))
    }
}

/// Looks up irradiance anywhere on the surfaces; the work for a side is done when it is first seen.
pub struct Reconstruction<'a> {
    hierarchy: &'a Hierarchy,
    forest: &'a Forest,
    /// Of each leaf element, by element id, W/m².
    irradiance: Cow<'a, [Vec3]>,
    /// What is darker than this share of an element says nothing about its corners.
    hidden: f32,
    sides: Vec<OnceLock<SideMesh>>,
}

impl<'a> Reconstruction<'a> {
    /// As a solution is to be shown: by its elements for display, if it has any. Nothing is computed yet.
    pub fn shown(hierarchy: &'a Hierarchy, solution: &'a Solution) -> Reconstruction<'a> {
        match &solution.display {
            Some(mesh) => Reconstruction::of_display(hierarchy, &mesh.forest, &mesh.irradiance),
            None => Reconstruction::new(hierarchy, solution),
        }
    }

    /// Of elements for display.
    pub(super) fn of_display(
        hierarchy: &'a Hierarchy,
        forest: &'a Forest,
        irradiance: &'a [Vec3],
    ) -> Reconstruction<'a> {
        let shown = Reconstruction::of(hierarchy, forest, Cow::Borrowed(irradiance));
        Reconstruction { hidden: HIDDEN, ..shown }
    }

    /// Of all light of a solution, by the elements that links have; nothing is computed yet.
    pub fn new(hierarchy: &'a Hierarchy, solution: &'a Solution) -> Reconstruction<'a> {
        Reconstruction::of(hierarchy, &solution.forest, Cow::Borrowed(&solution.light.irradiance))
    }

    /// Of any irradiance of leaf elements, by element id.
    pub fn of(
        hierarchy: &'a Hierarchy,
        forest: &'a Forest,
        irradiance: Cow<'a, [Vec3]>,
    ) -> Reconstruction<'a> {
        let sides = (0..forest.side_count()).map(|_| OnceLock::new()).collect();
        Reconstruction { hierarchy, forest, irradiance, hidden: 0.0, sides }
    }

    /// The element at `point` on a side, and its irradiance there; `None` for a side that takes no part.
    pub fn look_up(&self, side: Side, point: DVec3) -> Option<Spot> {
        let forest = self.forest;
        let index = forest.side_index(side)?;
        let piece = forest.leaf_on(self.hierarchy, index, point);
        let (element, normal) = (piece.id, piece.plane.normal);
        let irradiance = self.irradiance_on(element, index, normal, point);
        Some(Spot { element, polygon: piece.polygon, irradiance, side, index, normal })
    }

    /// The same as [`Reconstruction::look_up`] with `recent` for what was found before: much quicker when the point lies on
    /// the same element.
    pub fn look_up_near<'s>(
        &self,
        recent: &'s mut Option<Spot>,
        side: Side,
        point: DVec3,
    ) -> Option<&'s Spot> {
        match recent {
            Some(spot) if spot.holds(side, point) => {
                spot.irradiance = self.irradiance_on(spot.element, spot.index, spot.normal, point);
            }
            _ => *recent = self.look_up(side, point),
        }
        recent.as_ref()
    }

    /// The leaf elements of the side with this number; nothing of it is kept. Where elements meet, at whatever angle, their
    /// corners are the very same points.
    pub fn outlines(&self, index: usize) -> Outlines {
        let mut mesh = SideMesh::default();
        self.around().at_any_angle().visit(index, |piece, near| {
            mesh.first.push(mesh.points.len() as u32);
            let Some(near) = near else { return };
            let is_smooth = |other: &&Neighbour| other.normal.dot(piece.plane.normal) > SMOOTH_COSINE;
            let corners: Vec<(DVec3, Vec3)> = outline(&piece.polygon, near.iter().filter(is_smooth))
                .map(|corner| (corner, self.corner_value(corner, piece, near.iter().filter(is_smooth))))
                .collect();
            for (i, &(a, value)) in corners.iter().enumerate() {
                let (b, next) = corners[(i + 1) % corners.len()];
                mesh.points.push(shared(a, near));
                mesh.irradiance.push(value);
                // In between light is interpolated, as it is in pictures.
                for (t, corner) in on_edge(a, b, near.iter()) {
                    mesh.points.push(shared(corner, near));
                    mesh.irradiance.push(value.lerp(next, t as f32));
                }
            }
        });
        mesh.first.push(mesh.points.len() as u32);
        Outlines { mesh, first_element: self.forest.first_element[index] }
    }

    /// The side with this number as it is shown but for what is smoothed over from other planes; nothing of it is kept.
    pub(super) fn flat_side(&self, index: usize) -> ShownSide {
        ShownSide {
            mesh: self.mesh_of(index, self.around().in_plane()),
            first_element: self.forest.first_element[index],
        }
    }

    /// Irradiance at a point of an element on the side with this number.
    fn irradiance_on(&self, element: u32, index: usize, normal: DVec3, point: DVec3) -> Vec3 {
        let mesh = self.sides[index].get_or_init(|| self.mesh_of(index, self.around()));
        mesh.irradiance(element - self.forest.first_element[index], normal, point)
    }

    /// What continues a surface smoothly.
    fn around(&self) -> Neighbourhood<'_> {
        Neighbourhood::new(self.hierarchy, self.forest, &self.irradiance)
    }

    fn mesh_of(&self, index: usize, mut around: Neighbourhood<'_>) -> SideMesh {
        let mut mesh = SideMesh::default();
        around.visit(index, |piece, near| {
            mesh.first.push(mesh.points.len() as u32);
            let Some(near) = near else { return };
            for corner in outline(&piece.polygon, near.iter()) {
                mesh.irradiance.push(self.corner_value(corner, piece, near.iter()));
                mesh.points.push(corner);
            }
        });
        mesh.first.push(mesh.points.len() as u32);
        mesh
    }

    /// Mean irradiance of the elements that meet at a corner, slivers counting less.
    fn corner_value<'n>(
        &self,
        corner: DVec3,
        piece: &Piece,
        near: impl Iterator<Item = &'n Neighbour>,
    ) -> Vec3 {
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
        let hidden = self.hidden * self.irradiance[piece.id as usize].element_sum();
        for other in near {
            let is_parted = || other.facet == piece.side.facet && self.is_parted(piece, other);
            if other.irradiance.element_sum() >= hidden && other.meets(corner) && !is_parted() {
                sum += other.irradiance * other.weight;
                weights += other.weight;
            }
        }
        if weights > 0.0 { sum / weights } else { self.irradiance[piece.id as usize] }
    }

    /// Whether something stands on the facet between two of its elements, or covers one of them.
    fn is_parted(&self, piece: &Piece, other: &Neighbour) -> bool {
        let (from, to, normal) = (piece.polygon.center(), other.center, piece.plane.normal);
        let side = |a: DVec3, b: DVec3, point: DVec3| (b - a).cross(point - a).dot(normal) > 0.0;
        self.hierarchy
            .contacts
            .on_side(piece.side)
            .any(|&[a, b]| side(a, b, from) != side(a, b, to) && side(from, to, a) != side(from, to, b))
    }
}

/// The corners of an element and those of its neighbours on its edges, in order.
fn outline<'n>(
    polygon: &Polygon,
    near: impl Iterator<Item = &'n Neighbour> + Clone,
) -> impl Iterator<Item = DVec3> {
    polygon.edges().flat_map(move |(a, b)| {
        let between = on_edge(a, b, near.clone());
        std::iter::once(a).chain(between.into_iter().map(|(_, corner)| corner))
    })
}

/// The corners of neighbours between two points, in order, each with the part of the way at which it lies.
fn on_edge<'n>(a: DVec3, b: DVec3, near: impl Iterator<Item = &'n Neighbour>) -> Vec<(f64, DVec3)> {
    let along = b - a;
    let length_squared = along.length_squared();
    let mut between: Vec<(f64, DVec3)> = near
        .flat_map(|n| n.polygon.vertices())
        .filter_map(|&v| {
            let t = (v - a).dot(along) / length_squared;
            let off = (v - a - along * t).length_squared();
            let apart = SAME_POINT * SAME_POINT;
            let inner = t * t * length_squared > apart && (1.0 - t) * (1.0 - t) * length_squared > apart;
            (off <= apart && t > 0.0 && t < 1.0 && inner).then_some((t, v))
        })
        .collect();
    between.sort_by(|x, y| x.0.total_cmp(&y.0));
    between.dedup_by(|x, y| (x.0 - y.0) * (x.0 - y.0) * length_squared <= SAME_POINT * SAME_POINT);
    between
}

/// Of the corners that are the same as this one, that which all of their elements choose.
fn shared(corner: DVec3, near: &[Neighbour]) -> DVec3 {
    let order = |a: &DVec3, b: &DVec3| {
        a.x.total_cmp(&b.x).then_with(|| a.y.total_cmp(&b.y)).then_with(|| a.z.total_cmp(&b.z))
    };
    let same = near.iter().flat_map(|other| other.polygon.vertices()).copied();
    let same = same.filter(|&v| v.distance_squared(corner) <= SAME_POINT * SAME_POINT);
    same.min_by(order).unwrap_or(corner)
}
