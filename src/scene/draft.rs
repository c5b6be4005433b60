//! The scene while it is put together: geometry and materials as the files have them, before the
//! clean-up of [`super::validate`].

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::change::MaterialChange;
use super::description::{MaterialOverride, Quad};
use super::error::{SceneError, name_list, quoted};
use super::mtl::{self, MtlMaterial};
use super::obj::{self, ObjMesh};
use super::texture::Painting;
use super::triangulate::Triangulator;
use super::{Camera, ImportCounts, Triangle};
use crate::progress::Progress;

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
    corners: Vec<DVec3>,
    split: Vec<[u32; 3]>,
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
            cameras: Vec::new(),
            mesh_materials: BTreeSet::new(),
        }
    }

    /// Adds an OBJ file and its material libraries.
    pub(super) fn add_obj(&mut self, path: &Path, progress: &dyn Progress) -> Result<(), SceneError> {
        let mesh = obj::read(path, progress)?;
        self.files.push(path.to_path_buf());
        let library = self.read_libraries(path, &mesh)?;
        self.remark(path, &mesh);
        if mesh.models.iter().all(|model| model.mesh.indices.is_empty()) {
            self.warnings.push(format!("{}: no faces in it", path.display()));
        }
        let mut material_of_slot: Vec<Option<u32>> = vec![None; mesh.remarks.slots.len()];
        let mut cutter = Cutter::new();
        for model in mesh.models {
            if model.mesh.indices.is_empty() {
                continue;
            }
            let slot = ObjMesh::slot_of(&model);
            let material = match material_of_slot[slot] {
                Some(material) => material,
                None => {
                    self.materials.push(resolve(&mesh.remarks.slots[slot], &library));
                    let material = self.materials.len() as u32 - 1;
                    material_of_slot[slot] = Some(material);
                    material
                }
            };
            self.add_polygons(path, &model.mesh, material, &mut cutter)?;
        }
        self.mesh_materials.extend(library.into_keys());
        self.mesh_materials
            .extend(material_of_slot.iter().flatten().map(|&id| self.materials[id as usize].name.clone()));
        Ok(())
    }

    fn add_polygons(
        &mut self,
        path: &Path,
        mesh: &tobj::Mesh,
        material: u32,
        cutter: &mut Cutter,
    ) -> Result<(), SceneError> {
        let first = self.room_for(path, mesh.positions.len() / 3)?;
        let (points, _) = mesh.positions.as_chunks::<3>();
        self.positions.extend(points.iter().map(|&point| DVec3::from_array(point)));
        let mut start = 0;
        let arities = mesh.face_arities.iter().copied();
        let triangles = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 };
        for arity in arities.chain(std::iter::repeat_n(3, triangles)) {
            let polygon = &mesh.indices[start..start + arity as usize];
            start += arity as usize;
            self.add_polygon(path, first, polygon, material, cutter)?;
        }
        Ok(())
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

    /// Adds cameras of a mesh; of one name the first is kept.
    pub(super) fn add_cameras(&mut self, cameras: Vec<Camera>) {
        for camera in cameras {
            if self.cameras.iter().all(|other| other.name != camera.name) {
                self.cameras.push(camera);
            }
        }
    }

    /// The materials by name that the `mtllib` statements of a mesh bring in.
    fn read_libraries(
        &mut self,
        path: &Path,
        mesh: &ObjMesh,
    ) -> Result<HashMap<String, MtlMaterial>, SceneError> {
        let mut library = HashMap::new();
        let mut read = BTreeSet::new();
        for (line, names) in &mesh.remarks.libraries {
            for (name, found) in obj::library_paths(path, names) {
                match found {
                    Some(found) if read.insert(found.clone()) => {
                        for material in mtl::read(&found, &mut self.warnings, &mut self.files)? {
                            library.insert(material.name.clone(), material);
                        }
                        self.files.push(found);
                    }
                    Some(_) => {}
                    None => {
                        self.warnings.push(format!(
                            "{}:{line}: material library {} not found; materials it would define get grey \
                             reflectance {DEFAULT_GREY}",
                            path.display(),
                            quoted(&name)
                        ));
                        self.missing_libraries.push(name);
                    }
                }
            }
        }
        Ok(library)
    }

    /// Counts and warnings about what the OBJ says and we do not read.
    fn remark(&mut self, path: &Path, mesh: &ObjMesh) {
        let path = path.display();
        self.counts.skipped_faces += mesh.remarks.skipped_faces;
        if mesh.remarks.skipped_faces > 0 {
            self.warnings.push(format!(
                "{path}: {} point(s), line(s) or face(s) with fewer than 3 corners skipped",
                mesh.remarks.skipped_faces
            ));
        }
        if let Some((count, line, word)) = &mesh.remarks.unknown {
            self.warnings.push(format!(
                "{path}:{line}: {count} line(s) ignored that are not OBJ statements, first {}",
                quoted(word)
            ));
        }
        if let Some((count, line)) = mesh.remarks.free_form {
            self.warnings.push(format!(
                "{path}:{line}: {count} free-form curve(s) or surface(s) ignored; export polygons instead"
            ));
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

/// The material that `usemtl name` stands for.
fn resolve(name: &str, library: &HashMap<String, MtlMaterial>) -> DraftMaterial {
    // A comment may follow the name, but names such as `Material #3` are common: full name first.
    let bare = name.find(" #").map_or(name, |end| name[..end].trim_end());
    let (reflectance, radiance, origin) = match library.get(name).or_else(|| library.get(bare)) {
        Some(found) => {
            let origin = if found.reflectance.is_some() { Origin::Given } else { Origin::WithoutKd };
            (found.reflectance.unwrap_or([DEFAULT_GREY; 3]), found.radiance, origin)
        }
        None if name.is_empty() => ([DEFAULT_GREY; 3], [0.0; 3], Origin::Unnamed),
        None => ([DEFAULT_GREY; 3], [0.0; 3], Origin::Missing),
    };
    let name = if name.is_empty() {
        UNNAMED_MATERIAL
    } else if library.contains_key(name) {
        name
    } else {
        bare
    };
    DraftMaterial::of_mesh(name, reflectance, radiance, origin)
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
