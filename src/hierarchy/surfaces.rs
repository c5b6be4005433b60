//! Facets before they have their place in the tree.

use super::facets::MergedFacet;
use crate::math::{Aabb, MAX_VERTICES, Plane};
use crate::scene::Material;
use glam::Vec3;
use rayon::prelude::*;

/// The facets and what they are made of.
pub(super) struct Surfaces<'a> {
    pub(super) facets: Vec<MergedFacet>,
    pub(super) positions: Vec<Vec3>,
    /// Corners of all triangles, indices into `positions`.
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) materials: &'a [Material],
    pub(super) one_sided: bool,
}

impl Surfaces<'_> {
    /// A box around each facet.
    pub(super) fn boxes(&self) -> Vec<Aabb> {
        self.of_each(|facet| {
            let triangles = facet.triangles.iter().flat_map(|&t| self.triangles[t as usize]);
            Aabb::around(triangles.map(|v| self.positions[v as usize]))
        })
    }

    /// The plane of each facet.
    pub(super) fn planes(&self) -> Vec<Plane> {
        self.of_each(|facet| facet.plane(&self.positions))
    }

    /// The area of each facet.
    pub(super) fn areas(&self) -> Vec<f64> {
        self.of_each(|facet| facet.polygon(&self.positions).area())
    }

    /// New facets for a convex outline: parts with no more corners than a facet may have, in a fan around the first.
    pub(super) fn fan(&mut self, outline: &[u32], material: u32) -> Vec<MergedFacet> {
        let mut parts = Vec::new();
        let mut next = 1;
        while next + 1 < outline.len() {
            let last = (next + MAX_VERTICES - 2).min(outline.len() - 1);
            let mut corners = vec![outline[0]];
            corners.extend_from_slice(&outline[next..=last]);
            let first = self.triangles.len() as u32;
            self.triangles.extend((1..corners.len() - 1).map(|i| [corners[0], corners[i], corners[i + 1]]));
            let triangles = (first..self.triangles.len() as u32).collect();
            parts.push(MergedFacet { triangles, corners, material });
            next = last;
        }
        parts
    }

    fn of_each<T: Send>(&self, figure: impl Fn(&MergedFacet) -> T + Sync + Send) -> Vec<T> {
        self.facets.par_iter().map(figure).collect()
    }
}
