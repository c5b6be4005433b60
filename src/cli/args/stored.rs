//! The arguments about solution files: what writes one, and what is done with one instead of solving.

use std::path::PathBuf;

use clap::Args;

use super::{MachineArgs, SolutionArgs};

#[derive(Debug, Args)]
pub(in crate::cli) struct SolveArgs {
    /// Scene description (.toml) or a bare mesh (.obj)
    #[arg(value_name = "SCENE")]
    pub(in crate::cli) scene: PathBuf,
    /// Solution file to write (.lsol), for --solution of other commands
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: PathBuf,

    #[command(flatten)]
    pub(in crate::cli) solution: SolutionArgs,
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,

    /// Write the statistics of the run as JSON
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    pub(in crate::cli) stats: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(short, long, help_heading = "Report")]
    pub(in crate::cli) quiet: bool,
}

/// A solution that is read instead of computed.
#[derive(Debug, Args)]
pub(in crate::cli) struct StoredArgs {
    /// Solution file that `lightshaft solve` wrote for this scene, instead of solving again
    #[arg(long = "solution", value_name = "FILE", help_heading = "Solution", conflicts_with_all = OF_SOLVING)]
    pub(in crate::cli) stored: Option<PathBuf>,
}

/// What a solution that is there cannot follow any more: all options of [`SolutionArgs`].
const OF_SOLVING: [&str; 8] =
    ["quality", "epsilon", "min_size", "iterations", "certify", "one_sided", "rays", "visibility"];
