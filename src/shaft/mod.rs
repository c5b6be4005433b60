//! Shafts: convex regions that hold every segment between two nodes. What lies outside cannot block;
//! when nothing is left inside, the nodes see each other fully, and that is proved. \[HW91\]

mod blocker;
mod build;
mod cull;
mod enclosure;
mod fusion;
#[cfg(test)]
mod planted;
mod search;

pub use blocker::{blocks_all, has_facet_in};
pub use build::{End, Shaft};
pub use cull::{Culled, Placement, intervals_of};
pub use enclosure::{Occupant, walls_hide};
pub use fusion::blocks_together;
pub use search::{MOST_FOUND, large_facets_on};
