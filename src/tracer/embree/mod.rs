//! Embree 4 behind the trait [`Tracer`](super::Tracer): finding the library, checking it before the
//! first ray, and casting packets whose hits are filtered by facet id. All unsafe code of the package
//! is in this room.
//!
//! A library is found with [`EmbreeLibrary::find`], a mesh is handed over with [`EmbreeTracer::new`].
//!
//! The whole mesh is one Embree geometry, and a triangle's facet is looked up in a table. One geometry
//! per facet was measured with 500 000 facets of two triangles: 323 MB instead of 73 MB after the
//! build and 1.4 times its time, with the same rays per second.

mod device;
mod error;
mod filter;
mod library;
mod packet;
mod report;
mod scene;
mod search;
mod selftest;
mod trace;

#[cfg(test)]
mod tests;

pub use error::{Attempt, EmbreeError, Origin, Refusal};
pub use library::{EmbreeLibrary, InstructionSet, TaskSystem, Version};
pub use report::EmbreeReport;
pub use selftest::SelfTest;
pub use trace::EmbreeTracer;

/// How an [`EmbreeTracer`] is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EmbreeOptions {
    /// Threads that Embree may use to build its tree, ≥ 1 (0 counts as 1). Queries run on the caller's.
    pub threads: usize,
    /// Watertight intersection (\[WBW13\]); without it rays may pass between adjacent triangles.
    pub robust: bool,
    /// A smaller tree that is a little slower to traverse.
    pub compact: bool,
}

impl Default for EmbreeOptions {
    /// Every thread of the machine, robust, not compact.
    fn default() -> Self {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        EmbreeOptions { threads, robust: true, compact: false }
    }
}
