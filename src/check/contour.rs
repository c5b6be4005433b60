//! The form factor of two polygons, by turning both area integrals into integrals along their outlines
//! (Stokes' theorem, twice): another way than the solver's, which takes one outline and a few points.
//! \[CW93\]

use crate::math::{Plane, Polygon};
use glam::DVec3;
use std::f64::consts::TAU;

/// Nodes and weights of the Gauss–Legendre quadrature with 8 points on (−1, 1), positive half.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
];

/// Equal parts that an edge near the other polygon is cut into.
const PARTS: usize = 4;

/// An edge whose middle is further away than so many of its lengths is taken in one part: no singularity of the integrand is
/// nearer than three halves of the edge, and 8 points are right to ten digits.
const FAR: f64 = 1.5;

/// A polygon that lies in a plane; the front is the lit side.
pub(super) struct Surface {
    pub(super) polygon: Polygon,
    pub(super) plane: Plane,
}

/// Area of `a` times the form factor from it to `b`: equal to what it is from `b` to `a`. Parts that are
/// behind the other's plane do not count; nothing is taken to stand in between.
pub(super) fn exchange(a: &Surface, b: &Surface) -> f64 {
    let (Some(of_a), Some(of_b)) = (a.polygon.clipped(&b.plane), b.polygon.clipped(&a.plane)) else {
        return 0.0;
    };
    let (middle, radius) = (of_b.center(), 0.5 * of_b.extent());
    let sum: f64 = of_a
        .edges()
        .map(|(start, end)| {
            // No point of the other polygon is nearer to the middle of the edge.
            let way = middle.distance((start + end) * 0.5) - radius;
            let parts = if way > FAR * start.distance(end) { 1 } else { PARTS };
            let step = (end - start) / parts as f64;
            let inner: DVec3 = (0..parts)
                .flat_map(|part| {
                    let middle = start + step * (part as f64 + 0.5);
                    GAUSS.into_iter().flat_map(move |(node, weight)| {
                        [-node, node].map(|node| (middle + step * (0.5 * node), weight))
                    })
                })
                .map(|(point, weight)| along_outline(point, &of_b) * weight)
                .sum();
            // The weights of a part add up to 2.
            inner.dot(step) * 0.5
        })
        .sum();
    (sum / TAU).max(0.0)
}

/// ∮ ln|y − x| dy along the outline.
fn along_outline(x: DVec3, outline: &Polygon) -> DVec3 {
    outline
        .edges()
        .map(|(start, end)| {
            let length = start.distance(end);
            if length <= 0.0 {
                return DVec3::ZERO;
            }
            let direction = (end - start) / length;
            let before = (x - start).dot(direction);
            let height = (x - start - direction * before).length();
            let primitive = |t: f64| {
                let squared = t * t + height * height;
                if squared <= 0.0 { 0.0 } else { 0.5 * t * squared.ln() - t + height * t.atan2(height) }
            };
            direction * (primitive(length - before) - primitive(-before))
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(points: [[f64; 3]; 4]) -> Surface {
        let polygon = Polygon::new(&points.map(DVec3::from_array));
        Surface { polygon, plane: Plane::through(polygon.center(), polygon.area_vector().normalize()) }
    }

    fn floor() -> Surface {
        surface([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    }

    /// Howell, A catalogue of radiation configuration factors, C-11 and C-14, for unit squares.
    #[test]
    fn unit_squares_exchange_what_the_catalogue_says() {
        let above = surface([[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]]);
        let beside = surface([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]]);
        assert!((exchange(&floor(), &above) - 0.199_825).abs() < 1e-6);
        assert!((exchange(&floor(), &beside) - 0.200_044).abs() < 2e-5);
        assert!((exchange(&beside, &floor()) - 0.200_044).abs() < 2e-5);
    }

    #[test]
    fn far_apart_it_is_the_kernel() {
        let far = surface([[0.0, 0.0, 500.0], [0.0, 1.0, 500.0], [1.0, 1.0, 500.0], [1.0, 0.0, 500.0]]);
        let kernel = 1.0 / (std::f64::consts::PI * 250_000.0);
        assert!((exchange(&floor(), &far) / kernel - 1.0).abs() < 1e-4);
    }

    #[test]
    fn what_is_behind_does_not_count() {
        let sunk = surface([[0.0, 0.0, -1.0], [0.0, 1.0, -1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]]);
        assert!((exchange(&floor(), &sunk) - 0.200_044).abs() < 2e-5);
        let turned = surface([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]);
        assert_eq!(exchange(&floor(), &turned), 0.0);
    }
}
