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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn pictures_of_all_meshes_share_their_room() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let at = |name: &str| folder.path().join(name);
        for name in ["a", "b", "c"] {
            image::RgbImage::new(2, 1).save(at(&format!("{name}.png"))).expect("a picture");
        }
        for name in ["a", "b"] {
            let mtl = format!("newmtl {name}\nmap_Kd {name}.png\n");
            std::fs::write(at(&format!("{name}.mtl")), mtl).expect("a library");
        }
        std::fs::write(at("m.obj"), "mtllib a.mtl b.mtl\nv 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n")
            .expect("a mesh");
        let gltf = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "accessors": [{"componentType": 5126, "type": "VEC3", "count": 3}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            "textures": [{"source": 0}], "images": [{"uri": "c.png"}]}"#;
        std::fs::write(at("m.gltf"), gltf).expect("a mesh");
        let read = |room: u64| {
            let mut draft = Draft::new(&at("scene.toml"));
            draft.picture_room = room;
            for name in ["m.obj", "m.gltf"] {
                let kind = MeshKind::of(Path::new(name)).expect("a kind");
                draft.add_mesh(&at(name), kind, &Silent).expect("a mesh");
            }
            let refused = draft.warnings.iter().filter(|warning| warning.contains("2 × 1 pixels")).count();
            (refused, draft.picture_room)
        };
        assert_eq!([6, 5, 3, 1].map(read), [(0, 0), (1, 1), (2, 1), (3, 1)]);
    }
}
