//! Materials whose reflectance differs from triangle to triangle, by the colours of vertices: one material for each colour
//! that 8 bits of sRGB tell apart, so that neighbours of one colour can still become one facet.

use std::collections::HashMap;

use super::draft::Draft;
use crate::math::{linear_from_srgb, srgb_from_linear};

/// The tinted materials of one mesh.
#[derive(Default)]
pub(super) struct Tints {
    of_colour: HashMap<(u32, [u8; 3]), u32>,
}

impl Tints {
    /// The material with its reflectance multiplied by a linear colour, which is cut off at 0 and 1.
    pub(super) fn material(&mut self, draft: &mut Draft, base: u32, linear: [f64; 3]) -> u32 {
        let bytes = linear.map(|c| (255.0 * srgb_from_linear(c.clamp(0.0, 1.0) as f32)).round() as u8);
        *self.of_colour.entry((base, bytes)).or_insert_with(|| {
            let mut material = draft.materials[base as usize].clone();
            for (reflectance, byte) in material.reflectance.iter_mut().zip(bytes) {
                *reflectance *= f64::from(linear_from_srgb(f32::from(byte) / 255.0));
            }
            draft.add_material(material)
        })
    }
}
