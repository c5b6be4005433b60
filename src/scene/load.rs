//! From the path the user names to a checked [`Scene`].

use std::path::Path;

use super::draft::{Draft, shown_name};
use super::error::{SceneError, quoted};
use super::mesh_file::{MESH_KINDS, MeshKind};
use super::{MaterialChange, Rectangle, Scene, camera, description, validate};
use crate::progress::Progress;

/// How to load a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// Refuse a scene in which nothing emits light. On by default; off for looking at geometry.
    pub require_emitter: bool,
    /// What materials become, after all that the files say; names that the scene does not have do nothing.
    pub changes: Vec<MaterialChange>,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { require_emitter: true, changes: Vec::new() }
    }
}

/// Loads a scene description (`.toml`) or a bare mesh (`.obj`, `.glb`, `.gltf`, `.ply`), any case of the
/// extension.
///
/// What can be repaired is repaired and said in [`Scene::warnings`]; see `docs/scene-format.md`.
///
/// # Errors
/// [`SceneError`], one line with file and line number where there is one: a missing or unreadable
/// file, a malformed file, a scene without triangles or without emitter.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("lamp.toml");
/// std::fs::write(&path, "[[quad]]\ncorners = [[0,2,0],[0,2,1],[1,2,1],[1,2,0]]\nradiance = [1,1,1]")?;
/// let scene = lightshaft::scene::load(&path, &Default::default(), &lightshaft::progress::Silent).unwrap();
/// assert_eq!(scene.triangles.len(), 2);
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn load(path: &Path, options: &LoadOptions, progress: &dyn Progress) -> Result<Scene, SceneError> {
    let is_description = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    let mut draft = Draft::new(path);
    let mut cameras = Vec::new();
    let mut rectangles = Vec::new();
    let mut meters_per_unit = 1.0;
    match MeshKind::of(path) {
        Some(kind) => draft.add_mesh(path, kind, progress)?,
        None if is_description => {
            let description = description::read(path)?;
            draft.warnings.extend(description.warnings);
            for (mesh, kind, line) in &description.meshes {
                draft.add_mesh(mesh, *kind, progress).map_err(|error| named_by(error, path, mesh, *line))?;
            }
            for quad in &description.quads {
                draft.add_quad(quad);
                rectangles.push(Rectangle { name: quad.name.clone(), corners: quad.corners });
            }
            for change in &description.overrides {
                draft.override_material(change)?;
            }
            cameras = description.cameras;
            meters_per_unit = description.meters_per_unit;
        }
        None => return Err(unsupported(path)),
    }
    // Those of the description come first, and stand for those of the same name in its meshes.
    let seen = std::mem::replace(&mut draft.cameras, cameras);
    draft.add_cameras(seen);
    let mut cameras = std::mem::take(&mut draft.cameras);
    options.changes.iter().for_each(|change| draft.change_material(change));
    let mut scene = validate::finish(draft, scene_name(path), meters_per_unit, options)?;
    if cameras.is_empty() {
        cameras.push(camera::derive(&scene.positions, &scene.triangles));
    }
    scene.cameras = cameras;
    scene.rectangles = rectangles;
    Ok(scene)
}

/// Says which line of the description names a mesh that cannot be read.
fn named_by(error: SceneError, path: &Path, mesh: &Path, line: u64) -> SceneError {
    match error {
        SceneError::Io { file, message, .. } if file == mesh => {
            let mesh = mesh.display().to_string();
            SceneError::io(path, Some(line), format!("mesh {}: {message}", mesh.escape_debug()))
        }
        other => other,
    }
}

fn unsupported(path: &Path) -> SceneError {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if let Err(error) = super::lines::open_regular(path) {
        return error;
    }
    let advice = format!("give a .toml scene description, or a mesh ({MESH_KINDS})");
    let message = match extension.as_str() {
        "mtl" => "is a material library; give the .obj that uses it".to_owned(),
        "" => format!("has no extension; {advice}"),
        other => format!("files of type {} are not read; {advice}", quoted(&format!(".{other}"))),
    };
    SceneError::invalid(path, None, message)
}

/// The file's stem, or its folder's name when the file is just called `scene`.
fn scene_name(path: &Path) -> String {
    shown_name(&file_name(path))
}

fn file_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    if !stem.eq_ignore_ascii_case("scene") {
        return stem;
    }
    let folder = path.canonicalize().ok().and_then(|full| {
        let name = full.parent()?.file_name()?;
        Some(name.to_string_lossy().into_owned())
    });
    folder.unwrap_or(stem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_has_no_control_characters() {
        assert_eq!(scene_name(Path::new("a/my \u{1b}[31mred\nroom.toml")), "my  [31mred room");
        assert_eq!(scene_name(Path::new("room.obj")), "room");
    }
}
