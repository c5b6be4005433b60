//! The binary itself, run as a user runs it: arguments in, files, text and exit code out.

mod check;
mod compare;
mod convergence;
mod export;
mod failures;
mod layers;
mod pages;
mod probe;
mod profile;
mod relight;
mod render;
mod run;
mod solution;
mod statistics;
mod usage;
mod video;
mod views;
mod walk;
