//! Segments to trace: random ones, and those that are hard to decide.

use crate::tracer::{NO_FACET, Segment, TraceMesh};
use glam::{DVec3, Vec3};

/// A small deterministic generator of numbers in `[0, 1)`.
pub struct Numbers(pub u64);

impl Numbers {
    /// The next number; 24 bits, so that it is exact in single precision.
    pub fn next_number(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    /// An index below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.next_number() * count as f32) as usize).min(count - 1)
    }

    /// Anywhere in the cube from −1 to 1.
    pub fn point(&mut self) -> Vec3 {
        Vec3::new(self.next_number(), self.next_number(), self.next_number()) * 2.0 - 1.0
    }
}

/// What a segment does to some triangle of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Family {
    /// Goes through one of its edges.
    Edge,
    /// Goes through one of its corners.
    Corner,
    /// Passes one of its edges at this distance, inside or outside.
    Beside(f32),
    /// Lies in its plane.
    InPlane,
    /// Goes through it at this angle to its plane.
    Grazing(f32),
    /// Begins on it.
    EndOn,
    /// Begins on it, and the facet is named as the one it begins on.
    EndSkipped,
}

/// Every family, and every distance and angle that is tried.
pub const FAMILIES: [Family; 14] = [
    Family::Edge,
    Family::Corner,
    Family::Beside(1e-7),
    Family::Beside(1e-6),
    Family::Beside(1e-5),
    Family::Beside(1e-4),
    Family::Beside(1e-3),
    Family::InPlane,
    Family::Grazing(1e-3),
    Family::Grazing(1e-4),
    Family::Grazing(1e-5),
    Family::Grazing(1e-6),
    Family::EndOn,
    Family::EndSkipped,
];

impl Family {
    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Family::Edge => "through edges",
            Family::Corner => "through corners",
            Family::Beside(_) => "close beside edges",
            Family::InPlane => "in the plane of a triangle",
            Family::Grazing(_) => "grazing",
            Family::EndOn => "with an end on a triangle",
            Family::EndSkipped => "with an end on a triangle that is named",
        }
    }
}

/// `count` segments of one family, each about a random triangle of the mesh.
pub fn segments(mesh: &TraceMesh, family: Family, count: usize, seed: u64) -> Vec<Segment> {
    let mut numbers = Numbers(seed);
    (0..count)
        .map(|_| {
            let triangle = numbers.below(mesh.triangles.len());
            let turn = numbers.below(3);
            let corner =
                |i: usize| mesh.positions[mesh.triangles[triangle][(i + turn) % 3] as usize].as_dvec3();
            let (a, b, c) = (corner(0), corner(1), corner(2));
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let (s, t) = (numbers.next_number() as f64, numbers.next_number() as f64);
            let inside = a + (b - a) * (s.sqrt() * (1.0 - t)) + (c - a) * (s.sqrt() * t);
            let mut through = |point: DVec3| {
                let from = numbers.point();
                let beyond = 1.2 + numbers.next_number();
                (from, from + (point.as_vec3() - from) * beyond)
            };
            let (from, to) = match family {
                Family::Edge => through(a.lerp(b, s)),
                Family::Corner => through(a),
                Family::Beside(distance) => {
                    let outwards = (b - a).cross(normal).normalize_or_zero();
                    let sign = if t < 0.5 { 1.0 } else { -1.0 };
                    through(a.lerp(b, s) + outwards * (sign * distance as f64))
                }
                Family::InPlane => {
                    let mut anywhere = || {
                        let (u, v) = (3.0 * numbers.next_number() - 1.0, 3.0 * numbers.next_number() - 1.0);
                        (a + (b - a) * u as f64 + (c - a) * v as f64).as_vec3()
                    };
                    (anywhere(), anywhere())
                }
                Family::Grazing(angle) => {
                    let along = (b + (c - b) * numbers.next_number() as f64 - inside).normalize_or_zero();
                    let (sin, cos) = (angle as f64).sin_cos();
                    let direction = along * cos + normal * sin;
                    let (before, after) = (numbers.next_number() as f64, numbers.next_number() as f64);
                    ((inside - direction * before).as_vec3(), (inside + direction * after).as_vec3())
                }
                Family::EndOn | Family::EndSkipped => (inside.as_vec3(), numbers.point()),
            };
            let skipped =
                if family == Family::EndSkipped { mesh.facet_of_triangle[triangle] } else { NO_FACET };
            Segment { from, to, skip: [skipped, NO_FACET] }
        })
        .collect()
}

/// `count` segments between points anywhere in the cube from −1 to 1; some along an axis, some very short.
pub fn random_segments(count: usize, seed: u64) -> Vec<Segment> {
    let mut numbers = Numbers(seed);
    (0..count)
        .map(|i| {
            let from = numbers.point();
            let to = match i % 8 {
                0 => from + Vec3::X * (numbers.next_number() - 0.5),
                1 => from - Vec3::Y * numbers.next_number(),
                2 => from + Vec3::new(-0.0, -0.0, -1.0) * numbers.next_number(),
                3 => from + numbers.point() * 1e-3,
                _ => numbers.point(),
            };
            Segment { from, to, skip: [NO_FACET; 2] }
        })
        .collect()
}

/// `count` segments that begin 10 to 10 000 times as far away as the scene is large, and end in it or beyond.
pub fn far_segments(count: usize, seed: u64) -> Vec<Segment> {
    let mut numbers = Numbers(seed);
    (0..count)
        .map(|_| {
            let from = numbers.point().normalize_or(Vec3::X) * 10f32.powf(1.0 + 3.0 * numbers.next_number());
            let to = numbers.point();
            let beyond = if numbers.next_number() < 0.5 { 0.0 } else { 4.0 };
            let to = to + (to - from).normalize_or_zero() * beyond;
            Segment { from, to, skip: [NO_FACET; 2] }
        })
        .collect()
}
