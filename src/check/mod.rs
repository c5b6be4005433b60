//! Is a solution physically right: what can be known without a reference.

mod audit;

pub use audit::{Audit, KINDS, KindAudit, audit, name};
