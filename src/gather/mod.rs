//! Light at any point, from a solution: interpolated over the elements, or gathered anew at the point
//! itself. \[CW93\]

mod direct;
mod final_gather;
mod hemisphere;
mod interpolate;
mod levels;
mod local_pass;
mod neighbours;
mod parts;
mod point;
mod reconstruct;
mod sources;

pub use final_gather::{FinalGather, VisiblePoint};
pub use local_pass::local_pass;
pub use point::{Gatherer, Irradiance, SAMPLES};
pub use reconstruct::{Outline, Outlines, Reconstruction, Spot};
