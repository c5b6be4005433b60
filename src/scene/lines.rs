//! Lines of a text file as OBJ and MTL mean them: numbered, with any line ending, continued after a
//! backslash, without byte order mark. Bounded in memory whatever the file holds.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use super::error::SceneError;

/// Longest logical line in bytes; a longer one is not a mesh.
const LONGEST_LINE: usize = 16 << 20;
/// Largest PNG or JPEG in bytes.
pub(super) const MOST_PICTURE_BYTES: u64 = 1 << 28;

/// Reads logical lines. Bytes, not text: files with other encodings in comments and names are common.
pub(super) struct Lines {
    file: PathBuf,
    reader: BufReader<Box<dyn Read>>,
    /// Physical lines read so far.
    physical: u64,
    /// The last line ended in `\r`: a `\n` that follows belongs to it.
    after_return: bool,
    text: Vec<u8>,
}

impl Lines {
    /// Opens a regular file.
    ///
    /// # Errors
    /// [`SceneError::Io`] when it is missing, not a regular file or not readable;
    /// [`SceneError::Parse`] when it is UTF-16.
    pub(super) fn open(path: &Path) -> Result<Self, SceneError> {
        Self::over(path, Box::new(open_regular(path)?))
    }

    fn over(path: &Path, reader: Box<dyn Read>) -> Result<Self, SceneError> {
        let mut reader = BufReader::with_capacity(1 << 18, reader);
        let start = reader.fill_buf().map_err(|error| unreadable(path, &error))?;
        if start.starts_with(&[0xFF, 0xFE]) || start.starts_with(&[0xFE, 0xFF]) {
            return Err(SceneError::parse(path, Some(1), "the file is UTF-16; save it as UTF-8"));
        }
        if start.starts_with(&[0xEF, 0xBB, 0xBF]) {
            reader.consume(3);
        }
        Ok(Self { file: path.to_path_buf(), reader, physical: 0, after_return: false, text: Vec::new() })
    }

    /// The next logical line and the number of its first physical line; `None` at the end.
    ///
    /// # Errors
    /// On read errors, NUL bytes (binary or UTF-16 files) and lines without end.
    pub(super) fn next_line(&mut self) -> Result<Option<(u64, &[u8])>, SceneError> {
        self.text.clear();
        if !self.append_physical()? {
            return Ok(None);
        }
        let first = self.physical;
        // A comment that ends in a backslash (a Windows folder, say) does not swallow what follows.
        let is_comment = self.text.trim_ascii_start().starts_with(b"#");
        while !is_comment && self.text.ends_with(b"\\") {
            self.text.pop();
            self.text.push(b' ');
            if !self.append_physical()? {
                break;
            }
        }
        if self.text.contains(&0) {
            return Err(SceneError::parse(
                &self.file,
                Some(first),
                "the line holds NUL bytes, so the file is binary or UTF-16; save it as UTF-8 text",
            ));
        }
        Ok(Some((first, &self.text)))
    }

    /// Appends one physical line without its ending; false at the end of the file.
    fn append_physical(&mut self) -> Result<bool, SceneError> {
        let mut found_any = false;
        loop {
            let buffer = self.reader.fill_buf().map_err(|error| unreadable(&self.file, &error))?;
            if buffer.is_empty() {
                self.physical += u64::from(found_any);
                return Ok(found_any);
            }
            if std::mem::take(&mut self.after_return) && buffer[0] == b'\n' {
                self.reader.consume(1);
                continue;
            }
            found_any = true;
            let end = buffer.iter().position(|&byte| byte == b'\n' || byte == b'\r');
            let taken = end.unwrap_or(buffer.len());
            if self.text.len() + taken > LONGEST_LINE {
                return Err(SceneError::parse(
                    &self.file,
                    Some(self.physical + 1),
                    format!(
                        "the line is longer than {} MiB; is this a text file? Split the line",
                        LONGEST_LINE >> 20
                    ),
                ));
            }
            self.text.extend_from_slice(&buffer[..taken]);
            if end.is_some() {
                self.after_return = buffer[taken] == b'\r';
                self.reader.consume(taken + 1);
                self.physical += 1;
                return Ok(true);
            }
            self.reader.consume(taken);
        }
    }
}

/// Opens a file that must be a regular one: devices and pipes have no end or cannot be read twice.
pub(super) fn open_regular(path: &Path) -> Result<File, SceneError> {
    let about = std::fs::metadata(path).map_err(|error| unreadable(path, &error))?;
    if about.is_dir() {
        return Err(SceneError::io(path, None, "is a folder; give a file in it"));
    }
    if !about.is_file() {
        return Err(SceneError::io(path, None, "is not a regular file; copy it to one"));
    }
    File::open(path).map_err(|error| unreadable(path, &error))
}

/// A whole regular file of at most so many bytes.
pub(super) fn read_whole(path: &Path, most: u64) -> Result<Vec<u8>, SceneError> {
    let file = open_regular(path)?;
    let length = file.metadata().map_err(|error| unreadable(path, &error))?.len();
    if length > most {
        let message = format!("larger than {} MiB; make it smaller", most >> 20);
        return Err(SceneError::invalid(path, None, message));
    }
    let mut bytes = Vec::new();
    if bytes.try_reserve_exact(length as usize).is_err() {
        return Err(SceneError::invalid(path, None, "larger than the memory that is free; make it smaller"));
    }
    file.take(length).read_to_end(&mut bytes).map_err(|error| unreadable(path, &error))?;
    Ok(bytes)
}

/// What an operating system error means for the reader.
pub(super) fn unreadable(path: &Path, error: &std::io::Error) -> SceneError {
    let message = match error.kind() {
        std::io::ErrorKind::NotFound => "file not found; check the path".to_owned(),
        std::io::ErrorKind::PermissionDenied => "no permission to read the file; change its mode".to_owned(),
        _ => format!("cannot be read ({error}); check the file and the disk"),
    };
    SceneError::io(path, None, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines_of(text: &[u8]) -> Vec<(u64, String)> {
        let bytes = std::io::Cursor::new(text.to_vec());
        let mut lines = Lines::over(Path::new("x.obj"), Box::new(bytes)).unwrap();
        let mut all = Vec::new();
        while let Some((number, line)) = lines.next_line().unwrap() {
            all.push((number, String::from_utf8_lossy(line).into_owned()));
        }
        all
    }

    fn expected(list: &[(u64, &str)]) -> Vec<(u64, String)> {
        list.iter().map(|&(number, line)| (number, line.to_owned())).collect()
    }

    #[test]
    fn every_line_ending_counts_once() {
        let want = expected(&[(1, "a"), (2, ""), (3, "b")]);
        assert_eq!(lines_of(b"a\n\nb"), want);
        assert_eq!(lines_of(b"a\r\n\r\nb\r\n"), want);
        assert_eq!(lines_of(b"a\r\rb\r"), want);
        assert_eq!(lines_of(b"\xEF\xBB\xBFa\n\nb\n"), want);
        assert_eq!(lines_of(b""), expected(&[]));
    }

    #[test]
    fn a_backslash_continues_a_line_but_not_a_comment() {
        assert_eq!(lines_of(b"f 1\\\n 2\nv"), expected(&[(1, "f 1  2"), (3, "v")]));
        assert_eq!(lines_of(b"f 1\\\r\n 2\\"), expected(&[(1, "f 1  2 ")]));
        assert_eq!(lines_of(b"# C:\\\nv"), expected(&[(1, "# C:\\"), (2, "v")]));
    }

    #[test]
    fn binary_and_utf16_files_are_named_as_such() {
        let open = |text: &[u8]| {
            Lines::over(Path::new("x.obj"), Box::new(std::io::Cursor::new(text.to_vec())))
                .and_then(|mut lines| lines.next_line().map(|_| ()))
                .unwrap_err()
                .to_string()
        };
        assert!(open(&[0xFF, 0xFE, b'v', 0]).contains("x.obj:1: the file is UTF-16"));
        assert!(open(&[b'v', 0, b' ', 0]).contains("x.obj:1: the line holds NUL"));
        assert!(open(&vec![b'v'; LONGEST_LINE + 1]).contains("longer than 16 MiB"));
    }
}
