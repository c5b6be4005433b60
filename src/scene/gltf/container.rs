//! The file itself: JSON with what it needs beside it, or both in one GLB. What the JSON says is checked here as far as it can
//! be without its data.
//!
//! `gltf-json` reads the JSON. Container and data are read here: the readers of the crate `gltf` panic where offsets are
//! out of range.

use std::path::Path;

use gltf_json::Root;
use gltf_json::mesh::Semantic;
use gltf_json::validation::{Checked, Error as Fault, Validate};

use super::super::error::{SceneError, name_list};
use super::super::lines::read_whole;

/// Most objects in the JSON: each takes many times the memory of its text.
const MOST_OBJECTS: usize = 1 << 22;
/// Most bytes of all that is read for one file.
pub(super) const MOST_BYTES: u64 = 8 << 30;

const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// What diffuse surfaces need is read of these, or they do not change it.
const READ_EXTENSIONS: [&str; 7] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];
/// These say how surfaces shine or move, or hold notes.
const HARMLESS_EXTENSIONS: [&str; 13] = [
    "KHR_animation_pointer",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// The JSON, and the binary chunk where there is one.
pub(super) struct Container {
    pub(super) root: Root,
    pub(super) binary: Option<Vec<u8>>,
}

/// Reads a file and checks the JSON: every index in it is in range.
///
/// # Errors
/// All kinds of [`SceneError`].
pub(super) fn read(path: &Path, warnings: &mut Vec<String>) -> Result<Container, SceneError> {
    let mut bytes = read_whole(path, MOST_BYTES)?;
    let (text, binary) = match bytes.starts_with(b"glTF") {
        true => chunks(&bytes).map_err(|what| SceneError::parse(path, None, what))?,
        false => (0..bytes.len(), None),
    };
    let text = &bytes[text];
    let mut root = parse(path, text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text))?;
    // Of the text nothing is kept.
    let binary = binary.map(|Range { start, end }| {
        bytes.truncate(end);
        bytes.drain(..start);
        bytes.shrink_to_fit();
        bytes
    });
    check_extensions(path, &root, warnings)?;
    // They are checked above; the crate knows fewer.
    root.extensions_required.clear();
    check(&root).map_err(|what| SceneError::parse(path, None, what))?;
    Ok(Container { root, binary })
}

type Range = std::ops::Range<usize>;

/// Where the JSON and the binary chunk of a GLB are.
fn chunks(bytes: &[u8]) -> Result<(Range, Option<Range>), String> {
    let again = "export it again";
    let number = |at: usize| {
        let four = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes(four.try_into().ok()?))
    };
    let cut = || format!("the file is cut off after {} bytes; {again}", bytes.len());
    match number(4).ok_or_else(cut)? {
        2 => {}
        version => return Err(format!("GLB version {version} is not read; export it as glTF 2.0")),
    }
    let length = number(8).ok_or_else(cut)? as usize;
    if length > bytes.len() {
        return Err(format!("the file is cut off: it has {} of {length} bytes; {again}", bytes.len()));
    }
    let chunk = |at: usize, limit: usize| {
        let start = at + CHUNK_HEADER;
        let (length, kind) = (number(at)?, bytes.get(at + 4..start)?);
        let end = start.checked_add(length as usize)?;
        (end <= limit).then_some((kind, start..end))
    };
    let Some((b"JSON", json)) = chunk(HEADER, length) else {
        return Err(format!("the GLB does not begin with a whole chunk of JSON; {again}"));
    };
    let next = json.end;
    if length - next < CHUNK_HEADER {
        return Ok((json, None));
    }
    match chunk(next, length) {
        Some((b"BIN\0", binary)) => Ok((json, Some(binary))),
        // The format lets readers skip what they do not know.
        Some(_) => Ok((json, None)),
        None => Err(format!("the second chunk of the GLB is longer than the file; {again}")),
    }
}

fn parse(path: &Path, text: &[u8]) -> Result<Root, SceneError> {
    let objects = text.iter().filter(|&&byte| byte == b'{').count();
    if objects > MOST_OBJECTS {
        let message =
            format!("the JSON has more than {MOST_OBJECTS} objects; split the scene or join its meshes");
        return Err(SceneError::invalid(path, None, message));
    }
    gltf_json::deserialize::from_slice(text).map_err(|error| {
        let message = error.to_string();
        // The place is said before the message.
        let what = message.split(" at line ").next().unwrap_or_default();
        let what: String = what.chars().take(160).flat_map(char::escape_debug).collect();
        let line = (error.line() > 0).then_some(error.line() as u64);
        let message = format!("the JSON is no glTF 2.0 (column {}: {what}); export it again", error.column());
        SceneError::parse(path, line, message)
    })
}

/// Refuses extensions without which the geometry cannot be read.
fn check_extensions(path: &Path, root: &Root, warnings: &mut Vec<String>) -> Result<(), SceneError> {
    let is_known = |name: &&str| READ_EXTENSIONS.contains(name) || HARMLESS_EXTENSIONS.contains(name);
    let unknown = |names: &[String]| {
        let mut unknown: Vec<String> =
            names.iter().filter(|name| !is_known(&name.as_str())).cloned().collect();
        unknown.sort();
        unknown.dedup();
        unknown
    };
    let required = unknown(&root.extensions_required);
    if !required.is_empty() {
        let advice = match required.iter().any(|name| name.contains("compression")) {
            true => "export it without compression",
            false => "export it without them",
        };
        let names = name_list(required.iter().map(String::as_str));
        let message = format!("needs the extension(s) {names}, which are not read; {advice}");
        return Err(SceneError::invalid(path, None, message));
    }
    let used = unknown(&root.extensions_used);
    if !used.is_empty() {
        let names = name_list(used.iter().map(String::as_str));
        warnings.push(format!("{}: extension(s) that are not read: {names}", path.display()));
    }
    Ok(())
}

/// What is wrong with the JSON, first of all.
fn check(root: &Root) -> Result<(), String> {
    if !root.asset.version.starts_with("2.") {
        let version: String = root.asset.version.chars().take(16).flat_map(char::escape_debug).collect();
        return Err(format!("glTF version {version} is not read; export it as glTF 2.0"));
    }
    // The crate's own check looks up positions before it knows that they are there.
    for (mesh, of) in root.meshes.iter().enumerate() {
        for (primitive, of) in of.primitives.iter().enumerate() {
            let position = of.attributes.get(&Checked::Valid(Semantic::Positions));
            if position.is_some_and(|accessor| accessor.value() >= root.accessors.len()) {
                return Err(format!(
                    "meshes[{mesh}].primitives[{primitive}]: no such accessor; export it again"
                ));
            }
        }
    }
    let mut first = None;
    root.validate(root, gltf_json::Path::new, &mut |path, fault| {
        let path = path();
        // Positions are read without their bounds, which many programs leave out.
        let is_bound = path.as_str().ends_with(".min") || path.as_str().ends_with(".max");
        let is_bound = is_bound || path.as_str().contains("\"POSITION\"]");
        // An accessor without data is one of zeros.
        let is_zeros = path.as_str().ends_with(".bufferView") && matches!(fault, Fault::Missing);
        let is_bound = is_bound && matches!(fault, Fault::Missing | Fault::Invalid);
        if first.is_none() && !is_bound && !is_zeros {
            first = Some((path, fault));
        }
    });
    let Some((path, fault)) = first else { return Ok(()) };
    let what = match fault {
        Fault::IndexOutOfBounds => "names something that is not there",
        Fault::Invalid => "has a value that glTF does not know",
        Fault::Missing => "is missing",
        Fault::Oversize => "is too large",
        Fault::Unsupported => "is not read",
    };
    let path: String = path.as_str().chars().take(120).flat_map(char::escape_debug).collect();
    Err(format!("{path} {what}; export it again"))
}
