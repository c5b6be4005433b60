//! Form factors from a point, written for the tests from their sources and sharing no code with the
//! program. A failure here means that the other tests of this suite compare with something wrong.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// Irradiance at a point with unit `normal` from a convex polygon of unit exitance that shines on it:
/// Lambert's formula (1760), the sum over the edges of the angle they span, times the cosine of the
/// plane through edge and point against the horizon. What is below the horizon is cut away first.
pub(crate) fn polygon(point: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let seen: Vec<DVec3> = corners.iter().map(|&corner| corner - point).collect();
    let mut above = Vec::new();
    for (i, &a) in seen.iter().enumerate() {
        let b = seen[(i + 1) % seen.len()];
        let (height_a, height_b) = (a.dot(normal), b.dot(normal));
        if height_a >= 0.0 {
            above.push(a);
        }
        if height_a * height_b < 0.0 {
            above.push((a * height_b - b * height_a) / (height_b - height_a));
        }
    }
    let sum: f64 = (0..above.len())
        .map(|i| {
            let (a, b) = (above[i].normalize(), above[(i + 1) % above.len()].normalize());
            a.dot(b).clamp(-1.0, 1.0).acos() * a.cross(b).normalize_or_zero().dot(normal)
        })
        .sum();
    sum.abs() / TAU
}

/// The same for a rectangle in a plane parallel to the surface at height `h`; `x` and `y` are the
/// intervals it takes up there, seen from the foot of the perpendicular. Howell, A catalogue of
/// radiation configuration factors, B-3, for each corner in turn.
pub(crate) fn level_rectangle(x: [f64; 2], y: [f64; 2], h: f64) -> f64 {
    if x[1] <= x[0] || y[1] <= y[0] {
        return 0.0;
    }
    let corner = |x: f64, y: f64| {
        let (x, y) = (x / h, y / h);
        let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        (x / p * (y / p).atan() + y / q * (x / q).atan()) / TAU
    };
    corner(x[1], y[1]) - corner(x[0], y[1]) - corner(x[1], y[0]) + corner(x[0], y[0])
}

/// Two sources, one answer; the tolerance is rounding.
#[test]
fn lambert_and_the_catalogue_agree() {
    for (x, y, h) in
        [([0.0, 1.0], [0.0, 1.0], 1.0), ([-0.5, 2.0], [0.3, 0.9], 0.4), ([3.0, 4.0], [-9.0, 9.0], 2.0)]
    {
        let corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])];
        let lambert = polygon(DVec3::ZERO, DVec3::Z, &corners.map(|(x, y)| DVec3::new(x, y, h)));
        let catalogue = level_rectangle(x, y, h);
        assert!((lambert - catalogue).abs() < 1e-12, "{lambert} and {catalogue}");
    }
}

/// A wall without end, in a plane that is upright on the surface, fills half the sky of a point at its
/// foot: form factor ½. The tolerance is what a wall 10⁴ times as large as its distance leaves out.
#[test]
fn an_endless_wall_fills_half_the_sky() {
    let far = 1e4;
    let wall = [(-far, -far), (far, -far), (far, far), (-far, far)].map(|(y, z)| DVec3::new(1.0, y, z));
    let found = polygon(DVec3::ZERO, DVec3::Z, &wall);
    assert!((found - 0.5).abs() < 1e-3, "{found}");
    assert!((polygon(DVec3::ZERO, DVec3::X, &wall) * PI - PI).abs() < 1e-3, "straight ahead it fills it all");
}
