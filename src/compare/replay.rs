//! Files of rays to be traced again, one by one.
//!
//! The first line names the format and its version, the second the geometry; then a line for each ray, in local
//! coordinates: `segment` with both ends, the facets they lie on (`-` for none) and the kind, or `ray` with origin,
//! direction and the kind. `#` begins a comment.

use super::rays::{Disagreement, Question};
use crate::image::write::{FillError, OutputError, write_atomically};
use crate::tracer::{NO_FACET, Ray, Segment, TraceMesh};
use glam::Vec3;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// What the first line begins with.
const HEADING: &str = "lightshaft replay";

/// Of the format.
const VERSION: u32 = 1;

/// A ray of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// The kind of ray that it was.
    pub kind: String,
    /// What was asked.
    pub question: Question,
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

/// The fingerprint of the geometry, 16 hexadecimal digits.
fn fingerprint(mesh: &TraceMesh) -> String {
    format!("{:016x}", mesh.fingerprint())
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
    text += "# segment: from x y z, to x y z, facets at the two ends, kind; ray: origin x y z, direction x y z, kind\n";
    for disagreement in disagreements {
        // Writing to a string cannot fail. Numbers are as short as they can be and still read back the same.
        let _ = writeln!(text, "# {}", explain(disagreement));
        let numbers = |points: [Vec3; 2]| {
            let words = points.iter().flat_map(|p| p.to_array()).map(|x| format!("{x:e}"));
            words.collect::<Vec<_>>().join(" ")
        };
        let _ = match disagreement.question {
            Question::Segment(Segment { from, to, skip }) => {
                let [a, b] = skip.map(|f| if f == NO_FACET { "-".to_owned() } else { f.to_string() });
                writeln!(text, "segment {} {a} {b} {}", numbers([from, to]), disagreement.kind)
            }
            Question::Ray(Ray { origin, direction }) => {
                writeln!(text, "ray {} {}", numbers([origin, direction]), disagreement.kind)
            }
        };
    }
    write_atomically(path, |file| file.write_all(text.as_bytes()).map_err(FillError::Io))
}

/// Reads the rays of a file that was written for this mesh.
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
    let mut rays = Vec::new();
    for (number, line) in lines {
        let bare = line.trim();
        if !bare.is_empty() && !bare.starts_with('#') {
            rays.push(parse(bare, mesh).map_err(|message| malformed(number, message))?);
        }
    }
    Ok(rays)
}

/// One ray from its line.
fn parse(line: &str, mesh: &TraceMesh) -> Result<Replayed, String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let Some((what, rest)) = words.split_first() else { return Err("nothing is here".to_owned()) };
    let Some((numbers, rest)) = rest.split_at_checked(6) else {
        return Err(format!("{} numbers where six are needed", rest.len()));
    };
    let mut coordinates = [0.0f32; 6];
    for (coordinate, word) in coordinates.iter_mut().zip(numbers) {
        *coordinate = match word.parse() {
            Ok(number) if f32::is_finite(number) => number,
            _ => return Err(format!("'{}' is no finite number", shown(word))),
        };
    }
    let [a, b, c, d, e, f] = coordinates;
    let points = [Vec3::new(a, b, c), Vec3::new(d, e, f)];
    let facets = mesh.first_triangle.len() as u32 - 1;
    let facet = |word: &str| match word.parse() {
        _ if word == "-" => Ok(NO_FACET),
        Ok(facet) if facet < facets => Ok(facet),
        _ => Err(format!("'{}' is no facet; there are {facets}, and '-' is none", shown(word))),
    };
    let (question, kind) = match (*what, rest) {
        ("segment", [first, second, kind @ ..]) => {
            let skip = [facet(first)?, facet(second)?];
            (Question::Segment(Segment { from: points[0], to: points[1], skip }), kind)
        }
        ("segment", _) => return Err("the facets at the ends are missing; '-' is none".to_owned()),
        ("ray", kind) => (Question::Ray(Ray { origin: points[0], direction: points[1] }), kind),
        _ => return Err(format!("'{}' is neither 'segment' nor 'ray'", shown(what))),
    };
    if kind.is_empty() {
        return Err("the kind of ray is missing".to_owned());
    }
    Ok(Replayed { kind: kind.join(" "), question })
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
        let of = |mut segment: Segment, index: usize| {
            if index == 7 {
                segment.skip = [0, NO_FACET];
                segment.from = Vec3::new(-0.0, 1e-42, f32::MAX);
            }
            let ray = Ray { origin: segment.from, direction: segment.to };
            let question = if index == 3 { Question::Ray(ray) } else { Question::Segment(segment) };
            let kind = "close beside edges".to_owned();
            Disagreement { kind, question, answers: [0, NO_FACET], rulings: [Ruling::RIGHT; 2] }
        };
        random_segments(50, 3).into_iter().zip(0..).map(|(segment, index)| of(segment, index)).collect()
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
    fn rays_read_back_to_the_last_bit() {
        let bits = |question: &Question| match question {
            Question::Segment(s) => ([s.from, s.to].map(|p| p.to_array().map(f32::to_bits)), s.skip),
            Question::Ray(r) => ([r.origin, r.direction].map(|p| p.to_array().map(f32::to_bits)), [8; 2]),
        };
        let read = read(written()).expect("a replay file");
        assert_eq!(read.len(), 50);
        for (read, written) in read.iter().zip(disagreements()) {
            assert_eq!(bits(&read.question), bits(&written.question));
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
    fn the_line_that_is_no_ray_is_named() {
        let head = format!("lightshaft replay 1\ngeometry {}\n\n# why\n", fingerprint(&mesh()));
        assert_eq!(read(&head).expect("no rays"), []);
        for (bad, part) in [
            ("segment 0 0 0 1 1", "5 numbers"),
            ("segment 0 0 0 1 1 1 -", "facets"),
            ("segment 0 0 0 1 1 one - - random", "'one' is no finite number"),
            ("ray 0 0 0 1 1 inf random", "'inf' is no finite number"),
            ("segment 0 0 0 1 1 1 1 - random", "'1' is no facet"),
            ("segment 0 0 0 1 1 1 - -1 random", "'-1' is no facet"),
            ("segment 0 0 0 1 1 1 - -", "kind"),
            ("ray 0 0 0 1 1 1", "kind"),
            ("line 0 0 0 1 1 1 random", "'line' is neither"),
        ] {
            let error = read(format!("{head}segment 0 0 0 1 1 1 0 - random\n{bad}\n")).expect_err(bad);
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
