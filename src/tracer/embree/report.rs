//! What `doctor` prints about Embree.

use std::{fmt, path::Path, sync::Arc};

use super::{EmbreeError, EmbreeLibrary};

/// Which Embree is found and whether it works; its `Display` is several lines for people.
#[derive(Debug)]
pub struct EmbreeReport(Result<Arc<EmbreeLibrary>, EmbreeError>);

impl EmbreeReport {
    /// Searches as [`EmbreeLibrary::find`] does.
    pub fn new(option: Option<&Path>) -> Self {
        EmbreeReport(EmbreeLibrary::find(option))
    }

    /// The library, when one fits.
    pub fn library(&self) -> Option<&Arc<EmbreeLibrary>> {
        self.0.as_ref().ok()
    }

    /// Whether there is one and it passed every self-test.
    pub fn is_usable(&self) -> bool {
        self.0.is_ok()
    }
}

impl fmt::Display for EmbreeReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Ok(library) => {
                writeln!(f, "Embree            {}", library.version())?;
                writeln!(f, "  library         {}", library.path().display())?;
                writeln!(f, "  found           {}", library.origin())?;
                writeln!(f, "  instruction set {}", library.instruction_set())?;
                writeln!(f, "  task system     {}", library.task_system())?;
                for test in library.self_tests() {
                    writeln!(f, "  passed          {}: {}", test.name, test.message)?;
                }
                for attempt in library.refused() {
                    writeln!(f, "  tried before    {attempt}")?;
                }
                Ok(())
            }
            Err(error) => writeln!(f, "Embree            not usable\n{error}"),
        }
    }
}
