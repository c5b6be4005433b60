//! The checked configuration of which pictures are taken of a solution, and what they are called.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::super::args::ViewsArgs;
use super::super::errors::CliError;
use super::pattern::{Pattern, Place};
use super::{check_extension, usage};
use crate::scene::Pace;

/// Pictures a second where nothing is said.
const RATE: f64 = 24.0;

/// Which pictures are taken, and where they go.
#[derive(Clone, Debug)]
pub(in crate::cli) enum Views {
    /// That of this camera, or of the first one of the scene.
    One { camera: Option<String>, output: PathBuf },
    /// Those of these cameras, each by itself.
    Cameras { names: Vec<String>, output: Pattern },
    /// A sequence, of this camera or the first one.
    Sequence { camera: Option<String>, motion: Motion, output: Pattern },
}

/// How a camera moves.
#[derive(Clone, Debug)]
pub(in crate::cli) enum Motion {
    /// Around this point or its target, in so many steps.
    Turntable(u32, Option<DVec3>),
    /// Along the keyframes of a file.
    Path(PathBuf, Pace),
}

/// The video of a sequence.
#[derive(Clone, Debug)]
pub(in crate::cli) struct VideoConfig {
    pub(in crate::cli) path: PathBuf,
    /// Pictures a second.
    pub(in crate::cli) rate: f64,
}

impl Views {
    /// What is typed, with what comes out of it.
    ///
    /// # Errors
    /// [`CliError::Usage`] when options contradict each other, or the name of the output has no place for what several
    /// pictures differ in.
    pub(in crate::cli) fn check(
        typed: ViewsArgs,
        output: &Path,
    ) -> Result<(Views, Option<VideoConfig>), CliError> {
        let ViewsArgs { camera: cameras, turntable, around, path, frames, fps, video } = typed;
        check_extension("--video", video.as_deref(), "mp4")?;
        if turntable.is_some() && frames.is_some() {
            return usage("--frames is for --path; --turntable says by itself how many pictures there are");
        }
        if path.is_some() && around.is_some() {
            return usage("--around is for --turntable; a --path has its own targets");
        }
        let rate = fps.unwrap_or(RATE);
        let motion = match (turntable, path) {
            (Some(frames), _) => Some(Motion::Turntable(frames, around.map(DVec3::from_array))),
            (None, Some(file)) => {
                Some(Motion::Path(file, frames.map_or(Pace::PerSecond(rate), Pace::Frames)))
            }
            (None, None) => None,
        };
        let paced = matches!(motion, Some(Motion::Path(_, Pace::PerSecond(_)))) || video.is_some();
        if fps.is_some() && !paced {
            return usage("--fps is for a --path without --frames, and for --video");
        }
        let Some(motion) = motion else {
            if video.is_some() {
                return usage("--video is for --turntable and --path; one camera alone does not move");
            }
            if let Some(twice) = (1..cameras.len()).find(|&index| cameras[..index].contains(&cameras[index]))
            {
                return usage(&format!("--camera {} is given twice", cameras[twice]));
            }
            // One picture may be called anything.
            let is_one = cameras.is_empty() || cameras.len() == 1 && !output.to_string_lossy().contains("%s");
            let views = if is_one {
                Views::One { camera: cameras.into_iter().next(), output: output.to_owned() }
            } else {
                let output = several(output, &cameras)?;
                Views::Cameras { names: cameras, output }
            };
            return Ok((views, None));
        };
        if cameras.len() > 1 {
            return usage("one camera moves at a time; give --camera once");
        }
        let output = several(output, &[])?;
        let video = video.map(|path| VideoConfig { path, rate });
        Ok((Views::Sequence { camera: cameras.into_iter().next(), motion, output }, video))
    }
}

/// The names of several pictures, of these cameras or of a sequence.
fn several(output: &Path, cameras: &[String]) -> Result<Pattern, CliError> {
    let shown = output.display();
    let wanted =
        if cameras.is_empty() { "such as frame-%04d.png" } else { "such as view-%s.png or view-%d.png" };
    let pattern = Pattern::of(output).or_else(|why| {
        usage(&format!("--output {shown}: {why} for what pictures differ in; give a name {wanted}"))
    })?;
    if pattern.place() == Place::Name {
        if cameras.is_empty() {
            return usage(&format!(
                "--output {shown}: %s is the name of a camera, and this one moves; give a name {wanted}"
            ));
        }
        let is_part = |c: char| !matches!(c, '/' | '\\') && !c.is_control();
        if let Some(camera) = cameras.iter().find(|name| name.is_empty() || !name.chars().all(is_part)) {
            return usage(&format!(
                "--output {shown}: camera '{camera}' cannot be part of a file's name; use %d"
            ));
        }
    }
    Ok(pattern)
}
