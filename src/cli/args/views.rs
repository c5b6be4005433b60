//! The arguments about which pictures `render` takes of a solution.

use std::path::PathBuf;

use clap::Args;

use super::{positive, whole};

/// Most pictures of one run.
pub(in crate::cli) const MAX_FRAMES: u32 = 10_000;

/// Which pictures are taken.
#[derive(Debug, Args)]
pub(in crate::cli) struct ViewsArgs {
    /// Camera of the scene; several times for several pictures [default: the first]
    #[arg(long, value_name = "NAME", help_heading = "View")]
    pub(in crate::cli) camera: Vec<String>,
    /// Let the camera go once around what it looks at, in N even steps, 1 to 10000: so many pictures
    #[arg(long, value_name = "N", help_heading = "Motion", value_parser = whole(1, MAX_FRAMES), allow_negative_numbers = true)]
    pub(in crate::cli) turntable: Option<u32>,
    /// The point that the camera goes around and looks at, in scene units [default: its target]
    #[arg(long, value_name = "X,Y,Z", help_heading = "Motion", requires = "turntable", value_parser = point, allow_hyphen_values = true)]
    pub(in crate::cli) around: Option<[f64; 3]>,
    /// Let the camera move along the keyframes of a file (.toml); see docs/views.md
    #[arg(long, value_name = "FILE", help_heading = "Motion", conflicts_with = "turntable")]
    pub(in crate::cli) path: Option<PathBuf>,
    /// Pictures of a path, 1 to 10000, evenly spread from its first keyframe to its last [default: by --fps]
    #[arg(long, value_name = "N", help_heading = "Motion", requires = "path", value_parser = whole(1, MAX_FRAMES), allow_negative_numbers = true)]
    pub(in crate::cli) frames: Option<u32>,
    /// Pictures a second, of a path and of a video, at most 1000 [default: 24]
    #[arg(long, value_name = "X", help_heading = "Motion", value_parser = rate, allow_negative_numbers = true)]
    pub(in crate::cli) fps: Option<f64>,
    /// Video of a turntable or path to write besides (.mp4), through the program ffmpeg
    #[arg(long, value_name = "FILE", help_heading = "Motion")]
    pub(in crate::cli) video: Option<PathBuf>,
}

fn point(text: &str) -> Result<[f64; 3], String> {
    let numbers: Vec<f64> =
        text.split(',').map(|number| number.trim().parse()).collect::<Result<_, _>>().unwrap_or_default();
    match numbers[..] {
        [x, y, z] if numbers.iter().all(|number| number.is_finite()) => Ok([x, y, z]),
        _ => Err("write three finite numbers with commas between them, such as 0,1.5,0".into()),
    }
}

fn rate(text: &str) -> Result<f64, String> {
    match positive(text)? {
        rate if (1e-3..=1e3).contains(&rate) => Ok(rate),
        _ => Err("must lie between 0.001 and 1000".into()),
    }
}
