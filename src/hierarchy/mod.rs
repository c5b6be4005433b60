//! The hierarchy of bounding boxes (HBB): coplanar triangles are merged into convex facets, facets
//! are gathered into clusters, and both are numbered in depth-first order, so that **every node is
//! one interval of facet ids**. \[GH96\]

mod cells;
mod contacts;
mod facets;
mod fingerprint;
mod frame;
mod gaps;
mod mesh;
mod overlaps;
mod rooms;
mod surfaces;
mod tree;

pub(crate) use cells::is_behind;
pub use cells::{Cell, Wall};
pub(crate) use contacts::within;
pub use contacts::{Contact, Contacts};
pub use facets::{Facet, Side};
pub use fingerprint::Fingerprint;
pub use frame::Frame;
pub(crate) use gaps::Effort;
pub use mesh::{Interval, TraceMesh};
pub use tree::{Node, NodeKind};

use crate::math::{MAX_VERTICES, Polygon, PolygonSampler};
use crate::progress::Progress;
use crate::scene::{Material, Scene};
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

/// Distances below this are rounding, in local coordinates (the scene spans about −1 to 1).
pub const TOLERANCE: f64 = 2e-6;

/// The scene as the solver sees it: local coordinates, facets in depth-first order, the tree above.
#[derive(Debug)]
pub struct Hierarchy {
    /// From scene units to local coordinates and back.
    pub frame: Frame,
    /// Triangles by facet.
    pub mesh: TraceMesh,
    /// Facets in depth-first order.
    pub facets: Vec<Facet>,
    /// Corners of all facets, indices into `mesh.positions`.
    corners: Vec<u32>,
    /// Nodes in depth-first order; the root is node 0.
    pub nodes: Vec<Node>,
    /// Rooms and the walls around them, ascending by node.
    cells: Vec<Cell>,
    /// Whether each node is within the walls of a cell.
    within: Vec<bool>,
    /// Materials of the scene.
    pub materials: Vec<Material>,
    /// How many facets lay partly or wholly in others, and were cut to what those leave or dropped.
    pub covered_facets: usize,
    /// Where other surfaces stand on large facets or cover them.
    pub contacts: Contacts,
    /// Whether surfaces reflect on their front side only.
    pub one_sided: bool,
    /// First node of each facet's leaf.
    leaf_of_facet: Vec<u32>,
    /// The cluster that each node is a child of; the root names itself.
    parents: Vec<u32>,
    /// Area of one side of all facets before each, and of all of them, local units.
    area_before: Vec<f64>,
}

impl Hierarchy {
    /// Merges, sorts and numbers the triangles of a scene.
    ///
    /// With `one_sided`, backs neither reflect nor receive light; they still block it.
    pub fn build(scene: &Scene, one_sided: bool, progress: &dyn Progress) -> Hierarchy {
        let frame = Frame::around(&scene.positions);
        let positions: Vec<Vec3> = scene.positions.iter().map(|&p| frame.local_from_scene(p)).collect();
        let merged = facets::merge(&positions, &scene.triangles, progress);
        let triangles = scene.triangles.iter().map(|triangle| triangle.vertices).collect();
        let mut surfaces = surfaces::Surfaces {
            facets: merged,
            positions,
            triangles,
            materials: &scene.materials,
            one_sided,
        };
        let mut tree = tree::build(&mut surfaces);
        let covered_facets = surfaces.part_overlaps(&tree.nodes, &tree.order, progress);
        if covered_facets > 0 {
            tree = tree::build(&mut surfaces);
        }
        let tree::Tree { nodes, order, enclosures } = tree;
        let surfaces::Surfaces { facets: merged, positions, triangles, .. } = surfaces;

        let mut mesh = TraceMesh { positions, first_triangle: vec![0], ..TraceMesh::default() };
        let mut sorted = Vec::with_capacity(merged.len());
        let mut corners = Vec::new();
        for (id, &old) in order.iter().enumerate() {
            let facet = &merged[old as usize];
            for &t in &facet.triangles {
                mesh.triangles.push(triangles[t as usize]);
                mesh.facet_of_triangle.push(id as u32);
            }
            mesh.first_triangle.push(mesh.triangles.len() as u32);
            sorted.push(Facet::new(facet, corners.len() as u32, &mesh.positions));
            corners.extend_from_slice(&facet.corners);
        }
        let (mut leaf_of_facet, mut parents) = (vec![0; sorted.len()], vec![0; nodes.len()]);
        for (index, node) in (0..).zip(&nodes) {
            match node.kind(index) {
                NodeKind::Leaf(facet) => leaf_of_facet[facet as usize] = index,
                NodeKind::Cluster(children) => {
                    children.into_iter().for_each(|child| parents[child as usize] = index);
                }
            }
        }
        let mut hierarchy = Hierarchy {
            frame,
            mesh,
            facets: sorted,
            corners,
            nodes,
            cells: Vec::new(),
            within: Vec::new(),
            materials: scene.materials.clone(),
            covered_facets,
            contacts: Contacts::default(),
            one_sided,
            leaf_of_facet,
            parents,
            area_before: Vec::new(),
        };
        hierarchy.measure_nodes();
        hierarchy.measure_cells(&enclosures);
        hierarchy.contacts = Contacts::of(&hierarchy, progress);
        hierarchy
    }

    /// The polygon of a facet, counter-clockwise from its front.
    pub fn polygon(&self, facet: u32) -> Polygon {
        let mut points = [DVec3::ZERO; MAX_VERTICES];
        Polygon::new(self.corners_of(facet, &mut points))
    }

    /// The point of a facet at `(u, v)` of the unit square, uniform over its area: as of its polygon, but faster.
    pub fn point_on(&self, facet: u32, u: f64, v: f64) -> DVec3 {
        let mut points = [DVec3::ZERO; MAX_VERTICES];
        PolygonSampler::new(self.corners_of(facet, &mut points)).point_at(u, v)
    }

    fn corners_of<'a>(&self, facet: u32, points: &'a mut [DVec3; MAX_VERTICES]) -> &'a [DVec3] {
        let f = &self.facets[facet as usize];
        let corners = &self.corners[f.first_corner as usize..(f.first_corner + f.corner_count) as usize];
        for (point, &c) in points.iter_mut().zip(corners) {
            *point = self.mesh.positions[c as usize].as_dvec3();
        }
        &points[..corners.len()]
    }

    /// Material of a facet.
    pub fn material(&self, facet: u32) -> &Material {
        &self.materials[self.facets[facet as usize].material as usize]
    }

    /// What a facet reflects at a point of it, local coordinates, per channel.
    pub fn reflectance_at(&self, facet: u32, point: DVec3) -> Vec3 {
        Vec3::from(self.material(facet).reflectance_at(self.frame.scene_from_local(point)))
    }

    /// Whether what some facets reflect differs from point to point.
    pub fn has_paintings(&self) -> bool {
        self.materials.iter().any(|material| material.painting.is_some())
    }

    /// What a part of a facet reflects as a whole, local coordinates, per channel.
    pub fn mean_reflectance(&self, facet: u32, part: &Polygon) -> Vec3 {
        let material = self.material(facet);
        let Some(painting) = &material.painting else { return Vec3::from(material.reflectance) };
        let mut corners = [DVec3::ZERO; MAX_VERTICES];
        let count = part.vertices().len();
        for (corner, &vertex) in corners.iter_mut().zip(part.vertices()) {
            *corner = self.frame.scene_from_local(vertex);
        }
        Vec3::from(painting.mean_reflectance(&corners[..count]))
    }

    /// The side of a facet that a ray with this direction meets.
    pub fn side_met(&self, facet: u32, direction: Vec3) -> Side {
        let normal = self.facets[facet as usize].plane.normal;
        Side { facet, back: normal.dot(direction.as_dvec3()) > 0.0 }
    }

    /// Outline of a side, counter-clockwise from where it is lit.
    pub fn side_polygon(&self, side: Side) -> Polygon {
        let polygon = self.polygon(side.facet);
        if side.back { polygon.flipped() } else { polygon }
    }

    /// Unit normal of a side, away from its surface.
    pub fn side_normal(&self, side: Side) -> DVec3 {
        let normal = self.facets[side.facet as usize].plane.normal;
        if side.back { -normal } else { normal }
    }

    /// Exitance of a side by itself, W/m².
    pub fn emitted(&self, side: Side) -> Vec3 {
        if side.back { Vec3::ZERO } else { Vec3::from(self.material(side.facet).radiance) * PI }
    }

    /// The leaf that holds a facet.
    pub fn leaf(&self, facet: u32) -> u32 {
        self.leaf_of_facet[facet as usize]
    }

    /// The cluster that a node is a child of; `None` for the root.
    pub fn parent(&self, node: u32) -> Option<u32> {
        (node != 0).then(|| self.parents[node as usize])
    }

    /// A node and all clusters that hold it, upwards.
    pub fn lineage(&self, node: u32) -> impl Iterator<Item = u32> + '_ {
        std::iter::successors(Some(node), |&node| self.parent(node))
    }

    /// The facet below a node at a share of the node's area, in the order of the facets, and what is left of the share
    /// within it: a uniform number becomes a facet by area and another uniform number. Shares from 0 to 1.
    pub fn facet_at(&self, node: u32, share: f64) -> (u32, f64) {
        let Node { first, end, .. } = self.nodes[node as usize];
        let before = &self.area_before[first as usize..=end as usize];
        let (begin, last) = (before[0], before.len() - 1);
        let target = begin + share * (before[last] - begin);
        let at = before[1..last].partition_point(|&area| area <= target);
        let own = before[at + 1] - before[at];
        let left = if own > 0.0 { ((target - before[at]) / own).clamp(0.0, 1.0) } else { 0.5 };
        (first + at as u32, left)
    }

    /// How many sides of each facet take part in the exchange of light: 1 or 2.
    pub fn sides(&self) -> u32 {
        if self.one_sided { 1 } else { 2 }
    }

    /// Number of clusters: inner nodes.
    pub fn cluster_count(&self) -> usize {
        self.nodes.len() - self.facets.len()
    }

    /// All clusters by node id, ascending.
    pub fn clusters(&self) -> impl DoubleEndedIterator<Item = u32> + '_ {
        (0..self.nodes.len() as u32).filter(|&node| !self.nodes[node as usize].is_leaf())
    }

    /// The place of a cluster among all [`clusters`](Self::clusters).
    #[inline]
    pub fn cluster_place(&self, cluster: u32) -> usize {
        debug_assert!(!self.nodes[cluster as usize].is_leaf());
        // The leaves before it in depth-first order are the facets before its first.
        (cluster - self.nodes[cluster as usize].first) as usize
    }

    /// Adds to each of `sums`, by the places of clusters, the sums of its two children; that of a leaf is what `of_facet`
    /// says.
    pub fn sum_up<T: Copy>(&self, sums: &mut [T], of_facet: impl Fn(u32) -> T, add: impl Fn(&mut T, &T)) {
        for cluster in self.clusters().rev() {
            for child in self.nodes[cluster as usize].children(cluster) {
                let below = match self.nodes[child as usize].kind(child) {
                    NodeKind::Leaf(facet) => of_facet(facet),
                    NodeKind::Cluster(_) => sums[self.cluster_place(child)],
                };
                add(&mut sums[self.cluster_place(cluster)], &below);
            }
        }
    }

    /// Watts per unit of exitance and local area: square metres in one local unit of area.
    pub fn square_meters_per_unit(&self, meters_per_unit: f64) -> f64 {
        (self.frame.scene_units_per_local() * meters_per_unit).powi(2)
    }

    /// Fills in area and centre of every node, from the leaves up, and the sums of areas.
    fn measure_nodes(&mut self) {
        self.area_before = vec![0.0; self.facets.len() + 1];
        for index in (0..self.nodes.len()).rev() {
            let node = self.nodes[index];
            let (area, moment) = if node.is_leaf() {
                let polygon = self.polygon(node.first);
                let area = polygon.area();
                self.area_before[node.end as usize] = area;
                (area, polygon.center() * area)
            } else {
                let [a, b] = self.nodes[index].children(index as u32).map(|c| &self.nodes[c as usize]);
                let (area_a, area_b) = (a.area as f64, b.area as f64);
                (area_a + area_b, a.center.as_dvec3() * area_a + b.center.as_dvec3() * area_b)
            };
            let node = &mut self.nodes[index];
            node.area = area as f32;
            node.center = if area > 0.0 { (moment / area).as_vec3() } else { node.bounds.center().as_vec3() };
        }
        for facet in 0..self.facets.len() {
            self.area_before[facet + 1] += self.area_before[facet];
        }
    }

    /// Checks the invariants of the tree; for tests and debug builds.
    ///
    /// # Errors
    /// Says which node breaks which rule.
    pub fn validate(&self) -> Result<(), String> {
        let mut seen = 0;
        for (index, node) in self.nodes.iter().enumerate() {
            if node.is_leaf() {
                if node.first != seen {
                    return Err(format!("leaf {index} holds facet {} instead of {seen}", node.first));
                }
                seen += 1;
                let polygon = self.polygon(node.first);
                if polygon.vertices().iter().any(|&v| !node.bounds.contains(v, 0.0)) {
                    return Err(format!("facet {} leaves its box", node.first));
                }
            } else {
                let [a, b] = node.children(index as u32).map(|c| &self.nodes[c as usize]);
                if a.first != node.first || a.end != b.first || b.end != node.end {
                    return Err(format!("node {index} is not the interval of its children"));
                }
                if a.bounds.union(b.bounds) != node.bounds {
                    return Err(format!("node {index} does not bound its children"));
                }
                let children = node.children(index as u32);
                if children.iter().any(|&child| self.parent(child) != Some(index as u32)) {
                    return Err(format!("node {index} is not the parent of its children"));
                }
            }
        }
        if seen as usize != self.facets.len() {
            return Err(format!("{seen} leaves for {} facets", self.facets.len()));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use crate::scene::{ImportCounts, Triangle};

    /// Triangles side by side in a plane, from tiny to large.
    fn row() -> Scene {
        let corners = |i: u32| {
            let (x, size) = (f64::from(i) * 20.0, f64::from(1 + i * i));
            [(0.0, 0.0), (size / 20.0, 0.0), (0.0, 4.0)].map(|(a, b)| DVec3::new(x + a, b, f64::from(i % 3)))
        };
        let material =
            Material { name: String::new(), reflectance: [0.5; 3], radiance: [1.0; 3], painting: None };
        Scene {
            name: "row".to_owned(),
            positions: (0..20).flat_map(corners).collect(),
            triangles: (0..20)
                .map(|i| Triangle { vertices: [3 * i, 3 * i + 1, 3 * i + 2], material: 0, patch: i })
                .collect(),
            materials: vec![material],
            rectangles: Vec::new(),
            cameras: Vec::new(),
            meters_per_unit: 1.0,
            patch_count: 20,
            counts: ImportCounts::default(),
            files: Vec::new(),
            warnings: Vec::new(),
        }
    }

    #[test]
    fn shares_of_a_node_fall_on_its_facets_by_area() {
        let hierarchy = Hierarchy::build(&row(), false, &Silent);
        for node in 0..hierarchy.nodes.len() as u32 {
            let Node { first, end, area, .. } = hierarchy.nodes[node as usize];
            let (count, mut sums) = (10_000, vec![(0u32, 0.0); hierarchy.facets.len()]);
            for i in 0..count {
                let (facet, left) = hierarchy.facet_at(node, (f64::from(i) + 0.5) / f64::from(count));
                assert!((first..end).contains(&facet) && (0.0..=1.0).contains(&left), "{facet} {left}");
                sums[facet as usize].0 += 1;
                sums[facet as usize].1 += left;
            }
            for facet in first..end {
                let (found, left) = sums[facet as usize];
                let wanted = hierarchy.polygon(facet).area() / f64::from(area) * f64::from(count);
                assert!(
                    (f64::from(found) - wanted).abs() < 2.0,
                    "node {node}: {found} on {facet}, not {wanted}"
                );
                assert!((left / f64::from(found) - 0.5).abs() < 0.6 / f64::from(found), "{left} of {found}");
            }
        }
        for share in [0.0, 1.0] {
            let (facet, left) = hierarchy.facet_at(0, share);
            assert!(
                left == share && facet == if share == 0.0 { 0 } else { hierarchy.facets.len() as u32 - 1 }
            );
        }
    }

    #[test]
    fn points_on_a_facet_are_those_of_its_polygon() {
        let hierarchy = Hierarchy::build(&row(), false, &Silent);
        for facet in 0..hierarchy.facets.len() as u32 {
            for (u, v) in [(0.0, 0.0), (0.3, 0.7), (1.0, 1.0)] {
                assert_eq!(hierarchy.point_on(facet, u, v), hierarchy.polygon(facet).point_at(u, v));
            }
        }
    }
}
