//! Files of rays to be traced again, one by one.
//!
//! The first line names the format and its version, the second the geometry, the third how many rays there are and the
//! checksum of all that follows; then a line for each ray, in local coordinates: `segment` with both ends, the facets they
//! lie on (`-` for none), the facets that may block (`-` for all) and the kind, or `ray` with origin, direction and the
//! kind. `#` begins a comment.

use super::tally::{Disagreement, Question};
use crate::image::write::{FillError, OutputError, write_atomically};
use crate::tracer::{Interval, NO_FACET, Ray, Segment, TraceMesh};
use glam::Vec3;
use std::fmt::Write;
use std::fs::File;
use std::io::{self, Read};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// What the first line begins with.
const HEADING: &str = "lightshaft replay";

/// Of the format.
const VERSION: u32 = 2;

/// Largest file that is written and read, bytes: a hundred thousand rays, or fewer with long lists of candidates.
const MOST_BYTES: u64 = 16 << 20;

/// How long segments and directions may be, local units: what is outside rounds to nothing, or to no number.
const LENGTHS: RangeInclusive<f32> = 1e-12..=1e9;

/// A ray of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// The kind of ray that it was.
    pub kind: String,
    /// What was asked.
    pub question: Question,
    /// The facets that may block; `None` for the whole scene.
    pub within: Option<Vec<Interval>>,
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
    /// The file is not as it was written.
    #[error("{}: cut off or changed since it was written: {message}; record it again", path.display())]
    NotAsWritten {
        /// The file.
        path: PathBuf,
        /// How that is known.
        message: String,
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

/// Writes disagreements to `path`, whole or not at all; `explain` says for people what each is about. The worst first:
/// what would make the file larger than one that is read is left away.
///
/// # Errors
/// When the folder is missing or not writable or the disk is full.
pub fn write_replay(
    path: &Path,
    mesh: &TraceMesh,
    disagreements: &[Disagreement],
    explain: &dyn Fn(&Disagreement) -> String,
) -> Result<(), OutputError> {
    let mut body = String::from(
        "# segment: from x y z, to x y z, facets at the two ends, facets that may block, kind\n\
         # ray: origin x y z, direction x y z, kind\n",
    );
    let mut count = 0;
    for disagreement in disagreements {
        let lines = format!("# {}\n{}\n", explain(disagreement), line_of(disagreement));
        // Less the head, which is short.
        if body.len() + lines.len() + 1000 > MOST_BYTES as usize {
            break;
        }
        body += &lines;
        count += 1;
    }
    let sum = crc32fast::hash(body.as_bytes());
    let head = format!("{HEADING} {VERSION}\ngeometry {}\nrays {count} crc32 {sum:08x}\n", fingerprint(mesh));
    write_atomically(path, |file| {
        file.write_all(head.as_bytes())?;
        file.write_all(body.as_bytes()).map_err(FillError::Io)
    })
}

/// Numbers are as short as they can be and still read back the same.
fn line_of(disagreement: &Disagreement) -> String {
    let numbers = |points: [Vec3; 2]| {
        let words = points.iter().flat_map(|p| p.to_array()).map(|x| format!("{x:e}"));
        words.collect::<Vec<_>>().join(" ")
    };
    let kind = &disagreement.kind;
    match disagreement.question {
        Question::Segment(Segment { from, to, skip }) => {
            let [a, b] = skip.map(|f| if f == NO_FACET { "-".to_owned() } else { f.to_string() });
            format!("segment {} {a} {b} {} {kind}", numbers([from, to]), list_of(&disagreement.within))
        }
        Question::Ray(Ray { origin, direction }) => format!("ray {} {kind}", numbers([origin, direction])),
    }
}

/// One word: `-` for the whole scene, or facets such as `3-7,9`.
fn list_of(within: &Option<Vec<Interval>>) -> String {
    let Some(list) = within else { return "-".to_owned() };
    let mut text = String::new();
    for interval in list {
        let comma = if text.is_empty() { "" } else { "," };
        let last = interval.end - 1;
        // Writing to a string cannot fail.
        let _ = match interval.start == last {
            true => write!(text, "{comma}{last}"),
            false => write!(text, "{comma}{}-{last}", interval.start),
        };
    }
    if text.is_empty() { NOBODY.to_owned() } else { text }
}

/// The word for a list that is empty.
const NOBODY: &str = "none";

/// The list that a word of [`list_of`] stands for; there are so many facets.
fn read_list(word: &str, facets: u32) -> Option<Option<Vec<Interval>>> {
    match word {
        "-" => return Some(None),
        NOBODY => return Some(Some(Vec::new())),
        _ => {}
    }
    let mut list: Vec<Interval> = Vec::new();
    for part in word.split(',') {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let (start, last): (u32, u32) = (first.parse().ok()?, last.parse().ok()?);
        let after = list.last().map_or(0, |before| before.end);
        if start < after || last < start || last >= facets {
            return None;
        }
        list.push(Interval { start, end: last + 1 });
    }
    Some(Some(list))
}

/// A file of rays that was read and found to be one, of this version.
#[derive(Debug)]
pub struct ReplayFile {
    path: PathBuf,
    /// All below the head.
    body: String,
    geometry: String,
}

/// Lines before what the checksum is of.
const HEAD: usize = 3;

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
        let geometry = expect(2, "geometry", "…")?;
        let announced = expect(HEAD, "rays", "… crc32 …")?;
        let body = text.splitn(HEAD + 1, '\n').nth(HEAD).unwrap_or_default();
        let count = rays_of(body, 1).count();
        let message = match announced
            .split_once(" crc32 ")
            .and_then(|(rays, sum)| Some((rays.parse::<usize>().ok()?, sum)))
        {
            None => Some(format!("'rays {}' says neither how many nor their checksum", shown(&announced))),
            Some((rays, _)) if rays != count => {
                Some(format!("{rays} rays were written, and {count} are there"))
            }
            Some((_, sum)) if sum != format!("{:08x}", crc32fast::hash(body.as_bytes())) => {
                Some("the checksum is another one".to_owned())
            }
            Some(_) => None,
        };
        match message {
            Some(message) => Err(ReplayError::NotAsWritten { path: owned(), message }),
            None => Ok(ReplayFile { path: owned(), body: body.to_owned(), geometry }),
        }
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
        rays_of(&self.body, HEAD + 1)
            .map(|(line, text)| {
                parse(text, mesh).map_err(|message| ReplayError::Malformed { path: path(), line, message })
            })
            .collect()
    }
}

/// The lines that are neither empty nor comments, with their numbers, of which the first is that of the text.
fn rays_of(text: &str, first: usize) -> impl Iterator<Item = (usize, &str)> {
    (first..).zip(text.lines().map(str::trim)).filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
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
    let [from, to] = points.map(Vec3::as_dvec3);
    let way = if *what == "ray" { to } else { to - from }.length() as f32;
    if !LENGTHS.contains(&way) || from.length() as f32 > *LENGTHS.end() {
        return Err(format!(
            "from {:.1e} away it goes {way:.1e} far; rays begin at most {:.0e} away and go {:.0e} to {:.0e} far, where 1 is half the \
             size of the scene",
            from.length(),
            LENGTHS.end(),
            LENGTHS.start(),
            LENGTHS.end()
        ));
    }
    let facets = mesh.first_triangle.len() as u32 - 1;
    let facet = |word: &str| match word.parse() {
        _ if word == "-" => Ok(NO_FACET),
        Ok(facet) if facet < facets => Ok(facet),
        _ => Err(format!("'{}' is no facet; there are {facets}, and '-' is none", shown(word))),
    };
    let (question, within, kind) = match (*what, rest) {
        ("segment", [first, second, list, kind @ ..]) => {
            let skip = [facet(first)?, facet(second)?];
            let within = read_list(list, facets).ok_or_else(|| {
                format!(
                    "'{}' is no list of facets, such as 3-7,9; there are {facets}, and '-' is all",
                    shown(list)
                )
            })?;
            (Question::Segment(Segment { from: points[0], to: points[1], skip }), within, kind)
        }
        ("segment", _) => {
            return Err(
                "the facets at the ends and those that may block are missing; '-' is none and all".to_owned()
            );
        }
        ("ray", kind) => (Question::Ray(Ray { origin: points[0], direction: points[1] }), None, kind),
        _ => return Err(format!("'{}' is neither 'segment' nor 'ray'", shown(what))),
    };
    if kind.is_empty() {
        return Err("the kind of ray is missing".to_owned());
    }
    let kind = kind.join(" ");
    if kind.contains(char::is_control) {
        return Err(format!("the kind of ray has control characters: '{}'", shown(&kind)));
    }
    Ok(Replayed { kind, question, within })
}

/// Text from a file as a message shows it.
fn shown(text: &str) -> String {
    text.chars().take(40).flat_map(char::escape_debug).collect()
}

#[cfg(test)]
mod tests;
