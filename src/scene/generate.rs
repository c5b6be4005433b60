//! stub
use std::path::Path;
/// stub
#[derive(Debug)]
pub struct OfficeOptions;
/// stub
#[derive(Debug)]
pub struct OfficeSummary;
/// stub
#[derive(Debug)]
pub struct GenerateError;
/// stub
pub fn generate_office(_: &OfficeOptions, _: &Path) -> Result<OfficeSummary, GenerateError> {
    Err(GenerateError)
}
