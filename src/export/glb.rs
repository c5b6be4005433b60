//! Solved scenes as GLB, the binary form of glTF 2.0, with the light in the colours of the vertices. `docs/export.md` says
//! what is in it.

use std::io::{self, BufWriter, Read, Seek, Write};
use std::path::Path;

use glam::{DMat3, DQuat, DVec3, Vec3};
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Stride, Target, View};
use gltf_json::camera::{Perspective, Type as Projection};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::scene::UnitQuaternion;
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Accessor, Buffer, Index, Mesh, Node, Root, Scene};
use serde_json::json;
use serde_json::value::to_raw_value;

use super::lit::{Display, Exported, LitScene, Part, too_far};
use super::palette::Palette;
use crate::image::write::{OutputError, write_atomically};
use crate::progress::Progress;
use crate::scene;
use crate::unfinished::kept_aside;

const MAGIC: [u8; 4] = *b"glTF";
const VERSION: u32 = 2;
/// Of the file and of each of its two chunks.
const HEADS: u64 = 12 + 8 + 8;
/// A position, a colour of 3 × 16 bits, and 2 bytes to the next multiple of 4.
const VERTEX: usize = 20;
const COLOR_AT: u64 = 12;
/// Where the near plane is at least and at most, as shares of the distance to the far one: the nearer, the less depth can
/// tell apart what lies closely behind each other at the other end of the room.
const NEAR: [f64; 2] = [1e-4, 1e-2];

/// Writes the triangles of a lit scene with their colours, and the cameras, whole or not at all. One unit of progress for
/// each side of a surface, of a phase that the caller has started.
///
/// # Errors
/// When the folder is missing or not writable, the disk is full, the file would have more than 4 GiB or its numbers do not
/// fit single precision; then `path` is as before.
pub fn write_glb(
    path: &Path,
    lit: LitScene<'_>,
    display: Display,
    progress: &dyn Progress,
) -> Result<Exported, OutputError> {
    let mut exported = Exported::default();
    write_atomically(path, |file| {
        // The JSON comes first and tells what is in the rest, which is therefore kept aside meanwhile.
        let mut binary = BufWriter::new(kept_aside(path)?);
        let mut model = Model::new(Palette::of(lit)?);
        lit.for_each_part(None, progress, |part| model.add(part, display, &mut binary))?;
        let mut binary = binary.into_inner().map_err(io::IntoInnerError::into_error)?;
        binary.rewind()?;
        let root = model.finished(lit, display)?;
        exported = model.exported;
        exported.bytes = assemble(file, &root, &mut binary, model.length)?;
        Ok::<(), io::Error>(())
    })?;
    Ok(exported)
}

/// Header and chunks; answers how many bytes they are.
fn assemble(file: &mut dyn Write, root: &Root, binary: &mut dyn Read, length: u64) -> io::Result<u64> {
    let mut json = gltf_json::serialize::to_vec(root)?;
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = HEADS + json.len() as u64 + length;
    let fits = |bytes: u64| u32::try_from(bytes).map_err(|_| too_large());
    file.write_all(&MAGIC)?;
    for number in [VERSION, fits(total)?, fits(json.len() as u64)?] {
        file.write_all(&number.to_le_bytes())?;
    }
    file.write_all(b"JSON")?;
    file.write_all(&json)?;
    file.write_all(&fits(length)?.to_le_bytes())?;
    file.write_all(b"BIN\0")?;
    io::copy(binary, file)?;
    Ok(total)
}

fn too_large() -> io::Error {
    io::Error::other("a GLB holds 4 GiB at most, and this one would be larger; solve with a lower --quality")
}

/// A model that grows part by part.
struct Model {
    root: Root,
    palette: Palette,
    primitives: Vec<Primitive>,
    exported: Exported,
    /// Of all that is in the binary chunk so far, bytes; a multiple of 4.
    length: u64,
    bounds: Option<[Vec3; 2]>,
}

impl Model {
    fn new(palette: Palette) -> Model {
        let (root, exported) = (Root::default(), Exported::default());
        Model { root, palette, primitives: Vec::new(), exported, length: 0, bounds: None }
    }

    /// Writes the vertices and triangles of a part and notes where they are.
    fn add(&mut self, part: &Part, display: Display, to: &mut dyn Write) -> io::Result<()> {
        let mut low = Vec3::INFINITY;
        let mut high = Vec3::NEG_INFINITY;
        let mut bytes = Vec::with_capacity(part.vertices.len() * VERTEX);
        for vertex in &part.vertices {
            low = low.min(vertex.position);
            high = high.max(vertex.position);
            bytes.extend(vertex.position.to_array().into_iter().flat_map(f32::to_le_bytes));
            let color = display.color(vertex.exitance).map(|c| (c * f32::from(u16::MAX)).round() as u16);
            bytes.extend(color.into_iter().flat_map(u16::to_le_bytes));
            bytes.extend([0; VERTEX - 18]);
        }
        let vertices = self.view(&bytes, Target::ArrayBuffer, Some(Stride(VERTEX)), to)?;
        // One material after the other; of one, in the order in which they are there.
        let mut triangles: Vec<(u32, [u16; 3])> = part
            .coats
            .iter()
            .map(|&coat| self.palette.number(coat))
            .zip(part.triangles.iter().copied())
            .collect();
        triangles.sort_by_key(|&(material, _)| material);
        bytes.clear();
        bytes.extend(
            triangles.iter().flat_map(|(_, corners)| corners).flat_map(|corner| corner.to_le_bytes()),
        );
        let indices = self.view(&bytes, Target::ElementArrayBuffer, None, to)?;

        let corners = part.vertices.len() as u64;
        let positions = Accessor {
            min: Some(json!(low.to_array())),
            max: Some(json!(high.to_array())),
            ..accessor(vertices, corners, ComponentType::F32, Type::Vec3)
        };
        let colors = Accessor {
            byte_offset: Some(USize64(COLOR_AT)),
            normalized: true,
            ..accessor(vertices, corners, ComponentType::U16, Type::Vec3)
        };
        let positions = self.root.push(positions);
        let colors = self.root.push(colors);
        let mut first = 0;
        for run in triangles.chunk_by(|a, b| a.0 == b.0) {
            let count = 3 * run.len() as u64;
            let indices = Accessor {
                byte_offset: Some(USize64(2 * first)),
                ..accessor(indices, count, ComponentType::U16, Type::Scalar)
            };
            let indices = self.root.push(indices);
            first += count;
            self.primitives.push(Primitive {
                attributes: [(Semantic::Positions, positions), (Semantic::Colors(0), colors)]
                    .map(|(semantic, accessor)| (Checked::Valid(semantic), accessor))
                    .into(),
                extensions: None,
                extras: None,
                indices: Some(indices),
                material: Some(Index::new(run[0].0)),
                mode: Checked::Valid(Mode::Triangles),
                targets: None,
            });
        }
        self.exported.vertices += corners;
        self.exported.triangles += triangles.len() as u64;
        let [least, most] = self.bounds.unwrap_or([low, high]);
        self.bounds = Some([least.min(low), most.max(high)]);
        Ok(())
    }

    /// Writes bytes, filled up to a multiple of 4, and notes where they are.
    fn view(
        &mut self,
        bytes: &[u8],
        target: Target,
        stride: Option<Stride>,
        to: &mut dyn Write,
    ) -> io::Result<Index<View>> {
        to.write_all(bytes)?;
        let (begin, length) = (self.length, bytes.len() as u64);
        self.length += length.next_multiple_of(4);
        to.write_all(&[0; 3][..(self.length - begin - length) as usize])?;
        if self.length > u64::from(u32::MAX) {
            return Err(too_large());
        }
        Ok(self.root.push(View {
            buffer: Index::new(0),
            byte_length: USize64(length),
            byte_offset: Some(USize64(begin)),
            byte_stride: stride,
            name: None,
            target: Some(Checked::Valid(target)),
            extensions: None,
            extras: None,
        }))
    }

    /// All but the binary chunk.
    fn finished(&mut self, lit: LitScene<'_>, display: Display) -> io::Result<Root> {
        let mut root = std::mem::take(&mut self.root);
        root.asset.generator = Some(format!("lightshaft {}", env!("CARGO_PKG_VERSION")));
        root.extensions_used = vec!["KHR_materials_unlit".to_owned()];
        root.push(Buffer {
            byte_length: USize64(self.length),
            name: None,
            uri: None,
            extensions: None,
            extras: None,
        });
        root.materials = std::mem::take(&mut self.palette.materials);
        let mesh = root.push(Mesh {
            extensions: None,
            extras: None,
            name: Some(lit.scene.name.clone()),
            primitives: std::mem::take(&mut self.primitives),
            weights: None,
        });
        let mut children = vec![root.push(Node { mesh: Some(mesh), ..named(&lit.scene.name) })];
        let bounds = self.bounds.unwrap_or_default().map(|corner| corner.as_dvec3());
        for camera in &lit.scene.cameras {
            children.push(add_camera(&mut root, camera, lit, bounds)?);
        }
        let origin = single(lit.origin())?;
        let top = Node { children: Some(children), translation: Some(origin), ..named(&lit.scene.name) };
        let top = root.push(top);
        let extras = to_raw_value(&json!({
            "exposure": display.exposure,
            "tone": display.tone.name(),
            "radiance": "W/(m\u{b2}\u{b7}sr), linear RGB (Rec. 709), times exposure, through the tone curve, is COLOR_0",
        }))?;
        let scene = root.push(Scene {
            extensions: None,
            extras: Some(extras),
            name: Some(lit.scene.name.clone()),
            nodes: vec![top],
        });
        root.scene = Some(scene);
        Ok(root)
    }
}

fn accessor(view: Index<View>, count: u64, component: ComponentType, type_: Type) -> Accessor {
    Accessor {
        buffer_view: Some(view),
        byte_offset: None,
        count: USize64(count),
        component_type: Checked::Valid(GenericComponentType(component)),
        extensions: None,
        extras: None,
        type_: Checked::Valid(type_),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    }
}

fn named(name: &str) -> Node {
    Node { name: Some(name.to_owned()), ..Node::default() }
}

/// A camera and its node; it sees from before the nearest surface as far as the bounds of the scene reach.
fn add_camera(
    root: &mut Root,
    camera: &scene::Camera,
    lit: LitScene<'_>,
    bounds: [DVec3; 2],
) -> io::Result<Index<Node>> {
    let ([low, high], eye) = (bounds, lit.eye(camera));
    let far = (eye - low).abs().max((eye - high).abs()).length() * 1.01;
    let aspect = f64::from(camera.width) / f64::from(camera.height);
    // Depth is less than distance, most of all in the corners of the picture.
    let corner = (0.5 * camera.vfov_deg.to_radians()).tan() * aspect.hypot(1.0);
    let near = (lit.clearance(camera) / corner.hypot(1.0)).clamp(NEAR[0] * far, NEAR[1] * far);
    let lens = gltf_json::Camera {
        name: Some(camera.name.clone()),
        orthographic: None,
        perspective: Some(Perspective {
            aspect_ratio: Some(aspect as f32),
            yfov: camera.vfov_deg.to_radians() as f32,
            zfar: Some(far as f32),
            znear: near as f32,
            extensions: None,
            extras: None,
        }),
        type_: Checked::Valid(Projection::Perspective),
        extensions: None,
        extras: None,
    };
    let lens = root.push(lens);
    // It looks along its own −z, and up is +y.
    let back = (camera.eye - camera.target).normalize();
    let right = camera.up.cross(back).normalize();
    let turn = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back)).normalize().as_quat();
    Ok(root.push(Node {
        camera: Some(lens),
        translation: Some(single(eye)?),
        rotation: Some(UnitQuaternion(turn.normalize().to_array())),
        ..named(&camera.name)
    }))
}

/// In single precision.
fn single(point: DVec3) -> io::Result<[f32; 3]> {
    let point = point.as_vec3();
    match point.is_finite() {
        true => Ok(point.to_array()),
        false => Err(too_far()),
    }
}
