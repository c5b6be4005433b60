//! What pictures show besides radiance: for each pixel what lies in its middle, and the light there.

use super::camera::Lens;
use super::mesh_view::light_by_class;
use super::render::{Renderer, Shown, met};
use crate::scene::Camera;
use crate::tracer::{Hit, PACKET, Ray};
use rayon::prelude::*;

/// In the place of an element where there is none.
pub const NOTHING: u32 = u32::MAX;

/// Values for each pixel, row by row, top row first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Irradiance, interpolated over the elements, W/m².
    pub irradiance: Vec<[f32; 3]>,
    /// Reflectance.
    pub albedo: Vec<[f32; 3]>,
    /// Distance from the plane of the eye, scene units; infinite where nothing is seen.
    pub depth: Vec<f32>,
    /// Unit normal of the side that is seen; 0 where nothing is.
    pub normal: Vec<[f32; 3]>,
    /// Element, or [`NOTHING`].
    pub element: Vec<u32>,
    /// Class of the links that bring most light there: 0 no light, 1 visible, 2 certified visible, 3 partial.
    pub class: Vec<u32>,
}

/// Makes the layers of any number of pictures.
pub struct LayerMaker<'a> {
    shown: Shown<'a>,
    /// For each node, what it and the nodes above it receive by class.
    light: Vec<[f32; 4]>,
}

/// What one pixel shows.
#[derive(Clone, Copy)]
struct Seen {
    irradiance: [f32; 3],
    albedo: [f32; 3],
    depth: f32,
    normal: [f32; 3],
    element: u32,
    class: u32,
}

const NOTHING_SEEN: Seen = Seen {
    irradiance: [0.0; 3],
    albedo: [0.0; 3],
    depth: f32::INFINITY,
    normal: [0.0; 3],
    element: NOTHING,
    class: 0,
};

impl<'a> LayerMaker<'a> {
    /// For pictures of this renderer.
    pub fn new(renderer: &'a Renderer<'a>) -> LayerMaker<'a> {
        let shown = renderer.shown();
        LayerMaker { light: light_by_class(shown.hierarchy, shown.solution), shown }
    }

    /// The layers of the picture that a camera takes, with one ray through the middle of each pixel.
    pub fn layers(&self, camera: &Camera) -> Layers {
        let lens = Lens::new(camera, &self.shown.hierarchy.frame);
        let rows: Vec<Vec<Seen>> =
            (0..camera.height).into_par_iter().map(|y| self.row(camera, &lens, y)).collect();
        let mut layers = Layers::default();
        for seen in rows.into_iter().flatten() {
            layers.irradiance.push(seen.irradiance);
            layers.albedo.push(seen.albedo);
            layers.depth.push(seen.depth);
            layers.normal.push(seen.normal);
            layers.element.push(seen.element);
            layers.class.push(seen.class);
        }
        layers
    }

    fn row(&self, camera: &Camera, lens: &Lens, y: u32) -> Vec<Seen> {
        let rays: Vec<Ray> = (0..camera.width).map(|x| lens.ray(x as f32 + 0.5, y as f32 + 0.5)).collect();
        let mut row = Vec::with_capacity(rays.len());
        for rays in rays.chunks(PACKET) {
            let mut hits = [None; PACKET];
            self.shown.tracer.first_hits(rays, &mut hits[..rays.len()]);
            let seen = |(ray, hit): (&Ray, &Option<Hit>)| {
                hit.as_ref().map_or(NOTHING_SEEN, |hit| self.seen(camera, ray, hit))
            };
            row.extend(rays.iter().zip(&hits).map(seen));
        }
        row
    }

    fn seen(&self, camera: &Camera, ray: &Ray, hit: &Hit) -> Seen {
        let Shown { hierarchy, solution, surfaces, .. } = self.shown;
        let (side, point) = met(hierarchy, ray, hit);
        let forward = (camera.target - camera.eye).normalize();
        let depth = (point - ray.origin.as_dvec3()).dot(forward) * hierarchy.frame.scene_units_per_local();
        let (depth, normal) = (depth as f32, hierarchy.side_normal(side).as_vec3().to_array());
        // The back of a one-sided surface is black.
        let Some(spot) = surfaces.look_up(side, point) else {
            return Seen { depth, normal, ..NOTHING_SEEN };
        };
        // What is shown may be of elements for display.
        let linked = solution.forest.leaf_at(hierarchy, side, point).map_or(spot.element, |leaf| leaf.id);
        let light = &self.light[hierarchy.nodes.len() + linked as usize];
        let most =
            (1..light.len()).fold(0, |most, class| if light[class] > light[most] { class } else { most });
        Seen {
            irradiance: spot.irradiance.to_array(),
            albedo: hierarchy.reflectance_at(side.facet, point).to_array(),
            depth,
            normal,
            element: linked,
            class: most as u32,
        }
    }
}
