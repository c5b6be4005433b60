//! `render`: from a scene file to a picture and its statistics, one step after the other.

use super::args::ViewArg;
use super::camera::choose_camera;
use super::config::RenderConfig;
use super::console;
use super::errors::CliError;
use super::solved::{Loaded, Solved, in_pool};
use crate::compare::TruthDifference;
use crate::image::picture::Picture;
use crate::image::read::{PictureError, read_exr};
use crate::image::tone::Exposure;
use crate::image::write::{PictureFormat, check_destination, check_output, write_picture};
use crate::image::{self, Heat, HeatMap, RenderOptions, View};
use crate::memory;
use crate::progress::Progress;
use crate::report::{json, table};

/// Renders as configured.
///
/// # Errors
/// The first thing that goes wrong; then no output has been touched, except that the picture stays
/// when writing the statistics fails after it.
pub(super) fn run(config: &RenderConfig) -> Result<(), CliError> {
    check_output(&config.output)?;
    if let Some(path) = &config.stats {
        check_destination(path)?;
    }
    in_pool(&config.run, |progress| run_in_pool(config, progress))
}

fn run_in_pool(config: &RenderConfig, progress: &dyn Progress) -> Result<(), CliError> {
    let loaded = Loaded::load(&config.run, progress)?;
    let reference = config.reference.as_deref().map(read_exr).transpose().map_err(reference_failure)?;
    let mut camera = choose_camera(&loaded.scene, &config.view)?;
    if let Some(reference) = &reference {
        (camera.width, camera.height) = (reference.width, reference.height);
    }
    let Solved { scene, hierarchy, tracer, solution, quality, mut stats, mut clock, .. } =
        loaded.solve(&config.run, progress)?;

    let samples = config.view.samples(quality);
    let (picture, map) = match looked_at(config.view.kind, config.lighting.rays(quality)) {
        LookedAt::View(view) => {
            let options = RenderOptions { samples, view };
            (image::render(&hierarchy, tracer.as_ref(), &solution, &camera, options, progress), None)
        }
        LookedAt::Heat(heat) => {
            let square_meters = hierarchy.square_meters_per_unit(scene.meters_per_unit);
            let seen = image::seen(&hierarchy, tracer.as_ref(), &solution, &camera);
            let map = HeatMap::new(&hierarchy, &solution, square_meters, heat, &seen);
            let shown = (&map, samples);
            (image::render_heat(&hierarchy, tracer.as_ref(), &solution, &camera, shown, progress), Some(map))
        }
    };
    if !config.run.quiet && picture.pixels.iter().all(|&pixel| pixel == [0.0; 3]) {
        console::warning(&format!(
            "the picture is black: camera '{}' sees nothing that is lit; check its eye and target",
            camera.name
        ));
    }
    match &map {
        Some(_) => write_picture(&config.output, &picture, None)?,
        None => write_shown(config, &picture)?,
    }
    stats.seconds.render = clock.lap();
    stats.seconds.total = clock.total();
    stats.memory.peak_rss_bytes = memory::peak_rss_bytes();

    stats.reference = reference.map(|reference| TruthDifference::of(&picture, &reference));

    if let Some(difference) = stats.reference.filter(|_| !config.run.quiet || config.stats.is_none()) {
        console::note(&against_reference(&difference));
    }
    if !config.run.quiet {
        console::note(&table::table(&[(scene.name.as_str(), &stats)]));
        map.iter().for_each(|map| console::note(&map.legend().to_string()));
    }
    if let Some(path) = &config.stats {
        json::write_json(path, &stats)?;
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

/// What a picture can show.
enum LookedAt {
    View(View),
    Heat(Heat),
}

fn looked_at(view: ViewArg, gather_rays: Option<u32>) -> LookedAt {
    match view {
        ViewArg::Shaded => LookedAt::View(gather_rays.map_or(View::Shaded, View::Gathered)),
        ViewArg::Mesh => LookedAt::View(View::Mesh),
        ViewArg::Cost => LookedAt::Heat(Heat::Cost),
        ViewArg::Links => LookedAt::Heat(Heat::Links),
        ViewArg::Class => LookedAt::Heat(Heat::Class),
        ViewArg::Partial => LookedAt::Heat(Heat::Partial),
    }
}

/// Exposes and writes the picture, and says which exposure was chosen.
fn write_shown(config: &RenderConfig, picture: &Picture) -> Result<(), CliError> {
    let exposure = config.view.exposure.multiplier(picture);
    write_picture(&config.output, picture, Some(exposure))?;
    let is_chosen = config.view.exposure == Exposure::Automatic && config.format == PictureFormat::Png;
    if is_chosen && !config.run.quiet {
        console::note(&format!(
            "exposure chosen from the picture: {exposure:.4e} (repeat it with --exposure)\n"
        ));
    }
    Ok(())
}
