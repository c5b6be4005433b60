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
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// What the first line begins with.
const HEADING: &str = "lightshaft replay";

/// Of the format.
const VERSION: u32 = 1;

/// Largest file that is read, bytes: a hundred thousand rays.
const MOST_BYTES: u64 = 16 << 20;

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
        source: io::Error,
    },
    /// The file is larger than any that is written.
    #[error("{}: larger than {} MB; this is no replay file", path.display(), MOST_BYTES >> 20)]
    TooLarge {
        /// The file.
        path: PathBuf,
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

/// A file of rays that was read and found to be one, of this version.
#[derive(Debug)]
pub struct ReplayFile {
    path: PathBuf,
    text: String,
    geometry: String,
}

/// Lines before the first ray.
const HEAD: usize = 2;

impl ReplayFile {
    /// Reads a file and looks at its head.
    ///
    /// # Errors
    /// When the file cannot be read, is too large, is no replay file or one of another version.
    pub fn open(path: &Path) -> Result<ReplayFile, ReplayError> {
        let owned = || path.to_owned();
        let text = read(path).map_err(|source| ReplayError::Unreadable { path: owned(), source })?;
        let text = text.ok_or_else(|| ReplayError::TooLarge { path: owned() })?;
        let expect = |line: usize, what: &str, example: &str| {
            let found = text.lines().nth(line - 1).unwrap_or_default();
            match found.strip_prefix(what).map(str::trim) {
                Some(value) if !value.is_empty() => Ok(value.to_owned()),
                _ => {
                    let message = format!("'{what} {example}' is expected here; this is no replay file");
                    Err(ReplayError::Malformed { path: owned(), line, message })
                }
            }
        };
        let version = expect(1, HEADING, &VERSION.to_string())?;
        if version != VERSION.to_string() {
            return Err(ReplayError::OtherVersion { path: owned(), found: shown(&version) });
        }
        let geometry = expect(HEAD, "geometry", "…")?;
        Ok(ReplayFile { path: owned(), text, geometry })
    }

    /// Its rays, if it was written for this mesh.
    ///
    /// # Errors
    /// When it was written for another mesh, or a line is malformed.
    pub fn rays(&self, mesh: &TraceMesh) -> Result<Vec<Replayed>, ReplayError> {
        let (path, wanted) = (|| self.path.clone(), fingerprint(mesh));
        if self.geometry != wanted {
            return Err(ReplayError::OtherGeometry { path: path(), found: shown(&self.geometry), wanted });
        }
        let lines = (1..).zip(self.text.lines().map(str::trim)).skip(HEAD);
        let rays = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        rays.map(|(line, text)| {
            parse(text, mesh).map_err(|message| ReplayError::Malformed { path: path(), line, message })
        })
        .collect()
    }
}

/// The text of a file, if it is not too large.
fn read(path: &Path) -> io::Result<Option<String>> {
    // Looked at before it is opened: a pipe would wait for whoever writes to it.
    if !path.metadata()?.is_file() {
        return Err(io::Error::other("not a regular file"));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
    let is_small = bytes.len() as u64 <= MOST_BYTES;
    Ok(is_small.then(|| String::from_utf8_lossy(&bytes).into_owned()))
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
    let kind = kind.join(" ");
    if kind.contains(char::is_control) {
        return Err(format!("the kind of ray has control characters: '{}'", shown(&kind)));
    }
    Ok(Replayed { kind, question })
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
        ReplayFile::open(&path)?.rays(&mesh())
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
    fn what_is_no_file_of_this_size_is_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let error = ReplayFile::open(folder.path()).expect_err("a folder");
        assert!(error.to_string().contains("not a regular file"), "{error}");
        let path = folder.path().join("large.replay");
        std::fs::write(&path, written()).expect("written");
        let file = File::options().write(true).open(&path).expect("our own file");
        file.set_len(MOST_BYTES).expect("a file with a hole");
        assert!(ReplayFile::open(&path).is_ok(), "as large as can be");
        file.set_len(MOST_BYTES + 1).expect("a file with a hole");
        let error = ReplayFile::open(&path).expect_err("too large");
        assert!(matches!(error, ReplayError::TooLarge { .. }), "{error}");
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
            ("ray 0 0 0 1 1 1 \u{1b}[31mred", "control characters: '\\u{1b}[31mred'"),
            ("line 0 0 0 1 1 1 random", "'line' is neither"),
        ] {
            let error = read(format!("{head}segment 0 0 0 1 1 1 0 - random\n{bad}\n")).expect_err(bad);
            assert!(matches!(error, ReplayError::Malformed { line: 6, .. }), "{error}");
            assert!(error.to_string().contains(part), "{error}");
        }
        for (bad, at) in
            [("", 1), ("v 0 0 0", 1), ("lightshaft replay 1", 2), ("lightshaft replay 1\nx\n", 2)]
        {
            let error = read(bad).expect_err(bad);
            assert!(matches!(error, ReplayError::Malformed { line, .. } if line == at), "{error}");
        }
        assert!(matches!(read([0xff, 0xfe, 0]), Err(ReplayError::Malformed { line: 1, .. })));
    }
}
