//! What a run did, in numbers: statistics, the findings of a check, two tracers side by side, and
//! errors against time, who worked when: as tables, JSON, plots, traces and pages.

mod bars;
pub mod check;
pub mod compare;
pub mod convergence;
pub mod detail;
pub mod html;
pub mod json;
mod labels;
mod look;
pub mod plot;
pub mod profile;
pub mod setup;
pub mod stats;
pub mod table;
pub(crate) mod text;
pub mod trace;
