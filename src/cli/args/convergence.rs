//! The arguments of `convergence`.

use std::path::PathBuf;

use clap::Args;

use super::{MachineArgs, PrintArgs, SolutionArgs, whole};
use crate::gather::SAMPLES;

#[derive(Debug, Args)]
pub(in crate::cli) struct ConvergenceArgs {
    /// Scene description (.toml) or a bare mesh (.obj, .glb, .gltf, .ply)
    #[arg(value_name = "SCENE")]
    pub(in crate::cli) scene: PathBuf,
    /// Points to compare at: a text file as for `probe`
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) points: PathBuf,
    /// Reference values at these points, a CSV as for `probe`
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) reference: PathBuf,
    /// How many settings, 2 to 20: from half a step coarser than draft to --quality, in even steps
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = whole(2, 20), allow_negative_numbers = true)]
    pub(in crate::cli) settings: u32,
    /// Record to write as JSON
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Plot to write as SVG
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) plot: Option<PathBuf>,
    /// Rays for a point, 16 to 1048576: so many to the emitters, and so many to everything else
    #[arg(long, value_name = "N", default_value_t = SAMPLES, value_parser = whole(16, 1 << 20), allow_negative_numbers = true)]
    pub(in crate::cli) samples: u32,

    #[command(flatten)]
    pub(in crate::cli) solution: SolutionArgs,
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,
    #[command(flatten)]
    pub(in crate::cli) print: PrintArgs,
}
