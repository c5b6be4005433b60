//! PLY: polygons with positions and colours, as text or binary in either byte order, through `ply-rs-bw`, which gives room only
//! to what it has read. Counts in the header are held against the size of the file before anything is.

use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use super::draft::{Cutter, DEFAULT_GREY, Draft, DraftMaterial, Origin};
use super::error::{SceneError, quoted};
use super::lines::{open_regular, unreadable};
use super::ply_text::PlainText;
use super::tint::Tints;
use super::toml_file::is_position;
use crate::math::linear_from_srgb;
use crate::progress::Progress;

/// Most corners of one polygon, as in OBJ files.
const MOST_CORNERS: usize = 65_535;
/// Faces that are read before they are put with the others.
const FACES_AT_ONCE: usize = 1 << 14;
/// Bytes of a header; longer only in what is no PLY.
const LONGEST_HEADER: u64 = 1 << 20;

#[derive(Clone, Copy, Default)]
struct Vertex {
    position: [f64; 3],
    colour: Colour,
}

#[derive(Default)]
struct Face {
    corners: Corners,
    colour: Colour,
}

/// Numbers of vertices, as they are written.
#[derive(Default)]
enum Corners {
    #[default]
    None,
    Signed(Vec<i32>),
    Unsigned(Vec<u32>),
}

/// What is of no use here.
struct Other;

/// Linear channels, as far as they have been read.
#[derive(Clone, Copy, Default)]
struct Colour([Option<f32>; 3]);

impl Colour {
    /// Takes a channel: whole numbers are sRGB, others linear.
    fn take(&mut self, name: &str, value: &Property) {
        let channel = match name {
            "red" | "diffuse_red" | "r" => 0,
            "green" | "diffuse_green" | "g" => 1,
            "blue" | "diffuse_blue" | "b" => 2,
            _ => return,
        };
        let linear = match *value {
            Property::UChar(byte) => linear_from_srgb(f32::from(byte) / 255.0),
            Property::UShort(number) => linear_from_srgb(f32::from(number) / 65535.0),
            Property::Float(number) => number,
            Property::Double(number) => number as f32,
            _ => return,
        };
        self.0[channel] = Some(linear);
    }

    /// All three channels, when there are.
    fn rgb(self) -> Option<[f64; 3]> {
        let [red, green, blue] = self.0;
        Some([red?, green?, blue?].map(f64::from))
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Vertex::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => {
                self.colour.take(name, &property);
                return PropertyAccessResult::Set;
            }
        };
        match scalar(&property) {
            Some(value) => self.position[axis] = value,
            None => return PropertyAccessResult::UnsupportedType,
        }
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Face::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !is_corner_list(name) {
            self.colour.take(name, &property);
            return PropertyAccessResult::Set;
        }
        self.corners = match property {
            Property::ListInt(list) => Corners::Signed(list),
            Property::ListUInt(list) => Corners::Unsigned(list),
            Property::ListChar(list) => Corners::Signed(list.into_iter().map(i32::from).collect()),
            Property::ListShort(list) => Corners::Signed(list.into_iter().map(i32::from).collect()),
            Property::ListUChar(list) => Corners::Unsigned(list.into_iter().map(u32::from).collect()),
            Property::ListUShort(list) => Corners::Unsigned(list.into_iter().map(u32::from).collect()),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Other {
    fn new() -> Self {
        Other
    }

    fn set_property(&mut self, _name: &str, _property: Property) -> PropertyAccessResult {
        PropertyAccessResult::Set
    }
}

fn is_corner_list(name: &str) -> bool {
    matches!(name, "vertex_indices" | "vertex_index")
}

fn scalar(property: &Property) -> Option<f64> {
    match *property {
        Property::Char(value) => Some(f64::from(value)),
        Property::UChar(value) => Some(f64::from(value)),
        Property::Short(value) => Some(f64::from(value)),
        Property::UShort(value) => Some(f64::from(value)),
        Property::Int(value) => Some(f64::from(value)),
        Property::UInt(value) => Some(f64::from(value)),
        Property::Float(value) => Some(f64::from(value)),
        Property::Double(value) => Some(value),
        _ => None,
    }
}

/// What is read of a file.
#[derive(Default)]
struct Mesh {
    vertices: Vec<Vertex>,
    /// Corners of all polygons, one after the other; numbers of vertices.
    corners: Vec<i64>,
    /// For each polygon where its corners end, and its own colour.
    polygons: Vec<(usize, Option<[f64; 3]>)>,
    /// Faces with fewer than 3 corners.
    skipped: u64,
    has_faces: bool,
}

impl Mesh {
    fn add(&mut self, face: Face) -> Result<(), String> {
        let before = self.corners.len();
        match face.corners {
            Corners::None => {}
            Corners::Signed(list) => self.corners.extend(list.into_iter().map(i64::from)),
            Corners::Unsigned(list) => self.corners.extend(list.into_iter().map(i64::from)),
        }
        match self.corners.len() - before {
            0..=2 => {
                self.corners.truncate(before);
                self.skipped += 1;
            }
            3..=MOST_CORNERS => self.polygons.push((self.corners.len(), face.colour.rgb())),
            _ => return Err(format!("a face has more than {MOST_CORNERS} corners; split it")),
        }
        Ok(())
    }
}

impl Draft {
    /// Adds a PLY file; its material is called like the file.
    ///
    /// # Errors
    /// All kinds of [`SceneError`], with the line where there is one.
    pub(super) fn add_ply(&mut self, path: &Path, progress: &dyn Progress) -> Result<(), SceneError> {
        self.files.push(path.to_path_buf());
        let Mesh { vertices, corners, polygons, skipped, has_faces } = read(path)?;
        progress.start("load", polygons.len() as u64);
        let mut skip = |count: u64, what: &str| {
            self.counts.skipped_faces += count;
            self.warnings.push(format!("{}: {count} {what} skipped", path.display()));
        };
        if !has_faces {
            skip(vertices.len() as u64, "point(s) without faces");
        } else if skipped > 0 {
            skip(skipped, "face(s) with fewer than 3 corners");
        }
        let first = self.room_for(path, vertices.len())?;
        for (number, vertex) in vertices.iter().enumerate() {
            let position = DVec3::from_array(vertex.position);
            if !is_position(position) {
                let message = format!("vertex {number} is not finite or too far away; correct it");
                return Err(SceneError::parse(path, None, message));
            }
            self.positions.push(position);
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let grey = DraftMaterial::of_mesh(&name, [DEFAULT_GREY; 3], [0.0; 3], Origin::Unnamed);
        let white = DraftMaterial::of_mesh(&name, [1.0; 3], [0.0; 3], Origin::Given);
        let [grey, white] = [grey, white].map(|material| self.add_material(material));
        let (mut cutter, mut tints) = (Cutter::new(), Tints::default());
        let mut start = 0;
        let mut polygon = Vec::new();
        for (number, &(end, colour)) in polygons.iter().enumerate() {
            let fault = |what: String| SceneError::parse(path, None, format!("polygon {number}: {what}"));
            polygon.clear();
            for &corner in &corners[start..end] {
                if corner < 0 || corner >= vertices.len() as i64 {
                    let there = vertices.len();
                    return Err(fault(format!("vertex {corner} is none of the {there}; check the indices")));
                }
                polygon.push(corner as u32);
            }
            start = end;
            let material = match colour.or_else(|| mean_colour(&vertices, &polygon)) {
                Some(rgb) if rgb.iter().all(|c| c.is_finite()) => tints.material(self, white, rgb),
                Some(_) => return Err(fault("has a colour that is not finite; correct it".to_owned())),
                None => grey,
            };
            self.add_polygon(path, first, &polygon, material, &mut cutter)?;
        }
        progress.advance(polygons.len() as u64);
        Ok(())
    }
}

/// Of the corners of a face, when all have one.
fn mean_colour(vertices: &[Vertex], corners: &[u32]) -> Option<[f64; 3]> {
    let mut sum = [0.0; 3];
    for &corner in corners {
        let rgb = vertices[corner as usize].colour.rgb()?;
        sum = [0, 1, 2].map(|channel| sum[channel] + rgb[channel]);
    }
    Some(sum.map(|channel| channel / corners.len() as f64))
}

fn read(path: &Path) -> Result<Mesh, SceneError> {
    let file = open_regular(path)?;
    let length = file.metadata().map_err(|error| unreadable(path, &error))?.len();
    let mut bytes = BufReader::with_capacity(1 << 18, file);
    let start = bytes.fill_buf().map_err(|error| unreadable(path, &error))?;
    if !start.starts_with(b"ply") {
        return Err(SceneError::parse(path, Some(1), "does not begin with 'ply'; export it as PLY again"));
    }
    // What has no line breaks would be one line.
    let bytes = BufReader::with_capacity(1 << 16, PlainText::new(bytes));
    let mut reader = Reader::new(bytes.take(LONGEST_HEADER));
    let header =
        Parser::<Other>::new().read_header(&mut reader).map_err(|error| explain(path, "header", &error))?;
    reader.get_mut().set_limit(u64::MAX);
    check_sizes(path, &header, length)?;
    let mut mesh = Mesh::default();
    for element in header.elements.values() {
        let fault = |error: ParseError| explain(path, &element.name, &error);
        match element.name.as_str() {
            "vertex" => mesh.vertices = read_all(&mut reader, element, &header).map_err(fault)?,
            "face" => {
                mesh.has_faces = true;
                // Few at a time: each takes several times its room in the file.
                let mut left = element.clone();
                while left.count > 0 {
                    let few = ElementDef { count: left.count.min(FACES_AT_ONCE), ..left.clone() };
                    left.count -= few.count;
                    for face in read_all(&mut reader, &few, &header).map_err(fault)? {
                        mesh.add(face).map_err(|what| SceneError::parse(path, None, what))?;
                    }
                }
            }
            _ => drop(read_all::<Other>(&mut reader, element, &header).map_err(fault)?),
        }
    }
    Ok(mesh)
}

fn read_all<E: PropertyAccess>(
    reader: &mut Reader<impl BufRead>,
    element: &ElementDef,
    header: &Header,
) -> Result<Vec<E>, ParseError> {
    Parser::new().read_payload_for_element(reader, element, header)
}

/// Refuses a header that names more than the file can hold, or no vertices in space.
fn check_sizes(path: &Path, header: &Header, length: u64) -> Result<(), SceneError> {
    let parse = |what: String| Err(SceneError::parse(path, None, what));
    let mut needed = 0u64;
    for element in header.elements.values() {
        let size: u64 = element
            .properties
            .values()
            .map(|property| least_size(&property.data_type, header.encoding))
            .sum();
        if size == 0 && element.count > 0 {
            return parse(format!("element {} has no properties; remove it", quoted(&element.name)));
        }
        needed = needed.saturating_add(size.saturating_mul(element.count as u64));
    }
    if needed > length {
        return parse(format!(
            "the file is cut off: it has {length} of at least {needed} bytes; export it again"
        ));
    }
    let has = |element: &ElementDef, names: &[&str]| {
        names.iter().all(|name| element.properties.contains_key(*name))
    };
    match header.elements.get("vertex") {
        Some(vertex) if has(vertex, &["x", "y", "z"]) => {}
        _ => return parse("has no vertices with x, y and z; export it again".to_owned()),
    }
    match header.elements.get("face") {
        Some(face) if !face.properties.keys().any(|name| is_corner_list(name)) => {
            parse("has no list vertex_indices of faces; export it again".to_owned())
        }
        _ => Ok(()),
    }
}

/// Fewest bytes of a property: in text a digit, and what separates it from the next one.
fn least_size(kind: &PropertyType, encoding: Encoding) -> u64 {
    let scalar = match kind {
        PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => scalar,
    };
    match (encoding, scalar) {
        // Between two, or at the end of the line but the last.
        (Encoding::Ascii, _) => 1,
        (_, ScalarType::Char | ScalarType::UChar) => 1,
        (_, ScalarType::Short | ScalarType::UShort) => 2,
        (_, ScalarType::Int | ScalarType::UInt | ScalarType::Float) => 4,
        (_, ScalarType::Double) => 8,
    }
}

/// The reader's message on one line, shortened.
fn explain(path: &Path, element: &str, error: &ParseError) -> SceneError {
    let line = error.line().filter(|&line| line > 0).map(|line| line as u64);
    if error.kind() == ErrorKind::UnexpectedEof {
        let message = format!("the file ends before the last of {}; export it again", quoted(element));
        return SceneError::parse(path, line, message);
    }
    let whole = error.to_string();
    // It says the line, what it expected, the text of the line, and sometimes why.
    let text = whole
        .split_once(": ")
        .filter(|(line, _)| line.starts_with("Line "))
        .map_or(&*whole, |(_, text)| text);
    let first = text.lines().next().unwrap_or_default().trim_end_matches('.');
    let read = text.split_once("String: '").map_or(String::new(), |(_, line)| {
        format!(": {}", quoted(line.lines().next().unwrap_or_default().trim_end_matches('\'')))
    });
    let why = text.rsplit_once("Error: ").map(|(_, why)| why).filter(|why| !why.contains("ParseError {"));
    let why = why.map_or(String::new(), |why| format!(" ({})", short(why)));
    let what = format!("{}{read}{why}", short(first));
    SceneError::parse(path, line, format!("{} cannot be read: {what}; export it again", quoted(element)))
}

/// On one line of usual length.
fn short(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    line.chars().map(|c| if c.is_control() { ' ' } else { c }).take(100).collect()
}
