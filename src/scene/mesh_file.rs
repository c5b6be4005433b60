//! Which files are meshes, by their extension.

use std::path::Path;

use super::draft::Draft;
use super::error::SceneError;
use crate::progress::Progress;

/// The kinds of meshes, as messages name them.
pub(super) const MESH_KINDS: &str = ".obj, .glb, .gltf or .ply";

/// A kind of mesh that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MeshKind {
    Obj,
    Gltf,
    Ply,
}

impl MeshKind {
    /// The kind of a file; the case of its extension does not matter.
    pub(super) fn of(path: &Path) -> Option<MeshKind> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "obj" => Some(MeshKind::Obj),
            "glb" | "gltf" => Some(MeshKind::Gltf),
            "ply" => Some(MeshKind::Ply),
            _ => None,
        }
    }
}

impl Draft {
    /// Adds a mesh with all that its file brings.
    ///
    /// # Errors
    /// All kinds of [`SceneError`], with the line or the place in the file.
    pub(super) fn add_mesh(
        &mut self,
        path: &Path,
        kind: MeshKind,
        progress: &dyn Progress,
    ) -> Result<(), SceneError> {
        match kind {
            MeshKind::Obj => self.add_obj(path, progress),
            MeshKind::Gltf => self.add_gltf(path, progress),
            MeshKind::Ply => self.add_ply(path, progress),
        }
    }
}
