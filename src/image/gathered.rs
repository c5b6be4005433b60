//! A picture by final gather: what each pixel shows is found first, then light is gathered at all points in the order of
//! the elements they lie on.

use super::camera::Lens;
use super::picture::Picture;
use super::render::{met, sample_offset};
use crate::gather::{FinalGather, VisiblePoint};
use crate::hierarchy::{Hierarchy, Side};
use crate::math::hash_pair;
use crate::progress::Progress;
use crate::tracer::{PACKET, Tracer};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f32::consts::PI;

/// About so many pixels are worked on at a time: enough to share work, and little memory.
const BLOCK: usize = 1 << 16;

/// What one pixel shows of one side.
struct Share {
    pixel: u32,
    side: Side,
    /// Where the samples of the pixel met it: their mean lies on it too, since facets are convex.
    sum: DVec3,
    samples: u32,
}

/// Gathers light once for each side that a pixel shows.
pub(super) fn gathered(
    hierarchy: &Hierarchy,
    tracer: &dyn Tracer,
    gather: &FinalGather<'_>,
    (lens, width, height): (&Lens, usize, usize),
    samples: u32,
    progress: &dyn Progress,
) -> Picture {
    let mut pixels = vec![[0.0f32; 3]; width * height];
    let rows = (BLOCK / width.max(1)).max(1);
    for (block, pixels) in pixels.chunks_mut(rows * width).enumerate() {
        let first = block * rows;
        let shares: Vec<Vec<Share>> = (0..pixels.len() / width)
            .into_par_iter()
            .map(|row| seen_in_row(hierarchy, tracer, lens, first + row, width, samples))
            .collect();
        let mut points = Vec::new();
        for (row, shares) in shares.into_iter().enumerate() {
            for share in shares {
                let point = share.sum / f64::from(share.samples);
                let Some(element) = gather.element_at(share.side, point) else { continue };
                let seed = hash_pair(u64::from(share.pixel), (first + row) as u64);
                let visible = VisiblePoint { side: share.side, point, element, seed };
                points.push((visible, row * width + share.pixel as usize, share.samples));
            }
        }
        points.par_sort_by_key(|(visible, ..)| visible.element);
        let visible: Vec<VisiblePoint> = points.iter().map(|point| point.0).collect();
        let light = gather.irradiance(&visible);
        for ((visible, pixel, shown), irradiance) in points.iter().zip(light) {
            let material = hierarchy.material(visible.side.facet);
            let reflected = hierarchy.reflectance_at(visible.side.facet, visible.point) * irradiance / PI;
            let emitted = if visible.side.back { Vec3::ZERO } else { Vec3::from(material.radiance) };
            let radiance = (emitted + reflected) * (*shown as f32 / samples as f32);
            pixels[*pixel] = (Vec3::from(pixels[*pixel]) + radiance).to_array();
        }
        progress.advance((pixels.len() / width) as u64);
    }
    Picture { width: width as u32, height: height as u32, pixels }
}

/// What the samples of a row of pixels meet.
fn seen_in_row(
    hierarchy: &Hierarchy,
    tracer: &dyn Tracer,
    lens: &Lens,
    row: usize,
    width: usize,
    samples: u32,
) -> Vec<Share> {
    let mut shares: Vec<Share> = Vec::new();
    let mut of_pixel = 0;
    for x in 0..width {
        for first in (0..samples).step_by(PACKET) {
            let count = (samples - first).min(PACKET as u32) as usize;
            let rays: Vec<_> = (first..first + count as u32)
                .map(|sample| {
                    let (dx, dy) = sample_offset(sample, samples);
                    lens.ray(x as f32 + dx, row as f32 + dy)
                })
                .collect();
            let mut hits = [None; PACKET];
            tracer.first_hits(&rays, &mut hits[..count]);
            for (ray, hit) in rays.iter().zip(&hits) {
                let Some(hit) = hit else { continue };
                let (side, point) = met(hierarchy, ray, hit);
                match shares[of_pixel..].iter_mut().find(|share| share.side == side) {
                    Some(share) => {
                        share.sum += point;
                        share.samples += 1;
                    }
                    None => shares.push(Share { pixel: x as u32, side, sum: point, samples: 1 }),
                }
            }
        }
        of_pixel = shares.len();
    }
    shares
}
