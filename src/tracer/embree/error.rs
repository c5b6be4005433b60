//! What can go wrong: no library fits, or a mesh cannot be built.

use std::{fmt, path::PathBuf};

use embree4_sys::LoadError;

use super::library::Version;

/// Why there is no Embree tracer.
#[derive(Debug, thiserror::Error)]
pub enum EmbreeError {
    /// No library was found, or none of those found fits.
    #[error("no usable Embree (version 4.3 or later, below 5) was found; tried{}", list(tried))]
    NotFound {
        /// Every place in the order it was tried.
        tried: Vec<Attempt>,
    },
    /// The mesh breaks the rules of [`TraceMesh`](crate::tracer::TraceMesh).
    #[error("the mesh cannot be traced: {0}")]
    Mesh(String),
    /// Embree reported an error.
    #[error("Embree failed while {during}: {message}")]
    Failed {
        /// What it was doing.
        during: &'static str,
        /// What it said.
        message: String,
    },
}

impl EmbreeError {
    /// One line, for a warning; `Display` names every place that was tried, on lines of their own.
    pub fn summary(&self) -> String {
        let EmbreeError::NotFound { tried } = self else { return self.to_string() };
        // A library that is there and does not fit says more than places where there is none.
        match tried.iter().find(|attempt| attempt.is_of_a_library() || tried.len() == 1) {
            Some(attempt) => attempt.to_string(),
            None => "no version from 4.3 to below 5 was found".to_owned(),
        }
    }
}

/// One place where Embree was looked for in vain.
#[derive(Debug)]
pub struct Attempt {
    /// Why the place was tried.
    pub origin: Origin,
    /// File, folder or name; absent when the place itself is not known, such as a variable not set.
    pub place: Option<PathBuf>,
    /// Why it did not fit.
    pub refusal: Refusal,
}

impl Attempt {
    /// Whether a library was there. The system's loader does not say, so what it cannot load is not.
    fn is_of_a_library(&self) -> bool {
        match self.refusal {
            Refusal::Nothing(_) => false,
            Refusal::NotLoadable(_) => self.origin != Origin::System,
            _ => true,
        }
    }
}

/// Where a library came from, in the order of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Named on the command line.
    Option,
    /// Named by `LIGHTSHAFT_EMBREE_LIB`.
    Variable,
    /// In a folder `lib*` of `EMBREE_DIR`.
    EmbreeDir,
    /// Beside the executable, or in `../lib` from there.
    Executable,
    /// Fetched when lightshaft was built.
    Provisioned,
    /// On the system's search path for libraries.
    System,
}

/// Why a library is not used.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// Nothing is there.
    #[error("{0}")]
    Nothing(&'static str),
    /// It cannot be opened, or is not Embree.
    #[error("{0}")]
    NotLoadable(LoadError),
    /// Its device cannot be made, such as on an unsupported processor.
    #[error("it cannot make a device: {0}")]
    NoDevice(String),
    /// Its structs are not ours.
    #[error("it is version {0}; 4.3 or later and below 5 is needed")]
    Version(Version),
    /// It was built without filter functions.
    #[error("it was built without filter functions")]
    NoFilter,
    /// It loads, but does not do what it should.
    #[error("self-test `{name}` failed: {message}")]
    SelfTest {
        /// Which one.
        name: &'static str,
        /// What it saw.
        message: String,
    },
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Origin::Option => "--embree-lib",
            Origin::Variable => "LIGHTSHAFT_EMBREE_LIB",
            Origin::EmbreeDir => "EMBREE_DIR",
            Origin::Executable => "beside the executable",
            Origin::Provisioned => "provisioned by the build",
            Origin::System => "system",
        })
    }
}

impl fmt::Display for Attempt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            Some(place) => write!(f, "{} ({}): {}", place.display(), self.origin, self.refusal),
            None => write!(f, "{}: {}", self.origin, self.refusal),
        }
    }
}

fn list(tried: &[Attempt]) -> String {
    tried.iter().map(|attempt| format!("\n  {attempt}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn attempt(origin: Origin, refusal: Refusal) -> Attempt {
        Attempt { origin, place: Some("some/libembree4.so".into()), refusal }
    }

    #[test]
    fn the_summary_is_one_line_about_what_matters_most() {
        let old = || Refusal::Version(Version { major: 4, minor: 2, patch: 0 });
        let nothing = || attempt(Origin::Executable, Refusal::Nothing("no libembree4 is there"));
        for (tried, words) in [
            (vec![nothing(), nothing()], "no version from 4.3"),
            (vec![nothing(), attempt(Origin::System, old()), nothing()], "(system): it is version 4.2.0"),
            (vec![nothing()], "(beside the executable): no libembree4"),
        ] {
            let summary = EmbreeError::NotFound { tried }.summary();
            assert!(summary.contains(words) && summary.lines().count() == 1, "{summary}");
        }
    }
}
