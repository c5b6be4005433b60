//! The checked configuration of a comparison of the tracers.

use std::path::PathBuf;

use super::super::args::{CompareArgs, MachineArgs, SolutionArgs, TracerArg, ViewArg, VisibilityArg};
use super::super::errors::CliError;
use super::{RunConfig, ViewConfig, check_distinct, check_extension, usage};
use crate::image::tone::Exposure;

/// Everything a comparison of the tracers needs to know.
#[derive(Clone, Debug)]
pub(in crate::cli) struct CompareConfig {
    pub(in crate::cli) run: RunConfig,
    /// The first camera when absent.
    pub(in crate::cli) camera: Option<String>,
    pub(in crate::cli) view: ViewConfig,
    /// Rays made by rule.
    pub(in crate::cli) rays: u32,
    /// Times the rays are timed.
    pub(in crate::cli) repeats: u32,
    /// Times the scene is solved and rendered to see how long it takes.
    pub(in crate::cli) solves: u32,
    /// Where pictures go: native, fallback, difference.
    pub(in crate::cli) pictures: Option<Pictures>,
    /// Where the worst rays go.
    pub(in crate::cli) replay_file: Option<PathBuf>,
    /// Rays to be traced again, instead of everything else.
    pub(in crate::cli) replay: Option<PathBuf>,
    pub(in crate::cli) json: Option<PathBuf>,
    pub(in crate::cli) html: Option<PathBuf>,
}

/// The pictures of a comparison.
#[derive(Clone, Debug)]
pub(in crate::cli) struct Pictures {
    pub(in crate::cli) folder: PathBuf,
    /// Native, fallback, difference.
    pub(in crate::cli) files: [PathBuf; 3],
}

impl CompareConfig {
    /// Fills in the defaults and checks what depends on several options.
    ///
    /// # Errors
    /// [`CliError::Usage`] when options contradict each other. No file is touched.
    pub(in crate::cli) fn check(typed: CompareArgs) -> Result<Self, CliError> {
        check_extension("--json", typed.json.as_deref(), "json")?;
        check_extension("--html", typed.html.as_deref(), "html")?;
        if typed.visibility == VisibilityArg::All {
            return usage("--visibility all asks neither tracer, so there is nothing to compare");
        }
        let pictures = typed.output.map(|folder| {
            let files = ["native.png", "fallback.png", "difference.png"].map(|name| folder.join(name));
            Pictures { folder, files }
        });
        let written: Vec<&PathBuf> = pictures
            .iter()
            .flat_map(|pictures| &pictures.files)
            .chain(typed.replay_file.as_ref())
            .chain(typed.json.as_ref())
            .chain(typed.html.as_ref())
            .collect();
        let named: Vec<_> = [&typed.scene].into_iter().chain(written.iter().copied()).map(Some).collect();
        check_distinct(&named)?;
        let outputs = written.into_iter().cloned().collect();
        let view = ViewConfig::of(typed.picture, Exposure::Automatic, ViewArg::Shaded);
        let solution =
            SolutionArgs { exactness: typed.exactness, rays: typed.pair_rays, visibility: typed.visibility };
        let machine = MachineArgs { tracer: TracerArg::Embree, library: typed.machine };
        Ok(Self {
            run: RunConfig::check(typed.scene, outputs, solution, machine, typed.print.quiet)?,
            camera: typed.camera,
            view,
            rays: typed.rays,
            repeats: typed.repeat,
            solves: typed.solves,
            pictures,
            replay_file: typed.replay_file,
            replay: typed.replay,
            json: typed.json,
            html: typed.html,
        })
    }
}
