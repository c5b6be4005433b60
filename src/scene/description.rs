//! The scene description TOML: which meshes, in what unit, seen by which cameras, with which extra
//! rectangles and changed materials. Every fault names its line.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use toml::Spanned;

use super::Camera;
use super::draft::{DEFAULT_GREY, shown_name};
use super::error::{SceneError, quoted};
use super::mesh_file::{MESH_KINDS, MeshKind};
use super::pose::{PoseFault, pose_fault};
use super::statements::{LARGEST_COLOUR, LARGEST_COORDINATE};
use super::toml_file::{TomlFile, is_position};
use super::triangulate::newell_normal;

/// Most pixels along one side of a picture.
const MOST_PIXELS: i64 = 16_384;
/// Lengths that a unit may have, in metres.
const METERS: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

/// A checked description; the meshes are not read yet.
#[derive(Debug)]
pub(super) struct Description {
    /// Paths to the meshes, and the line that names each.
    pub(super) meshes: Vec<(PathBuf, MeshKind, u64)>,
    pub(super) meters_per_unit: f64,
    pub(super) cameras: Vec<Camera>,
    pub(super) quads: Vec<Quad>,
    pub(super) overrides: Vec<MaterialOverride>,
    pub(super) warnings: Vec<String>,
}

/// An extra rectangle (any flat convex quadrilateral), front side counter-clockwise.
#[derive(Clone, Debug)]
pub(super) struct Quad {
    pub(super) name: String,
    pub(super) corners: [DVec3; 4],
    pub(super) reflectance: [f64; 3],
    pub(super) radiance: [f64; 3],
}

/// What `[material."name"]` changes.
#[derive(Clone, Debug)]
pub(super) struct MaterialOverride {
    pub(super) name: String,
    pub(super) line: u64,
    pub(super) reflectance: Option<[f64; 3]>,
    pub(super) radiance: Option<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    mesh: Option<Spanned<MeshList>>,
    meters_per_unit: Option<Spanned<f64>>,
    #[serde(default)]
    camera: Vec<Spanned<CameraTable>>,
    #[serde(default)]
    quad: Vec<Spanned<QuadTable>>,
    #[serde(default)]
    material: BTreeMap<Spanned<String>, MaterialTable>,
}

enum MeshList {
    One(String),
    Many(Vec<Spanned<String>>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraTable {
    name: Option<Spanned<String>>,
    eye: Spanned<[f64; 3]>,
    target: Spanned<[f64; 3]>,
    up: Option<Spanned<[f64; 3]>>,
    vfov_deg: Option<Spanned<f64>>,
    width: Option<Spanned<i64>>,
    height: Option<Spanned<i64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct QuadTable {
    name: Option<Spanned<String>>,
    corners: Spanned<Vec<[f64; 3]>>,
    reflectance: Option<Spanned<[f64; 3]>>,
    radiance: Option<Spanned<[f64; 3]>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialTable {
    reflectance: Option<Spanned<[f64; 3]>>,
    radiance: Option<Spanned<[f64; 3]>>,
}

impl<'de> Deserialize<'de> for MeshList {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrMany;
        impl<'de> Visitor<'de> for OneOrMany {
            type Value = MeshList;
            fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str("the path of a mesh or a list of paths")
            }
            fn visit_str<E>(self, path: &str) -> Result<MeshList, E> {
                Ok(MeshList::One(path.to_owned()))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<MeshList, A::Error> {
                let mut paths = Vec::new();
                while let Some(path) = list.next_element()? {
                    paths.push(path);
                }
                Ok(MeshList::Many(paths))
            }
        }
        deserializer.deserialize_any(OneOrMany)
    }
}

/// Reads and checks a description.
///
/// # Errors
/// All kinds of [`SceneError`], with the line.
pub(super) fn read(path: &Path) -> Result<Description, SceneError> {
    let file = TomlFile::read(path, "put geometry in a mesh")?;
    let document: Document = file.parse()?;
    file.check(document)
}

/// Turns what parsed into what makes sense.
impl TomlFile {
    fn check(&self, document: Document) -> Result<Description, SceneError> {
        let meshes = self.meshes(document.mesh)?;
        let meters_per_unit = match document.meters_per_unit {
            None => 1.0,
            Some(value) => {
                let meters = *value.get_ref();
                if !METERS.contains(&meters) {
                    let (least, most) = (METERS.start(), METERS.end());
                    let message = format!(
                        "meters_per_unit is {meters:?}; write a number from {least:e} to {most:e}, such as 0.001 for mm"
                    );
                    return self.fault(value.span(), message);
                }
                meters
            }
        };
        let mut cameras: Vec<Camera> = Vec::new();
        for table in document.camera {
            let camera = self.camera(table, cameras.len() + 1, &cameras)?;
            cameras.push(camera);
        }
        let mut quads: Vec<Quad> = Vec::new();
        let mut warnings = Vec::new();
        for table in document.quad {
            let line = self.line(table.span());
            let quad = self.quad(table, quads.len() + 1)?;
            if quads.iter().any(|other| other.name == quad.name) {
                warnings.push(format!(
                    "{}:{line}: another quad is called {} too; names are easier to follow when they differ",
                    self.path.display(),
                    quoted(&quad.name)
                ));
            }
            quads.push(quad);
        }
        if meshes.is_empty() && quads.is_empty() {
            let message = "neither mesh nor [[quad]]; name a mesh = \"room.obj\" or give a [[quad]]";
            return Err(SceneError::invalid(&self.path, None, message));
        }
        let mut overrides = Vec::new();
        for (name, table) in document.material {
            overrides.push(MaterialOverride {
                line: self.line(name.span()),
                name: name.into_inner(),
                reflectance: table.reflectance.map(|rgb| self.colour(rgb, "reflectance")).transpose()?,
                radiance: table.radiance.map(|rgb| self.colour(rgb, "radiance")).transpose()?,
            });
        }
        // A fault in the first of several overrides is reported first.
        overrides.sort_by_key(|change| change.line);
        Ok(Description { meshes, meters_per_unit, cameras, quads, overrides, warnings })
    }

    fn meshes(&self, list: Option<Spanned<MeshList>>) -> Result<Vec<(PathBuf, MeshKind, u64)>, SceneError> {
        let Some(list) = list else { return Ok(Vec::new()) };
        let span = list.span();
        let names = match list.into_inner() {
            MeshList::One(name) => vec![Spanned::new(span, name)],
            MeshList::Many(names) => names,
        };
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let mut meshes = Vec::new();
        for name in names {
            let path = folder.join(name.get_ref());
            let Some(kind) = MeshKind::of(&path) else {
                let message =
                    format!("mesh {} is no {MESH_KINDS} file; export it as one", quoted(name.get_ref()));
                return self.fault(name.span(), message);
            };
            if !path.exists() {
                return Err(SceneError::io(
                    &self.path,
                    Some(self.line(name.span())),
                    format!(
                        "mesh file {} not found; give a path relative to this file ({} does not exist)",
                        quoted(name.get_ref()),
                        path.display().to_string().escape_debug()
                    ),
                ));
            }
            meshes.push((path, kind, self.line(name.span())));
        }
        Ok(meshes)
    }

    fn camera(
        &self,
        table: Spanned<CameraTable>,
        number: usize,
        others: &[Camera],
    ) -> Result<Camera, SceneError> {
        let span = table.span();
        let table = table.into_inner();
        let name_span = table.name.as_ref().map_or(span.clone(), Spanned::span);
        let name = table.name.map_or_else(|| format!("camera{number}"), |name| shown_name(name.as_ref()));
        if name.is_empty() {
            return self.fault(name_span, "the camera's name is empty; give it one for --camera");
        }
        if others.iter().any(|other| other.name == name) {
            let message = format!("another camera is called {} too; rename one", quoted(&name));
            return self.fault(name_span, message);
        }
        let eye = self.point(&table.eye, "eye")?;
        let target = self.point(&table.target, "target")?;
        let (up_span, up) = match &table.up {
            Some(up) => (up.span(), self.point(up, "up")?),
            None => (span, DVec3::Y),
        };
        if let Some(fault) = pose_fault(eye, target, up) {
            let span = if fault == PoseFault::NoView { table.target.span() } else { up_span };
            return self.fault(span, fault.message());
        }
        let vfov_deg = match &table.vfov_deg {
            None => super::camera::DEFAULT_VFOV_DEG,
            Some(angle) => self.vfov_deg(angle)?,
        };
        let width = self.pixels(table.width, "width", super::camera::DEFAULT_WIDTH)?;
        let height = self.pixels(table.height, "height", super::camera::DEFAULT_HEIGHT)?;
        Ok(Camera { name, eye, target, up, vfov_deg, width, height })
    }

    fn pixels(&self, value: Option<Spanned<i64>>, key: &str, default: u32) -> Result<u32, SceneError> {
        let Some(value) = value else { return Ok(default) };
        match *value.get_ref() {
            pixels @ 1..=MOST_PIXELS => Ok(pixels as u32),
            pixels => {
                let message = format!("{key} is {pixels}; write pixels between 1 and {MOST_PIXELS}");
                self.fault(value.span(), message)
            }
        }
    }

    fn quad(&self, table: Spanned<QuadTable>, number: usize) -> Result<Quad, SceneError> {
        let table = table.into_inner();
        let span = table.corners.span();
        let corners = table.corners.get_ref();
        let [a, b, c, d] = corners.as_slice() else {
            let message = format!("a quad has 4 corners and this one has {}; give 4", corners.len());
            return self.fault(span, message);
        };
        let corners = [a, b, c, d].map(|&corner| DVec3::from_array(corner));
        if corners.iter().any(|corner| !is_position(*corner)) {
            let message = format!("a corner is not finite or beyond {LARGEST_COORDINATE:e}; correct it");
            return self.fault(span, message);
        }
        if let Some(message) = quad_fault(corners) {
            return self.fault(span, message);
        }
        Ok(Quad {
            name: table.name.map_or_else(|| format!("quad{number}"), |name| shown_name(name.as_ref())),
            corners,
            reflectance: match table.reflectance {
                Some(rgb) => self.colour(rgb, "reflectance")?,
                None => [DEFAULT_GREY; 3],
            },
            radiance: match table.radiance {
                Some(rgb) => self.colour(rgb, "radiance")?,
                None => [0.0; 3],
            },
        })
    }

    fn colour(&self, value: Spanned<[f64; 3]>, key: &str) -> Result<[f64; 3], SceneError> {
        let rgb = *value.get_ref();
        if rgb.iter().all(|channel| (0.0..=LARGEST_COLOUR).contains(channel)) {
            return Ok(rgb);
        }
        self.fault(
            value.span(),
            format!("{key} {rgb:?} is negative, not finite or too large; write 0 to {LARGEST_COLOUR:e}"),
        )
    }
}

/// What keeps four points from being a flat convex quadrilateral.
fn quad_fault(corners: [DVec3; 4]) -> Option<&'static str> {
    let normal = newell_normal(&corners);
    let size = (corners[2] - corners[0]).length().max((corners[3] - corners[1]).length());
    let edge = |i: usize| corners[(i + 1) % 4] - corners[i % 4];
    let longest = (0..4).map(|i| edge(i).length()).fold(size, f64::max);
    let far = corners.iter().map(|corner| corner.abs().max_element()).fold(0.0, f64::max);
    let is_flat_triangle =
        |i: usize| edge(i).cross(edge(i + 1)).length() <= 1e-12 * longest * far.max(longest);
    if (0..4).all(is_flat_triangle) {
        return Some("the corners lie on one line; spread them");
    }
    let direction = normal.normalize_or_zero();
    if (0..4).any(|i| edge(i).cross(edge(i + 1)).dot(direction) <= 0.0) {
        return Some("the outline crosses itself or is not convex; list the corners around the outline");
    }
    if corners.iter().any(|corner| (*corner - corners[0]).dot(direction).abs() > 1e-3 * longest) {
        return Some("the corners do not lie in one plane; flatten the quad or split it");
    }
    None
}
