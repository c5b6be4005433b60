//! One exposure for all pictures of a sequence: each for itself, they would flicker.

use super::picture::Picture;
use super::render::Renderer;
use super::seen::spread;
use super::tone::automatic_exposure;
use crate::scene::Camera;

/// Pixels along the longer side of what the exposure is chosen from.
const ALONG: u32 = 128;

/// The multiplier that exposes the pictures of all these cameras well, together: what
/// [`automatic_exposure`] chooses for quick small pictures of at most 32 of them, spread evenly, side by side.
pub fn shared_exposure(renderer: &Renderer<'_>, cameras: &[Camera]) -> f32 {
    let mut strip = Picture { width: 0, height: 1, pixels: Vec::new() };
    for camera in spread(cameras) {
        strip.pixels.extend(renderer.preview(&small(camera)).pixels);
    }
    strip.width = strip.pixels.len() as u32;
    automatic_exposure(&strip)
}

fn small(camera: &Camera) -> Camera {
    let longer = camera.width.max(camera.height).max(1);
    let scaled = |side: u32| {
        let exact = f64::from(side) * f64::from(ALONG.min(longer)) / f64::from(longer);
        (exact.round() as u32).max(1)
    };
    Camera { width: scaled(camera.width), height: scaled(camera.height), ..camera.clone() }
}
