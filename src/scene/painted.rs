//! Materials with a picture on them: each way in which the picture lies is a material of its own, whose reflectance is the mean
//! of the picture over its surfaces. Light is exchanged with the mean, pictures show the texels.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::draft::Draft;
use super::texture::{Painting, Picture};

/// The painted material that is being added to.
#[derive(Default)]
pub(super) struct Painter {
    current: Option<Current>,
}

struct Current {
    base: u32,
    material: u32,
    painting: Arc<Painting>,
    /// Reflectance × area so far, and area.
    sum: [f64; 3],
    area: f64,
}

impl Painter {
    /// The material of a triangle: the one before, when the picture lies on both in the same way, else a new one like `base`,
    /// whose reflectance multiplies the picture.
    pub(super) fn material(
        &mut self,
        draft: &mut Draft,
        base: u32,
        picture: &Picture,
        corners: [DVec3; 3],
        places: [DVec2; 3],
    ) -> u32 {
        let is_same = |current: &Current| current.base == base && current.painting.fits(corners, places);
        if !self.current.as_ref().is_some_and(is_same) {
            let mut material = draft.materials[base as usize].clone();
            // What has no area is dropped later.
            let Some(painting) = Painting::on(picture, material.reflectance, corners, places) else {
                return base;
            };
            let painting = Arc::new(painting);
            material.painting = Some(painting.clone());
            let material = draft.add_material(material);
            self.current = Some(Current { base, material, painting, sum: [0.0; 3], area: 0.0 });
        }
        let Some(current) = &mut self.current else { return base };
        let [a, b, c] = corners;
        let area = (b - a).cross(c - a).length();
        let mean = current.painting.mean(corners);
        current.sum = [0, 1, 2].map(|channel| current.sum[channel] + mean[channel] * area);
        current.area += area;
        if current.area > 0.0 {
            draft.materials[current.material as usize].reflectance =
                current.sum.map(|sum| sum / current.area);
        }
        current.material
    }
}
