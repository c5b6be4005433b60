//! Wavefront OBJ through `tobj`: polygons with the material each one uses, in the order of the file.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::draft::{Cutter, DEFAULT_GREY, Draft, DraftMaterial, Origin, UNNAMED_MATERIAL};
use super::error::{SceneError, quoted};
use super::mtl::{self, MtlMaterial, MtlPicture};
use super::painted::Painter;
use super::statements::{Remarks, Statements};
use crate::progress::Progress;

/// The polygons of one file; see [`ObjMesh::slot_of`] for their materials.
struct ObjMesh {
    /// Runs of polygons that share a material, each with its own positions.
    models: Vec<tobj::Model>,
    /// Everything else the file says.
    remarks: Remarks,
}

impl ObjMesh {
    /// Index into [`Remarks::slots`] of the material of a model.
    fn slot_of(model: &tobj::Model) -> usize {
        model.name.parse().unwrap_or(0)
    }
}

/// Reads an OBJ file. Polygons keep their corners; nothing is triangulated or dropped but points and
/// lines. With `with_places`, every corner has a place on a picture, which is NaN where the file has none.
///
/// # Errors
/// [`SceneError::Io`] and [`SceneError::Parse`], with the line.
fn read(path: &Path, with_places: bool, progress: &dyn Progress) -> Result<ObjMesh, SceneError> {
    let mut statements = Statements::open(path, with_places, progress)?;
    let options = tobj::LoadOptions {
        triangulate: false,
        single_index: false,
        ignore_points: true,
        ignore_lines: true,
    };
    // Material libraries are read afterwards: a `usemtl` may stand before its `mtllib`.
    let no_materials = |_: &Path| Ok((Vec::new(), Default::default()));
    let result = tobj::load_obj_buf(&mut statements, &options, no_materials);
    let remarks = statements.finish()?;
    match result {
        Ok((models, _)) => Ok(ObjMesh { models, remarks }),
        Err(error) => Err(SceneError::parse(path, None, format!("cannot be read as OBJ ({error})"))),
    }
}

/// Where the files that a `mtllib` statement names may be: for each file it names, the paths to try.
///
/// The whole rest of the line is one name if there is such a file; otherwise names are separated by
/// blanks, and `\ ` is a blank inside a name.
fn library_paths(obj: &Path, names: &str) -> Vec<(String, Option<PathBuf>)> {
    if names.is_empty() {
        return Vec::new();
    }
    if let Some(path) = find_beside(obj, names) {
        return vec![(names.to_owned(), Some(path))];
    }
    let separated: Vec<String> =
        names.replace("\\ ", "\0").split_ascii_whitespace().map(|name| name.replace('\0', " ")).collect();
    let found: Vec<_> = separated
        .into_iter()
        .map(|name| {
            let path = find_beside(obj, &name);
            (name, path)
        })
        .collect();
    // One name with blanks that is not there reads better than its words one by one.
    if found.iter().all(|(_, path)| path.is_none()) && !names.contains("\\ ") {
        return vec![(names.to_owned(), None)];
    }
    found
}

/// A file that another one names: as written, then with Windows separators, then beside it under its bare name.
pub(super) fn find_beside(file: &Path, name: &str) -> Option<PathBuf> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let slashed = name.replace('\\', "/");
    let bare = slashed.rsplit('/').next().unwrap_or_default().to_owned();
    [name.to_owned(), slashed, bare]
        .into_iter()
        .filter(|name| !name.is_empty())
        .map(|name| folder.join(name))
        .find(|path| path.is_file())
}

impl Draft {
    /// Adds an OBJ file and its material libraries.
    pub(super) fn add_obj(&mut self, path: &Path, progress: &dyn Progress) -> Result<(), SceneError> {
        let mut mesh = read(path, false, progress)?;
        self.files.push(path.to_path_buf());
        let library = self.read_libraries(path, &mesh)?;
        let found = |slot: &String| find(slot, &library);
        if mesh.remarks.slots.iter().filter_map(found).any(|material| material.picture.is_some()) {
            // Few meshes have pictures, and places on them take much memory: only now are they read.
            drop(mesh);
            mesh = read(path, true, progress)?;
        }
        self.remark(path, &mesh);
        if mesh.models.iter().all(|model| model.mesh.indices.is_empty()) {
            self.warnings.push(format!("{}: no faces in it", path.display()));
        }
        let mut material_of_slot: Vec<Option<u32>> = vec![None; mesh.remarks.slots.len()];
        let mut base_of_slot = material_of_slot.clone();
        let (mut cutter, mut painter) = (Cutter::new(), Painter::default());
        for model in mesh.models {
            if model.mesh.indices.is_empty() {
                continue;
            }
            let slot = ObjMesh::slot_of(&model);
            let material = match material_of_slot[slot] {
                Some(material) => material,
                None => {
                    let material = self.add_material(resolve(&mesh.remarks.slots[slot], &library));
                    material_of_slot[slot] = Some(material);
                    material
                }
            };
            let picture = find(&mesh.remarks.slots[slot], &library).and_then(|found| found.picture.as_ref());
            let mut brush = picture.map(|picture| {
                let base = *base_of_slot[slot].get_or_insert_with(|| {
                    let mut base = self.materials[material as usize].clone();
                    base.reflectance = picture.factor;
                    self.add_material(base)
                });
                Brush { picture, base, painter: &mut painter }
            });
            self.add_polygons(path, &model.mesh, material, &mut cutter, brush.as_mut())?;
        }
        self.know_materials(library.into_keys());
        Ok(())
    }

    fn add_polygons(
        &mut self,
        path: &Path,
        mesh: &tobj::Mesh,
        material: u32,
        cutter: &mut Cutter,
        mut brush: Option<&mut Brush<'_>>,
    ) -> Result<(), SceneError> {
        let first = self.room_for(path, mesh.positions.len() / 3)?;
        let (points, _) = mesh.positions.as_chunks::<3>();
        self.positions.extend(points.iter().map(|&point| DVec3::from_array(point)));
        let mut start = 0;
        let arities = mesh.face_arities.iter().copied();
        let triangles = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 };
        for arity in arities.chain(std::iter::repeat_n(3, triangles)) {
            let corners = start..start + arity as usize;
            start = corners.end;
            let before = self.triangles.len();
            self.add_polygon(path, first, &mesh.indices[corners.clone()], material, cutter)?;
            if let Some(brush) = &mut brush {
                brush.paint(self, before, cutter, &mesh.texcoords, &mesh.texcoord_indices[corners]);
            }
        }
        Ok(())
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
            for (name, found) in library_paths(path, names) {
                match found {
                    Some(found) if read.insert(found.clone()) => {
                        for material in
                            mtl::read(&found, &mut self.warnings, &mut self.files, &mut self.picture_room)?
                        {
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
}

/// Puts the picture of a material on polygons of an OBJ file.
struct Brush<'a> {
    picture: &'a MtlPicture,
    /// The material that the picture is put on.
    base: u32,
    painter: &'a mut Painter,
}

impl Brush<'_> {
    /// Paints the triangles from `before` on, which are one polygon; `places` are those of its corners.
    fn paint(
        &mut self,
        draft: &mut Draft,
        before: usize,
        cutter: &Cutter,
        texcoords: &[f64],
        places: &[u32],
    ) {
        for (triangle, corners) in (before..).zip(&cutter.split) {
            let points = corners.map(|corner| cutter.corners[corner as usize]);
            let places = corners.map(|corner| {
                let at = 2 * places[corner as usize] as usize;
                self.picture.place(texcoords[at], texcoords[at + 1])
            });
            if places.iter().all(|place| place.is_finite()) {
                let material = self.painter.material(draft, self.base, &self.picture.picture, points, places);
                draft.triangles[triangle].material = material;
            }
        }
    }
}

/// The name without a comment after it.
pub(super) fn without_comment(name: &str) -> &str {
    name.find(" #").map_or(name, |end| name[..end].trim_end())
}

/// What a library says of a name. A comment may follow it, but names such as `Material #3` are common: full name first.
fn find<'a>(name: &str, library: &'a HashMap<String, MtlMaterial>) -> Option<&'a MtlMaterial> {
    library.get(name).or_else(|| library.get(without_comment(name)))
}

/// The material that `usemtl name` stands for.
fn resolve(name: &str, library: &HashMap<String, MtlMaterial>) -> DraftMaterial {
    let bare = without_comment(name);
    let (reflectance, radiance, origin) = match find(name, library) {
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
