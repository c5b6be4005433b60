//! What can be wrong with a solution file.

use std::io;
use std::path::{Path, PathBuf};

use super::solution::VERSION;

/// Why a solution file cannot be used; displays as one line that begins with the file.
#[derive(Debug, thiserror::Error)]
pub enum SolutionFileError {
    /// The file is missing or cannot be read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file is something else.
    #[error("{}: this is no solution file; `lightshaft solve` writes them", path.display())]
    NoSolution {
        /// The file.
        path: PathBuf,
    },
    /// The format has another version.
    #[error(
        "{}: written by {} lightshaft ({program}, format {found}; this one reads format {VERSION}); {}",
        path.display(),
        if *found > VERSION { "a newer" } else { "an older" },
        if *found > VERSION { "use that one, or solve again with this one" } else { "solve again" }
    )]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// Version of its format.
        found: u32,
        /// Version of the program that wrote it.
        program: String,
    },
    /// The file belongs to another scene.
    #[error("{}: solved {difference}; solve again, or give the scene that it was solved for", path.display())]
    OtherScene {
        /// The file.
        path: PathBuf,
        /// What differs, as in "solved …".
        difference: &'static str,
    },
    /// The file ends too early.
    #[error("{}: the file ends too early, as after a copy that was broken off; copy it or solve again", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
    },
    /// The content is not what was written.
    #[error("{}: the file is damaged: {what}; copy it or solve again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What gave it away.
        what: String,
    },
}

/// What can be wrong with a part of a file, wherever it comes from.
#[derive(Debug)]
pub(super) enum Fault {
    Unreadable(io::Error),
    NoSolution,
    OtherVersion(u32, String),
    OtherScene(&'static str),
    Truncated,
    Damaged(String),
}

impl Fault {
    pub(super) fn of(self, path: &Path) -> SolutionFileError {
        let path = path.to_owned();
        match self {
            Fault::Unreadable(source) => SolutionFileError::Unreadable { path, source },
            Fault::NoSolution => SolutionFileError::NoSolution { path },
            Fault::OtherVersion(found, program) => SolutionFileError::OtherVersion { path, found, program },
            Fault::OtherScene(difference) => SolutionFileError::OtherScene { path, difference },
            Fault::Truncated => SolutionFileError::Truncated { path },
            Fault::Damaged(what) => SolutionFileError::Damaged { path, what },
        }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Fault {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => Fault::Truncated,
            _ => Fault::Unreadable(error),
        }
    }
}
