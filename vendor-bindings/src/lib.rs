//! Embree 4.4 as it is: raw declarations of the functions lightshaft calls, and a loader that
//! opens the shared library at run time. Nothing is linked, so a program runs with or without
//! Embree, and no build needs its headers or libclang.
//!
//! The declarations are checked in (`src/bindings.rs`); feature `bindgen` writes fresh ones from
//! `EMBREE_DIR/include` and uses them instead. They describe the layout of Embree 4.3 and later
//! with instance arrays, which differs from that of 4.2: whoever opens a library must check its
//! version before the first ray.

#[allow(
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    unreachable_pub,
    unsafe_op_in_unsafe_fn,
    clippy::all,
    clippy::undocumented_unsafe_blocks
)]
mod bindings {
    #[cfg(feature = "bindgen")]
    include!(concat!(env!("OUT_DIR"), "/bindings.rs"));
    #[cfg(not(feature = "bindgen"))]
    include!("bindings.rs");
}
mod heap;
mod loader;

pub use bindings::*;
pub use heap::give_back_freed;
pub use loader::{Api, LoadError, open};

/// The id that Embree gives to "nothing".
pub const RTC_INVALID_GEOMETRY_ID: u32 = u32::MAX;
