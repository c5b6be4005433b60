//! Light at any point, from a solution: interpolated over the elements, or gathered anew at the point
//! itself. \[CW93\]

mod direct;
mod hemisphere;
mod interpolate;
mod neighbours;
mod point;
mod reconstruct;

pub use point::{Gatherer, Irradiance, SAMPLES};
pub use reconstruct::{Reconstruction, Spot};
