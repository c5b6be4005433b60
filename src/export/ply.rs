//! Solved scenes as PLY, binary and little-endian, with the exitance of every vertex. `docs/export.md` says what is in it.

use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

use super::lit::{Display, Exported, LitScene, Part};
use crate::image::write::{OutputError, write_atomically};
use crate::math::srgb_from_linear;
use crate::progress::Progress;
use crate::unfinished::kept_aside;

/// 3 × 8 bytes of position, 3 of colour, 3 × 4 of exitance.
const VERTEX: usize = 39;
/// 1 byte that says 3, and 3 × 4 of numbers.
const FACE: usize = 13;

/// Writes the triangles of a lit scene with exitance and colours, whole or not at all. One unit of progress for each side of
/// a surface, of a phase that the caller has started.
///
/// # Errors
/// When the folder is missing or not writable, the disk is full, there are more than 2³¹ vertices or numbers do not fit
/// single precision; then `path` is as before.
pub fn write_ply(
    path: &Path,
    lit: LitScene<'_>,
    display: Display,
    progress: &dyn Progress,
) -> Result<Exported, OutputError> {
    let mut exported = Exported::default();
    write_atomically(path, |file| {
        // The header has the counts and faces come after all vertices, so both are kept aside meanwhile.
        let [mut vertices, mut faces] =
            [BufWriter::new(kept_aside(path)?), BufWriter::new(kept_aside(path)?)];
        lit.for_each_part(None, progress, |part| {
            let first = exported.vertices;
            exported.vertices += part.vertices.len() as u64;
            exported.triangles += part.triangles.len() as u64;
            if exported.vertices > i32::MAX as u64 {
                return Err(io::Error::other(
                    "more vertices than a PLY can number; solve with a lower --quality",
                ));
            }
            write_vertices(&mut vertices, part, lit, display)?;
            write_faces(&mut faces, part, first as i32)
        })?;
        let header = header(&exported, display);
        file.write_all(header.as_bytes())?;
        exported.bytes = header.len() as u64 + append(vertices, file)? + append(faces, file)?;
        Ok::<(), io::Error>(())
    })?;
    Ok(exported)
}

fn header(exported: &Exported, display: Display) -> String {
    let Exported { vertices, triangles, .. } = exported;
    let (version, exposure, tone) = (env!("CARGO_PKG_VERSION"), display.exposure, display.tone.name());
    format!(
        "ply\n\
         format binary_little_endian 1.0\n\
         comment lightshaft {version}\n\
         comment x y z: metres\n\
         comment exitance: W/m2, linear RGB (Rec. 709)\n\
         comment red green blue: sRGB, radiance (exitance / pi) times {exposure}, tone {tone}\n\
         element vertex {vertices}\n\
         property double x\n\
         property double y\n\
         property double z\n\
         property uchar red\n\
         property uchar green\n\
         property uchar blue\n\
         property float exitance_red\n\
         property float exitance_green\n\
         property float exitance_blue\n\
         element face {triangles}\n\
         property list uchar int vertex_indices\n\
         end_header\n"
    )
}

fn write_vertices(to: &mut dyn Write, part: &Part, lit: LitScene<'_>, display: Display) -> io::Result<()> {
    let origin = lit.origin();
    let mut bytes = Vec::with_capacity(part.vertices.len() * VERTEX);
    for vertex in &part.vertices {
        let position = vertex.position.as_dvec3() + origin;
        bytes.extend(position.to_array().into_iter().flat_map(f64::to_le_bytes));
        bytes.extend(display.color(vertex.exitance).map(|c| (255.0 * srgb_from_linear(c)).round() as u8));
        bytes.extend(vertex.exitance.to_array().into_iter().flat_map(f32::to_le_bytes));
    }
    to.write_all(&bytes)
}

/// The vertices of the part are numbered from `first`.
fn write_faces(to: &mut dyn Write, part: &Part, first: i32) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(part.triangles.len() * FACE);
    for triangle in &part.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|&number| (first + i32::from(number)).to_le_bytes()));
    }
    to.write_all(&bytes)
}

/// Copies what was kept aside; answers how many bytes that were.
fn append(aside: BufWriter<File>, to: &mut dyn Write) -> io::Result<u64> {
    let mut aside = aside.into_inner().map_err(io::IntoInnerError::into_error)?;
    aside.rewind()?;
    io::copy(&mut aside, to)
}
