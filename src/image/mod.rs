//! Views of a solution: the picture, its tone mapping and its files.

mod camera;
mod interpolate;
mod mesh_view;
pub mod picture;
mod reconstruct;
mod render;
pub mod tone;
pub mod write;

pub use reconstruct::{Reconstruction, Spot};
pub use render::{RenderOptions, View, render};
