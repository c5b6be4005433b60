//! What can go wrong, and the exit code each kind of it gets.

use std::process::ExitCode;

use crate::image::write::OutputError;

/// How a run ended. The codes are an interface: `docs/exit-codes.md` documents them, and a test
/// holds the two together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ExitKind {
    Success,
    Usage,
    Unreadable,
    Malformed,
    InvalidScene,
    Output,
    Embree,
    CheckFailed,
    TracersDisagree,
    Internal,
}

impl ExitKind {
    pub(super) const ALL: [ExitKind; 10] = [
        ExitKind::Success,
        ExitKind::Usage,
        ExitKind::Unreadable,
        ExitKind::Malformed,
        ExitKind::InvalidScene,
        ExitKind::Output,
        ExitKind::Embree,
        ExitKind::CheckFailed,
        ExitKind::TracersDisagree,
        ExitKind::Internal,
    ];

    pub(super) fn code(self) -> u8 {
        match self {
            ExitKind::Success => 0,
            ExitKind::Usage => 2,
            ExitKind::Unreadable => 3,
            ExitKind::Malformed => 4,
            ExitKind::InvalidScene => 5,
            ExitKind::Output => 6,
            ExitKind::Embree => 7,
            ExitKind::CheckFailed => 8,
            ExitKind::TracersDisagree => 9,
            ExitKind::Internal => 70,
        }
    }

    pub(super) fn meaning(self) -> &'static str {
        match self {
            ExitKind::Success => "success",
            ExitKind::Usage => "bad arguments, such as an unknown option, a bad number or an unknown camera",
            ExitKind::Unreadable => "an input file is missing or cannot be read",
            ExitKind::Malformed => "an input file is malformed or belongs to another scene or version",
            ExitKind::InvalidScene => "the scene cannot be rendered, such as one without an emitter",
            ExitKind::Output => "an output cannot be written",
            ExitKind::Embree => "Embree is required but not usable",
            ExitKind::CheckFailed => "a check of the solution failed",
            ExitKind::TracersDisagree => "two tracers disagree by more than rounding",
            ExitKind::Internal => "a fault of lightshaft itself",
        }
    }
}

impl From<ExitKind> for ExitCode {
    fn from(kind: ExitKind) -> Self {
        ExitCode::from(kind.code())
    }
}

/// The exit codes as the last paragraph of `--help`.
pub(super) fn exit_codes_help() -> String {
    let mut text = String::from("Exit codes:");
    for kind in ExitKind::ALL {
        text.push_str(&format!("\n  {:>2}  {}", kind.code(), kind.meaning()));
    }
    text
}

/// Why a verb failed.
#[derive(Debug, thiserror::Error)]
pub(super) enum CliError {
    /// Arguments that fit the grammar but not each other or the scene.
    #[error("{0}")]
    Usage(String),
    /// An input file is missing or cannot be read.
    #[error("{0}")]
    Unreadable(String),
    /// An input file is malformed.
    #[error("{0}")]
    Malformed(String),
    /// The input is well formed, but not a scene that can be rendered.
    #[error("{0}")]
    InvalidScene(String),
    /// An output cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A folder cannot be filled.
    #[error("{0}")]
    OutputFolder(String),
    /// Embree is required, and none is usable.
    #[error("{0}")]
    Embree(String),
    /// The solution is not physically right.
    #[error("{0}")]
    CheckFailed(String),
    /// Two tracers gave different results.
    #[error("{0}")]
    TracersDisagree(String),
    /// Our own fault.
    #[error("internal fault, please report it: {0}")]
    Internal(String),
}

impl CliError {
    pub(super) fn kind(&self) -> ExitKind {
        match self {
            CliError::Usage(_) => ExitKind::Usage,
            CliError::Unreadable(_) => ExitKind::Unreadable,
            CliError::Malformed(_) => ExitKind::Malformed,
            CliError::InvalidScene(_) => ExitKind::InvalidScene,
            CliError::Output(_) | CliError::OutputFolder(_) => ExitKind::Output,
            CliError::Embree(_) => ExitKind::Embree,
            CliError::CheckFailed(_) => ExitKind::CheckFailed,
            CliError::TracersDisagree(_) => ExitKind::TracersDisagree,
            CliError::Internal(_) => ExitKind::Internal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documentation_has_every_code_and_no_other() {
        let documented: Vec<String> = include_str!("../../docs/exit-codes.md")
            .lines()
            .filter(|line| line.starts_with("| ") && line.as_bytes()[2].is_ascii_digit())
            .map(str::to_owned)
            .collect();
        assert_eq!(documented.len(), ExitKind::ALL.len(), "{documented:?}");
        for (kind, line) in ExitKind::ALL.iter().zip(&documented) {
            let expected = format!("| {} | {} |", kind.code(), kind.meaning());
            assert!(line.starts_with(&expected), "docs/exit-codes.md: {line}\nexpected: {expected}");
        }
    }

    #[test]
    fn codes_differ() {
        let mut codes = ExitKind::ALL.map(ExitKind::code);
        codes.sort_unstable();
        assert!(codes.windows(2).all(|pair| pair[0] < pair[1]), "{codes:?}");
    }
}
