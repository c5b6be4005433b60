//! MTL through `tobj`: the diffuse reflectance `Kd`, its picture, and the emitted radiance `Ke` of each material.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec2;

use super::error::{SceneError, name_list, quoted};
use super::lines::{Lines, MOST_PICTURE_BYTES, read_whole};
use super::obj::{find_beside, without_comment};
use super::statements::{LARGEST_COLOUR, number, words};
use super::texture::{Picture, Texture, Wrap};

/// Options and their values before the name of a picture, at most.
const MOST_WORDS: usize = 32;

const EVEN: &str =
    "emission with a picture (map_Ke) is even, Ke times the mean of the picture, of material(s)";
const DARK: &str = "Ke or the picture of it (map_Ke) is black, so nothing is emitted by material(s)";

/// One material of a library.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MtlMaterial {
    /// Name after `newmtl`, blanks inside kept.
    pub(super) name: String,
    /// Reflectance, linear RGB ≥ 0, when there is a `Kd` or a picture, of which it has the mean.
    pub(super) reflectance: Option<[f64; 3]>,
    /// Radiance in W/(m²·sr), ≥ 0; zero without `Ke` or a picture of it, of which it has the mean.
    pub(super) radiance: [f64; 3],
    /// The picture that `factor` multiplies.
    pub(super) picture: Option<MtlPicture>,
}

/// A picture of a material.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MtlPicture {
    pub(super) picture: Picture,
    /// What multiplies it, linear RGB.
    pub(super) factor: [f64; 3],
    /// What multiplies the coordinates of a corner, and what is added to them.
    scale: DVec2,
    offset: DVec2,
}

impl MtlPicture {
    /// Where a `vt` is on the picture, from the left and from the top.
    pub(super) fn place(&self, u: f64, v: f64) -> DVec2 {
        let DVec2 { x, y } = DVec2::new(u, v) * self.scale + self.offset;
        DVec2::new(x, 1.0 - y)
    }
}

/// Reads a library; a later material replaces an earlier one of the same name. Warnings are added to
/// `warnings`, and the pictures that it names to `files`; `room` is how many pixels they may have, and how many are left.
///
/// A picture (`map_Kd`, `map_Ke`) multiplies `Kd` or `Ke`; one that cannot be read is a warning.
///
/// # Errors
/// [`SceneError::Io`], [`SceneError::Parse`] and [`SceneError::Invalid`], with the line.
pub(super) fn read(
    path: &Path,
    warnings: &mut Vec<String>,
    files: &mut Vec<PathBuf>,
    room: &mut u64,
) -> Result<Vec<MtlMaterial>, SceneError> {
    let plain = plain_form(path, warnings)?;
    let (materials, _) = tobj::load_mtl_buf(&mut plain.as_slice())
        .map_err(|error| SceneError::parse(path, None, format!("cannot be read as MTL ({error})")))?;
    let mut shelf = Shelf { library: path, files, room, textures: HashMap::new(), missing: Vec::new() };
    let (mut even, mut dark) = (Vec::new(), Vec::new());
    let mut read = Vec::new();
    for material in materials {
        let mut reflectance = material.diffuse;
        let mut picture = None;
        let found = material.diffuse_texture.as_deref().and_then(|text| shelf.take(text));
        if let Some((texture, options)) = found {
            let (mean, factor) = (texture.mean(), reflectance.unwrap_or([1.0; 3]));
            reflectance = Some([0, 1, 2].map(|channel| factor[channel] * mean[channel]));
            picture = Some(placed(texture, factor, &options));
        }
        let mut radiance = material.emissive.unwrap_or_default();
        let found = material.unknown_param.get("map_Ke").and_then(|text| shelf.take(text));
        if let Some((texture, _)) = found {
            let (mean, factor) = (texture.mean(), material.emissive.unwrap_or([1.0; 3]));
            radiance = [0, 1, 2].map(|channel| factor[channel] * mean[channel]);
            let names = if radiance == [0.0; 3] { &mut dark } else { &mut even };
            names.push(material.name.clone());
        }
        read.push(MtlMaterial { name: material.name, reflectance, radiance, picture });
    }
    let missing = shelf.missing;
    for (names, what) in [(&even, EVEN), (&dark, DARK)] {
        if !names.is_empty() {
            let names = name_list(names.iter().map(String::as_str));
            warnings.push(format!("{}: {what} {names}", path.display()));
        }
    }
    if !missing.is_empty() {
        let (count, first) = (missing.len(), &missing[0]);
        warnings.push(format!(
            "{}: {count} texture(s) missing, so the colours of their materials alone count; first {first}",
            path.display()
        ));
    }
    Ok(read)
}

/// The pictures of a library, read once each.
struct Shelf<'a> {
    library: &'a Path,
    files: &'a mut Vec<PathBuf>,
    room: &'a mut u64,
    textures: HashMap<PathBuf, Result<Arc<Texture>, String>>,
    /// Why some cannot be read.
    missing: Vec<String>,
}

impl Shelf<'_> {
    /// The picture that a statement names, and its options; none that cannot be read.
    fn take(&mut self, text: &str) -> Option<(Arc<Texture>, Vec<String>)> {
        let found =
            picture_path(self.library, text).or_else(|| picture_path(self.library, without_comment(text)));
        let texture = match found {
            None => Err("file not found".to_owned()),
            Some((found, options)) => {
                let texture = self.textures.entry(found.clone()).or_insert_with(|| {
                    let texture = decoded(&found, *self.room);
                    self.files.push(found);
                    let texture = texture?;
                    *self.room -= texture.pixels();
                    Ok(Arc::new(texture))
                });
                texture.clone().map(|texture| (texture, options))
            }
        };
        texture.map_err(|why| self.missing.push(format!("{} ({why})", quoted(text)))).ok()
    }
}

/// The file that a `map_Kd` or `map_Ke` names, and the options before it: the whole rest of the line if there is such a file, else what
/// follows some words of it.
fn picture_path(library: &Path, text: &str) -> Option<(PathBuf, Vec<String>)> {
    let starts = text.match_indices([' ', '\t']).map(|(blank, _)| blank + 1);
    std::iter::once(0).chain(starts).take(MOST_WORDS).find_map(|start| {
        let found = find_beside(library, text[start..].trim_start())?;
        Some((found, text[..start].split_whitespace().map(str::to_owned).collect()))
    })
}

fn decoded(path: &Path, room: u64) -> Result<Texture, String> {
    let bytes = read_whole(path, MOST_PICTURE_BYTES).map_err(|error| error.to_string())?;
    Texture::decode(&bytes, room)
}

/// A texture with the options `-clamp on`, `-s U V` and `-o U V`; the others do not move it.
fn placed(texture: Arc<Texture>, factor: [f64; 3], options: &[String]) -> MtlPicture {
    let after = |name: &str, place: usize| {
        let at = options.iter().position(|word| word == name)?;
        options.get(at + place)
    };
    let number =
        |name: &str, place: usize| after(name, place)?.parse::<f64>().ok().filter(|value| value.is_finite());
    let vector = |name: &str, default: f64| {
        DVec2::new(number(name, 1).unwrap_or(default), number(name, 2).unwrap_or(default))
    };
    let is_clamped = after("-clamp", 1).is_some_and(|value| value == "on");
    let wrap = if is_clamped { Wrap::Clamp } else { Wrap::Repeat };
    let picture = Picture { texture, wrap: [wrap; 2] };
    MtlPicture { picture, factor, scale: vector("-s", 1.0), offset: vector("-o", 0.0) }
}

/// `newmtl`, `Kd`, `Ke` and the pictures of both, checked; `tobj` panics on a colour of one number, and stops at
/// values of statements that do not matter here.
fn plain_form(path: &Path, warnings: &mut Vec<String>) -> Result<Vec<u8>, SceneError> {
    let mut lines = Lines::open(path)?;
    let mut plain = Vec::new();
    let mut has_material = false;
    let mut is_unnamed = false;
    while let Some((line, text)) = lines.next_line()? {
        let text = text.trim_ascii();
        let end = text.iter().position(|byte| byte.is_ascii_whitespace()).unwrap_or(text.len());
        let (keyword, rest) = text.split_at(end);
        match keyword {
            b"newmtl" => {
                let name = String::from_utf8_lossy(rest).trim().to_owned();
                has_material = !name.is_empty();
                if name.is_empty() {
                    warnings.push(format!(
                        "{}:{line}: newmtl without a name, so nothing can use it; its statements are ignored",
                        path.display()
                    ));
                    is_unnamed = true;
                    continue;
                }
                plain.extend_from_slice(format!("newmtl {name}\n").as_bytes());
            }
            b"Kd" | b"Ke" => {
                let keyword = if keyword == b"Kd" { "Kd" } else { "Ke" };
                let [r, g, b] = colour(rest).map_err(|message| {
                    SceneError::parse(path, Some(line), format!("{keyword}: {message}"))
                })?;
                if [r, g, b].iter().any(|&value| value < 0.0) {
                    return Err(SceneError::invalid(
                        path,
                        Some(line),
                        format!("{keyword} is negative; reflectance and radiance are 0 or more"),
                    ));
                }
                if !has_material {
                    if !is_unnamed {
                        warnings.push(format!(
                            "{}:{line}: {keyword} before the first newmtl is ignored",
                            path.display()
                        ));
                    }
                    continue;
                }
                plain.extend_from_slice(format!("{keyword} {r:e} {g:e} {b:e}\n").as_bytes());
            }
            b"map_Kd" | b"map_Ke" if has_material && !rest.trim_ascii().is_empty() => {
                let keyword = if keyword == b"map_Kd" { "map_Kd" } else { "map_Ke" };
                let name = String::from_utf8_lossy(rest).trim().to_owned();
                plain.extend_from_slice(format!("{keyword} {name}\n").as_bytes());
            }
            _ => {}
        }
    }
    Ok(plain)
}

/// Three numbers, or one for all three channels.
fn colour(rest: &[u8]) -> Result<[f64; 3], String> {
    let values: Vec<&[u8]> = words(rest).collect();
    match values.as_slice() {
        [kind, ..] if [&b"spectral"[..], b"xyz"].contains(kind) => {
            let kind = String::from_utf8_lossy(kind);
            Err(format!("{} colours are not supported; write linear RGB", quoted(&kind)))
        }
        [grey] => number(grey).map(|value| [value; 3]),
        [r, g, b, ..] => Ok([number(r)?, number(g)?, number(b)?]),
        _ => Err(format!("a colour needs 3 numbers and has {}; write r g b", values.len())),
    }
    .and_then(|rgb: [f64; 3]| {
        if rgb.iter().all(|value| value.abs() <= LARGEST_COLOUR) {
            Ok(rgb)
        } else {
            Err(format!("the number is too large; write at most {LARGEST_COLOUR:e}"))
        }
    })
}
