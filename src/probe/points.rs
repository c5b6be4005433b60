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

/// Reads a text file whole; lines end with `\n` in the answer, whatever they end with in the file.
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
    let text = String::from_utf8(bytes).map_err(|error| {
        let before = String::from_utf8_lossy(&error.as_bytes()[..error.utf8_error().valid_up_to()]);
        let line = with_plain_ends(before.into_owned()).split('\n').count();
        let message = "not UTF-8 text; save the file as UTF-8".to_owned();
        ProbeError::Malformed { path: path.to_owned(), line, message }
    })?;
    Ok(with_plain_ends(text))
}

/// The same lines, with `\n` between them.
fn with_plain_ends(text: String) -> String {
    if text.contains('\r') { text.replace("\r\n", "\n").replace('\r', "\n") } else { text }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// What the reader makes of a file with this content.
    fn read(content: impl AsRef<[u8]>) -> Result<Vec<ProbePoint>, ProbeError> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("points.txt");
        std::fs::write(&path, content).expect("written");
        read_points(&path)
    }

    #[test]
    fn points_are_read_in_order_between_comments_and_empty_lines() {
        let text = "\u{feff}# x y z\r\n1 2 3 0 1 0\r\n\r\n \t4e0\t-5 .6 0 0 -1 # 7 8 9\n#\n";
        let expected = [(DVec3::new(1.0, 2.0, 3.0), DVec3::Y), (DVec3::new(4.0, -5.0, 0.6), -DVec3::Z)];
        let expected = expected.map(|(position, normal)| ProbePoint { position, normal });
        assert_eq!(read(text).expect("points"), expected);
        assert_eq!(read(text.replace("\r\n", "\r").replace('\n', "\r")).expect("points"), expected);
    }

    #[test]
    fn normals_get_unit_length_whatever_their_length() {
        for normal in ["0 1 0", "0 3 0", "0 1e-320 0", "0 1.7e308 0", "-0 1e-5 0"] {
            let points = read(format!("0 0 0 {normal}")).expect(normal);
            assert_eq!(points[0].normal, DVec3::Y, "{normal}");
        }
        for normal in ["1 2 -3", "1e308 1.5e308 -1e308", "1e-310 2e-310 1e-310"] {
            let points = read(format!("0 0 0 {normal}")).expect(normal);
            assert!((points[0].normal.length() - 1.0).abs() < 1e-12, "{normal}");
        }
    }

    #[test]
    fn the_first_line_that_is_no_point_is_named() {
        for (bad, part) in [
            ("0 0 0 0 0 0", "the normal has length zero"),
            ("0 0 0 -0 0 -0", "the normal has length zero"),
            ("0 0 0 0 1e-999 0", "the normal has length zero"),
            ("nan 0 0 0 1 0", "'nan' is not finite"),
            ("0 0 0 0 -inf 0", "'-inf' is not finite"),
            ("0 1e999 0 0 1 0", "'1e999' is not finite"),
            ("0 0 0 0 1", "5 numbers where six are needed"),
            ("0 0 0 0 1 0 0", "7 numbers where six are needed"),
            ("0, 0, 0, 0, 1, 0", "'0,' is not a number"),
            ("0 0 0 0 one 0", "'one' is not a number"),
            ("0 0 0 0 \u{1b}[31m 0", "'\\u{1b}[31m' is not a number"),
        ] {
            let error = read(format!("# heading\n\n0 0 0 0 1 0\n{bad}\nworse\n")).expect_err(bad);
            assert!(matches!(error, ProbeError::Malformed { line: 4, .. }), "{error}");
            assert!(error.to_string().contains(part), "{error}");
        }
    }

    #[test]
    fn files_without_points_are_unfit() {
        for text in ["", "\n\n", "# 0 0 0 0 1 0", "\u{feff}", "  \t \r\n#\n"] {
            let error = read(text).expect_err(text);
            assert!(matches!(error, ProbeError::Unfit { .. }), "{error}");
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_refused_with_their_line() {
        let error = read(b"0 0 0 0 1 0\n# \xe9t\xe9\n").expect_err("Latin-1");
        assert!(matches!(error, ProbeError::Malformed { line: 2, .. }), "{error}");
        assert!(error.to_string().contains("UTF-8"), "{error}");
        let error = read(b"0 0 0 0 1 0\r\n0 0 0 0 1 0\r# \xe9t\xe9\r").expect_err("Latin-1");
        assert!(matches!(error, ProbeError::Malformed { line: 3, .. }), "{error}");
    }

    #[test]
    fn what_is_no_file_is_unreadable() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for path in [folder.path().join("none.txt"), folder.path().to_owned()] {
            let error = read_points(&path).expect_err("no file");
            assert!(matches!(error, ProbeError::Unreadable { .. }), "{error}");
        }
    }
}
