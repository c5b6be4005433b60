//! `export`: from a solution file to models of the lit scene for other programs, and to a page to walk through.

use std::path::Path;

use super::config::{ExportConfig, RunConfig};
use super::console;
use super::errors::CliError;
use super::solved::{Loaded, Solved, in_pool};
use super::stored::scene_of;
use crate::export::{
    Display, Exported, LitScene, WebLibrary, WebLibraryError, write_glb, write_ply, write_walk,
};
use crate::image::tone::{Exposure, Tone};
use crate::image::write::{OutputError, check_destination};
use crate::image::{RenderOptions, Renderer, View, shared_exposure};
use crate::progress::Progress;

/// Exports as configured.
///
/// # Errors
/// The first thing that goes wrong; then no output has been touched, except that those that are written stay when writing
/// the next one fails.
pub(super) fn run(config: &ExportConfig) -> Result<(), CliError> {
    for path in &config.run.outputs {
        check_destination(path)?;
    }
    let library = config.html.as_ref().map(|_| WebLibrary::find(config.three.as_deref()));
    let library = library.transpose().map_err(library_failure)?;
    let scene = scene_of(&config.stored, config.scene.as_deref())?;
    let run = RunConfig { scene, ..config.run.clone() };
    in_pool(&run, |progress| run_in_pool(config, &run, library.as_ref(), progress))
}

fn run_in_pool(
    config: &ExportConfig,
    run: &RunConfig,
    library: Option<&WebLibrary>,
    progress: &dyn Progress,
) -> Result<(), CliError> {
    let solved = Loaded::load(run, progress)?.solve(run, progress)?;
    let exposure = exposure(config, &solved, progress);
    let display = |usual: Tone| Display { exposure, tone: config.tone.unwrap_or(usual) };
    if !run.quiet && config.exposure == Exposure::Automatic {
        console::note(&format!("exposure of the colours: {exposure} (--exposure)\n"));
    }
    let Solved { scene, hierarchy, solution, .. } = &solved;
    let lit = LitScene { scene, hierarchy, solution };
    let write = |path: &Path, write: &Writer<'_>| -> Result<(), CliError> {
        progress.start("export", solution.forest.side_count() as u64);
        let exported = write(path);
        progress.finish();
        if !run.quiet {
            console::note(&told(path, &exported?));
        } else {
            exported?;
        }
        Ok(())
    };
    if let Some(path) = &config.glb {
        write(path, &|path| write_glb(path, lit, display(Tone::Plain), progress))?;
    }
    if let Some(path) = &config.ply {
        write(path, &|path| write_ply(path, lit, display(Tone::Plain), progress))?;
    }
    if let (Some(path), Some(library)) = (&config.html, library) {
        write(path, &|path| write_walk(path, lit, display(Tone::Filmic), library, progress))?;
    }
    Ok(())
}

type Writer<'a> = dyn Fn(&Path) -> Result<Exported, OutputError> + 'a;

/// What a missing or unusable library of the page means for the caller.
fn library_failure(error: WebLibraryError) -> CliError {
    match error {
        WebLibraryError::Missing | WebLibraryError::Unreadable { .. } => {
            CliError::Unreadable(error.to_string())
        }
        WebLibraryError::Foreign { .. } => CliError::Malformed(error.to_string()),
    }
}

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
