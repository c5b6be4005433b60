//! Light at single points, against what is known on paper: Lambert's formula for a polygon, a penumbra
//! that is known exactly, an opening into a room of known brightness, one coloured bounce, the furnace; and final gather.

#[path = "../embree_or_skip/mod.rs"]
mod embree_or_skip;

#[allow(dead_code, reason = "shared with the suite of the solver, which needs all of it")]
#[path = "../solver/boxes.rs"]
mod boxes;
#[allow(dead_code, reason = "shared with the suite of the solver, which needs all of it")]
#[path = "../solver/solving.rs"]
mod solving;
#[allow(dead_code, reason = "shared with the suite of the solver, which needs all of it")]
#[path = "../solver/two_rooms.rs"]
mod two_rooms;

mod asking;
mod final_gather;
mod furnace;
mod lambert;
mod local_pass;
mod near;
mod opening;
mod penumbra;
mod polygon;
mod reflection;
mod slivers;
