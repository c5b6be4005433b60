//! What a run did, in numbers: the statistics record and the findings of a check, as tables and as JSON.

pub mod check;
pub mod json;
pub mod memory;
pub mod stats;
pub mod table;
