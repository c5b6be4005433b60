//! The solver as a whole, against what is known on paper and against itself: strategies and tracers
//! agree, light is conserved, pairs are covered once, proofs hold, threads do not matter. Every check
//! is also shown a planted fault that it has to notice.
//!
//! Tests that need Embree say so and are skipped without it; `LIGHTSHAFT_REQUIRE_EMBREE=1` makes them
//! fail instead.

#[path = "../embree_or_skip/mod.rs"]
mod embree_or_skip;
#[path = "../faulty_tracers/mod.rs"]
mod faulty_tracers;

mod boxes;
mod certified;
mod certify;
mod check;
mod closed_form;
mod conservation;
mod coverage;
mod covered_pairs;
mod culling_audit;
mod detail;
mod determinism;
mod dropped;
mod elements;
mod extremes;
mod furnace;
mod openness;
mod overlaps;
mod proofs;
mod quarters;
mod relight;
mod second_opinion;
mod segments;
mod solving;
mod stale;
mod stored;
mod strategies;
mod two_rooms;
mod windings;
