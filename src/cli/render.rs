//! `render`: from a scene file to pictures and their statistics, one step after the other.

use super::config::{RenderConfig, RunConfig};
use super::console;
use super::errors::CliError;
use super::frames::{self, Made};
use super::shots::Shots;
use super::solved::{Loaded, in_pool};
use crate::compare::TruthDifference;
use crate::image::read::{PictureError, read_exr};
use crate::image::video::{VideoShape, check_program, check_video};
use crate::image::write::check_destination;
use crate::memory;
use crate::progress::Progress;
use crate::report::{json, table};

/// Renders as configured.
///
/// # Errors
/// The first thing that goes wrong; then no output has been touched, except that pictures stay
/// when writing others, the video or the statistics fails after them.
pub(super) fn run(config: &RenderConfig) -> Result<(), CliError> {
    let shots = Shots::plan(config)?;
    shots.check()?;
    for path in &config.run.outputs {
        check_destination(shots.trial_of(path))?;
    }
    if let Some(video) = &config.video {
        check_program(&video.path)?;
    }
    let outputs = [&config.run.outputs[..], &shots.files].concat();
    let run = RunConfig { outputs, ..config.run.clone() };
    in_pool(&config.run, |progress| run_in_pool(config, &run, &shots, progress))
}

fn run_in_pool(
    config: &RenderConfig,
    run: &RunConfig,
    shots: &Shots<'_>,
    progress: &dyn Progress,
) -> Result<(), CliError> {
    let loaded = Loaded::load(run, progress)?;
    let reference = config.reference.as_deref().map(read_exr).transpose().map_err(reference_failure)?;
    let mut cameras = shots.cameras(&loaded.scene, &config.view)?;
    if let Some(reference) = &reference {
        cameras
            .iter_mut()
            .for_each(|camera| (camera.width, camera.height) = (reference.width, reference.height));
    }
    if let (Some(video), Some(camera)) = (&config.video, cameras.first()) {
        let shape = VideoShape { width: camera.width, height: camera.height, rate: video.rate };
        check_video(&video.path, shots.trial_of(&video.path), shape)?;
    }
    let mut solved = loaded.solve(run, progress)?;
    let Made { frames, seconds, last, legends } = frames::make(config, shots, &cameras, &solved, progress)?;

    let (stats, clock) = (&mut solved.stats, &mut solved.clock);
    stats.frames = frames;
    stats.frames_per_second = f64::from(frames) / seconds.max(f64::MIN_POSITIVE);
    stats.seconds.render = clock.lap();
    stats.seconds.total = clock.total();
    stats.memory.peak_rss_bytes = memory::peak_rss_bytes();
    stats.reference = reference.map(|reference| TruthDifference::of(&last, &reference));

    if let Some(difference) = stats.reference.filter(|_| !config.run.quiet || config.stats.is_none()) {
        console::note(&against_reference(&difference));
    }
    if !config.run.quiet {
        console::note(&table::table(&[(solved.scene.name.as_str(), stats)]));
        console::note(&legends);
    }
    if let Some(path) = &config.stats {
        json::write_json(path, stats)?;
    }
    Ok(())
}

/// What an unusable reference means for the caller.
fn reference_failure(error: PictureError) -> CliError {
    match error {
        PictureError::Unreadable { .. } => CliError::Unreadable(error.to_string()),
        PictureError::Malformed { .. } => CliError::Malformed(error.to_string()),
    }
}

/// One line about how far the picture is from its reference.
fn against_reference(difference: &TruthDifference) -> String {
    format!(
        "against the reference: relative RMSE {:.2} %, {:.2} % smoothed; FLIP {:.4}, {:.4} smoothed; mean {:+.2} %\n",
        100.0 * difference.relative_rmse,
        100.0 * difference.smoothed_relative_rmse,
        difference.flip,
        difference.smoothed_flip,
        100.0 * difference.relative_bias
    )
}
