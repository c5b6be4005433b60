//! The checked configuration of other light for a solution.

use std::path::PathBuf;

use super::super::args::RelightArgs;
use super::super::errors::CliError;
use super::{RunConfig, check_distinct, check_extension, usage};
use crate::radiosity::Reuse;
use crate::scene::MaterialChange;

/// Everything that is needed to give a solution other light.
#[derive(Clone, Debug)]
pub(in crate::cli) struct RelightConfig {
    /// The solution in it is the one to change; its scene is not known before that is opened.
    pub(in crate::cli) run: RunConfig,
    pub(in crate::cli) stored: PathBuf,
    /// Where the scene is, when it is typed.
    pub(in crate::cli) scene: Option<PathBuf>,
    pub(in crate::cli) changes: Vec<MaterialChange>,
    pub(in crate::cli) reuse: Reuse,
    /// Whether elements for display are made.
    pub(in crate::cli) local_pass: bool,
    pub(in crate::cli) output: PathBuf,
    pub(in crate::cli) stats: Option<PathBuf>,
}

impl RelightConfig {
    /// Checks what depends on several options.
    ///
    /// # Errors
    /// [`CliError::Usage`] when options contradict each other. No file is touched.
    pub(in crate::cli) fn check(typed: RelightArgs) -> Result<Self, CliError> {
        let RelightArgs { stored, changes, output, scene, refine, display, machine, statistics, print } =
            typed;
        let stats = statistics.stats;
        check_extension("--output", Some(&output), "lsol")?;
        check_extension("--stats", stats.as_deref(), "json")?;
        check_distinct(&[Some(&stored), scene.as_ref(), Some(&output), stats.as_ref()])?;
        let twice = (1..changes.len())
            .find(|&later| changes[..later].iter().any(|change| change.contradicts(&changes[later])));
        if let Some(change) = twice.map(|later| &changes[later]) {
            let key = if change.radiance.is_some() { "radiance" } else { "reflectance" };
            return usage(&format!("--set {}.{key} is given twice", change.name));
        }
        let outputs = [Some(&output), stats.as_ref()].into_iter().flatten().cloned().collect();
        let run = RunConfig::of_stored(stored.clone(), outputs, machine, print.quiet)?;
        let reuse = if refine { Reuse::Refined } else { Reuse::Links };
        Ok(Self { run, stored, scene, changes, reuse, local_pass: display.local_pass, output, stats })
    }
}
