//! `export`: from a solution file to a model of the lit scene for other programs.

use std::path::Path;

use super::config::{ExportConfig, RunConfig};
use super::console;
use super::errors::CliError;
use super::solved::{Loaded, Solved, in_pool};
use super::stored::scene_of;
use crate::export::{Display, Exported, LitScene, write_glb, write_ply};
use crate::image::tone::Exposure;
use crate::image::write::{OutputError, check_destination};
use crate::image::{RenderOptions, Renderer, View, shared_exposure};
use crate::progress::Progress;

/// Exports as configured.
///
/// # Errors
/// The first thing that goes wrong; then no output has been touched, except that the GLB stays when writing the PLY fails
/// after it.
pub(super) fn run(config: &ExportConfig) -> Result<(), CliError> {
    for path in &config.run.outputs {
        check_destination(path)?;
    }
    let scene = scene_of(&config.stored, config.scene.as_deref())?;
    let run = RunConfig { scene, ..config.run.clone() };
    in_pool(&run, |progress| run_in_pool(config, &run, progress))
}

fn run_in_pool(config: &ExportConfig, run: &RunConfig, progress: &dyn Progress) -> Result<(), CliError> {
    let solved = Loaded::load(run, progress)?.solve(run, progress)?;
    let display = Display { exposure: exposure(config, &solved, progress), tone: config.tone };
    if !run.quiet && config.exposure == Exposure::Automatic {
        console::note(&format!("exposure of the colours: {} (--exposure)\n", display.exposure));
    }
    let Solved { scene, hierarchy, solution, .. } = &solved;
    let lit = LitScene { scene, hierarchy, solution };
    let write = |path: &Path, write: Writer| -> Result<(), CliError> {
        progress.start("export", solution.forest.side_count() as u64);
        let exported = write(path, lit, display, progress);
        progress.finish();
        if !run.quiet {
            console::note(&told(path, &exported?));
        } else {
            exported?;
        }
        Ok(())
    };
    config.glb.as_deref().map_or(Ok(()), |path| write(path, write_glb))?;
    config.ply.as_deref().map_or(Ok(()), |path| write(path, write_ply))
}

type Writer = fn(&Path, LitScene<'_>, Display, &dyn Progress) -> Result<Exported, OutputError>;

/// As typed, else what suits all cameras of the scene together.
fn exposure(config: &ExportConfig, solved: &Solved, progress: &dyn Progress) -> f32 {
    match config.exposure {
        Exposure::Fixed(multiplier) => multiplier,
        Exposure::Automatic => {
            let Solved { scene, hierarchy, tracer, solution, .. } = solved;
            let options = RenderOptions { samples: 1, view: View::Shaded };
            let renderer = Renderer::new(hierarchy, tracer.as_ref(), solution, options, progress);
            shared_exposure(&renderer, &scene.cameras)
        }
    }
}

fn told(path: &Path, exported: &Exported) -> String {
    let Exported { triangles, vertices, bytes } = exported;
    let megabytes = *bytes as f64 / 1e6;
    format!("{}: {triangles} triangles, {vertices} vertices, {megabytes:.1} MB\n", path.display())
}
