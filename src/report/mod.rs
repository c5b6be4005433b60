//! What a run did, in numbers: the statistics record, its table and its JSON.

pub mod json;
pub mod memory;
pub mod stats;
pub mod table;
