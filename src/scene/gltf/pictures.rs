//! Textures of a file: pictures in its data, in its text or beside it, each decoded once. One that cannot be read is a warning.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec2;
use gltf_json::mesh::Primitive;
use gltf_json::mesh::Semantic;
use gltf_json::texture::{Info, Sampler, WrappingMode};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};

use super::super::lines::{MOST_PICTURE_BYTES, read_whole};
use super::super::texture::{Picture, Texture, Wrap};
use super::accessor::Values;
use super::buffers::{Buffers, decoded, file_of, is_data};

/// The pictures of a file, as far as they are used.
pub(super) struct Pictures<'a> {
    path: &'a std::path::Path,
    root: &'a Root,
    buffers: &'a Buffers,
    of_image: Vec<Option<Result<Arc<Texture>, String>>>,
    /// Pixels that they may still have.
    pub(super) room: u64,
    /// Files beside the scene.
    pub(super) files: Vec<PathBuf>,
}

/// A texture of a material, and where it lies.
#[derive(Clone)]
pub(super) struct Layer {
    pub(super) picture: Picture,
    /// Of the places of vertices.
    set: u32,
    /// By which places are scaled, turned and moved.
    scale: DVec2,
    turn: DVec2,
    offset: DVec2,
}

impl<'a> Pictures<'a> {
    /// `room` is how many pixels all of them may have.
    pub(super) fn new(
        path: &'a std::path::Path,
        root: &'a Root,
        buffers: &'a Buffers,
        room: u64,
    ) -> Pictures<'a> {
        let of_image = root.images.iter().map(|_| None).collect();
        Pictures { path, root, buffers, of_image, room, files: Vec::new() }
    }

    /// A texture of a material.
    ///
    /// # Errors
    /// Why it cannot be read.
    pub(super) fn layer(&mut self, info: &Info) -> Result<Layer, String> {
        let texture = &self.root.textures[info.index.value()];
        let image = texture.source.value();
        let texture_of_image = match self.of_image.get(image) {
            None => return Err("its texture has no picture that is read (PNG or JPEG)".to_owned()),
            Some(Some(known)) => known.clone(),
            Some(None) => {
                let read = self.read(image).map(Arc::new);
                self.of_image[image] = Some(read.clone());
                read
            }
        };
        let wrap = texture.sampler.map(|sampler: Index<Sampler>| {
            let sampler = &self.root.samplers[sampler.value()];
            [sampler.wrap_s, sampler.wrap_t].map(wrap)
        });
        let picture = Picture { texture: texture_of_image?, wrap: wrap.unwrap_or([Wrap::Repeat; 2]) };
        let transform = info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref());
        let vector = |[x, y]: [f32; 2]| DVec2::new(f64::from(x), f64::from(y));
        let Some(transform) = transform else {
            return Ok(Layer {
                picture,
                set: info.tex_coord,
                scale: DVec2::ONE,
                turn: DVec2::X,
                offset: DVec2::ZERO,
            });
        };
        Ok(Layer {
            picture,
            set: transform.tex_coord.unwrap_or(info.tex_coord),
            scale: vector(transform.scale.0),
            turn: DVec2::from_angle(f64::from(transform.rotation.0)),
            offset: vector(transform.offset.0),
        })
    }

    fn read(&mut self, image: usize) -> Result<Texture, String> {
        let about = &self.root.images[image];
        let held;
        let bytes = match (&about.uri, about.buffer_view) {
            (Some(uri), _) if is_data(uri) => {
                held = decoded(uri)?;
                &held[..]
            }
            (Some(uri), _) => {
                let file = file_of(self.path, uri)?;
                held = read_whole(&file, MOST_PICTURE_BYTES).map_err(|error| error.to_string())?;
                self.files.push(file);
                &held[..]
            }
            (None, Some(view)) => self.buffers.view(self.root, view.value())?,
            (None, None) => return Err("it has no data".to_owned()),
        };
        let texture = Texture::decode(bytes, self.room)?;
        self.room -= texture.pixels();
        Ok(texture)
    }
}

fn wrap(mode: Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    }
}

/// Where the vertices of a primitive are on a picture.
pub(super) struct Places<'a> {
    values: Values<'a>,
    layer: Layer,
}

impl<'a> Places<'a> {
    /// None where the primitive has none.
    ///
    /// # Errors
    /// What is wrong with them.
    pub(super) fn of(
        root: &Root,
        buffers: &'a Buffers,
        primitive: &Primitive,
        layer: Layer,
        vertices: usize,
    ) -> Result<Option<Places<'a>>, String> {
        let semantic = Checked::Valid(Semantic::TexCoords(layer.set));
        let Some(&index) = primitive.attributes.get(&semantic) else { return Ok(None) };
        let values = Values::of(root, buffers, index)?;
        if values.width != 2 || values.count != vertices {
            return Err("texture coordinates do not fit the positions; export it again".to_owned());
        }
        Ok(Some(Places { values, layer }))
    }

    pub(super) fn picture(&self) -> &Picture {
        &self.layer.picture
    }

    /// From the left and from the top.
    pub(super) fn place(&self, vertex: u32) -> DVec2 {
        let [u, v, ..] = self.values.share(vertex as usize);
        // Scaled, then turned clockwise as seen with v downwards (KHR_texture_transform), then moved.
        let [scaled, turn] = [DVec2::new(u, v) * self.layer.scale, self.layer.turn];
        let turned = DVec2::new(turn.x * scaled.x + turn.y * scaled.y, turn.x * scaled.y - turn.y * scaled.x);
        turned + self.layer.offset
    }
}
