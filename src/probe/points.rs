//! Files of probe points: a line `x y z nx ny nz` for each, `#` begins a comment.

use glam::DVec3;
use std::path::{Path, PathBuf};

/// Where irradiance is asked for, scene coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbePoint {
    /// Position, scene units.
    pub position: DVec3,
    /// Unit normal of the surface that is lit, real or imagined.
    pub normal: DVec3,
}

/// What is wrong with a file of points or of reference values; displays as one line `path:line: …`.
#[derive(Debug, thiserror::Error)]
pub enum ProbeError {
    /// The file is missing or cannot be read.
    #[error("{}: {message}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What was wrong and what to do.
        message: String,
    },
    /// A line does not follow the format.
    #[error("{}:{line}: {message}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What was wrong and what to do.
        message: String,
    },
    /// The file as a whole is of no use.
    #[error("{}: {message}", path.display())]
    Unfit {
        /// The file.
        path: PathBuf,
        /// What was wrong and what to do.
        message: String,
    },
}

/// Reads a text file whole.
pub(super) fn read_text(path: &Path) -> Result<String, ProbeError> {
    let unreadable = |message: String| ProbeError::Unreadable { path: path.to_owned(), message };
    let about = std::fs::metadata(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => unreadable("file not found; check the path".to_owned()),
        _ => unreadable(format!("cannot be read ({error}); check the file and its rights")),
    })?;
    if !about.is_file() {
        return Err(unreadable("is not a regular file; give a text file".to_owned()));
    }
    let bytes = std::fs::read(path)
        .map_err(|error| unreadable(format!("cannot be read ({error}); check the file and its rights")))?;
    String::from_utf8(bytes).map_err(|error| {
        let line =
            1 + error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count();
        let message = "not UTF-8 text; save the file as UTF-8".to_owned();
        ProbeError::Malformed { path: path.to_owned(), line, message }
    })
}

/// Reads a file of points. Normals need not have unit length.
///
/// # Errors
/// When the file cannot be read or holds no point; names the line of the first number that is malformed
/// or not finite, of a line that does not hold six of them, or of a normal of length zero.
pub fn read_points(path: &Path) -> Result<Vec<ProbePoint>, ProbeError> {
    let text = read_text(path)?;
    let mut points = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let bare = line.split('#').next().unwrap_or_default().trim_start_matches('\u{feff}').trim();
        if bare.is_empty() {
            continue;
        }
        let malformed =
            |message: String| ProbeError::Malformed { path: path.to_owned(), line: index + 1, message };
        points.push(parse(bare).map_err(malformed)?);
    }
    if points.is_empty() {
        let message = "holds no points; write one `x y z nx ny nz` a line".to_owned();
        return Err(ProbeError::Unfit { path: path.to_owned(), message });
    }
    Ok(points)
}

/// One point from its line.
fn parse(line: &str) -> Result<ProbePoint, String> {
    let mut numbers = Vec::with_capacity(6);
    for word in line.split_whitespace() {
        let number: f64 = word.parse().map_err(|_| {
            format!("{} is not a number; write `x y z nx ny nz`, separated by spaces", quoted(word))
        })?;
        if !number.is_finite() {
            return Err(format!("{} is not finite; write a finite number", quoted(word)));
        }
        numbers.push(number);
    }
    let &[x, y, z, nx, ny, nz] = numbers.as_slice() else {
        return Err(format!("{} numbers where six are needed; write `x y z nx ny nz`", numbers.len()));
    };
    let normal = DVec3::new(nx, ny, nz);
    // Scaled first: the squares of very long or short normals leave the range of numbers.
    let longest = normal.abs().max_element();
    if longest <= 0.0 {
        return Err("the normal has length zero; give the direction the lit surface faces".to_owned());
    }
    Ok(ProbePoint { position: DVec3::new(x, y, z), normal: (normal / longest).normalize() })
}

/// Text from a file as a message shows it.
pub(super) fn quoted(text: &str) -> String {
    let shown: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    format!("'{shown}'")
}
