//! Opening the shared library: all symbols bound at once, none made visible to others.

use std::{error::Error, fmt, mem::ManuallyDrop, ops::Deref, path::Path};

use crate::Embree;

/// Why a file could not be opened as Embree.
#[derive(Debug)]
pub enum LoadError {
    /// The system's loader refused it: no such file, not a library, a dependency is missing.
    Open(libloading::Error),
    /// It is a library, but a function of Embree 4.3 is not in it.
    Symbol(libloading::Error),
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LoadError::Open(error) => write!(f, "cannot be loaded: {}", deepest(error)),
            LoadError::Symbol(error) => write!(f, "is not Embree 4: {}", deepest(error)),
        }
    }
}

impl Error for LoadError {}

/// What the system said, which libloading keeps as the source of its own error.
fn deepest(error: &libloading::Error) -> String {
    let mut last: &dyn Error = error;
    while let Some(source) = last.source() {
        last = source;
    }
    last.to_string()
}

/// The functions of an opened library, until the end of the process.
///
/// It is never closed: worker threads of the library's task scheduler may still be running its
/// code after the last device is released.
pub struct Api(ManuallyDrop<Embree>);

impl Deref for Api {
    type Target = Embree;

    fn deref(&self) -> &Embree {
        &self.0
    }
}

impl fmt::Debug for Api {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Api").finish_non_exhaustive()
    }
}

/// Opens the library at `path` (or of that name, on the system's search path) and binds every
/// function. Its version is not checked.
///
/// # Safety
/// Opening a library runs its initialisers, and the functions are bound by name only: the file
/// must be trusted to be what its name says.
pub unsafe fn open(path: &Path) -> Result<Api, LoadError> {
    // SAFETY: the caller trusts the library's initialisers.
    let library = unsafe { open_library(path) }.map_err(LoadError::Open)?;
    // SAFETY: the caller trusts that functions of these names have Embree's signatures; a missing
    // one is an error here, not later.
    let functions = unsafe { Embree::from_library(library) }.map_err(LoadError::Symbol)?;
    Ok(Api(ManuallyDrop::new(functions)))
}

#[cfg(unix)]
unsafe fn open_library(path: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
    // SAFETY: handed on to the caller of `open`.
    unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map(Into::into)
}

#[cfg(not(unix))]
unsafe fn open_library(path: &Path) -> Result<libloading::Library, libloading::Error> {
    // SAFETY: handed on to the caller of `open`.
    unsafe { libloading::Library::new(path) }
}
