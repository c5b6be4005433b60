//! Ray queries: is a segment blocked, by what, and what does a ray hit first. One trait, and behind
//! it Embree, a pure-Rust tracer and an exhaustive f64 referee.
//!
//! **Endpoint rule** (the same for all): a segment is open; it is blocked by a hit further than
//! [`END_MARGIN`] from both ends ([`Segment::open_part`]).
//! **Id rule**: a segment is never blocked by a facet named in its `skip`.
//! **Candidate rule**: a hit on a facet outside the candidates does not count; it is reported to the
//! audit.

mod brute;
mod departure;
pub mod embree;
mod fallback;
mod lanes;
mod triangle;

pub use brute::BruteTracer;
pub use departure::{Departure, departing_hits};
pub use fallback::FallbackTracer;

pub use crate::hierarchy::{Interval, TraceMesh};
use glam::Vec3;

/// No facet: the segment is clear, or the slot of `skip` is not used.
pub const NO_FACET: u32 = u32::MAX;

/// Length at both ends of a segment in which nothing is hit, local units: some roundings.
pub const END_MARGIN: f32 = 2e-6;

/// Most segments in one call of [`Tracer::blockers`].
pub const PACKET: usize = 16;

/// The open segment between two points, usually one on each of two facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Receiver end, local coordinates.
    pub from: Vec3,
    /// Source end.
    pub to: Vec3,
    /// Facets the end points lie on: never a blocker. [`NO_FACET`] when unused.
    pub skip: [u32; 2],
}

impl Segment {
    /// Between which shares of its length a segment is blocked by a hit: the endpoint rule.
    #[inline]
    pub fn open_part(&self) -> [f32; 2] {
        open_part(self.from.distance_squared(self.to))
    }
}

/// See [`Segment::open_part`]: that of a segment whose length has this square.
#[inline]
fn open_part(squared_length: f32) -> [f32; 2] {
    let margin = (END_MARGIN / squared_length.sqrt()).min(0.5);
    [margin, 1.0 - margin]
}

/// Which facets may block.
#[derive(Clone, Copy, Debug)]
pub enum Candidates<'a> {
    /// Every facet of the scene.
    All,
    /// Sorted, disjoint intervals of facet ids.
    Only(&'a [Interval]),
}

impl Candidates<'_> {
    /// Whether `facet` may block.
    #[inline]
    pub fn contains(&self, facet: u32) -> bool {
        match self {
            Candidates::All => true,
            Candidates::Only(list) => {
                let after = list.partition_point(|interval| interval.start <= facet);
                after > 0 && facet < list[after - 1].end
            }
        }
    }
}

/// What the candidate filter saw during one or more calls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FilterAudit {
    /// Hits offered to the filter.
    pub calls: u64,
    /// Hits it rejected (skipped facets and non-candidates).
    pub rejects: u64,
    /// Hits on facets that are neither skipped nor candidates.
    pub outsiders: u64,
    /// Those facets, for the caller to check.
    pub named: Outsiders,
}

/// Some facets, each once: the first ones that were seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outsiders {
    facets: [u32; PACKET],
    count: usize,
}

impl Outsiders {
    /// The facets.
    pub fn facets(&self) -> &[u32] {
        self.facets.get(..self.count).unwrap_or_default()
    }

    fn name(&mut self, facet: u32) {
        if !self.facets().contains(&facet)
            && let Some(free) = self.facets.get_mut(self.count)
        {
            *free = facet;
            self.count += 1;
        }
    }
}

impl FilterAudit {
    /// The rule of the candidate filter for one hit, counted.
    #[inline]
    pub fn accepts(&mut self, facet: u32, skip: [u32; 2], candidates: &Candidates<'_>) -> bool {
        self.calls += 1;
        if facet == skip[0] || facet == skip[1] {
            self.rejects += 1;
            return false;
        }
        if !candidates.contains(facet) {
            self.rejects += 1;
            self.note_outsider(facet);
            return false;
        }
        true
    }

    fn note_outsider(&mut self, facet: u32) {
        self.outsiders += 1;
        self.named.name(facet);
    }
}

/// A ray without end, local coordinates; `direction` need not have unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes.
    pub direction: Vec3,
}

/// The first thing a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Facet id.
    pub facet: u32,
    /// Triangle id in [`TraceMesh::triangles`].
    pub triangle: u32,
    /// Distance in units of the ray's direction, > 0.
    pub t: f32,
}

/// Answers ray queries on one [`TraceMesh`]. Implementations are deterministic and thread-safe.
pub trait Tracer: Send + Sync {
    /// `"embree"`, `"fallback"` or `"brute"`.
    fn name(&self) -> &'static str;

    /// Bytes that it keeps besides the mesh: its tree, and copies that it made. 0 of one that keeps nothing.
    fn bytes(&self) -> u64 {
        0
    }

    /// For each of up to [`PACKET`] segments, a facet that blocks it or [`NO_FACET`].
    ///
    /// `blockers` has the length of `segments`. Which of several blockers is named is up to the
    /// tracer. The audit is added to, never reset.
    ///
    /// # Panics
    /// In debug builds, when there are more than [`PACKET`] segments or the lengths differ.
    fn blockers(
        &self,
        segments: &[Segment],
        candidates: Candidates<'_>,
        blockers: &mut [u32],
        audit: &mut FilterAudit,
    );

    /// For each of up to [`PACKET`] rays its first hit.
    ///
    /// # Panics
    /// In debug builds, when there are more than [`PACKET`] rays or the lengths differ.
    fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]);
}
