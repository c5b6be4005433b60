//! Form factors from a point to a polygon, by Lambert's contour formula. [CW93]

use crate::math::{Plane, Polygon};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A source that looks smaller than this (extent over distance, squared) is taken as a point: the
/// error is of the same order, below half a per cent.
const SMALL: f64 = 0.01;

/// Fraction of the light leaving a surface at `point`, uniformly in radiance, that reaches `source`;
/// 0 to 1, without occlusion. Also the irradiance at `point` for unit exitance of the source.
///
/// `receiver` is the plane at the point, facing the light; `front` is the source's plane. Both sides
/// of the pair have to face each other, and what lies below the receiver's horizon does not count.
pub fn point_form_factor(point: DVec3, receiver: &Plane, source: &Polygon, front: &Plane) -> f64 {
    let height = front.distance(point);
    if height <= 0.0 {
        return 0.0;
    }
    let center = source.center();
    let to_center = center - point;
    let distance_squared = to_center.length_squared();
    let extent = source.extent();
    let above = receiver.normal.dot(to_center);
    if extent * extent < SMALL * distance_squared && above.abs() > extent {
        // cos θr · cos θs · A / (π d²)
        return if above > 0.0 {
            above * height * source.area() / (PI * distance_squared * distance_squared)
        } else {
            0.0
        };
    }
    let horizon = Plane::through(point, receiver.normal);
    if source.vertices().iter().all(|&v| horizon.distance(v) >= 0.0) {
        return contour(point, receiver.normal, source);
    }
    source.clipped(&horizon).map_or(0.0, |visible| contour(point, receiver.normal, &visible))
}

fn contour(point: DVec3, normal: DVec3, source: &Polygon) -> f64 {
    let sum: f64 = source
        .edges()
        .map(|(a, b)| {
            let (a, b) = (a - point, b - point);
            let cross = a.cross(b);
            let length = cross.length();
            // The point lies on the line of the edge: no angle, no contribution.
            if length <= 0.0 {
                return 0.0;
            }
            normal.dot(cross) / length * length.atan2(a.dot(b))
        })
        .sum();
    // Seen from the point a source's outline runs clockwise.
    (sum.abs() / TAU).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(a: f64, b: f64, c: f64) -> Polygon {
        Polygon::new(&[(0.0, 0.0), (0.0, b), (a, b), (a, 0.0)].map(|(x, y)| DVec3::new(x, y, c)))
    }

    fn front(p: &Polygon) -> Plane {
        Plane::through(p.center(), p.area_vector().normalize())
    }

    /// Parallel rectangle with a corner straight above the point: Howell, catalogue of radiation
    /// configuration factors, B-3.
    #[test]
    fn rectangle_above_the_point() {
        for (a, b, c) in [(1.0, 1.0, 1.0), (0.5, 2.0, 0.3), (3.0, 0.1, 0.7)] {
            let source = rectangle(a, b, c);
            let up = Plane::through(DVec3::ZERO, DVec3::Z);
            let f = point_form_factor(DVec3::ZERO, &up, &source, &front(&source));
            let (x, y): (f64, f64) = (a / c, b / c);
            let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
            let exact = (x / p * (y / p).atan() + y / q * (x / q).atan()) / TAU;
            assert!((f - exact).abs() < 1e-12, "{f} for {exact}");
        }
    }

    #[test]
    fn below_the_horizon_or_behind_the_source_is_nothing() {
        let source = rectangle(1.0, 1.0, 1.0);
        let down = Plane::through(DVec3::ZERO, -DVec3::Z);
        assert_eq!(point_form_factor(DVec3::ZERO, &down, &source, &front(&source)), 0.0);
        let up = Plane::through(DVec3::ZERO, DVec3::Z);
        assert_eq!(point_form_factor(DVec3::ZERO, &up, &source.flipped(), &front(&source.flipped())), 0.0);
    }

    #[test]
    fn half_sunk_source_counts_half() {
        // A wall seen from the floor, and the same wall continued below the floor.
        let wall = |low: f64| {
            Polygon::new(
                &[(-1.0, low), (-1.0, 1.0), (1.0, 1.0), (1.0, low)].map(|(y, z)| DVec3::new(2.0, y, z)),
            )
        };
        let up = Plane::through(DVec3::ZERO, DVec3::Z);
        let [whole, sunk] = [wall(0.0), wall(-1.0)].map(|w| {
            let w = if front(&w).distance(DVec3::ZERO) > 0.0 { w } else { w.flipped() };
            point_form_factor(DVec3::ZERO, &up, &w, &front(&w))
        });
        assert!(whole > 0.01 && (whole - sunk).abs() < 1e-12);
    }

    #[test]
    fn small_and_exact_agree_where_they_meet() {
        let up = Plane::through(DVec3::ZERO, DVec3::Z);
        let size = 0.2;
        for height in [2.9, 3.0, 3.1] {
            let source = rectangle(size, size, height);
            let f = point_form_factor(DVec3::ZERO, &up, &source, &front(&source));
            let exact = contour(DVec3::ZERO, DVec3::Z, &source);
            assert!((f / exact - 1.0).abs() < 5e-3, "{f} for {exact}");
        }
    }
}
