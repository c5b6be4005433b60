//! Rooms: facets are parted along walls and floors before neighbours are gathered into clusters. A cluster that
//! reaches through a wall is seen by what is in either room, and no plane hides it from what is in only one of them.

use super::TOLERANCE;
use super::facets::{MergedFacet, corners_of};
use super::surfaces::Surfaces;
use crate::math::{Aabb, Axes, Clip, Plane};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::Range;

/// The share of the section through all facets that a wall has to fill: one with a door and windows does, a table
/// does not.
const FILLED: f64 = 0.5;

/// The share of all area that has to lie on either side: a shelf board makes no rooms.
const LEAST_SIDE: f64 = 0.05;

/// The share of all area that may reach through the wall.
const MOST_THROUGH: f64 = 0.3;

/// Fewer facets are not parted.
const LEAST_FACETS: usize = 32;

/// Planes tried as walls: those that hold the largest area.
const MOST_WALLS: usize = 64;

/// Directions are told apart in steps of this share of a unit normal.
const STEP: f64 = 1e-3;

/// Cosine of the angle between the normals of planes that count as parallel.
const PARALLEL: f64 = 1.0 - STEP * STEP;

/// Facets no farther from a plane than this lie in it, local units.
pub(super) const IN_PLANE: f64 = 4.0 * TOLERANCE;

/// Facets that reach further than this through a wall are cut by it, local units.
const LEAST_CUT: f64 = 50.0 * TOLERANCE;

/// Nothing is cut if more than this share of facets reach through a wall: that would be many small parts for nothing.
const MOST_CUT: f64 = 0.125;

/// Corners this near to a cut belong to both parts: what rounding does to new ones.
const ON_CUT: f64 = 0.1 * TOLERANCE;

/// The facets to be parted.
pub(super) struct Rooms<'a, 'b> {
    surfaces: &'a mut Surfaces<'b>,
    /// A box around each facet.
    pub(super) boxes: Vec<Aabb>,
    planes: Vec<Plane>,
    areas: Vec<f64>,
}

/// A plane that facets lie in.
struct Wall {
    /// The largest facet in it.
    largest: u32,
    plane: Plane,
    /// Of all facets in it.
    area: f64,
}

impl<'a, 'b> Rooms<'a, 'b> {
    pub(super) fn of(surfaces: &'a mut Surfaces<'b>) -> Rooms<'a, 'b> {
        let (boxes, planes, areas) = (surfaces.boxes(), surfaces.planes(), surfaces.areas());
        Rooms { surfaces, boxes, planes, areas }
    }

    /// The best wall among these facets, and both parts of them, in front of it and behind; `None` if there is no wall.
    /// Facets that reach through it are cut.
    pub(super) fn part(&mut self, facets: &[u32]) -> Option<(Plane, [Vec<u32>; 2])> {
        if facets.len() < LEAST_FACETS {
            return None;
        }
        let bounds = self.bounds(facets);
        let walls = self.walls(facets);
        let worths: Vec<f64> = walls.par_iter().map(|wall| self.worth(wall, facets, &bounds)).collect();
        let (best, worth) = worths.iter().enumerate().rev().max_by(|a, b| a.1.total_cmp(b.1))?;
        if *worth <= 0.0 {
            return None;
        }
        let wall = walls[best].plane;
        let all = self.cut(facets, &wall);
        let (front, back) = all.iter().partition(|&&facet| self.is_in_front(facet, &wall));
        Some((wall, [front, back]))
    }

    /// Cuts facets where they reach through a plane, if not too many do. All of them, and the new ones.
    fn cut(&mut self, facets: &[u32], plane: &Plane) -> Vec<u32> {
        let mut all = facets.to_vec();
        let reaches_through = |&facet: &u32| {
            let reach = self.reach(facet, plane);
            reach.start < -LEAST_CUT && reach.end > LEAST_CUT
        };
        let through: Vec<u32> = facets.iter().copied().filter(reaches_through).collect();
        if through.len() as f64 > MOST_CUT * facets.len() as f64 {
            return all;
        }
        // New corners by the ends of the edge they lie on, so that neighbours share them.
        let mut known = HashMap::new();
        for facet in through {
            let halves = [*plane, plane.flipped()].map(|side| self.part_in_front(facet, &side, &mut known));
            // Of a sliver no part may be left.
            if halves.iter().all(|outline| outline.len() >= 3) {
                let material = self.surfaces.facets[facet as usize].material;
                let parts: Vec<MergedFacet> =
                    halves.iter().flat_map(|outline| self.surfaces.fan(outline, material)).collect();
                all.extend(self.replace(facet, parts));
            }
        }
        all
    }

    /// Puts the first of some parts in the place of a facet. The others, which are new.
    fn replace(&mut self, facet: u32, parts: Vec<MergedFacet>) -> Range<u32> {
        let (plane, first) = (self.planes[facet as usize], self.surfaces.facets.len() as u32);
        for (i, part) in parts.into_iter().enumerate() {
            let polygon = part.polygon(&self.surfaces.positions);
            if i == 0 {
                let at = facet as usize;
                (self.boxes[at], self.areas[at]) = (polygon.bounds(), polygon.area());
                self.surfaces.facets[at] = part;
            } else {
                self.boxes.push(polygon.bounds());
                self.planes.push(plane);
                self.areas.push(polygon.area());
                self.surfaces.facets.push(part);
            }
        }
        first..self.surfaces.facets.len() as u32
    }

    /// Outline of the part of a facet in front of a plane.
    fn part_in_front(&mut self, facet: u32, plane: &Plane, known: &mut HashMap<(u32, u32), u32>) -> Vec<u32> {
        let corners = self.surfaces.facets[facet as usize].corners.clone();
        let mut outline = Vec::new();
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let distances =
                [a, b].map(|corner| plane.distance(self.surfaces.positions[corner as usize].as_dvec3()));
            if distances[0] >= -ON_CUT {
                outline.push(a);
            }
            if distances.iter().all(|distance| distance.abs() > ON_CUT) && distances[0] * distances[1] < 0.0 {
                outline.push(*known.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let [low, high] = [a.min(b), a.max(b)]
                        .map(|corner| self.surfaces.positions[corner as usize].as_dvec3());
                    let (from, to) = (plane.distance(low), plane.distance(high));
                    self.surfaces.positions.push(low.lerp(high, from / (from - to)).as_vec3());
                    self.surfaces.positions.len() as u32 - 1
                }));
            }
        }
        corners_of(&outline, &self.surfaces.positions)
    }

    /// The walls around a room, given its facets and the planes by which it was parted from others: in place of each
    /// plane the largest wall among the facets on that side, and the plane itself where there is none. The front of
    /// each is outside; there is one for each direction.
    pub(super) fn enclosure(&self, facets: &[u32], around: &[Plane]) -> Vec<Plane> {
        let mut enclosure: Vec<Plane> = Vec::new();
        if around.is_empty() {
            return enclosure;
        }
        let (bounds, walls) = (self.bounds(facets), self.walls(facets));
        // The last plane of a direction is the nearest.
        for plane in around.iter().rev() {
            if enclosure.iter().any(|wall| wall.normal.dot(plane.normal) > PARALLEL) {
                continue;
            }
            let own = walls.iter().find_map(|wall| {
                let own = turned(&wall.plane, plane)?;
                (own.distance(bounds.center()) < 0.0 && self.filled(wall, facets, &bounds) >= FILLED)
                    .then_some(own)
            });
            enclosure.push(own.unwrap_or(*plane));
        }
        enclosure
    }

    fn bounds(&self, facets: &[u32]) -> Aabb {
        facets.iter().fold(Aabb::EMPTY, |all, &facet| all.union(self.boxes[facet as usize]))
    }

    /// The planes that hold the largest area, the largest first.
    fn walls(&self, facets: &[u32]) -> Vec<Wall> {
        let mut flat: Vec<([i32; 3], f64, u32)> = facets
            .iter()
            .map(|&facet| {
                let plane = self.planes[facet as usize];
                let key = (plane.normal / STEP).round().as_ivec3().to_array();
                let opposite = key.map(|k| -k);
                if key < opposite { (opposite, -plane.offset, facet) } else { (key, plane.offset, facet) }
            })
            .collect();
        flat.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        let mut walls: Vec<Wall> = flat
            .chunk_by(|a, b| a.0 == b.0 && b.1 - a.1 <= TOLERANCE)
            .map(|together| {
                let area_of = |&(_, _, facet): &([i32; 3], f64, u32)| self.areas[facet as usize];
                let largest = together.iter().rev().max_by(|a, b| area_of(a).total_cmp(&area_of(b)));
                let largest = largest.expect("no chunk is empty").2;
                Wall {
                    largest,
                    plane: self.planes[largest as usize],
                    area: together.iter().map(area_of).sum(),
                }
            })
            .collect();
        walls.sort_by(|a, b| b.area.total_cmp(&a.area));
        walls.truncate(MOST_WALLS);
        walls
    }

    /// How well a wall parts facets, 0 to 1/2: better the more of its section it fills, the more alike both sides are,
    /// and the less reaches through it. 0 if it is none.
    fn worth(&self, wall: &Wall, facets: &[u32], bounds: &Aabb) -> f64 {
        let filled = self.filled(wall, facets, bounds);
        if filled < FILLED {
            return 0.0;
        }
        let (mut front, mut through, mut all) = (0.0, 0.0, 0.0);
        for &facet in facets {
            let area = self.areas[facet as usize];
            let reach = self.reach(facet, &wall.plane);
            all += area;
            front += if self.is_in_front(facet, &wall.plane) { area } else { 0.0 };
            through += if reach.start < -IN_PLANE && reach.end > IN_PLANE { area } else { 0.0 };
        }
        let side = front.min(all - front);
        if side < LEAST_SIDE * all || through > MOST_THROUGH * all {
            return 0.0;
        }
        filled * side / all * (1.0 - through / all)
    }

    /// The share of the section through these facets that a wall among them fills.
    fn filled(&self, wall: &Wall, facets: &[u32], bounds: &Aabb) -> f64 {
        let section = section(bounds, &wall.plane).min(self.extent(wall, facets));
        (wall.area / section.max(f64::MIN_POSITIVE)).min(1.0)
    }

    /// Area of the rectangle around all facets seen along the normal of a wall, which stands as the wall does: in a
    /// building that stands askew a section of the box is larger.
    fn extent(&self, wall: &Wall, facets: &[u32]) -> f64 {
        let outline = self.surfaces.facets[wall.largest as usize].polygon(&self.surfaces.positions);
        let axes = Axes::along(&outline, &wall.plane);
        let corners = facets.iter().flat_map(|&facet| &self.surfaces.facets[facet as usize].corners);
        let (mut low, mut high) = (DVec2::MAX, DVec2::MIN);
        for &corner in corners {
            let corner = axes.flat(self.surfaces.positions[corner as usize].as_dvec3());
            (low, high) = (low.min(corner), high.max(corner));
        }
        (high - low).element_product()
    }

    /// Smallest and largest distance of a facet from a plane.
    fn reach(&self, facet: u32, plane: &Plane) -> Range<f64> {
        let (start, end) = plane.distance_range(&self.boxes[facet as usize]);
        if start >= 0.0 || end <= 0.0 {
            return start..end;
        }
        let corners = &self.surfaces.facets[facet as usize].corners;
        let distances =
            corners.iter().map(|&c| plane.distance(self.surfaces.positions[c as usize].as_dvec3()));
        distances.fold(f64::MAX..f64::MIN, |range, d| range.start.min(d)..range.end.max(d))
    }

    /// Whether a facet belongs to what is in front of a plane. What lies in it belongs where it faces.
    fn is_in_front(&self, facet: u32, plane: &Plane) -> bool {
        let reach = self.reach(facet, plane);
        if reach.start >= -IN_PLANE && reach.end <= IN_PLANE {
            self.planes[facet as usize].normal.dot(plane.normal) > 0.0
        } else {
            reach.start + reach.end > 0.0
        }
    }
}

/// A plane as it faces where another does; `None` if they are not parallel.
fn turned(plane: &Plane, like: &Plane) -> Option<Plane> {
    let along = plane.normal.dot(like.normal);
    (along.abs() > PARALLEL).then(|| if along > 0.0 { *plane } else { plane.flipped() })
}

/// Area of the part of a plane within a box.
fn section(bounds: &Aabb, plane: &Plane) -> f64 {
    let middle = bounds.center() - plane.normal * plane.distance(bounds.center());
    let (along, across) = plane.normal.any_orthonormal_pair();
    let size = 2.0 * bounds.radius();
    let square = [along + across, along - across, -along - across, across - along].map(|c| middle + c * size);
    let mut clip: Clip<16> = Clip::new(&square);
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        clip.keep_front(&Plane::through(bounds.min.as_dvec3(), axis), 0.0);
        clip.keep_front(&Plane::through(bounds.max.as_dvec3(), -axis), 0.0);
    }
    0.5 * clip.area_vector().length()
}

#[cfg(test)]
mod tests {
    use super::super::Hierarchy;
    use super::*;
    use crate::progress::Silent;
    use crate::scene::{ImportCounts, Material, Scene, Triangle};
    use glam::DQuat;

    /// Quadrilaterals, turned as a whole. Those before and beyond x = 4 are of two materials, so that they stay apart.
    fn scene(quads: &[[DVec3; 4]], turn: DQuat) -> Scene {
        let material =
            || Material { name: String::new(), reflectance: [0.5; 3], radiance: [1.0; 3], painting: None };
        let triangles = |i: u32| {
            let material = u32::from(quads[i as usize].iter().all(|corner| corner.x >= 4.0));
            [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]].map(|vertices| Triangle {
                vertices,
                material,
                patch: i,
            })
        };
        Scene {
            name: "rooms".to_owned(),
            positions: quads.iter().flatten().map(|&corner| turn * corner).collect(),
            triangles: (0..quads.len() as u32).flat_map(triangles).collect(),
            materials: vec![material(), material()],
            rectangles: Vec::new(),
            cameras: Vec::new(),
            meters_per_unit: 1.0,
            patch_count: quads.len() as u32,
            counts: ImportCounts::default(),
            files: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// A rectangle from a corner along two edges.
    fn rectangle(corner: [f64; 3], a: [f64; 3], b: [f64; 3]) -> [DVec3; 4] {
        let [corner, a, b] = [corner, a, b].map(DVec3::from);
        [corner, corner + a, corner + a + b, corner + b]
    }

    /// Small things: those of one room stand near those of the next, and those of a room are far from each other.
    fn things(x: f64) -> impl Iterator<Item = [DVec3; 4]> {
        (0..30).map(move |i| {
            let (z, y) = (f64::from(i % 6) * 0.9 + 0.2, f64::from(i / 6) * 0.5 + 0.2);
            rectangle([x, y, z], [0.01, 0.02, 0.0], [0.0, 0.02, 0.02])
        })
    }

    /// Two rooms of 4 m × 3 m × 6 m without a ceiling. The wall between them, at x = 4, leaves `door` metres of 6 open.
    fn two_rooms(door: f64) -> Vec<[DVec3; 4]> {
        let floor = |x| rectangle([x, 0.0, 0.0], [0.0, 0.0, 6.0], [4.0, 0.0, 0.0]);
        let side = |x, z| rectangle([x, 0.0, z], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]);
        let wall = rectangle([4.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 6.0 - door]);
        let mut quads = vec![wall];
        quads.extend([0.0, 4.0].into_iter().flat_map(|x| [floor(x), side(x, 0.0), side(x, 6.0)]));
        quads.extend(things(3.95).chain(things(4.05)));
        quads
    }

    /// Whether one half of the tree holds what is on one side of x = 4 before the turn, and the other half the rest.
    fn is_parted_at_wall(quads: &[[DVec3; 4]], turn: DQuat) -> bool {
        let hierarchy = Hierarchy::build(&scene(quads, turn), false, &Silent);
        let normal = (turn * DVec3::X).as_vec3();
        let wall = hierarchy.frame.local_from_scene(turn * (DVec3::X * 4.0)).dot(normal);
        let halves = hierarchy.nodes[0].children(0).map(|child| hierarchy.nodes[child as usize]);
        let sides = halves.map(|half| {
            let beyond =
                |&facet: &u32| hierarchy.nodes[hierarchy.leaf(facet) as usize].center.dot(normal) - wall;
            let small = |&facet: &u32| hierarchy.polygon(facet).area() < 0.01;
            (half.first..half.end).filter(small).map(|facet| beyond(&facet) > 0.0).collect::<Vec<bool>>()
        });
        sides.iter().all(|side| side.iter().all(|&beyond| beyond == side[0])) && sides[0][0] != sides[1][0]
    }

    #[test]
    fn a_wall_with_a_door_parts_rooms_however_it_stands() {
        for turn in [
            DQuat::IDENTITY,
            DQuat::from_rotation_y(0.7),
            DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 1.0, 2.0),
        ] {
            assert!(is_parted_at_wall(&two_rooms(0.9), turn), "{turn}");
        }
    }

    /// A floor under both rooms becomes one for each, and a door frame what is on either side; what ends at the wall
    /// stays as it is.
    #[test]
    fn what_reaches_through_a_wall_is_cut() {
        for turn in [DQuat::IDENTITY, DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 1.0, 2.0)] {
            let mut quads = two_rooms(0.9);
            // A strip of the floor in one piece.
            for (floor, x) in [(1, 0.0), (4, 4.0)] {
                quads[floor] = rectangle([x, 0.0, 2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0]);
            }
            quads.push(rectangle([0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [8.0, 0.0, 0.0]));
            quads.push(rectangle([3.9, 0.1, 5.2], [0.3, 0.0, 0.0], [0.0, 2.0, 0.0]));
            let scene = scene(&quads, turn);
            let hierarchy = Hierarchy::build(&scene, false, &Silent);
            hierarchy.validate().expect("a tree in order");
            assert_eq!(hierarchy.facets.len(), quads.len() + 2);
            let normal = turn * DVec3::X;
            let wall = hierarchy.frame.local_from_scene(turn * (DVec3::X * 4.0)).as_dvec3().dot(normal);
            for half in hierarchy.nodes[0].children(0).map(|child| hierarchy.nodes[child as usize]) {
                let outlines: Vec<_> = (half.first..half.end).map(|facet| hierarchy.polygon(facet)).collect();
                let corners = outlines.iter().flat_map(|outline| outline.vertices());
                let beyond: Vec<f64> = corners.map(|corner| corner.dot(normal) - wall).collect();
                let is_in_one_room =
                    beyond.iter().all(|d| *d <= TOLERANCE) || beyond.iter().all(|d| *d >= -TOLERANCE);
                assert!(is_in_one_room, "{turn}");
            }
            let area = hierarchy.nodes[0].area as f64;
            let quad_area = |q: &[DVec3; 4]| 0.5 * (q[2] - q[0]).cross(q[3] - q[1]).length();
            let wanted: f64 = quads.iter().map(quad_area).sum();
            let scale = hierarchy.frame.scene_units_per_local();
            assert!((area * scale * scale - wanted).abs() < 1e-4 * wanted, "{area} {wanted}");
        }
    }

    /// Corners as near to the wall as what lies in it, on either side of it.
    #[test]
    fn both_parts_of_what_is_cut_have_its_area() {
        let outline = [(-0.5, 0.3), (-0.03, 0.5), (0.03, 0.5), (0.5, 0.3)];
        let below = outline.map(|(x, y)| (-x, -y));
        let positions: Vec<glam::Vec3> =
            outline.iter().chain(&below).map(|&(x, y)| glam::Vec3::new(x, y, 2.4e-4 * x)).collect();
        let corners: Vec<u32> = (0..8).rev().collect();
        let facet = MergedFacet { triangles: Vec::new(), corners, material: 0 };
        let whole = facet.polygon(&positions).area();
        let mut surfaces = Surfaces {
            facets: vec![facet],
            positions,
            triangles: Vec::new(),
            materials: &[],
            one_sided: false,
        };
        let mut rooms = Rooms::of(&mut surfaces);
        let plane = Plane::through(DVec3::ZERO, DVec3::Z);
        let parts = [plane, plane.flipped()].map(|side| rooms.part_in_front(0, &side, &mut HashMap::new()));
        let parts: Vec<MergedFacet> = parts.iter().flat_map(|part| surfaces.fan(part, 0)).collect();
        let area: f64 = parts.iter().map(|part| part.polygon(&surfaces.positions).area()).sum();
        assert!((area - whole).abs() < 1e-6, "{area} of {whole}");
    }

    #[test]
    fn a_pillar_parts_nothing() {
        assert!(!is_parted_at_wall(&two_rooms(4.5), DQuat::IDENTITY));
    }

    #[test]
    fn sections_of_a_box_have_their_area() {
        let bounds = Aabb { min: glam::Vec3::ZERO, max: glam::Vec3::new(2.0, 3.0, 4.0) };
        let across = Plane::through(DVec3::new(0.5, 9.0, 9.0), DVec3::X);
        assert!((section(&bounds, &across) - 12.0).abs() < 1e-9);
        let slant = Plane::through(DVec3::new(1.0, 1.5, 0.0), DVec3::new(3.0, -2.0, 0.0).normalize());
        assert!((section(&bounds, &slant) - 4.0 * 13f64.sqrt()).abs() < 1e-9, "{}", section(&bounds, &slant));
        assert_eq!(section(&bounds, &Plane::through(DVec3::splat(-1.0), DVec3::X)), 0.0);
    }
}
