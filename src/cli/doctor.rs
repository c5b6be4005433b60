//! `doctor`: which Embree was found, where, and whether it does what it should.

use std::fmt::Write;

use super::args::DoctorArgs;
use super::console;
use super::errors::CliError;
use super::pending::tracer::{self, Diagnosis};

/// Prints what was found on standard output.
///
/// # Errors
/// [`CliError::Embree`] when no Embree is usable.
pub(super) fn run(typed: &DoctorArgs) -> Result<(), CliError> {
    let diagnosis = tracer::diagnose(typed.embree_lib.as_deref());
    console::answer(&page(&diagnosis));
    match diagnosis.problem {
        None => Ok(()),
        Some(problem) => Err(CliError::Embree(problem)),
    }
}

/// One line for each fact, label first.
fn page(diagnosis: &Diagnosis) -> String {
    const UNKNOWN: &str = "-";
    let or_unknown = |fact: &Option<String>| fact.clone().unwrap_or_else(|| UNKNOWN.to_owned());
    let library = diagnosis.library.as_ref().map(|path| path.display().to_string());
    let mut rows = vec![
        ("lightshaft", env!("CARGO_PKG_VERSION").to_owned()),
        ("Embree library", or_unknown(&library)),
        ("found by", or_unknown(&diagnosis.found_by)),
        ("version", or_unknown(&diagnosis.version)),
        ("instruction set", or_unknown(&diagnosis.instruction_set)),
    ];
    for (test, outcome) in &diagnosis.self_tests {
        let verdict = match outcome {
            Ok(()) => "passed".to_owned(),
            Err(reason) => format!("FAILED: {reason}"),
        };
        rows.push((test, verdict));
    }
    rows.push((
        "tracer in use",
        match diagnosis.problem {
            None => "embree".to_owned(),
            Some(_) => "fallback (pure Rust)".to_owned(),
        },
    ));
    let width = rows.iter().map(|(label, _)| label.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for (label, fact) in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{label:<width$}  {fact}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_self_test_is_seen() {
        let diagnosis = Diagnosis {
            library: Some("/opt/libembree4.so".into()),
            found_by: Some("--embree-lib".to_owned()),
            version: Some("4.2.0".to_owned()),
            instruction_set: None,
            self_tests: vec![("struct layout", Err("wrote past RTCRayHit".to_owned()))],
            problem: Some("struct layout".to_owned()),
        };
        let text = page(&diagnosis);
        for part in
            ["/opt/libembree4.so", "--embree-lib", "4.2.0", "FAILED: wrote past RTCRayHit", "fallback"]
        {
            assert!(text.contains(part), "{part} is missing:\n{text}");
        }
    }
}
