//! `doctor`: which Embree was found, where, and whether it does what it should.

use super::args::DoctorArgs;
use super::console;
use super::errors::CliError;
use crate::tracer::embree::EmbreeReport;

/// Prints what was found on standard output.
///
/// # Errors
/// [`CliError::Embree`] when no Embree is usable.
pub(super) fn run(typed: &DoctorArgs) -> Result<(), CliError> {
    let report = EmbreeReport::new(typed.embree_lib.as_deref());
    let tracer = if report.is_usable() { "embree" } else { "fallback (pure Rust)" };
    console::answer(&format!(
        "lightshaft        {}\n{report}tracer in use     {tracer}\n",
        env!("CARGO_PKG_VERSION")
    ))?;
    if report.is_usable() {
        Ok(())
    } else {
        Err(CliError::Embree("Embree is not usable; every place tried is listed above".to_owned()))
    }
}
