//! Smooth interpolation inside a convex outline that may have vertices in the middle of its edges.

use glam::{DVec3, Vec3};

/// Mean value coordinates (Floater, 2003): linear along every edge between neighbouring vertices, so
/// that two outlines which share their vertices along an edge agree on it and no crack shows.
///
/// `outline` is counter-clockwise about `normal`, at least 3 vertices; `value` gives the value at each.
pub(super) fn mean_value(
    point: DVec3,
    normal: DVec3,
    outline: &[DVec3],
    value: impl Fn(usize) -> Vec3,
) -> Vec3 {
    let n = outline.len();
    let size_squared = outline[0].distance_squared(outline[n / 2]).max(f64::MIN_POSITIVE);
    let tiny = 1e-10 * size_squared;
    let mut weights = 0.0;
    let mut sum = DVec3::ZERO;
    let half_tangent = |a: DVec3, b: DVec3| {
        let area = normal.dot(a.cross(b)).max(0.0);
        if area <= tiny { 0.0 } else { (a.length() * b.length() - a.dot(b)) / area }
    };
    for i in 0..n {
        let (before, here, after) =
            (outline[(i + n - 1) % n] - point, outline[i] - point, outline[(i + 1) % n] - point);
        let distance_squared = here.length_squared();
        if distance_squared <= tiny {
            return value(i);
        }
        if normal.dot(here.cross(after)) <= tiny && here.dot(after) < 0.0 {
            let (a, b) = (here.length(), after.length());
            return value(i).lerp(value((i + 1) % n), (a / (a + b)) as f32);
        }
        let weight = (half_tangent(before, here) + half_tangent(here, after)) / distance_squared.sqrt();
        weights += weight;
        sum += value(i).as_dvec3() * weight;
    }
    if weights > 0.0 { (sum / weights).as_vec3() } else { value(0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square_with_a_t_vertex() -> Vec<DVec3> {
        [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
            .map(|(x, y)| DVec3::new(x, y, 0.0))
            .into()
    }

    #[test]
    fn linear_fields_are_reproduced() {
        let outline = square_with_a_t_vertex();
        let field = |p: DVec3| Vec3::splat((3.0 * p.x - 2.0 * p.y + 1.0) as f32);
        for (x, y) in [(0.5, 0.5), (0.1, 0.9), (0.5, 1e-6), (0.999_999, 0.3), (0.25, 0.0), (0.0, 0.0)] {
            let p = DVec3::new(x, y, 0.0);
            let v = mean_value(p, DVec3::Z, &outline, |i| field(outline[i]));
            assert!((v - field(p)).abs().max_element() < 1e-4, "{p}: {v} for {}", field(p));
        }
    }

    #[test]
    fn edges_are_linear_between_neighbours() {
        let outline = square_with_a_t_vertex();
        let value = |i: usize| Vec3::splat([0.0, 10.0, 0.0, 5.0, 7.0][i]);
        for x in [0.1, 0.25, 0.4] {
            let on = mean_value(DVec3::new(x, 0.0, 0.0), DVec3::Z, &outline, value).x;
            let near = mean_value(DVec3::new(x, 1e-5, 0.0), DVec3::Z, &outline, value).x;
            assert!((on - 20.0 * x as f32).abs() < 1e-3);
            assert!((near - on).abs() < 0.05, "a crack: {near} beside {on}");
        }
    }
}
