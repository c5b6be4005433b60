//! A camera for scenes that bring none, derived from their bounds. Up is +y.
//!
//! Which sides of the bounding box are walls decides where it stands: inside a closed room, in front of
//! the open side of a room, or diagonally above an object.

use glam::DVec3;

use super::{Camera, Triangle};

pub(super) const DEFAULT_VFOV_DEG: f64 = 45.0;
pub(super) const DEFAULT_WIDTH: u32 = 640;
pub(super) const DEFAULT_HEIGHT: u32 = 480;

/// Cells along one side of the grid that measures how much of a side is covered.
const CELLS: usize = 32;
/// A side is a wall when triangles in the outer twentieth of the extent cover this much of it.
const WALL_COVER: f64 = 0.6;
const WALL_DEPTH: f64 = 0.05;
/// Room left around what fills the frame.
const MARGIN: f64 = 1.05;

/// The camera of a scene without one; there is at least one triangle.
pub(super) fn derive(positions: &[DVec3], triangles: &[Triangle]) -> Camera {
    let corners = || triangles.iter().flat_map(|t| t.vertices).map(|vertex| positions[vertex as usize]);
    let low = corners().fold(DVec3::INFINITY, DVec3::min);
    let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
    let bounds = Bounds { low, high };
    // In order of preference for the open side: +z, −z, +x, −x.
    const SIDES: [(usize, bool); 4] = [(2, true), (2, false), (0, true), (0, false)];
    let walls = SIDES.map(|(axis, is_high)| bounds.is_wall(positions, triangles, axis, is_high));
    let wall_count = walls.iter().filter(|&&is_wall| is_wall).count();
    let opening = (0..4)
        .find(|&side| !walls[side] && walls[side ^ 1])
        .or((0..4).find(|&side| !walls[side]))
        .map(|side| SIDES[side]);
    match opening {
        None if bounds.is_hull(positions, triangles) => bounds.outside_view(),
        None => bounds.inside_view(),
        Some((axis, is_high)) if wall_count >= 2 => bounds.opening_view(axis, is_high),
        Some(_) => bounds.outside_view(),
    }
}

struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    fn size(&self) -> DVec3 {
        self.high - self.low
    }

    fn center(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    /// Whether triangles close to one side of the box cover most of it.
    fn is_wall(&self, positions: &[DVec3], triangles: &[Triangle], axis: usize, is_high: bool) -> bool {
        let size = self.size();
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        if size.min_element() <= 0.0 {
            return false;
        }
        let depth = |p: DVec3| if is_high { self.high[axis] - p[axis] } else { p[axis] - self.low[axis] };
        let on_grid = |p: DVec3| {
            let local = (p - self.low) / size * CELLS as f64;
            (local[u], local[v])
        };
        let mut is_covered = [[false; CELLS]; CELLS];
        for triangle in triangles {
            let corners = triangle.vertices.map(|vertex| positions[vertex as usize]);
            if corners.iter().all(|&corner| depth(corner) <= WALL_DEPTH * size[axis]) {
                cover(&mut is_covered, corners.map(on_grid));
            }
        }
        let count = is_covered.iter().flatten().filter(|&&covered| covered).count();
        count as f64 >= WALL_COVER * (CELLS * CELLS) as f64
    }

    /// Whether closed walls are all there is, and their front is outside: a box, not a room.
    fn is_hull(&self, positions: &[DVec3], triangles: &[Triangle]) -> bool {
        let mut volume = 0.0;
        let mut inner = 0;
        for triangle in triangles {
            let [a, b, c] = triangle.vertices.map(|vertex| positions[vertex as usize] - self.center());
            volume += a.dot(b.cross(c));
            // In units of half the extent: 1 is on the bounds.
            let place = ((a + b + c) / 3.0 / (0.5 * self.size())).abs().max_element();
            inner += usize::from(place < 1.0 - 2.0 * WALL_DEPTH);
        }
        volume > 0.0 && 2 * inner < triangles.len()
    }

    fn camera(&self, eye: DVec3, target: DVec3) -> Camera {
        Camera {
            name: "main".to_owned(),
            eye,
            target,
            up: DVec3::Y,
            vfov_deg: DEFAULT_VFOV_DEG,
            width: DEFAULT_WIDTH,
            height: DEFAULT_HEIGHT,
        }
    }

    /// From one upper corner of the room towards the opposite lower one.
    fn inside_view(&self) -> Camera {
        let at = |x: f64, y: f64, z: f64| self.low + self.size() * DVec3::new(x, y, z);
        self.camera(at(0.92, 0.6, 0.92), at(0.35, 0.4, 0.35))
    }

    /// Straight into a room, so that its open side fills the frame.
    fn opening_view(&self, axis: usize, is_high: bool) -> Camera {
        let outward = DVec3::AXES[axis] * if is_high { 1.0 } else { -1.0 };
        let across = self.size()[2 - axis] * 0.5;
        let (tan_x, tan_y) = half_angles();
        let distance = MARGIN * (across / tan_x).max(0.5 * self.size().y / tan_y);
        let eye = self.center() + outward * (0.5 * self.size()[axis] + distance);
        self.camera(eye, self.center())
    }

    /// From the front, right and above, as near as shows all of the bounds.
    fn outside_view(&self) -> Camera {
        let back = DVec3::new(0.5, 0.45, 1.0).normalize();
        let right = DVec3::Y.cross(back).normalize();
        let up = back.cross(right);
        let (tan_x, tan_y) = half_angles();
        let half = 0.5 * self.size();
        let distance = (0..8)
            .map(|corner| {
                let sign = |bit: i32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let offset = half * DVec3::new(sign(0), sign(1), sign(2));
                let spread = (offset.dot(right).abs() / tan_x).max(offset.dot(up).abs() / tan_y);
                spread + offset.dot(back)
            })
            .fold(0.0, f64::max);
        self.camera(self.center() + back * distance * MARGIN, self.center())
    }
}

/// Tangents of half the horizontal and half the vertical field of view.
fn half_angles() -> (f64, f64) {
    let tan_y = (0.5 * DEFAULT_VFOV_DEG.to_radians()).tan();
    (tan_y * f64::from(DEFAULT_WIDTH) / f64::from(DEFAULT_HEIGHT), tan_y)
}

/// Marks the cells whose centre lies in a triangle.
fn cover(is_covered: &mut [[bool; CELLS]; CELLS], corners: [(f64, f64); 3]) {
    let range = |values: [f64; 3]| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (low.floor().max(0.0) as usize)..(high.ceil().clamp(0.0, CELLS as f64) as usize)
    };
    let side = |(ax, ay): (f64, f64), (bx, by): (f64, f64), x: f64, y: f64| {
        (bx - ax) * (y - ay) - (by - ay) * (x - ax)
    };
    let [a, b, c] = corners;
    for row in range(corners.map(|corner| corner.1)) {
        for column in range(corners.map(|corner| corner.0)) {
            let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
            let sides = [side(a, b, x, y), side(b, c, x, y), side(c, a, x, y)];
            if sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0) {
                is_covered[row][column] = true;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sides of a 4 × 2 × 6 box as two triangles each; `open` sides are left out.
    fn room(open: &[(usize, bool)]) -> (Vec<DVec3>, Vec<Triangle>) {
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for axis in 0..3 {
            for is_high in [false, true] {
                if open.contains(&(axis, is_high)) {
                    continue;
                }
                let first = positions.len() as u32;
                for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                    let mut p = DVec3::ZERO;
                    p[axis] = f64::from(is_high);
                    p[(axis + 1) % 3] = u;
                    p[(axis + 2) % 3] = v;
                    positions.push(p * DVec3::new(4.0, 2.0, 6.0));
                }
                for vertices in [[first, first + 1, first + 2], [first, first + 2, first + 3]] {
                    triangles.push(Triangle { vertices, material: 0, patch: 0 });
                }
            }
        }
        (positions, triangles)
    }

    fn eye_of(open: &[(usize, bool)]) -> DVec3 {
        let (positions, triangles) = room(open);
        derive(&positions, &triangles).eye
    }

    #[test]
    fn a_closed_room_is_seen_from_inside_and_a_box_from_outside() {
        let (positions, mut triangles) = room(&[]);
        let is_inside =
            |eye: DVec3| eye.cmpgt(DVec3::ZERO).all() && eye.cmplt(DVec3::new(4.0, 2.0, 6.0)).all();
        // In `room` the fronts of all sides point along their axis: turn the high, then the low ones.
        let turn = |triangles: &mut [Triangle], is_high: usize| {
            for (i, triangle) in triangles.iter_mut().enumerate() {
                if i / 2 % 2 == is_high {
                    triangle.vertices.swap(1, 2);
                }
            }
        };
        turn(&mut triangles, 1);
        assert!(is_inside(derive(&positions, &triangles).eye), "walls that face inwards are a room");
        turn(&mut triangles, 1);
        turn(&mut triangles, 0);
        assert!(!is_inside(derive(&positions, &triangles).eye), "walls that face outwards are a box");
    }

    #[test]
    fn a_room_with_one_open_side_is_seen_through_it() {
        assert!(eye_of(&[(2, true)]).z > 6.0);
        assert!(eye_of(&[(2, false)]).z < 0.0);
        assert!(eye_of(&[(0, true)]).x > 4.0);
        assert!(eye_of(&[(0, false)]).x < 0.0);
    }

    #[test]
    fn an_object_is_seen_whole_and_fills_the_frame() {
        // A floor alone is no room.
        let sides = [(0, false), (0, true), (2, false), (2, true)];
        let (positions, triangles) = room(&sides);
        let camera = derive(&positions, &triangles);
        let back = (camera.eye - camera.target).normalize();
        let right = camera.up.cross(back).normalize();
        let up = back.cross(right);
        let (tan_x, tan_y) = half_angles();
        let largest = positions
            .iter()
            .map(|&p| {
                let view = p - camera.eye;
                let depth = -view.dot(back);
                (view.dot(right).abs() / (depth * tan_x)).max(view.dot(up).abs() / (depth * tan_y))
            })
            .fold(0.0, f64::max);
        assert!(largest < 1.0 && largest > 0.9, "the object reaches {largest} of the frame");
    }
}
