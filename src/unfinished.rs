//! Files on their way to their place: without a name, or under a temporary one, until they are complete.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::Stdio;

use tempfile::{Builder, NamedTempFile};

/// A file that takes its place when it is finished, and vanishes when it is not.
#[derive(Debug)]
pub struct Unfinished {
    destination: PathBuf,
    content: Content,
}

#[derive(Debug)]
enum Content {
    /// Without a name nothing is left behind, however the process ends.
    #[cfg(target_os = "linux")]
    Unnamed(File),
    /// Where the file system knows no files without a name.
    Named(NamedTempFile),
}

impl Unfinished {
    /// An empty file in the folder of `path`, or of the file that a link there leads to.
    ///
    /// It has the permissions of the file that it will replace, or those of any new file.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn at(path: &Path) -> io::Result<Self> {
        let destination = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let content = Content::in_folder(folder_of(&destination))?;
        if let Ok(replaced) = destination.metadata() {
            content.file().set_permissions(replaced.permissions())?;
        }
        Ok(Self { destination, content })
    }

    /// What another program needs to fill the file: what it gets as its standard output, and the name by which it can
    /// open the file then.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn lend(&self) -> io::Result<(Stdio, PathBuf)> {
        match &self.content {
            // It needs no rights over this process, and sees a file in which it can go back and forth.
            #[cfg(target_os = "linux")]
            Content::Unnamed(file) => Ok((Stdio::from(file.try_clone()?), PathBuf::from("/proc/self/fd/1"))),
            Content::Named(file) => Ok((Stdio::null(), std::path::absolute(file.path())?)),
        }
    }

    /// Bytes that are in it so far.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn size(&self) -> io::Result<u64> {
        Ok(self.content.file().metadata()?.len())
    }

    /// Moves the file to its place in one step.
    ///
    /// # Errors
    /// When the system refuses; then what stands there is as before.
    pub fn finish(self) -> io::Result<()> {
        self.content.file().sync_all()?;
        let named = match self.content {
            // A link cannot replace a file, so it goes beside it first.
            #[cfg(target_os = "linux")]
            Content::Unnamed(file) => temporary_name()
                .make_in(folder_of(&self.destination), |name| unnamed::link(&file, name))?
                .into_temp_path(),
            Content::Named(file) => file.into_temp_path(),
        };
        named.persist(&self.destination).map_err(|refused| refused.error)
    }
}

impl Write for Unfinished {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.content.file().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.content.file().flush()
    }
}

impl Seek for Unfinished {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.content.file().seek(to)
    }
}

impl Content {
    fn in_folder(folder: &Path) -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        if let Some(file) = unnamed::create(folder) {
            return Ok(Self::Unnamed(file));
        }
        let mut builder = temporary_name();
        // The usual rights of a new file, less the umask, instead of the private ones of a temporary.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        // The error of the library names the temporary file, which is no concern of the user.
        builder.tempfile_in(folder).map(Self::Named).map_err(|error| error.kind().into())
    }

    fn file(&self) -> &File {
        match self {
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => file,
            Self::Named(file) => file.as_file(),
        }
    }
}

/// A nameless file in the folder of `path`, for what has to wait until it can be written there.
///
/// # Errors
/// When the folder is missing or not writable, or the disk is full.
pub fn kept_aside(path: &Path) -> io::Result<File> {
    tempfile::tempfile_in(folder_of(path)).map_err(|error| error.kind().into())
}

/// The folder that a path names its file in.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn temporary_name() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(".lightshaft-").suffix(".tmp");
    builder
}

/// Files without a name, open(2) with `O_TMPFILE`.
#[cfg(target_os = "linux")]
mod unnamed {
    use std::fs::File;
    use std::io;
    use std::os::fd::AsRawFd;
    use std::path::{Path, PathBuf};

    use rustix::fs::{AtFlags, CWD, Mode, OFlags, linkat, open};

    /// A new file; nothing where the file system has none without a name or they cannot be named later.
    pub(super) fn create(folder: &Path) -> Option<File> {
        let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
        let file = File::from(open(folder, flags, Mode::from_raw_mode(0o666)).ok()?);
        by_descriptor(&file).exists().then_some(file)
    }

    /// Gives the file a name that is free.
    pub(super) fn link(file: &File, name: &Path) -> io::Result<()> {
        Ok(linkat(CWD, by_descriptor(file), CWD, name, AtFlags::SYMLINK_FOLLOW)?)
    }

    fn by_descriptor(file: &File) -> PathBuf {
        PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).expect("test folder");
        entries.map(|entry| entry.expect("entry").file_name().to_string_lossy().into_owned()).collect()
    }

    fn named_at(path: &Path) -> Unfinished {
        let file = temporary_name().tempfile_in(folder_of(path)).expect("a temporary file");
        Unfinished { destination: path.to_owned(), content: Content::Named(file) }
    }

    #[test]
    fn a_file_with_and_without_a_name_takes_its_place_or_vanishes() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("a");
        for create in [|path: &Path| Unfinished::at(path).expect("created"), named_at] {
            drop(create(&path));
            assert_eq!(names(folder.path()), Vec::<String>::new());
            for text in ["new", "replaced"] {
                let mut file = create(&path);
                file.write_all(text.as_bytes()).expect("written");
                file.finish().expect("finished");
                assert_eq!(std::fs::read_to_string(&path).expect("readable"), text);
                assert_eq!(names(folder.path()), ["a"]);
            }
            std::fs::remove_file(&path).expect("removed");
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn nothing_is_seen_of_a_file_before_it_is_finished() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let Some(_) = unnamed::create(folder.path()) else { return };
        let mut file = Unfinished::at(&folder.path().join("a")).expect("created");
        file.write_all(b"half").expect("written");
        // What is not there cannot be left behind by a signal.
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }
}
