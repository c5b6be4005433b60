//! The statements of an OBJ file, checked one by one and handed to `tobj` in their plainest form.
//!
//! `tobj` names no line in its errors, reads polylines as polygons, forgets the names of unknown
//! materials, splits names at the first space only and cannot look ahead. So the file is read here in
//! two passes, vertices first, then faces; what `tobj` sees is `v x y z`, `f i j k …` with absolute
//! indices in range, and `g SLOT`, where the number stands for the material in use.

use std::collections::HashMap;
use std::io::{self, BufRead, Read, Write};
use std::path::{Path, PathBuf};

use super::error::{SceneError, quoted};
use super::lines::Lines;
use crate::progress::Progress;

/// Largest coordinate: its square, as an area, still fits single precision.
pub(super) const LARGEST_COORDINATE: f64 = 1e18;
/// Largest reflectance or radiance in a file: powers made of it still fit single precision.
pub(super) const LARGEST_COLOUR: f64 = 1e30;
/// Bytes between two reports of progress.
const ADVANCE: u64 = 1 << 20;
/// Most corners of one polygon.
const MOST_CORNERS: usize = 65_535;

/// What an OBJ file says besides its geometry.
#[derive(Debug, Default)]
pub(super) struct Remarks {
    /// Names of the materials in order of first use; slot 0 is "no material".
    pub(super) slots: Vec<String>,
    /// `mtllib` statements: line and the rest of the line.
    pub(super) libraries: Vec<(u64, String)>,
    /// Faces that are points or lines, and `p` and `l` statements.
    pub(super) skipped_faces: u64,
    /// Statements that are not OBJ: how many, and the first with its line.
    pub(super) unknown: Option<(u64, u64, String)>,
    /// Free-form curves and surfaces, not read: how many, and the first line.
    pub(super) free_form: Option<(u64, u64)>,
}

#[derive(Clone, Copy, PartialEq)]
enum Pass {
    Vertices,
    Faces,
    Done,
}

/// A reader that yields the plain form of an OBJ file.
pub(super) struct Statements<'a> {
    file: PathBuf,
    lines: Lines,
    progress: &'a dyn Progress,
    pass: Pass,
    vertices: u64,
    vertices_before: u64,
    /// Whether places on pictures are of use.
    with_places: bool,
    places: u64,
    places_before: u64,
    slot: usize,
    slot_of_name: HashMap<String, usize>,
    remarks: Remarks,
    fault: Option<SceneError>,
    plain: Vec<u8>,
    taken: usize,
}

impl<'a> Statements<'a> {
    /// Opens the file; see [`Lines::open`] for the errors.
    pub(super) fn open(
        path: &Path,
        with_places: bool,
        progress: &'a dyn Progress,
    ) -> Result<Self, SceneError> {
        let lines = Lines::open(path)?;
        // It is read twice.
        progress.start("load", 2 * std::fs::metadata(path).map_or(0, |about| about.len()));
        Ok(Self {
            file: path.to_path_buf(),
            lines,
            progress,
            pass: Pass::Vertices,
            vertices: 0,
            vertices_before: 0,
            with_places,
            places: 0,
            places_before: 0,
            slot: 0,
            slot_of_name: HashMap::new(),
            remarks: Remarks { slots: vec![String::new()], ..Remarks::default() },
            fault: None,
            // The first place stands for those that are missing.
            plain: if with_places { b"g 0\nvt NaN NaN\n".to_vec() } else { b"g 0\n".to_vec() },
            taken: 0,
        })
    }

    /// What was found, or the error that ended the reading.
    pub(super) fn finish(self) -> Result<Remarks, SceneError> {
        match self.fault {
            Some(error) => Err(error),
            None => Ok(self.remarks),
        }
    }

    /// Reads lines until there is something to hand out, or the file ends.
    fn advance(&mut self) -> Result<(), SceneError> {
        self.plain.clear();
        self.taken = 0;
        let mut read = 0;
        while self.plain.len() < 1 << 16 && self.pass != Pass::Done {
            let Some((line, text)) = self.lines.next_line()? else {
                self.pass = match self.pass {
                    Pass::Vertices => {
                        self.lines = Lines::open(&self.file)?;
                        Pass::Faces
                    }
                    _ => Pass::Done,
                };
                continue;
            };
            read += text.len() as u64 + 1;
            if read > ADVANCE {
                self.progress.advance(std::mem::take(&mut read));
            }
            let text = text.trim_ascii();
            let end = text.iter().position(|byte| byte.is_ascii_whitespace()).unwrap_or(text.len());
            let (keyword, rest) = text.split_at(end);
            if self.pass == Pass::Vertices {
                if keyword == b"v" {
                    vertex(rest, &mut self.plain)
                        .map_err(|message| SceneError::parse(&self.file, Some(line), message))?;
                    self.vertices += 1;
                } else if keyword == b"vt" && self.with_places {
                    place(rest, &mut self.plain);
                    self.places += 1;
                }
                continue;
            }
            match keyword {
                b"v" => self.vertices_before += 1,
                b"vt" => self.places_before += 1,
                b"f" | b"fo" => {
                    let places = self.with_places.then_some([self.places, self.places_before]);
                    let is_face = face(rest, self.vertices, self.vertices_before, places, &mut self.plain)
                        .map_err(|message| SceneError::parse(&self.file, Some(line), message))?;
                    self.remarks.skipped_faces += u64::from(!is_face);
                }
                b"p" | b"l" => self.remarks.skipped_faces += 1,
                b"usemtl" => {
                    let name = String::from_utf8_lossy(rest).trim().to_owned();
                    self.select_material(name);
                }
                b"mtllib" => {
                    let names = String::from_utf8_lossy(rest).trim().to_owned();
                    self.remarks.libraries.push((line, names));
                }
                b"curv" | b"curv2" | b"surf" => self.remarks.free_form.get_or_insert((0, line)).0 += 1,
                _ if keyword.is_empty() || keyword[0] == b'#' || is_ignored(keyword) => {}
                _ => {
                    let word = String::from_utf8_lossy(keyword).into_owned();
                    self.remarks.unknown.get_or_insert((0, line, word)).0 += 1;
                }
            }
        }
        self.progress.advance(read);
        Ok(())
    }

    fn select_material(&mut self, name: String) {
        let slots = &mut self.remarks.slots;
        let slot = if name.is_empty() {
            0
        } else {
            *self.slot_of_name.entry(name).or_insert_with_key(|name| {
                slots.push(name.clone());
                slots.len() - 1
            })
        };
        if slot != self.slot {
            self.slot = slot;
            self.plain.extend_from_slice(format!("g {slot}\n").as_bytes());
        }
    }
}

impl Read for Statements<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(into)?;
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for Statements<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.taken == self.plain.len()
            && let Err(error) = self.advance()
        {
            self.pass = Pass::Done;
            self.fault = Some(error);
            return Err(io::Error::other("the file is at fault"));
        }
        Ok(&self.plain[self.taken..])
    }

    fn consume(&mut self, count: usize) {
        self.taken += count;
    }
}

/// Words of a statement up to a comment.
pub(super) fn words(rest: &[u8]) -> impl Iterator<Item = &[u8]> {
    rest.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).take_while(|word| word[0] != b'#')
}

/// A finite number, or what is wrong with it.
pub(super) fn number(word: &[u8]) -> Result<f64, String> {
    let text = std::str::from_utf8(word).ok();
    let Some(value) = text.and_then(|text| text.parse::<f64>().ok()) else {
        let hint = if word.contains(&b',') { "write a decimal point" } else { "write it as in -1.5e-3" };
        return Err(format!("{} is not a number; {hint}", quoted(&String::from_utf8_lossy(word))));
    };
    if !value.is_finite() {
        return Err(format!(
            "{} is not finite; every number must be finite",
            quoted(&String::from_utf8_lossy(word))
        ));
    }
    Ok(value)
}

/// `v x y z`, `v x y z w` (weight) or with a colour, which is ignored.
fn vertex(rest: &[u8], plain: &mut Vec<u8>) -> Result<(), String> {
    let mut position = [0.0; 3];
    let mut values = words(rest);
    let mut text = [&b""[..]; 3];
    for axis in 0..3 {
        let Some(word) = values.next() else {
            return Err(format!("a vertex needs 3 coordinates and has {axis}; write v x y z"));
        };
        position[axis] = number(word)?;
        text[axis] = word;
    }
    let mut weight = 1.0;
    if let Some(word) = values.next()
        && values.next().is_none()
    {
        weight = number(word)?;
        if weight == 0.0 {
            return Err("the vertex weight w is 0, a point at infinity; leave w out".to_owned());
        }
    }
    if let Some(far) = position.iter().find(|x| (*x / weight).abs() > LARGEST_COORDINATE) {
        return Err(format!(
            "coordinate {far:e} is beyond {LARGEST_COORDINATE:e}; use a larger unit and meters_per_unit"
        ));
    }
    plain.push(b'v');
    if weight == 1.0 {
        for word in text {
            plain.push(b' ');
            plain.extend_from_slice(word);
        }
    } else {
        for value in position {
            // Writing to a vector does not fail.
            let _ = write!(plain, " {:e}", value / weight);
        }
    }
    plain.push(b'\n');
    Ok(())
}

/// `f` with its indices made absolute; false, and nothing written, with fewer than three corners.
fn face(
    rest: &[u8],
    vertices: u64,
    vertices_before: u64,
    places: Option<[u64; 2]>,
    plain: &mut Vec<u8>,
) -> Result<bool, String> {
    let start = plain.len();
    let mut corners = 0;
    plain.push(b'f');
    for word in words(rest) {
        let vertex = corner(word, vertices, vertices_before)?;
        let _ = write!(plain, " {vertex}");
        if let Some([places, before]) = places {
            let _ = write!(plain, "/{}", place_of(word, places, before));
        }
        corners += 1;
        if corners > MOST_CORNERS {
            return Err(format!("the face has more than {MOST_CORNERS} corners; split it"));
        }
    }
    if corners < 3 {
        plain.truncate(start);
        return Ok(false);
    }
    plain.push(b'\n');
    Ok(true)
}

/// `vt u v`, as far as it is one; pictures are no reason to refuse a mesh.
fn place(rest: &[u8], plain: &mut Vec<u8>) {
    let mut values = words(rest).map(|word| number(word).unwrap_or(f64::NAN));
    let (u, v) = (values.next().unwrap_or(f64::NAN), values.next().unwrap_or(0.0));
    let _ = writeln!(plain, "vt {u:e} {v:e}");
}

/// The number, from 1, of the place in a corner; 1 where it has none that there is.
fn place_of(word: &[u8], places: u64, before: u64) -> u64 {
    let index = word
        .split(|&byte| byte == b'/')
        .nth(1)
        .and_then(|text| std::str::from_utf8(text).ok()?.parse::<i64>().ok());
    let found = match index {
        Some(index) if index < 0 => before.checked_add_signed(index).map(|index| index + 1),
        Some(index) => u64::try_from(index).ok(),
        None => None,
    };
    // The first one stands for what is missing.
    found.filter(|place| (1..=places).contains(place)).map_or(1, |place| place + 1)
}

/// The vertex index, from 1, of `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner(word: &[u8], vertices: u64, vertices_before: u64) -> Result<u64, String> {
    let shown = || quoted(&String::from_utf8_lossy(word));
    let end = word.iter().position(|&byte| byte == b'/').unwrap_or(word.len());
    let (index, others) = word.split_at(end);
    let is_well_formed = others.iter().filter(|&&byte| byte == b'/').count() <= 2
        && others.iter().all(|byte| byte.is_ascii_digit() || b"/+-".contains(byte));
    let digits = index.strip_prefix(b"-").or(index.strip_prefix(b"+")).unwrap_or(index);
    if !is_well_formed || digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return Err(format!("{} is not a face corner; write v, v/vt, v//vn or v/vt/vn", shown()));
    }
    // More than 18 digits are out of range in any file.
    let value =
        std::str::from_utf8(digits).ok().and_then(|text| text.parse::<u64>().ok()).unwrap_or(u64::MAX);
    if value == 0 {
        return Err(format!("vertex index 0 in {}; OBJ counts vertices from 1", shown()));
    }
    if index[0] == b'-' {
        if value > vertices_before {
            return Err(format!(
                "vertex index out of range in {}: only {vertices_before} vertices stand above it; \
                 check the indices",
                shown()
            ));
        }
        return Ok(vertices_before + 1 - value);
    }
    if value > vertices {
        return Err(format!(
            "vertex index out of range in {}: the file has {vertices} vertices; check the indices",
            shown()
        ));
    }
    Ok(value)
}

/// Statements of the OBJ format that say nothing about diffuse polygons.
fn is_ignored(keyword: &[u8]) -> bool {
    const IGNORED: [&[u8]; 37] = [
        b"vt",
        b"vn",
        b"vp",
        b"g",
        b"o",
        b"s",
        b"mg",
        b"lod",
        b"bevel",
        b"c_interp",
        b"d_interp",
        b"usemap",
        b"maplib",
        b"shadow_obj",
        b"trace_obj",
        b"ctech",
        b"stech",
        b"deg",
        b"bmat",
        b"step",
        b"cstype",
        b"parm",
        b"trim",
        b"hole",
        b"scrv",
        b"sp",
        b"end",
        b"con",
        b"call",
        b"csh",
        b"bsp",
        b"bzp",
        b"cdc",
        b"cdp",
        b"res",
        b"vc",
        b"param",
    ];
    IGNORED.contains(&keyword)
}
