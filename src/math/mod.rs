//! Geometry that knows nothing of light: boxes, planes, convex polygons, clipping, sample sequences,
//! curves through points, spherical harmonics and the curve of sRGB. Proofs are computed in double precision.

mod bounds;
mod clip;
mod curve;
mod flat;
mod plane;
mod polygon;
mod sequence;
mod spherical;
mod srgb;

pub use bounds::Aabb;
pub use clip::Clip;
pub use curve::Curve;
pub use flat::{Axes, FlatPolygon, FlatRegion};
pub use plane::Plane;
pub use polygon::{MAX_VERTICES, Polygon, PolygonSampler};
pub use sequence::{PairSequence, cosine_direction, golden_fraction, hash_pair};
pub use spherical::{CosineLobes, axial_parts};
pub use srgb::{linear_from_srgb, srgb_from_linear};
