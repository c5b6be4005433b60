//! What a diffuse renderer takes of the materials of glTF: the base colour as reflectance, whether it is of a metal or not (a
//! metal reflects about as much, in one direction), and emission as radiance.

use std::path::Path;

use gltf_json::material::AlphaMode;
use gltf_json::validation::Checked;
use gltf_json::{Material, Root};

use super::super::draft::{DEFAULT_GREY, Draft, DraftMaterial, Origin, UNNAMED_MATERIAL};
use super::super::error::{SceneError, name_list, quoted};
use super::super::statements::LARGEST_COLOUR;

/// Materials of the file, and what of them is not read.
pub(super) struct Materials {
    /// For each material of the file its number in the draft, once it is used.
    of_file: Vec<Option<u32>>,
    unnamed: Option<u32>,
    remarks: Vec<Remark>,
}

/// What a diffuse renderer makes of something, and the materials that have it.
struct Remark {
    what: &'static str,
    names: Vec<String>,
}

const UNTEXTURED: &str =
    "textures are not read; the colour alone counts, and where it is white, grey 0.5, of material(s)";
const DARK: &str = "textures are not read, so nothing is emitted by material(s)";
const OPAQUE: &str = "surfaces are opaque, though transparent in the file, of material(s)";
const UNLIT: &str = "colours of unlit surfaces are taken for reflectance, of material(s)";
const ONE_SIDE: &str =
    "light leaves the front of surfaces only, though both sides emit in the file, of material(s)";

impl Materials {
    pub(super) fn new(root: &Root) -> Materials {
        let remarks =
            [UNTEXTURED, DARK, OPAQUE, UNLIT, ONE_SIDE].map(|what| Remark { what, names: Vec::new() });
        Materials { of_file: vec![None; root.materials.len()], unnamed: None, remarks: remarks.into() }
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
        index: Option<usize>,
    ) -> Result<u32, SceneError> {
        let Some(index) = index else {
            return Ok(*self.unnamed.get_or_insert_with(|| {
                let grey = [DEFAULT_GREY; 3];
                draft.add_material(DraftMaterial::of_mesh(UNNAMED_MATERIAL, grey, [0.0; 3], Origin::Unnamed))
            }));
        };
        if let Some(known) = self.of_file[index] {
            return Ok(known);
        }
        let material = &root.materials[index];
        let name = material.name.clone().filter(|name| !name.is_empty());
        let name = name.unwrap_or_else(|| format!("material{index}"));
        let (reflectance, radiance) = self.surface(material, &name).map_err(|what| {
            SceneError::invalid(path, None, format!("material {index} {}: {what}", quoted(&name)))
        })?;
        let added = draft.add_material(DraftMaterial::of_mesh(&name, reflectance, radiance, Origin::Given));
        self.of_file[index] = Some(added);
        Ok(added)
    }

    /// Reflectance and radiance.
    fn surface(&mut self, material: &Material, name: &str) -> Result<([f64; 3], [f64; 3]), String> {
        let extensions = material.extensions.as_ref();
        let pbr = &material.pbr_metallic_roughness;
        let glossy = extensions.and_then(|extensions| extensions.pbr_specular_glossiness.as_ref());
        let (factor, texture) = match glossy {
            Some(glossy) => (glossy.diffuse_factor.0, &glossy.diffuse_texture),
            None => (pbr.base_color_factor.0, &pbr.base_color_texture),
        };
        let [red, green, blue, _] = factor;
        let mut reflectance = colour([red, green, blue], "base colour")?;
        if texture.is_some() {
            self.remark(UNTEXTURED, name);
            if reflectance == [1.0; 3] {
                reflectance = [DEFAULT_GREY; 3];
            }
        }
        let strength = extensions.and_then(|extensions| extensions.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
        let mut radiance = colour(material.emissive_factor.0.map(|c| c * strength), "emission")?;
        let emits = radiance.iter().any(|&channel| channel > 0.0);
        if emits && material.emissive_texture.is_some() {
            self.remark(DARK, name);
            radiance = [0.0; 3];
        } else if emits && material.double_sided {
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

    fn remark(&mut self, what: &'static str, name: &str) {
        self.remarks
            .iter_mut()
            .filter(|remark| remark.what == what)
            .for_each(|r| r.names.push(name.to_owned()));
    }

    /// One warning for each thing that is not read.
    pub(super) fn warn(&self, path: &Path, warnings: &mut Vec<String>) {
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
