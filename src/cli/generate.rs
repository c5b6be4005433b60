//! `generate`: scenes made by rule, of any size.

use super::args::{GenerateWhat, OfficeArgs};
use super::console;
use super::errors::CliError;
use crate::scene::{self, GenerateError, OfficeOptions};

/// Writes what was asked for and says what it is.
///
/// # Errors
/// [`CliError::Usage`] for a building that is too large, [`CliError::OutputFolder`] when the folder
/// cannot be made or filled, or holds files of the same names that were not generated.
pub(super) fn run(what: &GenerateWhat) -> Result<(), CliError> {
    match what {
        GenerateWhat::Office(office) => run_office(office),
    }
}

fn run_office(typed: &OfficeArgs) -> Result<(), CliError> {
    let options = OfficeOptions { floors: typed.floors, rooms: typed.rooms, ..OfficeOptions::default() };
    let written = scene::generate_office(&options, &typed.output).map_err(|error| match error {
        GenerateError::Options(message) => CliError::Usage(message),
        GenerateError::Occupied(_) | GenerateError::Io { .. } => CliError::OutputFolder(error.to_string()),
    })?;
    console::answer(&format!("{}: {} triangles\n", written.scene.display(), written.triangles))?;
    Ok(())
}
