//! What a run did, in numbers: statistics, the findings of a check, two tracers side by side, and
//! errors against time, as tables, as JSON, as plots and as pages.

mod bars;
pub mod check;
pub mod compare;
pub mod convergence;
pub mod html;
pub mod json;
pub mod memory;
pub mod plot;
pub mod profile;
pub mod stats;
pub mod table;
mod text;
