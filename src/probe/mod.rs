//! Irradiance at chosen points of a scene: which points, the answers as a table, and how far they are from
//! a reference.

mod grid;
mod lux;
mod points;
mod reference;
mod table;

pub use grid::{Grid, GridError, MOST_POINTS, grid_points};
pub use lux::illuminance;
pub use points::{ProbeError, ProbePoint, read_points};
pub use reference::{Deviation, Reference, check_points, read_reference};
pub use table::{Answer, Comparison, ProbeRun, write_csv};
