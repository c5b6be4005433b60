//! Solutions as files, so that a scene is solved once and looked at many times. `docs/solution-file.md` says byte by
//! byte what they hold.

mod fault;
mod origin;
mod records;
mod sections;
mod solution;

pub use fault::SolutionFileError;
pub use origin::{Origin, Quality};
pub use solution::{SolutionFile, write_solution};
