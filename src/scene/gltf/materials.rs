//! What a diffuse renderer takes of the materials of glTF: the base colour as reflectance, whether it is of a metal or not (a
//! metal reflects about as much, in one direction), and emission as radiance.

use std::path::Path;

use gltf_json::material::AlphaMode;
use gltf_json::texture::Info;
use gltf_json::validation::Checked;
use gltf_json::{Material, Root};
use serde::Deserialize;

use super::super::draft::{DEFAULT_GREY, Draft, DraftMaterial, Origin, UNNAMED_MATERIAL};
use super::super::error::{SceneError, name_list, quoted};
use super::super::statements::LARGEST_COLOUR;
use super::pictures::{Layer, Pictures};

/// Materials of the file, and what of them is not read.
pub(super) struct Materials {
    /// For each material of the file what it is here, once it is used.
    of_file: Vec<Option<Surface>>,
    unnamed: Option<u32>,
    remarks: Vec<Remark>,
    /// Why textures cannot be read.
    faults: Vec<String>,
}

/// A material of the draft, and the picture that its colour multiplies.
#[derive(Clone)]
pub(super) struct Surface {
    pub(super) material: u32,
    pub(super) layer: Option<Layer>,
    pub(super) baked: Option<Baked>,
}

/// What a surface reflects and emits whose colours are light, as our own models say it.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct Baked {
    reflectance: [f32; 3],
    radiance: [f32; 3],
    /// Whether there is its other side too, in the same place.
    pub(super) back: bool,
}

impl Baked {
    fn of(material: &Material) -> Option<Baked> {
        #[derive(Deserialize)]
        struct Extras {
            lightshaft: Baked,
        }
        let extras: Extras = serde_json::from_str(material.extras.as_ref()?.get()).ok()?;
        Some(extras.lightshaft)
    }
}

/// What a diffuse renderer makes of something, and the materials that have it.
struct Remark {
    what: &'static str,
    names: Vec<String>,
}

/// Most textures of which it is said why they cannot be read.
const MOST_FAULTS: usize = 8;

const UNTEXTURED: &str =
    "textures are missing; the colour alone counts, and where it is white, grey 0.5, of material(s)";
const DARK: &str = "textures of emission are missing, so nothing is emitted by material(s)";
const EVEN: &str = "emission with a texture is even, the mean of the texture, of material(s)";
const OPAQUE: &str = "surfaces are opaque, though transparent in the file, of material(s)";
const UNLIT: &str = "colours of unlit surfaces are taken for reflectance, of material(s)";
const BAKED: &str = "the light in the colours is left out, and surfaces reflect and emit, on one of both sides, what they did when it was \
     computed, of material(s)";
const ONE_SIDE: &str =
    "light leaves the front of surfaces only, though both sides emit in the file, of material(s)";

impl Materials {
    pub(super) fn new(root: &Root) -> Materials {
        let remarks = [UNTEXTURED, DARK, EVEN, OPAQUE, UNLIT, BAKED, ONE_SIDE]
            .map(|what| Remark { what, names: Vec::new() });
        Materials {
            of_file: vec![None; root.materials.len()],
            unnamed: None,
            remarks: remarks.into(),
            faults: Vec::new(),
        }
    }

    /// The material of a primitive, in the draft.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] for colours that are none.
    pub(super) fn get(
        &mut self,
        draft: &mut Draft,
        path: &Path,
        root: &Root,
        pictures: &mut Pictures<'_>,
        index: Option<usize>,
    ) -> Result<Surface, SceneError> {
        let Some(index) = index else {
            let material = *self.unnamed.get_or_insert_with(|| {
                let grey = [DEFAULT_GREY; 3];
                draft.add_material(DraftMaterial::of_mesh(UNNAMED_MATERIAL, grey, [0.0; 3], Origin::Unnamed))
            });
            return Ok(Surface { material, layer: None, baked: None });
        };
        if let Some(known) = &self.of_file[index] {
            return Ok(known.clone());
        }
        let material = &root.materials[index];
        let name = material.name.clone().filter(|name| !name.is_empty());
        let name = name.unwrap_or_else(|| format!("material{index}"));
        let (mut layer, baked) = (None, Baked::of(material));
        let (reflectance, radiance) =
            self.surface(material, &name, baked, pictures, &mut layer).map_err(|what| {
                SceneError::invalid(path, None, format!("material {index} {}: {what}", quoted(&name)))
            })?;
        let added = DraftMaterial::of_mesh(&name, reflectance, radiance, Origin::Given);
        let surface = Surface { material: draft.add_material(added), layer, baked };
        self.of_file[index] = Some(surface.clone());
        Ok(surface)
    }

    /// Reflectance and radiance, and the picture that multiplies the reflectance.
    fn surface(
        &mut self,
        material: &Material,
        name: &str,
        baked: Option<Baked>,
        pictures: &mut Pictures<'_>,
        layer: &mut Option<Layer>,
    ) -> Result<([f64; 3], [f64; 3]), String> {
        if let Some(Baked { reflectance, radiance, back }) = baked {
            if !back {
                self.remark(BAKED, name);
            }
            return Ok((colour(reflectance, "reflectance")?, colour(radiance, "radiance")?));
        }
        let extensions = material.extensions.as_ref();
        let pbr = &material.pbr_metallic_roughness;
        let glossy = extensions.and_then(|extensions| extensions.pbr_specular_glossiness.as_ref());
        let (factor, texture) = match glossy {
            Some(glossy) => (glossy.diffuse_factor.0, &glossy.diffuse_texture),
            None => (pbr.base_color_factor.0, &pbr.base_color_texture),
        };
        let [red, green, blue, _] = factor;
        let mut reflectance = colour([red, green, blue], "base colour")?;
        if let Some(info) = texture {
            *layer = self.layer(pictures, info, UNTEXTURED, name);
            if layer.is_none() && reflectance == [1.0; 3] {
                reflectance = [DEFAULT_GREY; 3];
            }
        }
        let strength = extensions.and_then(|extensions| extensions.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
        let mut radiance = colour(material.emissive_factor.0.map(|c| c * strength), "emission")?;
        let emits = radiance.iter().any(|&channel| channel > 0.0);
        if emits && let Some(info) = &material.emissive_texture {
            let mean = self.layer(pictures, info, DARK, name).map(|layer| layer.picture.texture.mean());
            if mean.is_some() {
                self.remark(EVEN, name);
            }
            let mean = mean.unwrap_or_default();
            radiance = [0, 1, 2].map(|channel| radiance[channel] * mean[channel]);
        }
        let emits = radiance.iter().any(|&channel| channel > 0.0);
        if emits && material.double_sided {
            self.remark(ONE_SIDE, name);
        }
        let is_clear = extensions
            .and_then(|extensions| extensions.transmission.as_ref())
            .is_some_and(|transmission| transmission.transmission_factor.0 > 0.0);
        if is_clear || !matches!(material.alpha_mode, Checked::Valid(AlphaMode::Opaque)) {
            self.remark(OPAQUE, name);
        }
        if extensions.is_some_and(|extensions| extensions.unlit.is_some()) {
            self.remark(UNLIT, name);
        }
        Ok((reflectance, radiance))
    }

    /// A texture, or a remark and why it cannot be read.
    fn layer(
        &mut self,
        pictures: &mut Pictures<'_>,
        info: &Info,
        missing: &'static str,
        name: &str,
    ) -> Option<Layer> {
        match pictures.layer(info) {
            Ok(layer) => Some(layer),
            Err(why) => {
                self.remark(missing, name);
                if self.faults.len() < MOST_FAULTS && !self.faults.contains(&why) {
                    self.faults.push(why);
                }
                None
            }
        }
    }

    fn remark(&mut self, what: &'static str, name: &str) {
        self.remarks
            .iter_mut()
            .filter(|remark| remark.what == what)
            .for_each(|r| r.names.push(name.to_owned()));
    }

    /// One warning for each thing that is not read.
    pub(super) fn warn(&self, path: &Path, warnings: &mut Vec<String>) {
        for fault in &self.faults {
            warnings.push(format!("{}: texture: {fault}", path.display()));
        }
        for remark in self.remarks.iter().filter(|remark| !remark.names.is_empty()) {
            let names = name_list(remark.names.iter().map(String::as_str));
            warnings.push(format!("{}: {} {names}", path.display(), remark.what));
        }
    }
}

fn colour(rgb: [f32; 3], what: &str) -> Result<[f64; 3], String> {
    let rgb = rgb.map(f64::from);
    if rgb.iter().all(|channel| (0.0..=LARGEST_COLOUR).contains(channel)) {
        return Ok(rgb);
    }
    Err(format!("{what} {rgb:?} is negative, not finite or too large; write 0 to {LARGEST_COLOUR:e}"))
}
