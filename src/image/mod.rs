//! Views of a solution: the picture, its tone mapping and its files.

pub mod picture;
pub mod tone;
pub mod write;
