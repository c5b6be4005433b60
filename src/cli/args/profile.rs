//! The arguments of `profile`.

use std::path::PathBuf;

use clap::Args;

use super::{ExactnessArgs, LibraryArgs, PrintArgs, TracerArg, VisibilityArg, whole};
use crate::gather::SAMPLES;

#[derive(Debug, Args)]
pub(in crate::cli) struct ProfileArgs {
    /// Scene description (.toml) or a bare mesh (.obj, .glb, .gltf, .ply)
    #[arg(value_name = "SCENE")]
    pub(in crate::cli) scene: PathBuf,
    /// Ways to decide visibility, separated by commas; the first sets the aim, the errors that the others have to
    /// reach [default: adaptive,root,sampled; with --certify adaptive,root]
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',')]
    pub(in crate::cli) strategies: Vec<VisibilityArg>,
    /// What casts the rays, separated by commas; `all` asks none of them, and is made once
    #[arg(long, value_name = "LIST", value_enum, value_delimiter = ',', default_value = "auto")]
    pub(in crate::cli) tracers: Vec<TracerArg>,
    /// Visibility rays for a pair of nodes, 1 to 1024 each, separated by commas; the aim has the first of them
    /// [default: 4,16,64 and those of --quality, which the aim has]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = whole(1, 1024), allow_negative_numbers = true)]
    pub(in crate::cli) rays: Vec<u32>,
    /// Times each run is made, 1 to 100, in turns; times are medians
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = whole(1, 100), allow_negative_numbers = true)]
    pub(in crate::cli) repeat: u32,
    /// Points to compare irradiance at: a text file as for `probe`
    #[arg(long, value_name = "FILE", requires = "reference")]
    pub(in crate::cli) points: Option<PathBuf>,
    /// Reference values at these points, a CSV as for `probe`
    #[arg(long, value_name = "FILE", requires = "points")]
    pub(in crate::cli) reference: Option<PathBuf>,
    /// Rays for a point, 16 to 1048576: so many to the emitters, and so many to everything else
    #[arg(long, value_name = "N", default_value_t = SAMPLES, value_parser = whole(16, 1 << 20), allow_negative_numbers = true)]
    pub(in crate::cli) samples: u32,
    /// Record to write as JSON
    #[arg(short = 'o', long, visible_alias = "output", value_name = "FILE")]
    pub(in crate::cli) json: Option<PathBuf>,
    /// Plot of error over time to write as SVG
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) plot: Option<PathBuf>,
    /// Trace to write: phases and what each thread did when, as JSON for chrome://tracing or ui.perfetto.dev
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) trace: Option<PathBuf>,
    /// Page to write as HTML, one file: words, plots and tables
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) html: Option<PathBuf>,

    #[command(flatten)]
    pub(in crate::cli) exactness: ExactnessArgs,
    #[command(flatten)]
    pub(in crate::cli) machine: LibraryArgs,
    #[command(flatten)]
    pub(in crate::cli) print: PrintArgs,
}
