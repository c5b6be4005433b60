//! The materials of a GLB. What viewers show is the light in the colours of the vertices; beside it each material says what
//! its surfaces reflect and emit, so that the model can be read and solved again.

use std::collections::HashMap;
use std::io;

use gltf_json::Material;
use gltf_json::extensions::material::{Material as Extensions, Unlit};
use gltf_json::material::{PbrMetallicRoughness, StrengthFactor};
use serde_json::json;
use serde_json::value::to_raw_value;

use super::lit::{Coat, LitScene};
use crate::scene;

/// Viewers draw what has another material apart: where there are more, such as one for each colour of a vertex, there is one
/// for all, which says nothing.
const MOST: usize = 256;

/// The materials, and which surface has which.
#[derive(Debug)]
pub(super) struct Palette {
    of_coat: HashMap<Coat, u32>,
    /// In order.
    pub(super) materials: Vec<Material>,
}

impl Palette {
    /// For all sides of a scene.
    ///
    /// # Errors
    /// None that numbers of a scene can cause.
    pub(super) fn of(lit: LitScene<'_>) -> io::Result<Palette> {
        let mut palette = Palette { of_coat: HashMap::new(), materials: Vec::new() };
        let mut numbers = HashMap::new();
        let forest = &lit.solution.forest;
        for coat in (0..forest.side_count()).map(|side| lit.coat(forest.side(side))) {
            if palette.of_coat.contains_key(&coat) {
                continue;
            }
            let scene::Material { name, reflectance, radiance, .. } =
                &lit.hierarchy.materials[coat.material as usize];
            let bits = [*reflectance, *radiance].map(|rgb| rgb.map(f32::to_bits));
            let next = palette.materials.len() as u32;
            let number = *numbers.entry((name, bits, coat.is_back)).or_insert(next);
            if number == next {
                let surface = json!({"reflectance": reflectance, "radiance": radiance, "back": coat.is_back});
                let extras = to_raw_value(&json!({"lightshaft": surface}))?;
                palette.materials.push(Material { extras: Some(extras), ..unlit(name) });
            }
            palette.of_coat.insert(coat, number);
            if palette.materials.len() > MOST {
                return Ok(Palette { of_coat: HashMap::new(), materials: vec![unlit("light")] });
            }
        }
        Ok(palette)
    }

    /// The number of the material of a surface.
    pub(super) fn number(&self, coat: Coat) -> u32 {
        self.of_coat.get(&coat).copied().unwrap_or(0)
    }
}

/// Light that is there already is shown as it is. What does not know how shows a matt surface.
fn unlit(name: &str) -> Material {
    Material {
        name: Some(name.to_owned()),
        pbr_metallic_roughness: PbrMetallicRoughness {
            metallic_factor: StrengthFactor(0.0),
            ..PbrMetallicRoughness::default()
        },
        extensions: Some(Extensions { unlit: Some(Unlit {}), ..Extensions::default() }),
        ..Material::default()
    }
}
