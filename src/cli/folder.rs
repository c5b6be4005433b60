//! Folders that are filled by one run, and made for it when they are missing.

use std::path::{Path, PathBuf};

use super::errors::CliError;
use crate::image::write::{OutputError, check_destination};

/// Checks, before a long run, that files can be written into a folder of their own; leaves nothing behind. A folder that
/// is missing can be made, if the one that it lies in is there.
///
/// # Errors
/// [`CliError::OutputFolder`] and [`CliError::Output`] when they cannot.
pub(super) fn check_folder(folder: &Path, files: &[PathBuf]) -> Result<(), CliError> {
    if is_here(folder) || folder.is_dir() {
        return Ok(files.iter().try_for_each(|path| check_destination(path))?);
    }
    if folder.exists() {
        return Err(CliError::OutputFolder(format!("{}: exists and is not a folder", folder.display())));
    }
    // It needs what a file in its place would need.
    Ok(check_destination(folder)?)
}

/// Makes the folder when it is missing.
///
/// # Errors
/// When the system refuses.
pub(super) fn make_folder(folder: &Path) -> Result<(), OutputError> {
    if is_here(folder) || folder.is_dir() {
        return Ok(());
    }
    std::fs::create_dir(folder).map_err(|source| OutputError::Io { path: folder.to_owned(), source })
}

/// The folder of a bare file name.
fn is_here(folder: &Path) -> bool {
    folder.as_os_str().is_empty()
}
