//! Facets before they have their place in the tree.

use super::facets::MergedFacet;
use crate::math::{Aabb, Plane};
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

    fn of_each<T: Send>(&self, figure: impl Fn(&MergedFacet) -> T + Sync + Send) -> Vec<T> {
        self.facets.par_iter().map(figure).collect()
    }
}
