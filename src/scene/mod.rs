//! What is to be lit: polygons, materials, emitters and cameras, read from files and checked, then
//! never changed again.

mod camera;
mod camera_path;
mod change;
mod description;
mod draft;
mod error;
mod generate;
mod gltf;
mod lines;
mod load;
mod mesh_file;
mod mtl;
mod obj;
mod painted;
mod ply;
mod ply_text;
mod pose;
mod statements;
mod texture;
mod tint;
mod toml_file;
mod triangulate;
mod turntable;
mod validate;

pub use camera_path::{CameraPath, Pace};
pub use change::{MaterialChange, check_names};
pub use error::{SceneError, SceneErrorKind};
pub use generate::{GenerateError, OfficeOptions, OfficeSummary, generate_office};
pub use load::{LoadOptions, load};
pub use texture::{Painting, Texture, Wrap};
pub use turntable::{TurntableError, turntable};

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;

/// A validated scene. Positions are in scene units, as in the file (double precision).
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name shown to people: the file's stem or its folder's name.
    pub name: String,
    /// Vertex positions in scene units; all finite.
    pub positions: Vec<DVec3>,
    /// Triangles; vertex, material and patch ids are in range and the area is not zero.
    pub triangles: Vec<Triangle>,
    /// Materials; reflectance in `[0, 0.98]`, radiance ≥ 0, all finite.
    pub materials: Vec<Material>,
    /// The rectangles of the scene description, by name.
    pub rectangles: Vec<Rectangle>,
    /// Cameras, never empty after loading (one is derived from the bounds when the file has none).
    pub cameras: Vec<Camera>,
    /// Metres in one scene unit; areas and powers in watts use it.
    pub meters_per_unit: f64,
    /// How many input polygons (patches) the triangles came from.
    pub patch_count: u32,
    /// What the import dropped or repaired.
    pub counts: ImportCounts,
    /// The files it was read from.
    pub files: Vec<PathBuf>,
    /// One line each, for standard error: what was repaired.
    pub warnings: Vec<String>,
}

/// A rectangle (any flat convex quadrilateral) of the scene description.
#[derive(Clone, Debug, PartialEq)]
pub struct Rectangle {
    /// Its name; several may have the same.
    pub name: String,
    /// Corners in scene units, counter-clockwise seen from the front.
    pub corners: [DVec3; 4],
}

/// Three vertices in counter-clockwise order seen from the front (emitting) side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Indices into [`Scene::positions`].
    pub vertices: [u32; 3],
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// The input polygon it came from, `0..patch_count`.
    pub patch: u32,
}

/// A diffuse surface, linear RGB (Rec. 709).
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the mesh, its library or the scene description; several may have one.
    pub name: String,
    /// Fraction of light reflected, `[0, 0.98]` per channel; the mean of its picture, where there is one.
    pub reflectance: [f32; 3],
    /// Emitted radiance in W/(m²·sr), from the front side only.
    pub radiance: [f32; 3],
    /// What its surfaces reflect from point to point.
    pub painting: Option<Arc<Painting>>,
}

impl Material {
    /// What is reflected at a point, scene units, `[0, 0.98]` per channel.
    pub fn reflectance_at(&self, point: DVec3) -> [f32; 3] {
        self.painting.as_ref().map_or(self.reflectance, |painting| painting.reflectance_at(point))
    }

    /// Whether any channel emits.
    pub fn is_emitter(&self) -> bool {
        self.radiance.iter().any(|&l| l > 0.0)
    }
}

/// A pinhole camera in scene units.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Chosen with `--camera NAME`.
    pub name: String,
    /// Where it stands.
    pub eye: DVec3,
    /// What it looks at; differs from `eye`.
    pub target: DVec3,
    /// Up, not parallel to the view direction.
    pub up: DVec3,
    /// Full vertical field of view, degrees, in (0, 180).
    pub vfov_deg: f64,
    /// Pixels, ≥ 1.
    pub width: u32,
    /// Pixels, ≥ 1.
    pub height: u32,
}

/// What the import counted while it cleaned up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImportCounts {
    /// Triangles after triangulation, before anything was dropped.
    pub triangles_initial: u64,
    /// Triangles of zero area.
    pub dropped_degenerate: u64,
    /// Triangles with the very same three positions as an earlier one (either winding).
    pub dropped_duplicate: u64,
    /// Faces that are points or lines.
    pub skipped_faces: u64,
}
