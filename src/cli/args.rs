//! The arguments as typed. Every number is checked for its range here; what depends on several of
//! them, or on files, in [`super::config`].

mod compare;
mod convergence;
mod profile;
mod report;
mod stored;
mod views;

pub(super) use compare::CompareArgs;
pub(super) use convergence::ConvergenceArgs;
pub(super) use profile::ProfileArgs;
pub(super) use report::{PrintArgs, StatsArgs};
pub(super) use stored::{ExportArgs, RelightArgs, SolveArgs, StoredArgs};
pub(super) use views::{MAX_FRAMES, ViewsArgs};

use std::path::PathBuf;

use clap::builder::{RangedU64ValueParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};

use super::errors::exit_codes_help;
use crate::export::Quality;
use crate::gather::SAMPLES;
use crate::image::tone::Tone;

/// Diffuse global illumination by hierarchical radiosity: solves a scene once and renders views of it.
#[derive(Debug, Parser)]
#[command(version, after_help = exit_codes_help(), arg_required_else_help = true)]
pub(super) struct Arguments {
    #[command(subcommand)]
    pub(super) verb: Verb,
}

#[derive(Debug, Subcommand)]
pub(super) enum Verb {
    /// Solve a scene and render pictures of it
    #[command(after_help = exit_codes_help())]
    Render(Box<RenderArgs>),
    /// Solve a scene once and keep the solution in a file, for --solution of other commands
    #[command(after_help = exit_codes_help())]
    Solve(Box<SolveArgs>),
    /// Give a solution other lamps or reflectances, over the links that it has, and keep it in a file
    #[command(after_help = exit_codes_help())]
    Relight(Box<RelightArgs>),
    /// Write a solved scene as a model for other programs, GLB with the light in its colours or PLY with exitance, or as a
    /// page to walk through in a browser
    #[command(after_help = exit_codes_help())]
    Export(Box<ExportArgs>),
    /// Solve a scene and print the irradiance at points of it
    #[command(after_help = exit_codes_help())]
    Probe(Box<ProbeArgs>),
    /// Solve a scene at one setting after the other and print error against time
    #[command(after_help = exit_codes_help())]
    Convergence(Box<ConvergenceArgs>),
    /// Solve a scene with several strategies and tracers and print where visibility time goes
    #[command(after_help = exit_codes_help())]
    Profile(Box<ProfileArgs>),
    /// Solve a scene and check that the solution is physically right
    ///
    /// The answer is a table; the exit code is 8 when something in it failed.
    #[command(after_help = exit_codes_help())]
    Check(Box<CheckArgs>),
    /// Do the same work on Embree and on the pure-Rust tracer and say whether and where they differ
    ///
    /// The answer is in words and tables; the exit code is 9 when a ray is wrong, or links or light differ though no ray does.
    #[command(after_help = exit_codes_help())]
    Compare(Box<CompareArgs>),
    /// Say which Embree is used, where it is and whether it works
    ///
    /// The exit code is 7 when Embree is not usable; rendering then uses the pure-Rust tracer.
    #[command(after_help = exit_codes_help())]
    Doctor(DoctorArgs),
    /// Write a scene made by rule
    #[command(after_help = exit_codes_help(), arg_required_else_help = true)]
    Generate(GenerateArgs),
}

#[derive(Debug, Args)]
pub(super) struct RenderArgs {
    /// Scene description (.toml) or a bare mesh (.obj, .glb, .gltf, .ply)
    #[arg(value_name = "SCENE")]
    pub(super) scene: PathBuf,
    /// Picture to write: .png (tone-mapped), .exr or .hdr (linear radiance). For several pictures, the name has a place for
    /// what they differ in: %04d for a number from 1 in at least 4 digits, or %s for the name of a camera
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: PathBuf,

    #[command(flatten)]
    pub(super) views: ViewsArgs,
    #[command(flatten)]
    pub(super) picture: PictureArgs,
    /// Multiplier on linear radiance before tone mapping [default: chosen from the picture]
    #[arg(long, value_name = "X", help_heading = "View", value_parser = positive, allow_negative_numbers = true)]
    pub(super) exposure: Option<f64>,
    /// How exposed radiance becomes colours of the screen [default: filmic]
    #[arg(long, value_name = "TONE", help_heading = "View", value_enum)]
    pub(super) tone: Option<ToneArg>,
    /// Keep layers besides radiance in an .exr: irradiance, albedo, depth, normal, element, class
    #[arg(long, help_heading = "View")]
    pub(super) layers: bool,
    /// Light each pixel anew over the links to what it shows: crisp shadows, which take longer
    #[arg(long, help_heading = "View", overrides_with = "reconstruct")]
    pub(super) final_gather: bool,
    /// Rays of a final gather for a pixel, 16 to 4096, about; up to 8 times as many where most light is kept off
    /// [default: by --quality]
    #[arg(long, value_name = "N", help_heading = "View", requires = "final_gather", value_parser = whole(16, 4096), allow_negative_numbers = true)]
    pub(super) gather_rays: Option<u32>,
    /// Light each pixel by interpolation over the elements [default]
    #[arg(long, help_heading = "View", overrides_with = "final_gather")]
    pub(super) reconstruct: bool,
    /// What the picture shows
    #[arg(long, value_name = "KIND", help_heading = "View", value_enum, default_value_t = ViewArg::Shaded)]
    pub(super) view: ViewArg,

    #[command(flatten)]
    pub(super) stored: StoredArgs,
    #[command(flatten)]
    pub(super) solution: SolutionArgs,
    #[command(flatten)]
    pub(super) machine: MachineArgs,

    /// A picture of the same view that is right but for noise, .exr (linear radiance): says how far the picture is from
    /// it, which has its size
    #[arg(long, value_name = "FILE", help_heading = "Report", conflicts_with_all = ["width", "height"])]
    pub(super) reference: Option<PathBuf>,
    #[command(flatten)]
    pub(super) statistics: StatsArgs,
    #[command(flatten)]
    pub(super) print: PrintArgs,
}

#[derive(Debug, Args)]
pub(super) struct ProbeArgs {
    /// Scene description (.toml) or a bare mesh (.obj, .glb, .gltf, .ply)
    #[arg(value_name = "SCENE")]
    pub(super) scene: PathBuf,
    /// Points to probe: a text file with one `x y z nx ny nz` a line, in scene units; `#` begins a comment
    #[arg(long, value_name = "FILE", required_unless_present = "grid")]
    pub(super) points: Option<PathBuf>,
    /// Instead of points, a regular grid: over the rectangle of the scene description with this name, or,
    /// given a number, over the plane at that height
    #[arg(long, value_name = "NAME|HEIGHT", conflicts_with_all = ["points", "reference"], allow_negative_numbers = true)]
    pub(super) grid: Option<String>,
    /// Distance between the points of a grid, scene units [default: 20 along the longer side]
    #[arg(long, value_name = "LENGTH", requires = "grid", value_parser = positive, allow_negative_numbers = true)]
    pub(super) spacing: Option<f64>,
    /// Table to write: .csv, or .json with more detail [default: CSV on standard output]
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Illuminance in lux instead of irradiance by channel: 683 lm/W times the weights 0.2126, 0.7152, 0.0722
    #[arg(long)]
    pub(super) lux: bool,
    /// Rays for a point, 16 to 1048576: so many to the emitters, and so many to everything else
    #[arg(long, value_name = "N", default_value_t = SAMPLES, value_parser = whole(16, 1 << 20), allow_negative_numbers = true)]
    pub(super) samples: u32,
    /// Reference values to compare with, a CSV with one row a point; says how far the answers are from them
    #[arg(long, value_name = "FILE")]
    pub(super) reference: Option<PathBuf>,

    #[command(flatten)]
    pub(super) stored: StoredArgs,
    #[command(flatten)]
    pub(super) solution: SolutionArgs,
    #[command(flatten)]
    pub(super) machine: MachineArgs,
    #[command(flatten)]
    pub(super) print: PrintArgs,
}

#[derive(Debug, Args)]
pub(super) struct CheckArgs {
    /// Scene description (.toml) or a bare mesh (.obj, .glb, .gltf, .ply)
    #[arg(value_name = "SCENE")]
    pub(super) scene: PathBuf,

    #[command(flatten)]
    pub(super) stored: StoredArgs,
    #[command(flatten)]
    pub(super) solution: SolutionArgs,
    #[command(flatten)]
    pub(super) machine: MachineArgs,

    /// Write the findings as JSON
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    pub(super) json: Option<PathBuf>,
    #[command(flatten)]
    pub(super) print: PrintArgs,
}

/// How large and how smooth pictures are.
#[derive(Debug, Args)]
pub(super) struct PictureArgs {
    /// Width in pixels; alone, the height follows the camera's proportions
    #[arg(long, value_name = "PIXELS", help_heading = "View", value_parser = whole(1, MAX_PIXELS), allow_negative_numbers = true)]
    pub(super) width: Option<u32>,
    /// Height in pixels; alone, the width follows the camera's proportions
    #[arg(long, value_name = "PIXELS", help_heading = "View", value_parser = whole(1, MAX_PIXELS), allow_negative_numbers = true)]
    pub(super) height: Option<u32>,
    /// Samples per pixel, 1 to 1024, against jagged edges [default: by --quality]
    #[arg(long, value_name = "N", help_heading = "View", value_parser = whole(1, 1024), allow_negative_numbers = true)]
    pub(super) samples: Option<u32>,
}

/// How exact the solution has to be and how visibility is decided.
#[derive(Debug, Args)]
pub(super) struct SolutionArgs {
    #[command(flatten)]
    pub(super) exactness: ExactnessArgs,
    /// Visibility rays for a pair of nodes, 1 to 1024 [default: by --quality]; up to 4 times as many for
    /// what draws a shadow or seems blocked, up to 16 times where their answer is believed without a proof
    #[arg(long, value_name = "N", help_heading = "Solution", value_parser = whole(1, 1024), allow_negative_numbers = true)]
    pub(super) rays: Option<u32>,
    /// How visibility between two nodes is decided
    #[arg(long, value_name = "STRATEGY", help_heading = "Solution", value_enum, default_value_t = VisibilityArg::Adaptive)]
    pub(super) visibility: VisibilityArg,
}

/// How exact the solution has to be.
#[derive(Debug, Args)]
pub(super) struct ExactnessArgs {
    /// Sets --epsilon, --min-size, --rays and --iterations, where they are not given, how closely shadows are
    /// followed, and the samples of a picture
    #[arg(long, value_name = "LEVEL", help_heading = "Solution", value_enum, default_value_t = QualityArg::Normal)]
    pub(super) quality: QualityArg,
    /// Power a link may get wrong, relative to the power that the irradiance there brings to a wall, in (0, 1]
    /// [default: by --quality]
    #[arg(long, value_name = "X", help_heading = "Solution", value_parser = fraction, allow_negative_numbers = true)]
    pub(super) epsilon: Option<f64>,
    /// Smallest edge of an element in scene units [default: from the size of the rooms, by --quality]
    #[arg(long, value_name = "LENGTH", help_heading = "Solution", value_parser = positive, allow_negative_numbers = true)]
    pub(super) min_size: Option<f64>,
    /// Most iterations of gathering, 1 to 10000 [default: by --quality]
    #[arg(long, value_name = "N", help_heading = "Solution", value_parser = whole(1, 10_000), allow_negative_numbers = true)]
    pub(super) iterations: Option<u32>,
    /// Let parts inherit visibility only when it is proved, never when it was sampled
    #[arg(long, help_heading = "Solution")]
    pub(super) certify: bool,
    /// Surfaces reflect from their front (counter-clockwise) side only; for closed models
    #[arg(long, help_heading = "Solution")]
    pub(super) one_sided: bool,
}

/// What the work is done with.
#[derive(Debug, Args)]
pub(super) struct MachineArgs {
    /// What casts the rays
    #[arg(long, value_name = "TRACER", help_heading = "Machine", value_enum, default_value_t = TracerArg::Auto)]
    pub(super) tracer: TracerArg,
    #[command(flatten)]
    pub(super) library: LibraryArgs,
}

/// Where Embree is, and how many threads there are.
#[derive(Debug, Args)]
pub(super) struct LibraryArgs {
    /// The Embree library to use
    #[arg(long, value_name = "PATH", help_heading = "Machine")]
    pub(super) embree_lib: Option<PathBuf>,
    /// Worker threads, 1 to 1024 [default: all cores]
    #[arg(long, value_name = "N", help_heading = "Machine", value_parser = whole(1, 1024), allow_negative_numbers = true)]
    pub(super) threads: Option<u32>,
}

#[derive(Debug, Args)]
pub(super) struct DoctorArgs {
    /// The Embree library to examine, instead of the one that would be found
    #[arg(long, value_name = "PATH")]
    pub(super) embree_lib: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(super) struct GenerateArgs {
    #[command(subcommand)]
    pub(super) what: GenerateWhat,
}

#[derive(Debug, Subcommand)]
pub(super) enum GenerateWhat {
    /// An office building with desks, chairs, lamps and corridors
    Office(OfficeArgs),
}

#[derive(Debug, Args)]
pub(super) struct OfficeArgs {
    /// Floors of the building, 1 to 1000
    #[arg(long, value_name = "F", value_parser = whole(1, 1000), allow_negative_numbers = true)]
    pub(super) floors: u32,
    /// Rooms on each floor, 1 to 1000
    #[arg(long, value_name = "R", value_parser = whole(1, 1000), allow_negative_numbers = true)]
    pub(super) rooms: u32,
    /// Folder for scene.toml, office.obj and office.mtl; created when missing. Files of these names are
    /// replaced only if they were generated
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: PathBuf,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ViewArg {
    /// The lit scene
    Shaded,
    /// Element edges, coloured by the visibility classes of the links
    Mesh,
    /// Heat map: work of visibility tests, by area
    Cost,
    /// Heat map: links over which each element is lit
    Links,
    /// Heat map: class of the links that cost the most on each element
    Class,
    /// Heat map: share of the light that comes over partial links
    Partial,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ToneArg {
    /// A shoulder that keeps highlights and hues
    Filmic,
    /// No curve: what is brighter than white is white
    Plain,
}

impl From<ToneArg> for Tone {
    fn from(typed: ToneArg) -> Tone {
        match typed {
            ToneArg::Filmic => Tone::Filmic,
            ToneArg::Plain => Tone::Plain,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum QualityArg {
    Draft,
    Normal,
    High,
}

impl From<QualityArg> for Quality {
    fn from(typed: QualityArg) -> Quality {
        match typed {
            QualityArg::Draft => Quality::Draft,
            QualityArg::Normal => Quality::Normal,
            QualityArg::High => Quality::High,
        }
    }
}

impl From<Quality> for QualityArg {
    fn from(stored: Quality) -> QualityArg {
        match stored {
            Quality::Draft => QualityArg::Draft,
            Quality::Normal => QualityArg::Normal,
            Quality::High => QualityArg::High,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum VisibilityArg {
    /// Test every facet one by one (slow; for comparison)
    All,
    /// Let each ray traverse the whole hierarchy
    Root,
    /// Cull the occluders by a shaft first, then cast rays against what is left
    Shaft,
    /// Rays first, proofs where more would have to agree than are worth casting
    Adaptive,
    /// A sampled fraction for every link, no proofs (classic radiosity)
    Sampled,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum TracerArg {
    /// Embree if usable, the fallback otherwise
    Auto,
    /// Embree, or fail
    Embree,
    /// The pure-Rust tracer
    Fallback,
}

/// The largest side of a picture, pixels.
pub(super) const MAX_PIXELS: u32 = 16_384;

fn whole(from: u32, to: u32) -> impl TypedValueParser<Value = u32> {
    RangedU64ValueParser::<u32>::new().range(u64::from(from)..=u64::from(to))
}

fn positive(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        Ok(_) => Err("must be a finite number above 0".into()),
        Err(_) => Err("not a number".into()),
    }
}

fn fraction(text: &str) -> Result<f64, String> {
    match positive(text)? {
        number if number <= 1.0 => Ok(number),
        _ => Err("must be above 0 and at most 1".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_grammar_is_sound() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn numbers_that_make_no_sense_are_refused_by_name() {
        let cases = [
            ("--rays", "0"),
            ("--rays", "1025"),
            ("--rays", "4.5"),
            ("--rays", "-4"),
            ("--width", "0"),
            ("--width", "16385"),
            ("--height", "99999999999"),
            ("--epsilon", "nan"),
            ("--epsilon", "inf"),
            ("--epsilon", "0"),
            ("--epsilon", "-1"),
            ("--epsilon", "1.5"),
            ("--min-size", "0"),
            ("--min-size", "1e999"),
            ("--exposure", "-2"),
            ("--exposure", "bright"),
            ("--iterations", "0"),
            ("--samples", "0"),
            ("--samples", "2000"),
            ("--threads", "0"),
        ];
        for (option, value) in cases {
            let typed = ["lightshaft", "render", "a.toml", "-o", "a.png", option, value];
            let error =
                Arguments::try_parse_from(typed).expect_err(&format!("{option} {value} was accepted"));
            let text = error.to_string();
            let first = text.lines().next().unwrap_or_default();
            assert!(first.contains(option) && first.contains(value), "{option} {value}: {first}");
        }
    }

    #[test]
    fn the_ends_of_the_ranges_are_accepted() {
        for (option, value) in [("--rays", "1"), ("--rays", "1024"), ("--epsilon", "1"), ("--width", "16384")]
        {
            let typed = ["lightshaft", "render", "a.toml", "-o", "a.png", option, value];
            assert!(Arguments::try_parse_from(typed).is_ok(), "{option} {value}");
        }
    }
}
