//! Lines for people. Nothing here panics when the other end of a pipe is gone.

use std::io::{self, Write};
use std::path::PathBuf;

use crate::image::write::OutputError;
use crate::report::text::printable;

/// Writes `error: …` on standard error, as one line whatever `message` holds.
pub(super) fn error(message: &str) {
    let _ = writeln!(io::stderr(), "error: {}", one_line(message));
}

/// Writes `warning: …` on standard error, as one line.
pub(super) fn warning(message: &str) {
    let _ = writeln!(io::stderr(), "warning: {}", one_line(message));
}

/// Writes `text` on standard error, but for control characters.
pub(super) fn note(text: &str) {
    let _ = io::stderr().write_all(printable(text).as_bytes());
}

/// Writes `text` on standard output, but for control characters. A reader that has left is no error; a full disk is.
pub(super) fn answer(text: &str) -> Result<(), OutputError> {
    let mut out = io::stdout().lock();
    match out.write_all(printable(text).as_bytes()).and_then(|()| out.flush()) {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(OutputError::Io { path: PathBuf::from("standard output"), source })
        }
        _ => Ok(()),
    }
}

/// Joins the lines of a message, and blanks control characters that a file may have smuggled in.
fn one_line(message: &str) -> String {
    let lines = message.lines().map(str::trim).filter(|line| !line.is_empty());
    let joined = lines.collect::<Vec<_>>().join(" ");
    joined.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_one_line_without_control_characters() {
        assert_eq!(one_line("a: bad\n   |\n 2 | x\r\n\n"), "a: bad | 2 | x");
        assert_eq!(one_line("red \u{1b}[31mtext\u{7}"), "red  [31mtext ");
    }
}
