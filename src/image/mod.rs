//! Views of a solution: pictures, their tone mapping, and their files and videos.

mod camera;
mod descent;
mod exposure;
mod gathered;
mod heat;
mod layers;
mod mesh_view;
pub mod picture;
pub mod read;
mod render;
mod seen;
pub mod tone;
pub mod video;
pub mod write;

pub use exposure::shared_exposure;
pub use heat::{Heat, HeatMap, Legend};
pub use layers::{LayerMaker, Layers, NOTHING};
pub use render::{RenderOptions, Renderer, View, render};
pub use seen::seen;
