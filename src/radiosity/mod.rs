//! Light: elements, form factors, links, refinement, gathering, push-pull and the solution. \[HSA91\]
//! \[SAG94\] \[Sil95\]
//!
//! Exitance `B` and irradiance `E` are in W/m², radiance in W/(m²·sr), colours linear RGB. Lengths are
//! local (see [`crate::hierarchy::Frame`]); powers become watts when they leave this room.

mod approach;
mod conservation;
mod cuts;
mod display;
mod estimate;
mod fidelity;
mod flight;
mod forest;
mod form_factor;
mod gains;
mod lines;
mod links;
mod openness;
mod place;
mod portion;
mod quarters;
mod refine;
mod reflectance;
mod relight;
mod shading;
mod solve;
mod splits;
mod strays;
mod transport;
mod work;

pub(crate) use transport::intensities;
pub use transport::{Light, direction};

pub use display::DisplayMesh;
pub use fidelity::VisibilityError;
pub use forest::{Forest, Leaf, Piece, Way};
pub use form_factor::{PolygonSource, SourceShape};
pub use gains::Gains;
pub use links::{Link, LinkClass, LinkSet, LinkWork, Spread};
pub use openness::{Arriving, Kept, Openness};
pub use place::place;
pub use quarters::Quarters;
pub use refine::RefineCounters;
pub use reflectance::Reflectance;
pub use relight::{Relit, Reuse, relight};
pub use solve::{Energy, MIN_LOCAL_SIZE, Record, Solution, SolveOptions, solve};
