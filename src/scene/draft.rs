//! The scene while it is put together: geometry and materials as the files have them, before the
//! clean-up of [`super::validate`].

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::change::MaterialChange;
use super::description::{MaterialOverride, Quad};
use super::error::{SceneError, name_list, quoted};
use super::texture::{MOST_PIXELS_OF_ALL, Painting};
use super::triangulate::Triangulator;
use super::{Camera, ImportCounts, Triangle};

/// Reflectance of everything that no file gives one.
pub(super) const DEFAULT_GREY: f64 = 0.5;
/// Name of the material of faces that have none.
pub(super) const UNNAMED_MATERIAL: &str = "default";

/// Why a material has the reflectance it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// Some file says so.
    Given,
    /// In a library, but without `Kd`.
    WithoutKd,
    /// In no library.
    Missing,
    /// The faces name no material.
    Unnamed,
}

/// A material as given, not yet clamped.
#[derive(Clone, Debug)]
pub(super) struct DraftMaterial {
    pub(super) name: String,
    pub(super) reflectance: [f64; 3],
    pub(super) radiance: [f64; 3],
    pub(super) origin: Origin,
    /// The picture on its surfaces.
    pub(super) painting: Option<Arc<Painting>>,
    is_quad: bool,
}

impl DraftMaterial {
    /// A material of a mesh.
    pub(super) fn of_mesh(name: &str, reflectance: [f64; 3], radiance: [f64; 3], origin: Origin) -> Self {
        DraftMaterial { name: name.to_owned(), reflectance, radiance, origin, painting: None, is_quad: false }
    }

    /// What is given takes the place of what was.
    fn become_other(&mut self, reflectance: Option<[f64; 3]>, radiance: Option<[f64; 3]>) {
        if let Some(reflectance) = reflectance {
            self.reflectance = reflectance;
            self.painting = None;
            self.origin = Origin::Given;
        }
        if let Some(radiance) = radiance {
            self.radiance = radiance;
        }
    }
}

/// A name as a scene has it: it goes to terminals, pages and files of rays, so control characters are blanked.
pub(super) fn shown_name(name: &str) -> String {
    name.replace(char::is_control, " ")
}

/// Splits polygons; keeps its buffers between them.
pub(super) struct Cutter {
    triangulator: Triangulator,
    /// Of the last polygon.
    pub(super) corners: Vec<DVec3>,
    /// Its triangles, as numbers of its corners.
    pub(super) split: Vec<[u32; 3]>,
}

impl Cutter {
    pub(super) fn new() -> Self {
        Self { triangulator: Triangulator::new(), corners: Vec::new(), split: Vec::new() }
    }
}

/// Everything read so far.
pub(super) struct Draft {
    /// The file that the user named, for messages about the whole scene.
    pub(super) file: PathBuf,
    /// All files that were read.
    pub(super) files: Vec<PathBuf>,
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: Vec<Triangle>,
    pub(super) materials: Vec<DraftMaterial>,
    pub(super) patch_count: u32,
    pub(super) counts: ImportCounts,
    pub(super) warnings: Vec<String>,
    /// Material libraries that were not found, as the meshes name them.
    pub(super) missing_libraries: Vec<String>,
    /// Lights of the meshes that have no surface.
    pub(super) pointlike_lights: usize,
    /// Pixels that the pictures of further meshes may have.
    pub(super) picture_room: u64,
    /// Cameras of the meshes; names differ.
    pub(super) cameras: Vec<Camera>,
    /// Materials that the meshes use or their libraries define.
    mesh_materials: BTreeSet<String>,
}

impl Draft {
    pub(super) fn new(file: &Path) -> Self {
        Self {
            file: file.to_path_buf(),
            files: vec![file.to_path_buf()],
            positions: Vec::new(),
            triangles: Vec::new(),
            materials: Vec::new(),
            patch_count: 0,
            counts: ImportCounts::default(),
            warnings: Vec::new(),
            missing_libraries: Vec::new(),
            pointlike_lights: 0,
            picture_room: MOST_PIXELS_OF_ALL,
            cameras: Vec::new(),
            mesh_materials: BTreeSet::new(),
        }
    }

    /// The number of the next position, when so many can follow.
    pub(super) fn room_for(&self, path: &Path, positions: usize) -> Result<u32, SceneError> {
        let first = self.positions.len();
        if first + positions > u32::MAX as usize {
            return Err(SceneError::invalid(path, None, "more than 4 billion vertices; split the scene"));
        }
        Ok(first as u32)
    }

    /// Adds the triangles of a polygon, whose corners are numbers of positions counted from `first`.
    pub(super) fn add_polygon(
        &mut self,
        path: &Path,
        first: u32,
        polygon: &[u32],
        material: u32,
        cutter: &mut Cutter,
    ) -> Result<(), SceneError> {
        cutter.corners.clear();
        cutter.corners.extend(polygon.iter().map(|&i| self.positions[(first + i) as usize]));
        cutter.split.clear();
        cutter.triangulator.split(&cutter.corners, &mut cutter.split);
        let expected = (polygon.len() as u64).saturating_sub(2);
        self.counts.triangles_initial += expected;
        self.counts.dropped_degenerate += expected.saturating_sub(cutter.split.len() as u64);
        let patch = self.patch_count;
        self.triangles.extend(cutter.split.iter().map(|corner| Triangle {
            vertices: corner.map(|i| first + polygon[i as usize]),
            material,
            patch,
        }));
        self.count_patch(path)
    }

    /// Adds a triangle of three positions, a patch of its own.
    pub(super) fn add_triangle(
        &mut self,
        path: &Path,
        vertices: [u32; 3],
        material: u32,
    ) -> Result<(), SceneError> {
        self.counts.triangles_initial += 1;
        self.triangles.push(Triangle { vertices, material, patch: self.patch_count });
        self.count_patch(path)
    }

    fn count_patch(&mut self, path: &Path) -> Result<(), SceneError> {
        let too_many = |what: &str| {
            SceneError::invalid(path, None, format!("more than 4 billion {what}; split the scene"))
        };
        self.patch_count = self.patch_count.checked_add(1).ok_or_else(|| too_many("polygons"))?;
        if self.triangles.len() > u32::MAX as usize {
            return Err(too_many("triangles"));
        }
        Ok(())
    }

    /// Adds a material of a mesh; its number.
    pub(super) fn add_material(&mut self, material: DraftMaterial) -> u32 {
        if !self.mesh_materials.contains(&material.name) {
            self.mesh_materials.insert(material.name.clone());
        }
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// Names of materials that a description may change although nothing has them.
    pub(super) fn know_materials(&mut self, names: impl Iterator<Item = String>) {
        self.mesh_materials.extend(names);
    }

    /// Adds cameras of a mesh; of one name the first is kept.
    pub(super) fn add_cameras(&mut self, cameras: Vec<Camera>) {
        for camera in cameras {
            if self.cameras.iter().all(|other| other.name != camera.name) {
                self.cameras.push(camera);
            }
        }
    }

    /// Adds an extra rectangle of the description, with a material of its own.
    pub(super) fn add_quad(&mut self, quad: &Quad) {
        let first = self.positions.len() as u32;
        self.positions.extend(quad.corners);
        let material = self.materials.len() as u32;
        self.materials.push(DraftMaterial {
            name: quad.name.clone(),
            reflectance: quad.reflectance,
            radiance: quad.radiance,
            origin: Origin::Given,
            painting: None,
            is_quad: true,
        });
        for vertices in [[first, first + 1, first + 2], [first, first + 2, first + 3]] {
            self.triangles.push(Triangle { vertices, material, patch: self.patch_count });
        }
        self.patch_count += 1;
        self.counts.triangles_initial += 2;
    }

    /// Applies `[material."name"]` to every mesh material of that name.
    pub(super) fn override_material(&mut self, change: &MaterialOverride) -> Result<(), SceneError> {
        if !self.mesh_materials.contains(&change.name) {
            return Err(SceneError::invalid(&self.file, Some(change.line), self.unknown_material(change)));
        }
        for material in self.materials.iter_mut().filter(|m| !m.is_quad && m.name == change.name) {
            material.become_other(change.reflectance, change.radiance);
        }
        Ok(())
    }

    /// Changes every material and quad of a name, as a scene shows names; there may be none.
    pub(super) fn change_material(&mut self, change: &MaterialChange) {
        for material in self.materials.iter_mut().filter(|m| shown_name(&m.name) == change.name) {
            material.become_other(change.reflectance, change.radiance);
        }
    }

    fn unknown_material(&self, change: &MaterialOverride) -> String {
        let name = &change.name;
        if self.materials.iter().any(|material| material.is_quad && material.name == *name) {
            return format!(
                "{} is a quad, not a material of the mesh; set reflectance and radiance in its [[quad]]",
                quoted(name)
            );
        }
        let nearest = nearest_names(name, &self.mesh_materials);
        let advice = if self.mesh_materials.is_empty() {
            "the scene has no mesh materials; remove the override".to_owned()
        } else if nearest.is_empty() {
            format!("the mesh has {}", name_list(self.mesh_materials.iter().map(String::as_str)))
        } else {
            format!("did you mean {}?", name_list(nearest))
        };
        format!("no material {} in the mesh; {advice}", quoted(name))
    }
}

/// Up to three names that are a few letters away, nearest first.
pub(super) fn nearest_names<'a>(name: &str, known: &'a BTreeSet<String>) -> Vec<&'a str> {
    let short = |text: &str| text.to_lowercase().chars().take(64).collect::<Vec<_>>();
    let wanted = short(name);
    let most = 2.max(wanted.len() / 3);
    let mut near: Vec<(usize, &str)> = known
        .iter()
        .map(|known| (edit_distance(&wanted, &short(known)), known.as_str()))
        .filter(|&(distance, _)| distance <= most)
        .collect();
    near.sort_unstable();
    near.into_iter().take(3).map(|(_, name)| name).collect()
}

/// Insertions, deletions and substitutions between two words.
fn edit_distance(a: &[char], b: &[char]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_found_by_a_few_letters() {
        let known: BTreeSet<String> =
            ["wood", "Wood_dark", "glass", "wool"].iter().map(|name| name.to_string()).collect();
        assert_eq!(nearest_names("wod", &known), ["wood", "wool"]);
        assert_eq!(nearest_names("GLAS", &known), ["glass"]);
        assert!(nearest_names("chrome", &known).is_empty());
    }
}
