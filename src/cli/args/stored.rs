//! The arguments about solution files: what writes one, what changes one, and what is done with one instead of solving.

use std::path::PathBuf;

use clap::Args;

use super::{MachineArgs, PrintArgs, SolutionArgs, StatsArgs, ToneArg, positive};
use crate::scene::MaterialChange;

#[derive(Debug, Args)]
pub(in crate::cli) struct SolveArgs {
    /// Scene description (.toml) or a bare mesh (.obj, .glb, .gltf, .ply)
    #[arg(value_name = "SCENE")]
    pub(in crate::cli) scene: PathBuf,
    /// Solution file to write (.lsol), for --solution of other commands
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: PathBuf,

    #[command(flatten)]
    pub(in crate::cli) display: DisplayArgs,
    #[command(flatten)]
    pub(in crate::cli) solution: SolutionArgs,
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,

    #[command(flatten)]
    pub(in crate::cli) statistics: StatsArgs,
    #[command(flatten)]
    pub(in crate::cli) print: PrintArgs,
}

/// What pictures and models are to show.
#[derive(Debug, Args)]
pub(in crate::cli) struct DisplayArgs {
    /// Gather light once more at every element, and divide elements until interpolation shows it: pictures and models nearly
    /// as crisp as with --final-gather, for the time of a few such pictures
    #[arg(long, help_heading = "Display")]
    pub(in crate::cli) local_pass: bool,
}

#[derive(Debug, Args)]
pub(in crate::cli) struct RelightArgs {
    /// Solution file that `lightshaft solve` or `relight` wrote
    #[arg(value_name = "SOLUTION")]
    pub(in crate::cli) stored: PathBuf,
    /// What changes: NAME.radiance=[R,G,B] in W/(m²·sr) or NAME.reflectance=[R,G,B], of the material or [[quad]] of that
    /// name; as often as wanted
    #[arg(long = "set", value_name = "CHANGE", required = true, value_parser = MaterialChange::parse)]
    pub(in crate::cli) changes: Vec<MaterialChange>,
    /// Solution file to write (.lsol), for --solution of other commands
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: PathBuf,
    /// The scene that was solved, when it is not where it was, seen from the solution file
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) scene: Option<PathBuf>,
    /// Divide links further that are too coarse for the new light: less error, and more time
    #[arg(long)]
    pub(in crate::cli) refine: bool,

    #[command(flatten)]
    pub(in crate::cli) display: DisplayArgs,
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,

    #[command(flatten)]
    pub(in crate::cli) statistics: StatsArgs,
    #[command(flatten)]
    pub(in crate::cli) print: PrintArgs,
}

#[derive(Debug, Args)]
#[group(id = "models", required = true, multiple = true, args = ["glb", "ply", "html"])]
pub(in crate::cli) struct ExportArgs {
    /// Solution file that `lightshaft solve` or `relight` wrote
    #[arg(value_name = "SOLUTION")]
    pub(in crate::cli) stored: PathBuf,
    /// Model to write (.glb): triangles with the light in the colours of their vertices, and the cameras
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) glb: Option<PathBuf>,
    /// Model to write (.ply): triangles with exitance in W/m² at their vertices
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) ply: Option<PathBuf>,
    /// Page to write (.html): the scene to walk through in a browser, in one file
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) html: Option<PathBuf>,
    /// Multiplier on linear radiance for colours [default: chosen for all cameras of the scene together]
    #[arg(long, value_name = "X", value_parser = positive, allow_negative_numbers = true)]
    pub(in crate::cli) exposure: Option<f64>,
    /// How exposed radiance becomes colours; in a page it can be changed [default: plain for models, filmic for a page]
    #[arg(long, value_name = "TONE", value_enum)]
    pub(in crate::cli) tone: Option<ToneArg>,
    /// The npm package `three` for the page, instead of the copy in this program
    #[arg(long, value_name = "FOLDER", requires = "html")]
    pub(in crate::cli) three: Option<PathBuf>,
    /// The scene that was solved, when it is not where it was, seen from the solution file
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) scene: Option<PathBuf>,

    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,

    #[command(flatten)]
    pub(in crate::cli) print: PrintArgs,
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
