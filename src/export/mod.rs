//! Solutions as files, so that a scene is solved once and looked at many times: `docs/solution-file.md` says byte by
//! byte what they hold. And solved scenes as models for other programs and as
//! pages to walk through: `docs/export.md`.

mod fault;
mod glb;
mod lit;
mod origin;
mod palette;
mod ply;
mod records;
mod sections;
mod solution;
mod walk;

pub use fault::SolutionFileError;
pub use glb::write_glb;
pub use lit::{Display, Exported, LitScene};
pub use origin::{Origin, Quality};
pub use ply::write_ply;
pub use solution::{SolutionFile, write_solution};
pub use walk::{WebLibrary, WebLibraryError, write_walk};
