//! Files of segments to be traced again, one by one.
//!
//! The first line names the format and its version, the second the geometry; then a line for each segment: both ends
//! in local coordinates, the facets they lie on (`-` for none), and the kind. `#` begins a comment.

use super::rays::Disagreement;
use crate::image::write::{FillError, OutputError, write_atomically};
use crate::math::hash_pair;
use crate::tracer::{NO_FACET, Segment, TraceMesh};
use glam::Vec3;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// What the first line begins with.
const HEADING: &str = "lightshaft replay";

/// Of the format.
const VERSION: u32 = 1;

/// A segment of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// The kind of segment that it was.
    pub kind: String,
    /// The segment.
    pub segment: Segment,
}

/// What is wrong with a replay file; displays as one line `path:line: …`.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The file is missing or cannot be read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A line does not follow the format.
    #[error("{}:{line}: {message}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What was wrong.
        message: String,
    },
    /// The file is of another version of the format.
    #[error(
        "{}: a replay file of version {found}, and this lightshaft reads version {VERSION}; record it again",
        path.display()
    )]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: String,
    },
    /// The file belongs to another scene.
    #[error(
        "{}: recorded on other geometry ({found}, and the scene's is {wanted}): another scene, a scene that has \
         changed, or other options such as --one-sided; record it again",
        path.display()
    )]
    OtherGeometry {
        /// The file.
        path: PathBuf,
        /// Geometry of the file.
        found: String,
        /// Geometry of the scene.
        wanted: String,
    },
}

/// A fingerprint of the triangles and of the facets they make, 16 hexadecimal digits.
pub fn fingerprint(mesh: &TraceMesh) -> String {
    let pair = |a: u32, b: u32| u64::from(a) << 32 | u64::from(b);
    let positions =
        mesh.positions.iter().flat_map(|p| [pair(p.x.to_bits(), p.y.to_bits()), p.z.to_bits().into()]);
    let triangles = mesh.triangles.iter().zip(&mesh.facet_of_triangle);
    let triangles = triangles.flat_map(|(&[a, b, c], &facet)| [pair(a, b), pair(c, facet)]);
    let counts = [mesh.positions.len() as u64, mesh.triangles.len() as u64];
    format!("{:016x}", counts.into_iter().chain(positions).chain(triangles).fold(0, hash_pair))
}

/// Writes disagreements to `path`, whole or not at all; `explain` says for people what each is about.
///
/// # Errors
/// When the folder is missing or not writable or the disk is full.
pub fn write_replay(
    path: &Path,
    mesh: &TraceMesh,
    disagreements: &[Disagreement],
    explain: &dyn Fn(&Disagreement) -> String,
) -> Result<(), OutputError> {
    let mut text = format!("{HEADING} {VERSION}\ngeometry {}\n", fingerprint(mesh));
    text += "# from x y z, to x y z (local coordinates), facets at the two ends, kind\n";
    for disagreement in disagreements {
        let Segment { from, to, skip } = disagreement.segment;
        let [a, b] = skip.map(|facet| if facet == NO_FACET { "-".to_owned() } else { facet.to_string() });
        // Writing to a string cannot fail. Numbers are as short as they can be and still read back the same.
        let _ = writeln!(
            text,
            "# {}\n{:e} {:e} {:e} {:e} {:e} {:e} {a} {b} {}",
            explain(disagreement),
            from.x,
            from.y,
            from.z,
            to.x,
            to.y,
            to.z,
            disagreement.kind
        );
    }
    write_atomically(path, |file| file.write_all(text.as_bytes()).map_err(FillError::Io))
}

/// Reads the segments of a file that was written for this mesh.
///
/// # Errors
/// When the file cannot be read, is of another version or for another mesh, or a line is malformed.
pub fn read_replay(path: &Path, mesh: &TraceMesh) -> Result<Vec<Replayed>, ReplayError> {
    let bytes =
        std::fs::read(path).map_err(|source| ReplayError::Unreadable { path: path.to_owned(), source })?;
    let text = String::from_utf8_lossy(&bytes);
    let malformed =
        |line: usize, message: String| ReplayError::Malformed { path: path.to_owned(), line, message };
    let mut lines = (1..).zip(text.lines());
    let mut expect = |what: &str, example: &str| {
        let (line, text) = lines.next().unwrap_or((1, ""));
        match text.strip_prefix(what).map(str::trim) {
            Some(value) if !value.is_empty() => Ok(value.to_owned()),
            _ => Err(malformed(line, format!("'{what} {example}' is expected here; this is no replay file"))),
        }
    };
    let version = expect(HEADING, &VERSION.to_string())?;
    if version != VERSION.to_string() {
        return Err(ReplayError::OtherVersion { path: path.to_owned(), found: shown(&version) });
    }
    let (found, wanted) = (expect("geometry", "…")?, fingerprint(mesh));
    if found != wanted {
        return Err(ReplayError::OtherGeometry { path: path.to_owned(), found: shown(&found), wanted });
    }
    let mut segments = Vec::new();
    for (number, line) in lines {
        let bare = line.trim();
        if !bare.is_empty() && !bare.starts_with('#') {
            segments.push(parse(bare, mesh).map_err(|message| malformed(number, message))?);
        }
    }
    Ok(segments)
}

/// One segment from its line.
fn parse(line: &str, mesh: &TraceMesh) -> Result<Replayed, String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let Some((numbers, [first, second, kind @ ..])) = words.split_at_checked(6) else {
        return Err(format!("{} words where six numbers, two facets and a kind are needed", words.len()));
    };
    let mut coordinates = [0.0f32; 6];
    for (coordinate, word) in coordinates.iter_mut().zip(numbers) {
        *coordinate = match word.parse() {
            Ok(number) if f32::is_finite(number) => number,
            _ => return Err(format!("'{}' is no finite number", shown(word))),
        };
    }
    let facets = mesh.first_triangle.len() as u32 - 1;
    let facet = |word: &str| match word.parse() {
        _ if word == "-" => Ok(NO_FACET),
        Ok(facet) if facet < facets => Ok(facet),
        _ => Err(format!("'{}' is no facet; there are {facets}, and '-' is none", shown(word))),
    };
    let [a, b, c, d, e, f] = coordinates;
    let skip = [facet(first)?, facet(second)?];
    if kind.is_empty() {
        return Err("the kind of segment is missing".to_owned());
    }
    Ok(Replayed {
        kind: kind.join(" "),
        segment: Segment { from: Vec3::new(a, b, c), to: Vec3::new(d, e, f), skip },
    })
}

/// Text from a file as a message shows it.
fn shown(text: &str) -> String {
    text.chars().take(40).flat_map(char::escape_debug).collect()
}

#[cfg(test)]
mod tests {
    use super::super::referee::Ruling;
    use super::*;
    use crate::compare::random_segments;

    fn mesh() -> TraceMesh {
        TraceMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            first_triangle: vec![0, 1],
            facet_of_triangle: vec![0],
        }
    }

    fn disagreements() -> Vec<Disagreement> {
        let of = |segment| Disagreement {
            kind: "close beside edges".to_owned(),
            segment,
            answers: [0, NO_FACET],
            rulings: [Ruling::RIGHT; 2],
        };
        let mut all: Vec<Disagreement> = random_segments(50, 3).into_iter().map(of).collect();
        all[7].segment.skip = [0, NO_FACET];
        all[8].segment.from = Vec3::new(-0.0, 1e-42, f32::MAX);
        all
    }

    /// What the reader makes of a file with this content.
    fn read(content: impl AsRef<[u8]>) -> Result<Vec<Replayed>, ReplayError> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.replay");
        std::fs::write(&path, content).expect("written");
        read_replay(&path, &mesh())
    }

    fn written() -> String {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.replay");
        write_replay(&path, &mesh(), &disagreements(), &|_| "why".to_owned()).expect("written");
        std::fs::read_to_string(path).expect("readable")
    }

    #[test]
    fn segments_read_back_to_the_last_bit() {
        let bits = |s: &Segment| ([s.from, s.to].map(|p| p.to_array().map(f32::to_bits)), s.skip);
        let read = read(written()).expect("a replay file");
        assert_eq!(read.len(), 50);
        for (read, written) in read.iter().zip(disagreements()) {
            assert_eq!(bits(&read.segment), bits(&written.segment));
            assert_eq!(read.kind, written.kind);
        }
    }

    #[test]
    fn other_geometry_and_other_versions_are_refused() {
        let mut moved = mesh();
        moved.positions[1].x += 1e-6;
        assert_ne!(fingerprint(&moved), fingerprint(&mesh()));
        let text = written().replace(&fingerprint(&mesh()), &fingerprint(&moved));
        assert!(matches!(read(text), Err(ReplayError::OtherGeometry { .. })));
        let text = written().replace("lightshaft replay 1", "lightshaft replay 2");
        let error = read(text).expect_err("another version");
        assert!(matches!(error, ReplayError::OtherVersion { .. }), "{error}");
        assert!(error.to_string().contains("version 2"), "{error}");
    }

    #[test]
    fn the_line_that_is_no_segment_is_named() {
        let head = format!("lightshaft replay 1\ngeometry {}\n\n# why\n", fingerprint(&mesh()));
        assert_eq!(read(&head).expect("no segments"), []);
        for (bad, part) in [
            ("0 0 0 1 1 1 -", "7 words"),
            ("0 0 0 1 1 one - - random", "'one' is no finite number"),
            ("0 0 0 1 1 inf - - random", "'inf' is no finite number"),
            ("0 0 0 1 1 1 1 - random", "'1' is no facet"),
            ("0 0 0 1 1 1 - -1 random", "'-1' is no facet"),
            ("0 0 0 1 1 1 - -", "kind"),
        ] {
            let error = read(format!("{head}0 0 0 1 1 1 0 - random\n{bad}\n")).expect_err(bad);
            assert!(matches!(error, ReplayError::Malformed { line: 6, .. }), "{error}");
            assert!(error.to_string().contains(part), "{error}");
        }
        for (bad, at) in
            [("", 1), ("v 0 0 0", 1), ("lightshaft replay 1", 1), ("lightshaft replay 1\nx\n", 2)]
        {
            let error = read(bad).expect_err(bad);
            assert!(matches!(error, ReplayError::Malformed { line, .. } if line == at), "{error}");
        }
        assert!(matches!(read([0xff, 0xfe, 0]), Err(ReplayError::Malformed { line: 1, .. })));
    }
}
