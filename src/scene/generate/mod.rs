//! Office buildings of any size, as test scenes: one OBJ with its MTL and a scene description, written
//! as a stream so that memory does not grow with the building.

mod building;
mod furniture;
mod obj_writer;
mod shapes;
mod small_things;
mod variation;

use std::fmt::Write as _;
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use obj_writer::ObjWriter;

use crate::unfinished::Unfinished;

/// First words of the mesh and the description, so that those written here may be replaced.
const SIGNATURE: &str = "# Office building";
/// First words of the materials.
const MATERIALS_SIGNATURE: &str = "# Materials of an office building";
/// Every file of a building and its first words, in the order in which they appear.
const FILES: [(&str, &str); 3] =
    [("office.obj", SIGNATURE), ("office.mtl", MATERIALS_SIGNATURE), ("scene.toml", SIGNATURE)];
/// Most rooms of one building; about 70 million triangles.
const MOST_ROOMS: u64 = 10_000;

/// How large an office building to write. A room with its share of the corridor has about 7
/// thousand triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OfficeOptions {
    /// Storeys, at least 1.
    pub floors: u32,
    /// Rooms on each floor, at least 1, on both sides of a corridor.
    pub rooms: u32,
    /// Different seeds furnish the rooms differently; the same seed gives the same files.
    pub seed: u64,
}

impl Default for OfficeOptions {
    fn default() -> Self {
        Self { floors: 1, rooms: 4, seed: 1 }
    }
}

/// What was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OfficeSummary {
    /// The scene description, to be rendered.
    pub scene: PathBuf,
    /// Triangles of the mesh after triangulation.
    pub triangles: u64,
    /// Rooms in the whole building.
    pub rooms: u64,
}

/// Why no building was written.
#[derive(Debug, thiserror::Error)]
pub enum GenerateError {
    /// The numbers make no building.
    #[error("{0}")]
    Options(String),
    /// Something that was not generated stands where a file should go.
    #[error("{}: is here already and was not generated; choose another folder", .0.display())]
    Occupied(PathBuf),
    /// The folder cannot be made or written to.
    #[error("{}: cannot be written ({source}); choose another folder or free some space", .path.display())]
    Io {
        /// The folder or file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
}

impl OfficeOptions {
    /// Whether such a building can be written.
    ///
    /// # Errors
    /// [`GenerateError::Options`] with advice.
    pub fn validate(&self) -> Result<(), GenerateError> {
        if self.floors == 0 || self.rooms == 0 {
            let message = format!(
                "an office needs at least 1 floor and 1 room a floor, not {} and {}",
                self.floors, self.rooms
            );
            return Err(GenerateError::Options(message));
        }
        if self.room_count() > MOST_ROOMS {
            let message = format!(
                "{} floors of {} rooms are {} rooms; at most {MOST_ROOMS} (about 70 million triangles) are \
                 written, so choose fewer",
                self.floors,
                self.rooms,
                self.room_count()
            );
            return Err(GenerateError::Options(message));
        }
        Ok(())
    }

    /// Rooms in the whole building.
    pub fn room_count(&self) -> u64 {
        u64::from(self.floors) * u64::from(self.rooms)
    }

    /// Triangles of the building, counted by building it without writing.
    ///
    /// # Errors
    /// As [`OfficeOptions::validate`].
    pub fn triangle_count(&self) -> Result<u64, GenerateError> {
        self.validate()?;
        let mut mesh = ObjWriter::new(std::io::sink());
        building::build(self, &mut mesh);
        Ok(mesh.triangles())
    }
}

/// Writes `office.obj`, `office.mtl` and `scene.toml` into `out_dir`, which is made if needed.
///
/// Each file appears under its name only when it is complete, the description last. Files of these names
/// are replaced if they were generated too; other files in the folder are left alone.
///
/// # Errors
/// [`GenerateError`]; nothing half-written is left behind.
pub fn generate_office(options: &OfficeOptions, out_dir: &Path) -> Result<OfficeSummary, GenerateError> {
    options.validate()?;
    std::fs::create_dir_all(out_dir).map_err(failed(out_dir))?;
    for (name, signature) in FILES {
        let path = out_dir.join(name);
        if path.symlink_metadata().is_ok() && !starts_with(&path, signature) {
            return Err(GenerateError::Occupied(path));
        }
    }
    let [mesh_path, materials_path, scene_path] = FILES.map(|(name, _)| out_dir.join(name));
    let mesh_file = Unfinished::at(&mesh_path).map_err(failed(&mesh_path))?;
    let mut mesh = ObjWriter::new(BufWriter::with_capacity(1 << 18, mesh_file));
    mesh.line(&format!("{SIGNATURE}, {} floor(s) of {} room(s), metres", options.floors, options.rooms));
    mesh.line("mtllib office.mtl");
    building::build(options, &mut mesh);
    let triangles = mesh.triangles();
    let mesh_file = mesh
        .finish()
        .and_then(|buffer| buffer.into_inner().map_err(|error| error.into_error()))
        .map_err(failed(&mesh_path))?;
    let materials_file = written(&materials_path, &materials_text())?;
    let scene_file = written(&scene_path, &scene_text(options, triangles))?;
    for (file, path) in
        [(mesh_file, &mesh_path), (materials_file, &materials_path), (scene_file, &scene_path)]
    {
        file.finish().map_err(failed(path))?;
    }
    Ok(OfficeSummary { scene: scene_path, triangles, rooms: options.room_count() })
}

/// Why a file cannot be written.
fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> GenerateError {
    let path = path.to_path_buf();
    move |source| GenerateError::Io { path, source }
}

fn written(path: &Path, text: &str) -> Result<Unfinished, GenerateError> {
    let mut file = Unfinished::at(path).map_err(failed(path))?;
    file.write_all(text.as_bytes()).map_err(failed(path))?;
    Ok(file)
}

/// Whether a regular file starts with these words.
fn starts_with(path: &Path, words: &str) -> bool {
    let mut start = Vec::new();
    let read = path.is_file()
        && std::fs::File::open(path)
            .and_then(|file| file.take(words.len() as u64).read_to_end(&mut start))
            .is_ok();
    read && start == words.as_bytes()
}

fn materials_text() -> String {
    let mut text = format!("{MATERIALS_SIGNATURE}: linear RGB reflectance and radiance\n");
    for material in building::MATERIALS {
        let [r, g, b] = material.reflectance;
        // Writing to a string does not fail.
        let _ = writeln!(text, "newmtl {}\nKd {r} {g} {b}", material.name);
        if let Some([r, g, b]) = material.radiance {
            let _ = writeln!(text, "Ke {r} {g} {b}");
        }
    }
    text
}

fn scene_text(options: &OfficeOptions, triangles: u64) -> String {
    let mut text = format!(
        "{SIGNATURE}: {} floor(s) of {} room(s), {triangles} triangles, seed {}.\nmesh = \"office.obj\"\n\
         meters_per_unit = 1.0\n",
        options.floors, options.rooms, options.seed
    );
    for view in building::views(options) {
        let ([ex, ey, ez], [tx, ty, tz]) = (view.eye.to_array(), view.target.to_array());
        let _ = write!(
            text,
            "\n[[camera]]\nname = \"{}\"\neye = [{ex:?}, {ey:?}, {ez:?}]\ntarget = [{tx:?}, {ty:?}, {tz:?}]\n\
             up = [0, 1, 0]\nvfov_deg = {:?}\nwidth = 640\nheight = 480\n",
            view.name, view.vfov_deg
        );
    }
    text
}

#[cfg(test)]
mod tests;
