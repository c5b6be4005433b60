//! From a solution to pictures through cameras.

use super::camera::Lens;
use super::gathered::gathered;
use super::heat::HeatMap;
use super::mesh_view::{MeshView, edge};
use super::picture::Picture;
use crate::gather::{FinalGather, Reconstruction, Spot};
use crate::hierarchy::{Hierarchy, Side};
use crate::progress::{Progress, Silent};
use crate::radiosity::Solution;
use crate::scene::Camera;
use crate::tracer::{Hit, PACKET, Ray, Tracer};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Elements of a heat map that are this many pixels large have their edges drawn in full.
const EDGED: f32 = 24.0;

/// Rows handed to a thread at a time.
const BAND: usize = 4;

/// What the picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// The lit scene, light interpolated over the elements.
    Shaded,
    /// The lit scene, light gathered at each pixel with about so many rays.
    Gathered(u32),
    /// Elements with their edges, coloured by the class of the links that light them.
    Mesh,
}

/// How to render.
#[derive(Clone, Copy, Debug)]
pub struct RenderOptions {
    /// Rays per pixel, at least 1.
    pub samples: u32,
    /// What to show.
    pub view: View,
}

/// Renders linear radiance, W/(m²·sr); black where nothing is hit. Deterministic for any number of
/// threads.
pub fn render(
    hierarchy: &Hierarchy,
    tracer: &dyn Tracer,
    solution: &Solution,
    camera: &Camera,
    options: RenderOptions,
    progress: &dyn Progress,
) -> Picture {
    let renderer = Renderer::new(hierarchy, tracer, solution, options, progress);
    progress.start("render", camera.height.into());
    let picture = renderer.picture(camera, progress);
    progress.finish();
    picture
}

/// Any number of pictures of one solution: what they have in common is computed once, when it is first needed.
pub struct Renderer<'a> {
    hierarchy: &'a Hierarchy,
    tracer: &'a dyn Tracer,
    solution: &'a Solution,
    /// The light that is shown.
    surfaces: Reconstruction<'a>,
    /// Elements that links have, where others are shown.
    elements: Option<Reconstruction<'a>>,
    look: Look<'a>,
    gather: Option<FinalGather<'a>>,
    samples: u32,
}

impl<'a> Renderer<'a> {
    /// Prepares what does not depend on the camera: the sources of a final gather, the classes of a view of the mesh.
    pub fn new(
        hierarchy: &'a Hierarchy,
        tracer: &'a dyn Tracer,
        solution: &'a Solution,
        options: RenderOptions,
        progress: &dyn Progress,
    ) -> Renderer<'a> {
        let (look, gather) = match options.view {
            View::Shaded => (Look::Shaded, None),
            View::Gathered(rays) => {
                (Look::Shaded, Some(FinalGather::new(hierarchy, tracer, solution, rays, progress)))
            }
            View::Mesh => (Look::Mesh(MeshView::new(hierarchy, solution)), None),
        };
        // What is gathered has nothing to do with elements for display.
        let is_interpolated = options.view == View::Shaded;
        let shown = if is_interpolated { Reconstruction::shown } else { Reconstruction::new };
        let surfaces = shown(hierarchy, solution);
        let others = is_interpolated && solution.display.is_some();
        let elements = others.then(|| Reconstruction::new(hierarchy, solution));
        Renderer {
            hierarchy,
            tracer,
            solution,
            surfaces,
            elements,
            look,
            gather,
            samples: options.samples.max(1),
        }
    }

    /// Linear radiance, W/(m²·sr), seen by a camera; black where nothing is hit. Deterministic for any number of threads.
    /// One unit of progress for each row of pixels, of a phase that the caller has started.
    pub fn picture(&self, camera: &Camera, progress: &dyn Progress) -> Picture {
        match &self.gather {
            Some(gather) => {
                let lens = Lens::new(camera, &self.hierarchy.frame);
                let shown = (&lens, camera.width as usize, camera.height as usize);
                gathered(self.hierarchy, self.tracer, gather, shown, self.samples, progress)
            }
            None => self.looked_at(camera, &self.look, self.samples, progress),
        }
    }

    /// Likewise the colours of a heat map, linear, from 0 to 1.
    pub fn heat(&self, camera: &Camera, map: &HeatMap, progress: &dyn Progress) -> Picture {
        self.looked_at(camera, &Look::Heat(map), self.samples, progress)
    }

    /// What pictures are made of.
    pub(super) fn shown(&self) -> Shown<'_> {
        let (hierarchy, tracer, solution) = (self.hierarchy, self.tracer, self.solution);
        Shown { hierarchy, tracer, solution, surfaces: &self.surfaces }
    }

    /// A quick picture, interpolated, with one ray a pixel.
    pub(super) fn preview(&self, camera: &Camera) -> Picture {
        self.looked_at(camera, &self.look, 1, &Silent)
    }

    fn looked_at(&self, camera: &Camera, look: &Look<'_>, samples: u32, progress: &dyn Progress) -> Picture {
        let lens = Lens::new(camera, &self.hierarchy.frame);
        let (width, height) = (camera.width as usize, camera.height as usize);
        let (hierarchy, solution) = (self.hierarchy, self.solution);
        let is_shaded = matches!(look, Look::Shaded);
        let surfaces = self.elements.as_ref().filter(|_| !is_shaded).unwrap_or(&self.surfaces);
        let shader = Shader { hierarchy, solution, surfaces, look, pixel_angle: lens.pixel_angle() };
        let mut pixels = vec![[0.0f32; 3]; width * height];
        pixels.par_chunks_mut(width * BAND).enumerate().for_each(|(band, rows)| {
            for (row, line) in rows.chunks_mut(width).enumerate() {
                shader.line(self.tracer, &lens, band * BAND + row, samples, line);
                progress.advance(1);
            }
        });
        Picture { width: camera.width, height: camera.height, pixels }
    }
}

/// What pictures are made of, whatever they show of it.
#[derive(Clone, Copy)]
pub(super) struct Shown<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) tracer: &'a dyn Tracer,
    pub(super) solution: &'a Solution,
    /// The light that is shown.
    pub(super) surfaces: &'a Reconstruction<'a>,
}

struct Shader<'a> {
    hierarchy: &'a Hierarchy,
    solution: &'a Solution,
    surfaces: &'a Reconstruction<'a>,
    look: &'a Look<'a>,
    pixel_angle: f32,
}

/// What a surface is shown as.
enum Look<'a> {
    Shaded,
    Mesh(MeshView<'a>),
    Heat(&'a HeatMap),
}

impl Shader<'_> {
    fn line(&self, tracer: &dyn Tracer, lens: &Lens, y: usize, samples: u32, line: &mut [[f32; 3]]) {
        let mut rays = Vec::with_capacity(PACKET);
        let mut owners = Vec::with_capacity(PACKET);
        let mut hits = [None; PACKET];
        // Samples that follow each other mostly show the same element.
        let mut recent = None;
        let total = line.len() * samples as usize;
        for index in 0..total {
            let (x, sample) = (index / samples as usize, (index % samples as usize) as u32);
            let (dx, dy) = sample_offset(sample, samples);
            rays.push(lens.ray(x as f32 + dx, y as f32 + dy));
            owners.push(x);
            if rays.len() == PACKET || index + 1 == total {
                tracer.first_hits(&rays, &mut hits[..rays.len()]);
                for ((ray, owner), hit) in rays.iter().zip(&owners).zip(&hits) {
                    if let Some(hit) = hit {
                        let radiance = self.radiance(ray, hit, &mut recent) / samples as f32;
                        line[*owner] = (Vec3::from(line[*owner]) + radiance).to_array();
                    }
                }
                rays.clear();
                owners.clear();
            }
        }
    }

    /// Radiance towards the start of the ray.
    fn radiance(&self, ray: &Ray, hit: &Hit, recent: &mut Option<Spot>) -> Vec3 {
        let (side, point) = met(self.hierarchy, ray, hit);
        let material = self.hierarchy.material(hit.facet);
        let Some(spot) = self.surfaces.look_up_near(recent, side, point) else {
            return Vec3::ZERO;
        };
        let emitted = if side.back { Vec3::ZERO } else { Vec3::from(material.radiance) };
        let radiance = emitted + self.hierarchy.reflectance_at(hit.facet, point) * spot.irradiance / PI;
        let pixel = hit.t * self.pixel_angle;
        match self.look {
            Look::Shaded => radiance,
            Look::Mesh(mesh) => mesh.color(self.solution, spot, point, pixel),
            // Fainter where elements are small: colours are what it is about.
            Look::Heat(map) => {
                let size = spot.polygon.extent() as f32 / pixel;
                map.color(spot.element) * (1.0 - 0.5 * (size / EDGED).min(1.0) * edge(spot, point, pixel))
            }
        }
    }
}

/// The side that a ray met and where, in double precision: on its plane itself, unless the ray only grazes it.
pub(super) fn met(hierarchy: &Hierarchy, ray: &Ray, hit: &Hit) -> (Side, DVec3) {
    let plane = &hierarchy.facets[hit.facet as usize].plane;
    let (origin, direction, t) = (ray.origin.as_dvec3(), ray.direction.as_dvec3(), hit.t as f64);
    let facing = plane.normal.dot(direction);
    let exact = -plane.distance(origin) / facing;
    let t = if facing.abs() > 1e-6 && (exact - t).abs() < 1e-3 * t { exact } else { t };
    (Side { facet: hit.facet, back: plane.distance(origin) < 0.0 }, origin + direction * t)
}

/// Where in the pixel sample `index` of `count` lies: evenly spread, the first in the middle.
pub(super) fn sample_offset(index: u32, count: u32) -> (f32, f32) {
    if count == 1 {
        return (0.5, 0.5);
    }
    // The two-dimensional additive recurrence with the plastic number (Roberts, 2018).
    let at = |alpha: f64| (0.5 + alpha * index as f64).fract() as f32;
    (at(0.754_877_666_246_692_8), at(0.569_840_290_998_053_3))
}
