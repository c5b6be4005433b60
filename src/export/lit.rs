//! A solved scene as triangles with the light at their corners: what other programs can show. The triangles are those of
//! the elements, with the corners that neighbours have on their edges, so that no crack shows; both sides of a surface
//! have their own. They come in parts, one after the other, and the whole is never in memory.

use std::collections::HashMap;
use std::io;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::gather::{Outlines, Reconstruction};
use crate::hierarchy::{Hierarchy, Side};
use crate::image::tone::Tone;
use crate::progress::Progress;
use crate::radiosity::{Forest, Solution};
use crate::scene::{Camera, Scene};

/// Most vertices of a part: what 16 bits can number without the last number, which glTF keeps for itself.
const MOST_VERTICES: usize = 65_535;

/// So many elements are worked on at a time, or one side when that has more.
const AT_A_TIME: u32 = 1 << 14;

/// A scene with its light.
#[derive(Clone, Copy)]
pub struct LitScene<'a> {
    /// Gives the cameras and the unit of length.
    pub scene: &'a Scene,
    /// Gives the surfaces.
    pub hierarchy: &'a Hierarchy,
    /// Gives elements and irradiance.
    pub solution: &'a Solution,
}

/// How light becomes colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Multiplier on linear radiance, finite and > 0.
    pub exposure: f32,
    /// How exposed radiance becomes displayable.
    pub tone: Tone,
}

/// What was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exported {
    /// Triangles, of both sides of what has light on both.
    pub triangles: u64,
    /// Their corners; where several meet in the same light they share one.
    pub vertices: u64,
    /// Size of the file.
    pub bytes: u64,
}

/// A corner of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertex {
    /// In metres, from the origin of the [`LitScene`].
    pub(super) position: Vec3,
    /// W/m², linear RGB.
    pub(super) exitance: Vec3,
    /// 0 for a corner of elements; in the middle of one what [`Marks`] say.
    pub(super) mark: u8,
}

/// What the middle of an element is marked with, at least 1, by the id that links have of it; then all elements are divided from there, and it
/// is the last corner of each of their triangles.
pub(super) type Marks<'a> = &'a dyn Fn(u32) -> u8;

/// What a side of a surface is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Coat {
    /// Of the hierarchy.
    pub(super) material: u32,
    /// The side that does not emit, and that is the same as the other one but for its light.
    pub(super) is_back: bool,
}

/// Some of the triangles.
#[derive(Debug, Default)]
pub(super) struct Part {
    pub(super) vertices: Vec<Vertex>,
    /// Counter-clockwise seen from the lit side.
    pub(super) triangles: Vec<[u16; 3]>,
    /// What each of them is of.
    pub(super) coats: Vec<Coat>,
    /// The numbers of the vertices, by the bits of their values.
    numbers: HashMap<[u32; 7], u16>,
}

impl Display {
    /// Displayable linear RGB in `[0, 1]` of a surface that sends out this much light.
    pub(super) fn color(&self, exitance: Vec3) -> [f32; 3] {
        let radiance = exitance / std::f32::consts::PI;
        self.tone.displayable((radiance * self.exposure).to_array())
    }
}

impl LitScene<'_> {
    /// Where positions are measured from, in metres: the middle of the scene, so that single precision is spent on
    /// the scene and not on where it lies.
    pub(super) fn origin(&self) -> DVec3 {
        self.hierarchy.frame.scene_from_local(DVec3::ZERO) * self.scene.meters_per_unit
    }

    /// Where a camera stands, in metres from the origin.
    pub(super) fn eye(&self, camera: &Camera) -> DVec3 {
        camera.eye * self.scene.meters_per_unit - self.origin()
    }

    /// How far the nearest surface is from a camera, at least, in metres.
    pub(super) fn clearance(&self, camera: &Camera) -> f64 {
        let hierarchy = self.hierarchy;
        let eye = hierarchy.frame.local_from_scene(camera.eye).as_dvec3();
        let distance = |facet: usize| {
            let plane = &hierarchy.facets[facet].plane;
            let beside = hierarchy.polygon(facet as u32).outside_distance(eye, plane.normal).max(0.0);
            plane.distance(eye).hypot(beside)
        };
        let nearest = (0..hierarchy.facets.len()).map(distance).fold(f64::INFINITY, f64::min);
        nearest * self.meters_per_local()
    }

    /// What a side is of.
    pub(super) fn coat(&self, side: Side) -> Coat {
        Coat { material: self.hierarchy.facets[side.facet as usize].material, is_back: side.back }
    }

    /// The elements that triangles are made of.
    pub(super) fn shown(&self) -> &Forest {
        self.solution.display.as_ref().map_or(&self.solution.forest, |mesh| &mesh.forest)
    }

    fn meters_per_local(&self) -> f64 {
        self.hierarchy.frame.scene_units_per_local() * self.scene.meters_per_unit
    }

    /// All triangles, part by part. One unit of progress for each side of a surface.
    ///
    /// # Errors
    /// Those of `visit`; when positions are too large or too small for single precision.
    pub(super) fn for_each_part(
        &self,
        marks: Option<Marks<'_>>,
        progress: &dyn Progress,
        mut visit: impl FnMut(&Part) -> io::Result<()>,
    ) -> io::Result<()> {
        let reconstruction = Reconstruction::shown(self.hierarchy, self.solution);
        let forest = self.shown();
        let (first, sides) = (&forest.first_element, forest.side_count());
        let (mut part, mut begin, mut is_empty) = (Part::default(), 0, true);
        while begin < sides {
            let most = first[begin] + AT_A_TIME;
            let end = (begin + 1..sides).find(|&side| first[side + 1] > most).unwrap_or(sides);
            let outlines: Vec<Outlines> = (begin..end)
                .into_par_iter()
                .with_max_len(1)
                .map(|side| reconstruction.outlines(side))
                .collect();
            for (side, outlines) in (begin..end).zip(&outlines) {
                let coat = self.coat(forest.side(side));
                for triangle in self.triangles(side, outlines, marks) {
                    if !triangle
                        .iter()
                        .all(|corner| corner.position.is_finite() && corner.exitance.is_finite())
                    {
                        return Err(too_far());
                    }
                    if part.vertices.len() + 3 > MOST_VERTICES {
                        visit(&part)?;
                        part.clear();
                    }
                    is_empty &= !part.add(triangle, coat);
                }
            }
            progress.advance((end - begin) as u64);
            begin = end;
        }
        if is_empty {
            return Err(io::Error::other("the scene is too small for single precision"));
        }
        if !part.triangles.is_empty() {
            visit(&part)?;
        }
        Ok(())
    }

    /// The triangles of all elements of a side: an element that is no triangle, or has corners of others on its edges,
    /// is divided from its middle.
    fn triangles<'o>(
        &'o self,
        side: usize,
        outlines: &'o Outlines,
        marks: Option<Marks<'o>>,
    ) -> impl Iterator<Item = [Vertex; 3]> + 'o {
        let forest = self.shown();
        let reflectance = forest.reflectance(self.hierarchy, side);
        let side = forest.side(side);
        let (normal, emitted) = (self.hierarchy.side_normal(side), self.hierarchy.emitted(side));
        let meters = self.meters_per_local();
        let linked = self.solution.display.as_ref().map(|mesh| &mesh.linked[..]);
        outlines.iter().flat_map(move |outline| {
            let reflectance = reflectance.of(outline.element);
            let vertex = move |(point, irradiance): (DVec3, Vec3), mark: u8| Vertex {
                // Zero has one sign, so that what is the same has the same bits.
                position: (point * meters).as_vec3() + 0.0,
                exitance: emitted + reflectance * irradiance + 0.0,
                mark,
            };
            let count = outline.points.len();
            let corner =
                move |i: usize| vertex((outline.points[i % count], outline.irradiance[i % count]), 0);
            let linked = linked.map_or(outline.element, |linked| linked[outline.element as usize]);
            let mark = marks.map_or(0, |marks| marks(linked));
            let is_whole = count == 3 && marks.is_none();
            let middle = if is_whole { corner(2) } else { vertex(outline.center(normal), mark) };
            let edges = if is_whole { 0..1 } else { 0..count };
            edges.map(move |i| [corner(i), corner(i + 1), middle])
        })
    }
}

impl Part {
    fn clear(&mut self) {
        self.vertices.clear();
        self.triangles.clear();
        self.coats.clear();
        self.numbers.clear();
    }

    /// Adds a triangle, unless rounding has left nothing of it; whether it did.
    fn add(&mut self, corners: [Vertex; 3], coat: Coat) -> bool {
        let [a, b, c] = corners.map(|corner| corner.position);
        if a == b || b == c || c == a {
            return false;
        }
        let triangle = corners.map(|corner| {
            let [x, y, z] = corner.position.to_array().map(f32::to_bits);
            let [red, green, blue] = corner.exitance.to_array().map(f32::to_bits);
            *self.numbers.entry([x, y, z, red, green, blue, corner.mark.into()]).or_insert_with(|| {
                self.vertices.push(corner);
                (self.vertices.len() - 1) as u16
            })
        });
        self.triangles.push(triangle);
        self.coats.push(coat);
        true
    }
}

pub(super) fn too_far() -> io::Error {
    io::Error::other("numbers of the scene are too large for single precision")
}
