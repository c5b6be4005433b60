//! The complete visibility test of a pair of nodes (paper §3, Figure 2) and the strategies that order
//! its steps: facing, inherited class, shaft, single blocker, rays.

mod counters;
mod detail;
mod end;
mod rays;
mod steps;
mod test;
mod worker;

pub use counters::VisibilityCounters;
pub use detail::{Answer, Bin, Detail, Effort, Histogram};
pub use end::NodeEnd;
pub use rays::Sighting;
pub use steps::{Step, StepTimes};
pub use test::{Brightness, CandidateSet, Class, Inheritance, Pair, Tester, Verdict};
pub use worker::Worker;

/// The order of the steps and what may be inherited; the classes they give are the same for the first
/// three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// Every ray tests the whole list of triangles one by one (paper §1.2, first scheme). Slow by
    /// design.
    All,
    /// Every ray traverses the tree from its root (second scheme).
    Root,
    /// A shaft is built and culled first; rays see its candidates only (third scheme, the paper's
    /// method).
    Shaft,
    /// Rays first; a proof only where it will be inherited and matters.
    Adaptive,
    /// Classic hierarchical radiosity (paper §2.1): a sampled fraction at every level, nothing
    /// inherited.
    Sampled,
}

impl Strategy {
    /// The name used on the command line and in statistics.
    pub fn name(self) -> &'static str {
        match self {
            Strategy::All => "all",
            Strategy::Root => "root",
            Strategy::Shaft => "shaft",
            Strategy::Adaptive => "adaptive",
            Strategy::Sampled => "sampled",
        }
    }
}

/// How visibility is decided.
#[derive(Clone, Copy, Debug)]
pub struct VisibilityOptions {
    /// Order of the steps.
    pub strategy: Strategy,
    /// Rays for a pair, 1 to 1024.
    pub rays: u32,
    /// Only proved classes are inherited.
    pub certify: bool,
}
