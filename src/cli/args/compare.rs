//! The arguments of `compare`.

use std::path::PathBuf;

use clap::Args;

use super::{ExactnessArgs, LibraryArgs, PictureArgs, PrintArgs, VisibilityArg, whole};

#[derive(Debug, Args)]
pub(in crate::cli) struct CompareArgs {
    /// Scene description (.toml) or a bare mesh (.obj, .glb, .gltf, .ply)
    #[arg(value_name = "SCENE")]
    pub(in crate::cli) scene: PathBuf,
    /// Random rays and rays that are hard to decide, 0 to 100000000, besides those of the solutions
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = whole(0, 100_000_000), allow_negative_numbers = true)]
    pub(in crate::cli) rays: u32,
    /// Times the rays are timed, 1 to 100, in turns; figures are medians
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = whole(1, 100), allow_negative_numbers = true)]
    pub(in crate::cli) repeat: u32,
    /// Times the scene is solved and rendered with each to see how long it takes, 1 to 100, in turns; figures are
    /// medians
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = whole(1, 100), allow_negative_numbers = true)]
    pub(in crate::cli) solves: u32,
    /// Folder for native.png, fallback.png and difference.png (16 times as bright); made when missing
    #[arg(short, long, value_name = "DIR")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Write the worst rays, to be traced again with --replay
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) replay_file: Option<PathBuf>,
    /// Instead of all that, trace the rays of such a file one by one and tell everything about them
    #[arg(long, value_name = "FILE", conflicts_with_all = OF_COMPARING)]
    pub(in crate::cli) replay: Option<PathBuf>,

    /// Camera of the scene [default: the first]
    #[arg(long, value_name = "NAME", help_heading = "View")]
    pub(in crate::cli) camera: Option<String>,
    #[command(flatten)]
    pub(in crate::cli) picture: PictureArgs,

    #[command(flatten)]
    pub(in crate::cli) exactness: ExactnessArgs,
    /// Visibility rays for a pair of nodes, 1 to 1024: what other commands call --rays [default: by --quality]
    #[arg(long, value_name = "N", help_heading = "Solution", value_parser = whole(1, 1024), allow_negative_numbers = true)]
    pub(in crate::cli) pair_rays: Option<u32>,
    /// How visibility between two nodes is decided
    #[arg(long, value_name = "STRATEGY", help_heading = "Solution", value_enum, default_value_t = VisibilityArg::Adaptive)]
    pub(in crate::cli) visibility: VisibilityArg,
    #[command(flatten)]
    pub(in crate::cli) machine: LibraryArgs,

    /// Write what was found as JSON
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    pub(in crate::cli) json: Option<PathBuf>,
    /// Write what was found as a page, one HTML file: words, pictures, plots and tables
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    pub(in crate::cli) html: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) print: PrintArgs,
}

/// What has no say in how rays are traced again; which sides of surfaces there are has.
const OF_COMPARING: [&str; 18] = [
    "rays",
    "repeat",
    "solves",
    "output",
    "replay_file",
    "json",
    "html",
    "camera",
    "width",
    "height",
    "samples",
    "quality",
    "epsilon",
    "min_size",
    "iterations",
    "certify",
    "pair_rays",
    "visibility",
];
