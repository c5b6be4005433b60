//! `generate`: scenes made by rule, of any size.

use std::fs;
use std::path::Path;

use super::args::{GenerateWhat, OfficeArgs};
use super::console;
use super::errors::CliError;
use crate::scene::{self, GenerateError, OfficeOptions};

/// Writes what was asked for and says what it is.
///
/// # Errors
/// [`CliError::OutputFolder`] when the folder cannot be made or filled, or is not empty.
pub(super) fn run(what: &GenerateWhat) -> Result<(), CliError> {
    match what {
        GenerateWhat::Office(office) => run_office(office),
    }
}

fn run_office(typed: &OfficeArgs) -> Result<(), CliError> {
    prepare_folder(&typed.output, typed.force)?;
    let options = OfficeOptions { floors: typed.floors, rooms: typed.rooms, ..OfficeOptions::default() };
    let written = scene::generate_office(&options, &typed.output).map_err(|error| match error {
        GenerateError::Options { .. } => CliError::Usage(error.to_string()),
        _ => CliError::OutputFolder(error.to_string()),
    })?;
    console::answer(&format!(
        "{}: {} triangles\n",
        typed.output.join("scene.toml").display(),
        written.triangles
    ));
    Ok(())
}

/// Makes sure that `folder` exists and is empty, or may be overwritten.
fn prepare_folder(folder: &Path, force: bool) -> Result<(), CliError> {
    let refused = |what: &str| CliError::OutputFolder(format!("{}: {what}", folder.display()));
    if folder.exists() && !folder.is_dir() {
        return Err(refused("exists and is not a folder"));
    }
    fs::create_dir_all(folder).map_err(|error| refused(&format!("cannot create it: {error}")))?;
    let mut entries = fs::read_dir(folder).map_err(|error| refused(&format!("cannot read it: {error}")))?;
    if !force && entries.next().is_some() {
        return Err(refused("the folder is not empty; choose another or add --force"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn somebodys_files_are_not_overwritten_unasked() {
        let parent = tempfile::tempdir().expect("temporary folder");
        let new = parent.path().join("a/b");
        prepare_folder(&new, false).expect("made");
        prepare_folder(&new, false).expect("an empty folder will do");
        fs::write(new.join("scene.toml"), "mine").expect("written");
        assert!(matches!(prepare_folder(&new, false), Err(CliError::OutputFolder(_))));
        prepare_folder(&new, true).expect("asked for");
        assert!(matches!(prepare_folder(&new.join("scene.toml"), true), Err(CliError::OutputFolder(_))));
    }
}
