//! The checked configuration of solving once and keeping the solution.

use std::path::PathBuf;

use super::super::args::SolveArgs;
use super::super::errors::CliError;
use super::{RunConfig, check_distinct, check_extension};

/// Everything that is needed to keep a solution.
#[derive(Clone, Debug)]
pub(in crate::cli) struct KeepConfig {
    pub(in crate::cli) run: RunConfig,
    /// Whether elements for display are made.
    pub(in crate::cli) local_pass: bool,
    pub(in crate::cli) output: PathBuf,
    pub(in crate::cli) stats: Option<PathBuf>,
}

impl KeepConfig {
    /// Fills in the defaults and checks what depends on several options.
    ///
    /// # Errors
    /// [`CliError::Usage`] when options contradict each other. No file is touched.
    pub(in crate::cli) fn check(typed: SolveArgs) -> Result<Self, CliError> {
        check_extension("--output", Some(&typed.output), "lsol")?;
        check_extension("--stats", typed.statistics.stats.as_deref(), "json")?;
        check_distinct(&[Some(&typed.scene), Some(&typed.output), typed.statistics.stats.as_ref()])?;
        let outputs =
            [Some(&typed.output), typed.statistics.stats.as_ref()].into_iter().flatten().cloned().collect();
        let run = RunConfig::check(typed.scene, outputs, typed.solution, typed.machine, typed.print.quiet)?;
        Ok(Self {
            run,
            local_pass: typed.display.local_pass,
            output: typed.output,
            stats: typed.statistics.stats,
        })
    }
}
