//! What can be wrong with a scene, said in one line: where, what, and what to do about it.

use std::path::{Path, PathBuf};

/// Why a scene could not be loaded.
///
/// Displays as one line: `path:line: what was wrong; what to do`, without `:line` where there is no
/// line to name.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A file is missing or cannot be read.
    #[error("{}{message}", place(.file, .line))]
    Io {
        /// The file that names the missing one, or the missing file itself.
        file: PathBuf,
        /// Line that names the missing file, from 1.
        line: Option<u64>,
        /// What was wrong and what to do.
        message: String,
    },
    /// A file does not follow its format.
    #[error("{}{message}", place(.file, .line))]
    Parse {
        /// The malformed file.
        file: PathBuf,
        /// Line, from 1.
        line: Option<u64>,
        /// What was wrong and what to do.
        message: String,
    },
    /// Every file follows its format, but the scene makes no sense.
    #[error("{}{message}", place(.file, .line))]
    Invalid {
        /// The file with the senseless value.
        file: PathBuf,
        /// Line, from 1.
        line: Option<u64>,
        /// What was wrong and what to do.
        message: String,
    },
}

/// The kinds of [`SceneError`], for exit codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneErrorKind {
    /// A file is missing or cannot be read.
    Io,
    /// A file does not follow its format.
    Parse,
    /// The content makes no sense.
    Invalid,
}

impl SceneError {
    /// Which kind of fault it is.
    pub fn kind(&self) -> SceneErrorKind {
        match self {
            SceneError::Io { .. } => SceneErrorKind::Io,
            SceneError::Parse { .. } => SceneErrorKind::Parse,
            SceneError::Invalid { .. } => SceneErrorKind::Invalid,
        }
    }

    /// The file at fault, and the line in it (from 1) where one can be named.
    pub fn location(&self) -> (&Path, Option<u64>) {
        match self {
            SceneError::Io { file, line, .. }
            | SceneError::Parse { file, line, .. }
            | SceneError::Invalid { file, line, .. } => (file, *line),
        }
    }

    pub(super) fn io(file: &Path, line: Option<u64>, message: impl Into<String>) -> Self {
        SceneError::Io { file: file.to_path_buf(), line, message: message.into() }
    }

    pub(super) fn parse(file: &Path, line: Option<u64>, message: impl Into<String>) -> Self {
        SceneError::Parse { file: file.to_path_buf(), line, message: message.into() }
    }

    pub(super) fn invalid(file: &Path, line: Option<u64>, message: impl Into<String>) -> Self {
        SceneError::Invalid { file: file.to_path_buf(), line, message: message.into() }
    }
}

/// `file:line: ` or `file: `, on one line whatever the file is called.
fn place(file: &Path, line: &Option<u64>) -> String {
    let file: String = file
        .display()
        .to_string()
        .chars()
        .map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c })
        .collect();
    match line {
        Some(line) => format!("{file}:{line}: "),
        None => format!("{file}: "),
    }
}

/// Text from a file as it is shown in a message: quoted, control characters escaped, shortened.
pub(super) fn quoted(text: &str) -> String {
    const LONGEST: usize = 40;
    let mut shown: String = text.chars().take(LONGEST).flat_map(|c| c.escape_debug()).collect();
    if text.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    format!("'{shown}'")
}

/// Names for a message: quoted, in order, shortened after a few.
pub(super) fn name_list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 8;
    let names: Vec<&str> = names.into_iter().collect();
    let mut text = names.iter().take(SHOWN).map(|name| quoted(name)).collect::<Vec<_>>().join(", ");
    if names.len() > SHOWN {
        text.push_str(&format!(" and {} more", names.len() - SHOWN));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_one_line_with_its_place() {
        let error = SceneError::parse(Path::new("a\nb.obj"), Some(7), format!("{} is odd", quoted("x\ny")));
        assert_eq!(error.to_string(), "a\u{fffd}b.obj:7: 'x\\ny' is odd");
        assert_eq!(error.kind(), SceneErrorKind::Parse);
        let error = SceneError::io(Path::new("a.obj"), None, "not found");
        assert_eq!(error.to_string(), "a.obj: not found");
    }

    #[test]
    fn long_lists_and_long_names_are_shortened() {
        let names: Vec<String> = (0..12).map(|i| format!("m{i}")).collect();
        let list = name_list(names.iter().map(String::as_str));
        assert!(list.ends_with("'m7' and 4 more"), "{list}");
        assert!(quoted(&"y".repeat(1000)).chars().count() < 50);
    }
}
