//! The checked configuration of a model for other programs, or a page.

use std::path::PathBuf;

use super::super::args::ExportArgs;
use super::super::errors::CliError;
use super::{RunConfig, check_distinct, check_extension, checked_exposure};
use crate::image::tone::{Exposure, Tone};

/// Everything that is needed to export a solution.
#[derive(Clone, Debug)]
pub(in crate::cli) struct ExportConfig {
    /// The solution in it is the one to export; its scene is not known before that is opened.
    pub(in crate::cli) run: RunConfig,
    pub(in crate::cli) stored: PathBuf,
    /// Where the scene is, when it is typed.
    pub(in crate::cli) scene: Option<PathBuf>,
    pub(in crate::cli) glb: Option<PathBuf>,
    pub(in crate::cli) ply: Option<PathBuf>,
    pub(in crate::cli) html: Option<PathBuf>,
    /// The library of the page, when its folder is typed.
    pub(in crate::cli) three: Option<PathBuf>,
    pub(in crate::cli) exposure: Exposure,
    /// When it is typed.
    pub(in crate::cli) tone: Option<Tone>,
}

impl ExportConfig {
    /// Checks what depends on several options.
    ///
    /// # Errors
    /// [`CliError::Usage`] when options contradict each other. No file is touched.
    pub(in crate::cli) fn check(typed: ExportArgs) -> Result<Self, CliError> {
        let ExportArgs { stored, glb, ply, html, exposure, tone, three, scene, machine, print } = typed;
        check_extension("--glb", glb.as_deref(), "glb")?;
        check_extension("--ply", ply.as_deref(), "ply")?;
        check_extension("--html", html.as_deref(), "html")?;
        check_distinct(&[Some(&stored), scene.as_ref(), glb.as_ref(), ply.as_ref(), html.as_ref()])?;
        let exposure = checked_exposure(exposure)?;
        let outputs = [glb.as_ref(), ply.as_ref(), html.as_ref()].into_iter().flatten().cloned().collect();
        let run = RunConfig::of_stored(stored.clone(), outputs, machine, print.quiet)?;
        Ok(Self { run, stored, scene, glb, ply, html, three, exposure, tone: tone.map(Tone::from) })
    }
}
