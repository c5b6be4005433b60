//! The checked configuration of a convergence run.

use std::path::PathBuf;

use super::super::args::{ConvergenceArgs, QualityArg};
use super::super::errors::CliError;
use super::{Preset, RunConfig, SolveConfig, check_distinct, check_extension};

/// The coarsest setting of a convergence run, on the scale of [`Preset::at`].
const COARSEST: f64 = -0.5;

/// Everything a convergence run needs to know.
#[derive(Clone, Debug)]
pub(in crate::cli) struct ConvergenceConfig {
    /// With the last of the settings.
    pub(in crate::cli) run: RunConfig,
    /// From coarse to fine.
    pub(in crate::cli) settings: Vec<SolveConfig>,
    pub(in crate::cli) points: PathBuf,
    pub(in crate::cli) reference: PathBuf,
    pub(in crate::cli) samples: u32,
    pub(in crate::cli) output: Option<PathBuf>,
    pub(in crate::cli) plot: Option<PathBuf>,
}

impl ConvergenceConfig {
    /// Makes the settings and checks what depends on several options.
    ///
    /// # Errors
    /// [`CliError::Usage`] when options contradict each other. No file is touched.
    pub(in crate::cli) fn check(typed: ConvergenceArgs) -> Result<Self, CliError> {
        check_extension("--output", typed.output.as_deref(), "json")?;
        check_extension("--plot", typed.plot.as_deref(), "svg")?;
        let outputs = [typed.output.as_ref(), typed.plot.as_ref()];
        let inputs = [Some(&typed.scene), Some(&typed.points), Some(&typed.reference)];
        check_distinct(&[&inputs[..], &outputs[..]].concat())?;
        let last = match typed.solution.exactness.quality {
            QualityArg::Draft => 0.0,
            QualityArg::Normal => 1.0,
            QualityArg::High => 2.0,
        };
        let step = (last - COARSEST) / f64::from(typed.settings - 1);
        let settings = (0..typed.settings)
            .map(|i| SolveConfig::of(&typed.solution, &Preset::at(COARSEST + f64::from(i) * step)))
            .collect();
        let outputs = outputs.into_iter().flatten().cloned().collect();
        let run = RunConfig::check(typed.scene, outputs, typed.solution, typed.machine, typed.print.quiet)?;
        Ok(Self {
            run,
            settings,
            points: typed.points,
            reference: typed.reference,
            samples: typed.samples,
            output: typed.output,
            plot: typed.plot,
        })
    }
}
