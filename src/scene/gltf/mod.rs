//! glTF 2.0 and GLB: the triangles, materials and cameras of the default scene, at rest. `docs/scene-format.md` says what is
//! read and what is left out.

mod accessor;
mod buffers;
mod cameras;
mod container;
mod materials;
mod nodes;
mod pictures;
mod primitives;

use std::path::Path;

use gltf_json::Root;

use self::buffers::Buffers;
use self::nodes::Placed;
use self::primitives::Meshes;
use super::draft::Draft;
use super::error::SceneError;
use crate::progress::Progress;

impl Draft {
    /// Adds the default scene of a glTF or GLB file.
    ///
    /// # Errors
    /// All kinds of [`SceneError`], with the place in the file.
    pub(super) fn add_gltf(&mut self, path: &Path, progress: &dyn Progress) -> Result<(), SceneError> {
        self.files.push(path.to_path_buf());
        let container = container::read(path, &mut self.warnings)?;
        let root = container.root;
        let buffers = Buffers::read(path, &root, container.binary)?;
        self.files.extend(buffers.files.iter().cloned());
        let placed = nodes::placed(path, &root)?;
        progress.start("load", placed.len() as u64);
        let first = self.positions.len();
        let mut meshes = Meshes::new(path, &root, &buffers, self.picture_room);
        for Placed { node, world } in &placed {
            if let Some(mesh) = root.nodes[*node].mesh {
                meshes.add(self, mesh.value(), *world)?;
            }
            progress.advance(1);
        }
        self.files.append(&mut meshes.pictures.files);
        self.picture_room = meshes.pictures.room;
        let file = path.display().to_string();
        self.counts.skipped_faces += meshes.skipped;
        if meshes.skipped > 0 {
            self.warnings.push(format!("{file}: {} point(s) or line(s) skipped", meshes.skipped));
        }
        if meshes.without_positions > 0 {
            let count = meshes.without_positions;
            self.warnings.push(format!("{file}: {count} primitive(s) without positions skipped"));
        }
        meshes.materials.warn(path, &mut self.warnings);
        self.remark_gltf(&file, &root, &placed);
        let seen = cameras::cameras(&file, &root, &placed, &self.positions[first..], &mut self.warnings);
        self.add_cameras(seen);
        Ok(())
    }

    /// Warnings about what the nodes hold and we do not read.
    fn remark_gltf(&mut self, file: &str, root: &Root, placed: &[Placed]) {
        let nodes = || placed.iter().map(|placed| &root.nodes[placed.node]);
        let lights = nodes()
            .filter(|node| node.extensions.as_ref().is_some_and(|ext| ext.khr_lights_punctual.is_some()))
            .count();
        if lights > 0 {
            self.pointlike_lights += lights;
            self.warnings.push(format!(
                "{file}: {lights} point, spot or directional light(s) left out; only surfaces emit: model lamps \
                 with emissive materials"
            ));
        }
        let meshes = || nodes().filter_map(|node| Some((node, &root.meshes[node.mesh?.value()])));
        let skinned = meshes().filter(|(node, _)| node.skin.is_some()).count();
        let morphed = meshes()
            .filter(|(_, mesh)| mesh.primitives.iter().any(|primitive| primitive.targets.is_some()))
            .count();
        for (count, what) in [(skinned, "skinned"), (morphed, "morphed")] {
            if count > 0 {
                self.warnings.push(format!("{file}: {count} {what} mesh(es) taken as they are at rest"));
            }
        }
        if !root.animations.is_empty() {
            let count = root.animations.len();
            self.warnings.push(format!("{file}: {count} animation(s) left out"));
        }
    }
}
