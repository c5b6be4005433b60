//! Views of a solution: the picture, its tone mapping and its files.

mod camera;
mod descent;
mod gathered;
mod heat;
mod mesh_view;
pub mod picture;
pub mod read;
mod render;
mod seen;
pub mod tone;
pub mod write;

pub use heat::{Heat, HeatMap, Legend};
pub use render::{RenderOptions, View, render, render_heat};
pub use seen::seen;
