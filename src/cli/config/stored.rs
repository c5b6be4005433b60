//! The checked configuration of what is done with a solution file alone.

use std::path::PathBuf;

use super::super::args::{ExactnessArgs, MachineArgs, QualityArg, SolutionArgs, VisibilityArg};
use super::super::errors::CliError;
use super::RunConfig;

impl RunConfig {
    /// With a solution that is read; its scene is not known before that is opened.
    ///
    /// # Errors
    /// [`CliError::Usage`] when options contradict each other.
    pub(super) fn of_stored(
        stored: PathBuf,
        outputs: Vec<PathBuf>,
        machine: MachineArgs,
        quiet: bool,
    ) -> Result<Self, CliError> {
        // All that is said here about solving is what the file says.
        let exactness = ExactnessArgs {
            quality: QualityArg::Normal,
            epsilon: None,
            min_size: None,
            iterations: None,
            certify: false,
            one_sided: false,
        };
        let solution = SolutionArgs { exactness, rays: None, visibility: VisibilityArg::Adaptive };
        let run = RunConfig::check(PathBuf::new(), outputs, solution, machine, quiet)?;
        Ok(RunConfig { stored: Some(stored), ..run })
    }
}
