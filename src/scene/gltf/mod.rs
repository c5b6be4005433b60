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

use glam::DMat4;
use gltf_json::{Node, Root};

use self::buffers::Buffers;
use self::cameras::MOST_CAMERAS;
use self::primitives::Meshes;
use super::draft::Draft;
use super::error::SceneError;
use crate::progress::Progress;

/// How many nodes hold what is not read.
#[derive(Default)]
struct Held {
    lights: usize,
    skinned: usize,
    morphed: usize,
}

impl Held {
    fn count(&mut self, root: &Root, node: &Node) {
        let has_light = node.extensions.as_ref().is_some_and(|ext| ext.khr_lights_punctual.is_some());
        self.lights += usize::from(has_light);
        let Some(mesh) = node.mesh else { return };
        self.skinned += usize::from(node.skin.is_some());
        let primitives = &root.meshes[mesh.value()].primitives;
        self.morphed += usize::from(primitives.iter().any(|primitive| primitive.targets.is_some()));
    }
}

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
        progress.start("load", root.nodes.len() as u64);
        let first = self.positions.len();
        let mut meshes = Meshes::new(path, &root, &buffers, self.picture_room);
        meshes.check_room()?;
        let (mut held, mut lenses) = (Held::default(), Vec::new());
        nodes::visit(path, &root, |placed| {
            let node = &root.nodes[placed.node];
            held.count(&root, node);
            if let Some(mesh) = node.mesh {
                meshes.add(self, mesh.value(), placed.world)?;
            }
            // One too many tells that there are.
            if node.camera.is_some() && lenses.len() <= MOST_CAMERAS {
                lenses.push(placed);
            }
            progress.advance(1);
            Ok(())
        })?;
        if nodes::is_without_scene(&root) && !root.meshes.is_empty() {
            for mesh in 0..root.meshes.len() {
                meshes.add(self, mesh, DMat4::IDENTITY)?;
            }
            self.warnings.push(format!(
                "{}: {} mesh(es) without a scene, which stand at the origin",
                path.display(),
                root.meshes.len()
            ));
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
        self.remark_gltf(&file, &root, &held);
        let seen = cameras::cameras(&file, &root, &lenses, &self.positions[first..], &mut self.warnings);
        self.add_cameras(seen);
        Ok(())
    }

    /// Warnings about what the nodes hold and we do not read.
    fn remark_gltf(&mut self, file: &str, root: &Root, held: &Held) {
        let &Held { lights, skinned, morphed } = held;
        if lights > 0 {
            self.pointlike_lights += lights;
            self.warnings.push(format!(
                "{file}: {lights} point, spot or directional light(s) left out; only surfaces emit: model lamps \
                 with emissive materials"
            ));
        }
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
