//! Diffuse global illumination by hierarchical radiosity with clustering, where visibility is
//! proved by shafts first and decided by rays (Embree 4, or a pure-Rust tracer) only where no
//! proof is found.
//!
//! Data flows one way through the rooms below; a room uses only the rooms above it:
//!
//! ```text
//! progress → unfinished → memory → math → scene → hierarchy → shaft → tracer → visibility → radiosity → gather
//!     → image → export → probe → check → compare → report → cli
//! ```

// Some tests share code with those outside, where the crate has this name.
#[cfg(test)]
extern crate self as lightshaft;

pub mod progress;

pub mod check;
pub mod cli;
pub mod compare;
pub mod export;
pub mod gather;
pub mod hierarchy;
pub mod image;
pub mod math;
pub mod memory;
pub mod probe;
pub mod radiosity;
pub mod report;
pub mod scene;
pub mod shaft;
pub mod tracer;
pub mod unfinished;
pub mod visibility;
