//! Facets that lie in each other: a box on a table, a sheet on a wall. Both would receive all of the light and
//! send it back, and light would be made. Of what several facets cover one keeps its part, and the others are cut
//! to what is left of them.

use super::TOLERANCE;
use super::facets::{MergedFacet, corners_of};
use super::surfaces::Surfaces;
use super::tree::{Node, NodeKind};
use crate::math::{Axes, FlatPolygon, FlatRegion, Plane, Polygon};
use crate::progress::Progress;
use glam::DVec3;
use rayon::prelude::*;

/// Overlaps less deep are left alone: some roundings, and of no weight.
const LEAST_DEPTH: f64 = 4.0 * TOLERANCE;

/// A facet that would fall into more pieces is left whole.
const MOST_PIECES: usize = 4096;

/// A facet that others cover partly or wholly.
struct Covered {
    facet: usize,
    /// What is left of it.
    pieces: Vec<Vec<DVec3>>,
    /// Facets that cover it.
    by: Vec<usize>,
}

impl Surfaces<'_> {
    /// Leaves what several facets cover to one of them. `nodes` is the tree above the facets, which stand in it in
    /// this `order`. How many were cut or dropped: if any, the tree is to be built anew.
    pub(super) fn part_overlaps(&mut self, nodes: &[Node], order: &[u32], progress: &dyn Progress) -> usize {
        progress.start("overlaps", self.facets.len() as u64);
        let (planes, areas) = (self.planes(), self.areas());
        let found: Vec<Covered> = (0..self.facets.len())
            .into_par_iter()
            .filter_map(|facet| {
                progress.advance(1);
                self.covered(facet, &planes, &areas, nodes, order)
            })
            .collect();
        let pieces: Vec<MergedFacet> = found.iter().flat_map(|covered| self.pieces_of(covered)).collect();
        let mut covered = found.iter().map(|covered| covered.facet).peekable();
        let mut place = 0;
        self.facets.retain(|_| {
            place += 1;
            covered.next_if_eq(&(place - 1)).is_none()
        });
        self.facets.extend(pieces);
        found.len()
    }

    /// New facets for what is left of one.
    fn pieces_of(&mut self, covered: &Covered) -> Vec<MergedFacet> {
        let ends = [covered.facet].into_iter().chain(covered.by.iter().copied());
        let mut known: Vec<u32> = ends.flat_map(|facet| self.facets[facet].corners.iter().copied()).collect();
        let material = self.facets[covered.facet].material;
        let mut pieces = Vec::new();
        for piece in &covered.pieces {
            let mut outline: Vec<u32> =
                piece.iter().map(|&corner| self.corner_at(corner, &mut known)).collect();
            outline.dedup();
            let corners = corners_of(&outline, &self.positions);
            pieces.extend(self.fan(&corners, material));
        }
        pieces
    }

    /// Corners that are there already stay the very same, so that no crack opens.
    fn corner_at(&mut self, point: DVec3, known: &mut Vec<u32>) -> u32 {
        let is_near = |&&v: &&u32| self.positions[v as usize].as_dvec3().distance(point) < 0.5 * TOLERANCE;
        known.iter().find(is_near).copied().unwrap_or_else(|| {
            let corner = self.positions.len() as u32;
            self.positions.push(point.as_vec3());
            known.push(corner);
            corner
        })
    }

    /// What others leave of a facet, if they cover any of it.
    fn covered(
        &self,
        facet: usize,
        planes: &[Plane],
        areas: &[f64],
        nodes: &[Node],
        order: &[u32],
    ) -> Option<Covered> {
        let plane = &planes[facet];
        let polygon = self.facets[facet].polygon(&self.positions);
        let bounds = polygon.bounds();
        let axes = Axes::along(&polygon, plane);
        let outline = axes.outline(&polygon);
        let mut coverers: Vec<(usize, FlatPolygon)> = Vec::new();
        let mut stack = vec![0u32];
        while let Some(index) = stack.pop() {
            let node = &nodes[index as usize];
            if !node.is_near(bounds, plane, TOLERANCE) {
                continue;
            }
            match node.kind(index) {
                NodeKind::Cluster(children) => stack.extend(children),
                NodeKind::Leaf(place) => {
                    let other = order[place as usize] as usize;
                    if other == facet || !self.keeps(other, facet, planes, areas) {
                        continue;
                    }
                    let covering = self.facets[other].polygon(&self.positions);
                    if !lies_in(&covering, plane) || !lies_in(&polygon, &planes[other]) {
                        continue;
                    }
                    let covering = axes.outline(&covering);
                    if outline.overlaps(&covering, LEAST_DEPTH) {
                        coverers.push((other, covering));
                    }
                }
            }
        }
        if coverers.is_empty() {
            return None;
        }
        // The largest first: few pieces, and perhaps none.
        coverers.sort_unstable_by(|(a, _), (b, _)| areas[*b].total_cmp(&areas[*a]).then(a.cmp(b)));
        let mut left = FlatRegion::new(outline, TOLERANCE);
        for (_, covering) in &coverers {
            if !left.remove(covering) {
                return Some(Covered { facet, pieces: Vec::new(), by: Vec::new() });
            }
            if left.pieces.len() > MOST_PIECES {
                return None;
            }
        }
        let pieces = left
            .pieces
            .iter()
            .map(|piece| piece.corners().iter().map(|&c| axes.point(c)).collect())
            .collect();
        Some(Covered { facet, pieces, by: coverers.iter().map(|(other, _)| *other).collect() })
    }

    /// Whether `one` rather than `other` keeps what both cover: what emits, else the larger, else what stands first
    /// in the file.
    fn keeps(&self, one: usize, other: usize, planes: &[Plane], areas: &[f64]) -> bool {
        let faces_away = planes[one].normal.dot(planes[other].normal) < 0.0;
        let [emits, other_emits] =
            [one, other].map(|facet| self.materials[self.facets[facet].material as usize].is_emitter());
        // Back to back, each keeps the side it faces, or its own light.
        if faces_away && (self.one_sided || emits && other_emits) {
            return false;
        }
        let [place, other_place] = [one, other].map(|facet| self.facets[facet].triangles[0]);
        let order =
            emits.cmp(&other_emits).then(areas[one].total_cmp(&areas[other])).then(other_place.cmp(&place));
        order.is_gt()
    }
}

fn lies_in(polygon: &Polygon, plane: &Plane) -> bool {
    polygon.vertices().iter().all(|&v| plane.distance(v).abs() <= TOLERANCE)
}
