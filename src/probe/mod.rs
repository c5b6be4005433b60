//! Irradiance at chosen points of a scene: which points, and how far the answer is from a reference.

mod points;
mod reference;

pub use points::{ProbeError, ProbePoint, read_points};
pub use reference::{Deviation, Reference, read_reference};
