//! What a camera sees, for scales that have to say something in its picture.

use super::camera::Lens;
use super::render::met;
use crate::hierarchy::Hierarchy;
use crate::radiosity::Solution;
use crate::scene::Camera;
use crate::tracer::{PACKET, Ray, Tracer};

/// Most rays along one side of the picture.
const ALONG: u32 = 256;

/// Most cameras of a sequence that are looked through for something that all its pictures share.
const CAMERAS: usize = 32;

/// The leaf elements that rays spread evenly over pictures meet, one for each ray that meets any; at most 65 536 rays a
/// picture, and 32 pictures, spread evenly over all.
pub fn seen(hierarchy: &Hierarchy, tracer: &dyn Tracer, solution: &Solution, cameras: &[Camera]) -> Vec<u32> {
    spread(cameras).flat_map(|camera| seen_by(hierarchy, tracer, solution, camera)).collect()
}

/// Some of the cameras, spread evenly.
pub(super) fn spread(cameras: &[Camera]) -> impl Iterator<Item = &Camera> {
    let count = cameras.len().min(CAMERAS);
    (0..count).map(move |index| &cameras[index * cameras.len() / count])
}

fn seen_by(hierarchy: &Hierarchy, tracer: &dyn Tracer, solution: &Solution, camera: &Camera) -> Vec<u32> {
    let lens = Lens::new(camera, &hierarchy.frame);
    let at = |index: u32, pixels: u32| {
        let count = pixels.min(ALONG);
        (index as f32 + 0.5) * pixels as f32 / count as f32
    };
    let [columns, rows] = [camera.width, camera.height].map(|pixels| pixels.min(ALONG));
    let across = |y| (0..columns).map(move |x| (x, y));
    let rays: Vec<Ray> = (0..rows)
        .flat_map(across)
        .map(|(x, y)| lens.ray(at(x, camera.width), at(y, camera.height)))
        .collect();
    let mut elements = Vec::with_capacity(rays.len());
    for packet in rays.chunks(PACKET) {
        let mut hits = [None; PACKET];
        tracer.first_hits(packet, &mut hits[..packet.len()]);
        for (ray, hit) in packet.iter().zip(hits) {
            let Some(hit) = hit else { continue };
            let (side, point) = met(hierarchy, ray, &hit);
            elements.extend(solution.forest.leaf_at(hierarchy, side, point).map(|leaf| leaf.id));
        }
    }
    elements
}
