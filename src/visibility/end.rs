//! The two nodes of a pair, as visibility sees them.

use crate::hierarchy::{Hierarchy, TOLERANCE};
use crate::math::{Plane, Polygon, PolygonSampler};
use crate::shaft::{End, Occupant};
use glam::DVec3;

/// A node of a pair.
#[derive(Clone, Copy, Debug)]
pub enum NodeEnd<'a> {
    /// An element: a piece of one side of a facet.
    Element {
        /// Its outline, counter-clockwise from the side that exchanges light.
        polygon: &'a Polygon,
        /// Its plane; the front exchanges light.
        plane: Plane,
        /// The facet it lies on.
        facet: u32,
    },
    /// A cluster, by node id.
    Cluster(u32),
}

impl NodeEnd<'_> {
    /// The end of a shaft.
    pub fn shaft_end(&self, hierarchy: &Hierarchy) -> End<'_> {
        match self {
            NodeEnd::Element { polygon, plane, .. } => End::Polygon(polygon, *plane),
            NodeEnd::Cluster(node) => End::Box(hierarchy.nodes[*node as usize].bounds),
        }
    }

    /// As the walls of rooms see it; `corners` are those of [`NodeEnd::shaft_end`].
    pub(super) fn occupant<'c>(&self, hierarchy: &Hierarchy, corners: &'c [DVec3]) -> Occupant<'c> {
        match self {
            NodeEnd::Element { plane, facet, .. } => {
                Occupant { corners, node: hierarchy.leaf(*facet), side: Some(*plane) }
            }
            NodeEnd::Cluster(node) => Occupant { corners, node: *node, side: None },
        }
    }

    /// Its middle.
    pub fn center(&self, hierarchy: &Hierarchy) -> DVec3 {
        match self {
            NodeEnd::Element { polygon, .. } => polygon.center(),
            NodeEnd::Cluster(node) => hierarchy.nodes[*node as usize].center.as_dvec3(),
        }
    }

    /// Radius of a sphere around it.
    pub(super) fn radius(&self, hierarchy: &Hierarchy) -> f64 {
        match self {
            NodeEnd::Element { polygon, .. } => polygon.extent() * 0.5,
            NodeEnd::Cluster(node) => hierarchy.nodes[*node as usize].bounds.radius(),
        }
    }

    /// For points on it.
    pub(super) fn sampler(&self) -> EndSampler<'_> {
        match self {
            NodeEnd::Element { polygon, facet, .. } => EndSampler::Element(polygon.sampler(), *facet),
            NodeEnd::Cluster(node) => EndSampler::Cluster(*node),
        }
    }

    /// Height of `other` above the side of `facet` that exchanges light: not positive when none can
    /// pass. A point in the plane of the facet, but for rounding, exchanges none.
    pub fn height(&self, hierarchy: &Hierarchy, facet: u32, other: DVec3) -> f64 {
        let height = match self {
            NodeEnd::Element { plane, .. } => plane.distance(other),
            NodeEnd::Cluster(_) => {
                let height = hierarchy.facets[facet as usize].plane.distance(other);
                if hierarchy.one_sided { height } else { height.abs() }
            }
        };
        if height > TOLERANCE { height } else { 0.0 }
    }

    /// Whether the side of `facet` that `other` sees is its front.
    pub(super) fn is_front(&self, hierarchy: &Hierarchy, facet: u32, other: DVec3) -> bool {
        hierarchy.facets[facet as usize].plane.distance(other) > 0.0
    }
}

/// Maps the unit square to the surfaces of a node.
pub(super) enum EndSampler<'a> {
    Element(PolygonSampler<'a>, u32),
    Cluster(u32),
}

impl EndSampler<'_> {
    /// The point at `(u, v)` of the unit square, uniform over the area, and its facet.
    pub(super) fn point_at(&self, hierarchy: &Hierarchy, u: f64, v: f64) -> (DVec3, u32) {
        match self {
            EndSampler::Element(sampler, facet) => (sampler.point_at(u, v), *facet),
            EndSampler::Cluster(node) => {
                let (facet, u) = hierarchy.facet_at(*node, u);
                (hierarchy.point_on(facet, u, v), facet)
            }
        }
    }
}
