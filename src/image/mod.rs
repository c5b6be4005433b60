//! Views of a solution: the picture, its tone mapping and its files.

mod camera;
mod mesh_view;
pub mod picture;
mod render;
pub mod tone;
pub mod write;

pub use render::{RenderOptions, View, render};
