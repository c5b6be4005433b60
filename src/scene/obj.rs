//! Wavefront OBJ through `tobj`: polygons with the material each one uses, in the order of the file.

use std::path::{Path, PathBuf};

use super::error::SceneError;
use super::statements::{Remarks, Statements};
use crate::progress::Progress;

/// The polygons of one file; see [`ObjMesh::slot_of`] for their materials.
pub(super) struct ObjMesh {
    /// Runs of polygons that share a material, each with its own positions.
    pub(super) models: Vec<tobj::Model>,
    /// Everything else the file says.
    pub(super) remarks: Remarks,
}

impl ObjMesh {
    /// Index into [`Remarks::slots`] of the material of a model.
    pub(super) fn slot_of(model: &tobj::Model) -> usize {
        model.name.parse().unwrap_or(0)
    }
}

/// Reads an OBJ file. Polygons keep their corners; nothing is triangulated or dropped but points and
/// lines.
///
/// # Errors
/// [`SceneError::Io`] and [`SceneError::Parse`], with the line.
pub(super) fn read(path: &Path, progress: &dyn Progress) -> Result<ObjMesh, SceneError> {
    let mut statements = Statements::open(path, progress)?;
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
pub(super) fn library_paths(obj: &Path, names: &str) -> Vec<(String, Option<PathBuf>)> {
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
