//! Form factors from a point to a polygon, by Lambert's contour formula. [CW93]

use crate::math::{Plane, Polygon};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// A source that looks smaller than this (extent over distance, squared) is taken as a point: the
/// error is of the same order, below one per cent.
const SMALL: f64 = 0.02;

/// What every form factor to a polygon needs, besides its outline.
#[derive(Clone, Copy, Debug)]
pub struct SourceShape {
    front: Plane,
    center: DVec3,
    extent: f64,
    area: f64,
}

impl SourceShape {
    /// Of a source that shines to the front of its plane.
    pub fn of(polygon: &Polygon, front: Plane) -> SourceShape {
        let (center, extent, area) = (polygon.center(), polygon.extent(), polygon.area());
        SourceShape { front, center, extent, area }
    }

    /// Whether its extent over its distance from a point, squared, is more than `limit`.
    pub fn looks_larger(&self, limit: f64, point: DVec3) -> bool {
        self.extent * self.extent > limit * self.center.distance_squared(point)
    }

    /// As [`PolygonSource::form_factor`]; `polygon` is what the shape was made of.
    pub fn form_factor(&self, polygon: &Polygon, point: DVec3, normal: DVec3) -> f64 {
        let height = self.front.distance(point);
        if height <= 0.0 {
            return 0.0;
        }
        let to_center = self.center - point;
        let distance_squared = to_center.length_squared();
        let above = normal.dot(to_center);
        if self.extent * self.extent < SMALL * distance_squared && above.abs() > self.extent {
            // cos θr · cos θs · A / (π d²)
            return if above > 0.0 {
                above * height * self.area / (PI * distance_squared * distance_squared)
            } else {
                0.0
            };
        }
        let horizon = Plane::through(point, normal);
        let heights = polygon.vertices().iter().map(|&v| horizon.distance(v));
        let (low, high) = heights.fold((f64::MAX, f64::MIN), |(low, high), h| (low.min(h), high.max(h)));
        if low >= 0.0 {
            return contour(point, normal, polygon);
        }
        let visible = if high > 0.0 { polygon.clipped(&horizon) } else { None };
        visible.map_or(0.0, |visible| contour(point, normal, &visible))
    }
}

/// A polygon that sends light, with what every form factor to it needs.
#[derive(Clone, Copy, Debug)]
pub struct PolygonSource<'a> {
    polygon: &'a Polygon,
    shape: SourceShape,
}

impl<'a> PolygonSource<'a> {
    /// A source that shines to the front of its plane.
    pub fn new(polygon: &'a Polygon, front: Plane) -> PolygonSource<'a> {
        PolygonSource { polygon, shape: SourceShape::of(polygon, front) }
    }

    /// Centre of the source.
    pub fn center(&self) -> DVec3 {
        self.shape.center
    }

    /// Size of the source, see [`Polygon::extent`].
    pub fn extent(&self) -> f64 {
        self.shape.extent
    }

    /// Fraction of the light leaving a surface at `point`, uniformly in radiance, that reaches the
    /// source; 0 to 1, without occlusion. Also the irradiance at `point` for unit exitance of the
    /// source.
    ///
    /// `normal` is the unit normal at the point. Both sides of the pair have to face each other, and
    /// what lies below the receiver's horizon does not count.
    pub fn form_factor(&self, point: DVec3, normal: DVec3) -> f64 {
        self.shape.form_factor(self.polygon, point, normal)
    }
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
            normal.dot(cross) / length * angle(length, a.dot(b))
        })
        .sum();
    // Seen from the point a source's outline runs clockwise.
    (sum.abs() / TAU).min(1.0)
}

/// The arc tangents of 0, 1/4, 1/2, 3/4 and 1.
const ARC_TANGENTS: [f64; 5] =
    [0.0, 0.244_978_663_126_864_15, 0.463_647_609_000_806_1, 0.643_501_108_793_284_4, FRAC_PI_4];

/// `atan2(sine, cosine)` for a sine that is not negative, to 1e-14 and without a branch: most of the work for a form
/// factor is this.
///
/// With `x` the smaller over the larger of both and `c` the nearest of the quarters, atan x = atan c +
/// atan((x − c) / (1 + c·x)), and the last argument is below 1/8: eight terms of its series do.
fn angle(sine: f64, cosine: f64) -> f64 {
    let steep = sine > cosine.abs();
    let (small, large) = if steep { (cosine.abs(), sine) } else { (sine, cosine.abs()) };
    let nearest = [1.0, 3.0, 5.0, 7.0].map(|eighths| usize::from(8.0 * small > eighths * large));
    let nearest = nearest[0] + nearest[1] + nearest[2] + nearest[3];
    let quarter = 0.25 * nearest as f64;
    let rest = (small - quarter * large) / (large + quarter * small);
    let square = rest * rest;
    let series =
        [13.0, 11.0, 9.0, 7.0, 5.0, 3.0, 1.0].iter().fold(1.0 / 15.0, |sum, n| 1.0 / n - square * sum);
    let acute = ARC_TANGENTS[nearest] + rest * series;
    let first = if steep { FRAC_PI_2 - acute } else { acute };
    if cosine < 0.0 { PI - first } else { first }
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
            let f = PolygonSource::new(&source, front(&source)).form_factor(DVec3::ZERO, DVec3::Z);
            let (x, y): (f64, f64) = (a / c, b / c);
            let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
            let exact = (x / p * (y / p).atan() + y / q * (x / q).atan()) / TAU;
            assert!((f - exact).abs() < 1e-12, "{f} for {exact}");
        }
    }

    #[test]
    fn below_the_horizon_or_behind_the_source_is_nothing() {
        let source = rectangle(1.0, 1.0, 1.0);
        assert_eq!(PolygonSource::new(&source, front(&source)).form_factor(DVec3::ZERO, -DVec3::Z), 0.0);
        let turned = source.flipped();
        assert_eq!(PolygonSource::new(&turned, front(&turned)).form_factor(DVec3::ZERO, DVec3::Z), 0.0);
    }

    #[test]
    fn angles_are_those_of_the_library() {
        for i in 0..=100_000 {
            let (sine, cosine) = (i as f64 * PI / 100_000.0).sin_cos();
            for scale in [1e-30, 1.0, 7e20] {
                let (y, x) = (sine.max(0.0) * scale, cosine * scale);
                assert!((angle(y, x) - y.atan2(x)).abs() < 2e-14, "{y} {x}");
            }
        }
    }

    #[test]
    fn half_sunk_source_counts_half() {
        // A wall seen from the floor, and the same wall continued below the floor.
        let wall = |low: f64| {
            Polygon::new(
                &[(-1.0, low), (-1.0, 1.0), (1.0, 1.0), (1.0, low)].map(|(y, z)| DVec3::new(2.0, y, z)),
            )
        };
        let [whole, sunk] = [wall(0.0), wall(-1.0)].map(|w| {
            let w = if front(&w).distance(DVec3::ZERO) > 0.0 { w } else { w.flipped() };
            PolygonSource::new(&w, front(&w)).form_factor(DVec3::ZERO, DVec3::Z)
        });
        assert!(whole > 0.01 && (whole - sunk).abs() < 1e-12);
    }

    #[test]
    fn small_and_exact_agree_where_they_meet() {
        let size = 0.2;
        for height in [1.9, 2.0, 2.1, 3.0] {
            let source = rectangle(size, size, height);
            let f = PolygonSource::new(&source, front(&source)).form_factor(DVec3::ZERO, DVec3::Z);
            let exact = contour(DVec3::ZERO, DVec3::Z, &source);
            assert!((f / exact - 1.0).abs() < 1e-2, "{f} for {exact}");
        }
    }
}
