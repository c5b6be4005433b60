//! Boxes, panels and round things in frames that stand anywhere, turned about the vertical.

use std::f64::consts::TAU;
use std::io::Write;

use glam::{DVec3, dvec3};

use super::obj_writer::ObjWriter;

/// A place and a direction: local x and z are turned about y.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    origin: DVec3,
    cos: f64,
    sin: f64,
}

impl Frame {
    pub(super) const WORLD: Self = Self { origin: DVec3::ZERO, cos: 1.0, sin: 0.0 };

    /// The world position of a local point.
    pub(super) fn point(&self, p: DVec3) -> DVec3 {
        self.origin + dvec3(self.cos * p.x + self.sin * p.z, p.y, self.cos * p.z - self.sin * p.x)
    }

    /// A frame in this one, at `origin`, turned by whole quarters: exact.
    pub(super) fn quarter(&self, origin: DVec3, quarters: u8) -> Self {
        let (cos, sin) = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][usize::from(quarters % 4)];
        self.turned(origin, cos, sin)
    }

    /// A frame in this one, at `origin`, turned by any angle in radians.
    pub(super) fn turn(&self, origin: DVec3, angle: f64) -> Self {
        self.turned(origin, angle.cos(), angle.sin())
    }

    fn turned(&self, origin: DVec3, cos: f64, sin: f64) -> Self {
        Self {
            origin: self.point(origin),
            cos: self.cos * cos - self.sin * sin,
            sin: self.sin * cos + self.cos * sin,
        }
    }
}

/// Sides of a box, to leave out those that touch something: hidden coplanar surfaces help nobody.
pub(super) const LEFT: u8 = 1;
pub(super) const RIGHT: u8 = 2;
pub(super) const BOTTOM: u8 = 4;
pub(super) const TOP: u8 = 8;
pub(super) const BACK: u8 = 16;
pub(super) const FRONT: u8 = 32;

/// Corners of the six sides: bits 1, 2 and 4 of a corner stand for high x, y and z.
const SIDES: [[u8; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

impl<W: Write> ObjWriter<W> {
    /// A box between two local corners, seen from outside, without the sides in `omit`.
    pub(super) fn cuboid(&mut self, frame: &Frame, low: DVec3, high: DVec3, omit: u8) {
        let mut corners = [DVec3::ZERO; 8];
        for (i, corner) in corners.iter_mut().enumerate() {
            let pick = |bit: usize, low: f64, high: f64| if i & bit == 0 { low } else { high };
            *corner =
                frame.point(dvec3(pick(1, low.x, high.x), pick(2, low.y, high.y), pick(4, low.z, high.z)));
        }
        let shown = SIDES.iter().enumerate().filter(|(side, _)| omit >> side & 1 == 0);
        self.faces(&corners, shown.map(|(_, side)| &side[..]));
    }

    /// A flat polygon, counter-clockwise from its front.
    pub(super) fn panel(&mut self, frame: &Frame, corners: [DVec3; 4]) {
        self.faces(&corners.map(|corner| frame.point(corner)), [&[0, 1, 2, 3][..]]);
    }

    /// The side of a cone frustum about the vertical through `base`, seen from outside.
    pub(super) fn tube(&mut self, frame: &Frame, base: DVec3, height: f64, radii: [f64; 2], segments: u8) {
        let mut vertices = Vec::with_capacity(2 * usize::from(segments));
        for (radius, y) in [(radii[0], 0.0), (radii[1], height)] {
            vertices.extend(ring(frame, base + DVec3::Y * y, radius, segments));
        }
        let sides: Vec<[u8; 4]> = (0..segments)
            .map(|i| {
                let next = (i + 1) % segments;
                [i, i + segments, next + segments, next]
            })
            .collect();
        self.faces(&vertices, sides.iter().map(|side| &side[..]));
    }

    /// A horizontal disc that faces up, or down.
    pub(super) fn disc(&mut self, frame: &Frame, center: DVec3, radius: f64, segments: u8, is_up: bool) {
        let vertices: Vec<DVec3> = ring(frame, center, radius, segments).collect();
        let mut corners: Vec<u8> = (0..segments).collect();
        if is_up {
            corners.reverse();
        }
        self.faces(&vertices, [&corners[..]]);
    }

    /// A closed cylinder standing on something: side and top.
    pub(super) fn cylinder(&mut self, frame: &Frame, base: DVec3, height: f64, radius: f64, segments: u8) {
        self.tube(frame, base, height, [radius, radius], segments);
        self.disc(frame, base + DVec3::Y * height, radius, segments, true);
    }

    /// An open vessel with a wall, a rim and a bottom inside.
    pub(super) fn vessel(&mut self, frame: &Frame, base: DVec3, height: f64, radii: [f64; 2], segments: u8) {
        let wall = 0.08 * radii[1];
        let inner = [radii[0] - wall, radii[1] - wall];
        self.tube(frame, base, height, radii, segments);
        let top = base + DVec3::Y * height;
        // The rim is a frustum without height, and the inside one that goes down.
        self.tube(frame, top, 0.0, [radii[1], inner[1]], segments);
        let depth = 0.92 * height;
        self.tube(frame, top, -depth, [inner[1], inner[0]], segments);
        self.disc(frame, top - DVec3::Y * depth, inner[0], segments, true);
    }
}

/// Points on a circle, from above clockwise.
fn ring(frame: &Frame, center: DVec3, radius: f64, segments: u8) -> impl Iterator<Item = DVec3> {
    (0..segments).map(move |i| {
        let angle = TAU * f64::from(i) / f64::from(segments);
        frame.point(center + radius * dvec3(angle.cos(), 0.0, angle.sin()))
    })
}
