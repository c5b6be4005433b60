//! Small convex planar polygons, stored in place: facets, elements, and what is left of them after
//! clipping.

use super::{Aabb, Plane};
use glam::DVec3;

/// Most vertices of a facet.
pub const MAX_VERTICES: usize = 8;

/// How often a point is moved inside each edge in turn.
const MOVES_INSIDE: u32 = 4;

/// A quadrilateral whose diagonals miss each other by no more than this share of one is a parallelogram.
const STRAIGHT: f64 = 1e-6;

/// A convex planar polygon with 3 to [`MAX_VERTICES`] vertices, counter-clockwise from its front.
#[derive(Clone, Copy, Debug)]
pub struct Polygon {
    count: u8,
    points: [DVec3; MAX_VERTICES],
}

impl Polygon {
    /// The polygon with these vertices, which must be convex and planar.
    ///
    /// # Panics
    /// With fewer than 3 or more than [`MAX_VERTICES`] vertices.
    pub fn new(vertices: &[DVec3]) -> Polygon {
        assert!((3..=MAX_VERTICES).contains(&vertices.len()), "a polygon of {} vertices", vertices.len());
        let mut points = [DVec3::ZERO; MAX_VERTICES];
        points[..vertices.len()].copy_from_slice(vertices);
        Polygon { count: vertices.len() as u8, points }
    }

    /// The vertices in order.
    #[inline]
    pub fn vertices(&self) -> &[DVec3] {
        &self.points[..self.count as usize]
    }

    /// The edges as pairs of end points, in order.
    pub fn edges(&self) -> impl Iterator<Item = (DVec3, DVec3)> + Clone + '_ {
        let v = self.vertices();
        (0..v.len()).map(move |i| (v[i], v[(i + 1) % v.len()]))
    }

    /// Twice the area times the unit normal (Newell's formula).
    pub fn area_vector(&self) -> DVec3 {
        let v = self.vertices();
        (1..v.len() - 1).map(|i| (v[i] - v[0]).cross(v[i + 1] - v[0])).sum()
    }

    /// Area.
    pub fn area(&self) -> f64 {
        self.area_vector().length() * 0.5
    }

    /// Mean of the vertices.
    pub fn center(&self) -> DVec3 {
        self.vertices().iter().sum::<DVec3>() / self.count as f64
    }

    /// Length of the longest edge or diagonal's upper bound: twice the largest distance of a vertex
    /// from the center.
    pub fn extent(&self) -> f64 {
        let c = self.center();
        2.0 * self.vertices().iter().map(|v| v.distance_squared(c)).fold(0.0, f64::max).sqrt()
    }

    /// Area over extent: of a strip how wide it is.
    pub fn width(&self) -> f64 {
        self.area() / self.extent().max(f64::MIN_POSITIVE)
    }

    /// Length of the longest edge.
    pub fn longest_edge(&self) -> f64 {
        self.edges().map(|(a, b)| a.distance_squared(b)).fold(0.0, f64::max).sqrt()
    }

    /// The same polygon seen from behind.
    pub fn flipped(&self) -> Polygon {
        let mut flipped = *self;
        flipped.points[..self.count as usize].reverse();
        flipped
    }

    /// Smallest box around it in single precision (rounded to nearest).
    pub fn bounds(&self) -> Aabb {
        Aabb::around(self.vertices().iter().map(|v| v.as_vec3()))
    }

    /// Two convex halves that cover the polygon: a triangle is cut from the middle of its longest
    /// edge, a quadrilateral across its longer pair of opposite edges, anything larger along its
    /// shortest balanced diagonal. Longest-edge bisection keeps the shapes of the pieces bounded.
    pub fn bisect(&self) -> [Polygon; 2] {
        [0, 1].map(|half| {
            let mut part = *self;
            part.keep_half(half);
            part
        })
    }

    /// Becomes one of its halves, the first or the second.
    pub fn keep_half(&mut self, half: usize) {
        let start = self.start_of_cut();
        self.keep_half_from(start, self.cut_from(start), half);
    }

    /// The line along which it is bisected; the first half lies to its left.
    pub fn cut(&self) -> (DVec3, DVec3) {
        self.cut_from(self.start_of_cut())
    }

    /// A plane through that line, across the polygon's own with this `normal`; the first half lies in front. Its normal is as
    /// long as the line.
    pub fn cut_plane(&self, normal: DVec3) -> Plane {
        let (from, to) = self.cut();
        Plane::through(from, normal.cross(to - from))
    }

    /// The corner that the first half starts with, or ends with if it is a triangle's.
    fn start_of_cut(&self) -> usize {
        let v = self.vertices();
        let n = v.len();
        match *v {
            [a, b, c] => {
                let edges = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
                (0..3).max_by(|&i, &j| edges[i].total_cmp(&edges[j])).unwrap_or(0)
            }
            [a, b, c, d] => {
                let along = a.distance_squared(b) + c.distance_squared(d);
                usize::from(along < b.distance_squared(c) + d.distance_squared(a))
            }
            _ => {
                let across = |i: usize| v[i].distance_squared(v[(i + n / 2) % n]);
                (0..n).min_by(|&i, &j| across(i).total_cmp(&across(j))).unwrap_or(0)
            }
        }
    }

    /// The corners of a polygon of so many, in order, beginning with this one.
    #[inline]
    fn corners_from<const N: usize>(&self, start: usize) -> [DVec3; N] {
        std::array::from_fn(|i| self.points[(start + i) % N])
    }

    fn cut_from(&self, start: usize) -> (DVec3, DVec3) {
        match self.vertices().len() {
            3 => {
                let [a, b, c] = self.corners_from(start);
                ((a + b) * 0.5, c)
            }
            4 => {
                let [a, b, c, d] = self.corners_from(start);
                ((a + b) * 0.5, (c + d) * 0.5)
            }
            n => (self.points[(start + n / 2) % n], self.points[start]),
        }
    }

    fn keep_half_from(&mut self, start: usize, (from, to): (DVec3, DVec3), half: usize) {
        let n = self.count as usize;
        match n {
            3 => {
                let [a, b, c] = self.corners_from(start);
                self.points[..3].copy_from_slice(&if half == 0 { [c, a, from] } else { [from, b, c] });
            }
            4 => {
                let [a, b, c, d] = self.corners_from(start);
                self.points[..4].copy_from_slice(&if half == 0 {
                    [a, from, to, d]
                } else {
                    [from, b, c, to]
                });
            }
            _ => {
                let at = |i: usize| self.points[(start + i) % n];
                let (first, count) = if half == 0 { (0, n / 2 + 1) } else { (n / 2, n - n / 2 + 1) };
                let mut points = [DVec3::ZERO; MAX_VERTICES];
                for (i, point) in points[..count].iter_mut().enumerate() {
                    *point = at(first + i);
                }
                self.points = points;
                self.count = count as u8;
            }
        }
    }

    /// The point at `(u, v)` of the unit square, uniform over the area.
    pub fn point_at(&self, u: f64, v: f64) -> DVec3 {
        self.sampler().point_at(u, v)
    }

    /// For many points of [`Polygon::point_at`].
    pub fn sampler(&self) -> PolygonSampler<'_> {
        PolygonSampler::new(self.vertices())
    }

    /// The part in front of `plane` (closed), or `None` when nothing remains. A polygon that would
    /// get more than [`MAX_VERTICES`] vertices keeps the ones it has room for, in order, which can
    /// only happen when it starts with that many.
    pub fn clipped(&self, plane: &Plane) -> Option<Polygon> {
        if self.vertices().iter().all(|&v| plane.distance(v) >= 0.0) {
            return Some(*self);
        }
        let mut piece = super::Clip::<{ MAX_VERTICES + 1 }>::new(self.vertices());
        piece.keep_front(plane, 0.0);
        let v = piece.vertices();
        (v.len() >= 3).then(|| Polygon::new(&v[..v.len().min(MAX_VERTICES)]))
    }

    /// `point` moved along the plane, not much further than need be, to `margin` inside the outline, seen along
    /// the unit `normal`; only half as deep as the middle where that is less.
    pub fn inside(&self, point: DVec3, normal: DVec3, margin: f64) -> DVec3 {
        let center = self.center();
        // For each edge: outward direction, a point of it, how deep the point has to lie.
        let edges = self.edges().map(|(a, b)| {
            let outward = (b - a).cross(normal).normalize_or_zero();
            (outward, a, margin.min(0.5 * (a - center).dot(outward)))
        });
        let mut moved = point;
        for _ in 0..MOVES_INSIDE {
            for (outward, a, depth) in edges.clone() {
                moved -= outward * ((moved - a).dot(outward) + depth).max(0.0);
            }
        }
        // In a sharp corner the edges push back and forth: the rest of the way is towards the middle.
        let share = edges.map(|(outward, a, depth)| {
            let missing = (moved - a).dot(outward) + depth;
            if missing > 0.0 { missing / (moved - center).dot(outward) } else { 0.0 }
        });
        moved.lerp(center, share.fold(0.0, f64::max).min(1.0))
    }

    /// How far `point` lies outside the outline, seen along the unit `normal`; negative inside.
    pub fn outside_distance(&self, point: DVec3, normal: DVec3) -> f64 {
        self.edges()
            .map(|(a, b)| {
                let outward = (b - a).cross(normal).normalize_or_zero();
                (point - a).dot(outward)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Maps the unit square to the area of a polygon.
#[derive(Clone, Copy, Debug)]
pub struct PolygonSampler<'a> {
    vertices: &'a [DVec3],
    /// Then both coordinates run along its edges.
    is_parallelogram: bool,
    /// Twice the area up to and with each triangle of the fan around the first vertex, where there are several.
    sums: [f64; MAX_VERTICES - 2],
}

impl<'a> PolygonSampler<'a> {
    /// For the polygon with these vertices, which must be convex and planar, at least 3 and at most [`MAX_VERTICES`].
    pub fn new(v: &'a [DVec3]) -> PolygonSampler<'a> {
        let skew = if v.len() == 4 { v[0] + v[2] - v[1] - v[3] } else { DVec3::INFINITY };
        let is_parallelogram = skew.length_squared() <= STRAIGHT * STRAIGHT * v[0].distance_squared(v[2]);
        let mut sampler = PolygonSampler { vertices: v, is_parallelogram, sums: [0.0; MAX_VERTICES - 2] };
        if is_parallelogram || v.len() == 3 {
            return sampler;
        }
        let mut sum = 0.0;
        for (i, total) in sampler.sums[..v.len() - 2].iter_mut().enumerate() {
            sum += (v[i + 1] - v[0]).cross(v[i + 2] - v[0]).length();
            *total = sum;
        }
        sampler
    }

    /// The point at `(u, v)` of the unit square, uniform over the area.
    #[inline]
    pub fn point_at(&self, u: f64, v: f64) -> DVec3 {
        let p = self.vertices;
        if self.is_parallelogram {
            return p[0] + (p[1] - p[0]) * u + (p[3] - p[0]) * v;
        }
        let last = p.len() - 3;
        let (mut fan, mut share) = (0, u);
        if last > 0 {
            let at = u * self.sums[last];
            while fan < last && at >= self.sums[fan] {
                fan += 1;
            }
            let before = if fan == 0 { 0.0 } else { self.sums[fan - 1] };
            share = (at - before) / (self.sums[fan] - before).max(f64::MIN_POSITIVE);
        }
        let r = share.clamp(0.0, 1.0).sqrt();
        p[0] + (p[fan + 1] - p[0]) * (r * (1.0 - v)) + (p[fan + 2] - p[0]) * (r * v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Polygon {
        Polygon::new(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0)))
    }

    #[test]
    fn halves_cover_the_polygon() {
        let octagon: Vec<DVec3> = (0..8)
            .map(|i| (i as f64 * std::f64::consts::TAU / 8.0).sin_cos())
            .map(|(s, c)| DVec3::new(c, s, 0.0))
            .collect();
        for polygon in
            [square(), Polygon::new(&octagon), Polygon::new(&octagon[..5]), Polygon::new(&octagon[..3])]
        {
            let mut pieces = vec![polygon];
            for _ in 0..6 {
                pieces = pieces.iter().flat_map(|p| p.bisect()).collect();
                let area: f64 = pieces.iter().map(Polygon::area).sum();
                assert!((area - polygon.area()).abs() < 1e-12);
                assert!(pieces.iter().all(|p| p.area_vector().z > 0.0), "a piece is turned over");
            }
        }
    }

    #[test]
    fn halves_lie_on_their_sides_of_the_cut() {
        let octagon: Vec<DVec3> = (0..8)
            .map(|i| (i as f64 * std::f64::consts::TAU / 8.0).sin_cos())
            .map(|(s, c)| DVec3::new(c, s, 0.0))
            .collect();
        for count in 3..=8 {
            let mut polygon = Polygon::new(&octagon[..count]);
            for step in 0..8 {
                let halves = polygon.bisect();
                for (i, half) in halves.iter().enumerate() {
                    let mut kept = polygon;
                    let is_in_front = polygon.cut_plane(DVec3::Z).distance(half.center()) > 0.0;
                    assert_eq!(is_in_front, i == 0, "{count} {step}");
                    kept.keep_half(i);
                    assert_eq!(kept.vertices(), half.vertices());
                    let (from, to) = polygon.cut();
                    assert!([from, to].iter().all(|end| half.vertices().contains(end)), "{count} {step}");
                }
                polygon = halves[step % 2];
            }
        }
    }

    #[test]
    fn points_are_uniform() {
        let pentagon = Polygon::new(
            &[(0.0, 0.0), (3.0, 0.0), (4.0, 1.0), (2.0, 3.0), (0.0, 2.0)].map(|(x, y)| DVec3::new(x, y, 1.0)),
        );
        let left = pentagon.clipped(&Plane::through(DVec3::new(1.5, 0.0, 0.0), -DVec3::X)).map(|p| p.area());
        let n = 200;
        let mut inside = 0;
        for i in 0..n {
            for j in 0..n {
                let p = pentagon.point_at((i as f64 + 0.5) / n as f64, (j as f64 + 0.5) / n as f64);
                assert!(pentagon.outside_distance(p, DVec3::Z) < 1e-9);
                inside += usize::from(p.x < 1.5);
            }
        }
        let share = inside as f64 / (n * n) as f64;
        assert!((share - left.unwrap_or(0.0) / pentagon.area()).abs() < 5e-3, "share {share}");
    }

    #[test]
    fn points_move_inside_and_not_much_further_than_need_be() {
        let margin = 1e-5;
        for degrees in [3f64, 10.0, 45.0, 60.0, 90.0, 120.0, 170.0] {
            let half = 0.5 * degrees.to_radians();
            let (sin, cos) = half.sin_cos();
            let corner = Polygon::new(&[DVec3::ZERO, DVec3::new(cos, -sin, 0.0), DVec3::new(cos, sin, 0.0)]);
            let moved = corner.inside(DVec3::ZERO, DVec3::Z, margin);
            let depth = -corner.outside_distance(moved, DVec3::Z);
            assert!(depth > 0.999 * margin, "{degrees}: {depth}");
            assert!(moved.length() < 2.1 * margin / sin, "{degrees}: {moved}");
            let deep = corner.center();
            assert_eq!(corner.inside(deep, DVec3::Z, margin), deep);
        }
        // Of a strip narrower than the margin, points go to where it is half as deep as in the middle.
        let strip = Polygon::new(
            &[(0.0, 0.0), (1.0, 0.0), (1.0, 1e-6), (0.0, 1e-6)].map(|(x, y)| DVec3::new(x, y, 0.0)),
        );
        for x in [0.1, 0.5, 0.9] {
            let moved = strip.inside(DVec3::new(x, 0.0, 0.0), DVec3::Z, margin);
            assert!(moved.distance(DVec3::new(x, 2.5e-7, 0.0)) < 1e-9, "{moved}");
        }
    }

    #[test]
    fn clipping_away_everything_leaves_none() {
        assert!(square().clipped(&Plane::through(DVec3::new(3.0, 0.0, 0.0), DVec3::X)).is_none());
        assert!(
            (square().clipped(&Plane::through(DVec3::X, DVec3::X)).map_or(0.0, |p| p.area()) - 1.0).abs()
                < 1e-12
        );
    }
}
