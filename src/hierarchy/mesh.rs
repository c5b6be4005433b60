//! The triangles as tracers see them, and the intervals that name parts of them.

use glam::Vec3;

/// The triangles to trace, in local coordinates (recentred, scaled to about one).
///
/// Triangles are ordered by facet and facets in depth-first order of the hierarchy, so that a
/// hierarchy node is one interval of facet ids.
#[derive(Clone, Debug, Default)]
pub struct TraceMesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Indices into `positions`; facet by facet.
    pub triangles: Vec<[u32; 3]>,
    /// First triangle of each facet, with the total number at the end: `facets + 1` entries.
    pub first_triangle: Vec<u32>,
    /// Facet of each triangle.
    pub facet_of_triangle: Vec<u32>,
}

impl TraceMesh {
    /// The triangles of a facet.
    pub fn triangles_of(&self, facet: u32) -> &[[u32; 3]] {
        let first = &self.first_triangle[facet as usize..];
        &self.triangles[first[0] as usize..first[1] as usize]
    }

    /// Where the corners of a triangle are.
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize])
    }
}

/// Facet ids `start..end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Interval {
    /// First id.
    pub start: u32,
    /// One past the last.
    pub end: u32,
}
