//! Solution files that are named without their scene.

use std::path::{Path, PathBuf};

use super::errors::CliError;
use super::solved::file_failure;
use crate::export::SolutionFile;

/// Where the scene of a solution is: where it is said to be, else where the solution file says that it was.
///
/// # Errors
/// When the file cannot be read or does not say, or the scene is not there any more.
pub(super) fn scene_of(stored: &Path, typed: Option<&Path>) -> Result<PathBuf, CliError> {
    if let Some(scene) = typed {
        return Ok(scene.to_owned());
    }
    let file = SolutionFile::open(stored).map_err(file_failure)?;
    let shown = stored.display();
    let Some(scene) = &file.origin().scene else {
        return Err(CliError::Usage(format!(
            "{shown} does not say where its scene is; give it with --scene"
        )));
    };
    let seen_from = |file: &Path| file.parent().unwrap_or(Path::new("")).join(scene);
    // Seen from the name that is given, or from where a link leads to.
    let behind = || stored.canonicalize().ok().map(|file| seen_from(&file)).filter(|scene| scene.exists());
    let scene = Some(seen_from(stored)).filter(|scene| scene.exists()).or_else(behind);
    let scene = scene.unwrap_or_else(|| seen_from(stored));
    if !scene.exists() {
        return Err(CliError::Unreadable(format!(
            "{}: the scene of {shown} is not there any more; give it with --scene",
            scene.display()
        )));
    }
    Ok(scene)
}
