//! What every command says of its run, and how little it prints.

use std::path::PathBuf;

use clap::Args;

/// How little is printed.
#[derive(Debug, Args)]
pub(in crate::cli) struct PrintArgs {
    /// Print nothing but errors, the tables of profile and convergence, and a comparison with a reference that no file has
    #[arg(short, long, help_heading = "Report")]
    pub(in crate::cli) quiet: bool,
}

/// Where the statistics go.
#[derive(Debug, Args)]
pub(in crate::cli) struct StatsArgs {
    /// Write the statistics of the run as JSON
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    pub(in crate::cli) stats: Option<PathBuf>,
}
