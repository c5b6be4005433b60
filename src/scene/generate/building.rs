//! The building: storeys of rooms on both sides of a corridor, walls with thickness, door openings, one
//! closed shell around it all. x runs along the corridor, y up, in metres.

use std::io::Write;

use glam::{DVec3, dvec3};

use super::OfficeOptions;
use super::furniture::furnish;
use super::obj_writer::ObjWriter;
use super::shapes::{BACK, BOTTOM, FRONT, Frame, LEFT, RIGHT, TOP};
use super::variation::Variation;

/// Distance from room to room, between the middles of their walls.
const BAY: f64 = 4.0;
pub(super) const WALL: f64 = 0.15;
/// Clear width of a room, along the corridor.
pub(super) const ROOM_WIDTH: f64 = BAY - WALL;
/// Clear depth of a room, away from the corridor.
pub(super) const ROOM_DEPTH: f64 = 5.0;
/// Clear height of rooms and corridor.
pub(super) const ROOM_HEIGHT: f64 = 2.8;
const SLAB: f64 = 0.3;
const CORRIDOR_WIDTH: f64 = 2.0;
/// The door opening in room coordinates.
pub(super) const DOOR: [f64; 2] = [2.7, 3.6];
pub(super) const DOOR_HEIGHT: f64 = 2.1;

/// A material of the building: linear RGB.
pub(super) struct OfficeMaterial {
    pub(super) name: &'static str,
    pub(super) reflectance: [f32; 3],
    /// W/(m²·sr); a ceiling lamp of this radiance and size gives about 500 lux on the desks.
    pub(super) radiance: Option<[f32; 3]>,
}

const fn plain(name: &'static str, r: f32, g: f32, b: f32) -> OfficeMaterial {
    OfficeMaterial { name, reflectance: [r, g, b], radiance: None }
}

/// Every material that the generator names.
pub(super) const MATERIALS: [OfficeMaterial; 21] = [
    plain("wall", 0.75, 0.74, 0.70),
    plain("ceiling", 0.84, 0.84, 0.82),
    plain("carpet", 0.20, 0.24, 0.28),
    plain("corridor_floor", 0.42, 0.38, 0.33),
    plain("facade", 0.45, 0.43, 0.40),
    plain("door", 0.48, 0.32, 0.18),
    plain("frame", 0.60, 0.60, 0.60),
    plain("window", 0.10, 0.13, 0.16),
    plain("blind", 0.72, 0.70, 0.64),
    plain("metal", 0.55, 0.55, 0.57),
    plain("dark_metal", 0.12, 0.12, 0.13),
    plain("desk", 0.62, 0.50, 0.36),
    plain("plastic", 0.08, 0.08, 0.09),
    plain("fabric_blue", 0.10, 0.16, 0.38),
    plain("fabric_red", 0.42, 0.09, 0.08),
    plain("paper", 0.80, 0.80, 0.77),
    plain("book_green", 0.12, 0.30, 0.16),
    plain("book_ochre", 0.55, 0.38, 0.12),
    plain("leaf", 0.10, 0.28, 0.07),
    plain("pot", 0.45, 0.22, 0.14),
    OfficeMaterial { name: "lamp", reflectance: [0.5; 3], radiance: Some([10.0, 9.6, 8.8]) },
];

/// A view worth rendering.
pub(super) struct View {
    pub(super) name: &'static str,
    pub(super) eye: DVec3,
    pub(super) target: DVec3,
    pub(super) vfov_deg: f64,
}

/// One view in a room in the middle of the ground floor and one along its corridor.
pub(super) fn views(options: &OfficeOptions) -> [View; 2] {
    let room = room_frame(0, bays(options) / 2, 0);
    let to_micrometres = |p: DVec3| (p * 1e6).round() / 1e6;
    let at = |x, y, z| to_micrometres(room.point(dvec3(x, y, z)));
    let length = f64::from(bays(options)) * BAY;
    [
        View { name: "room", eye: at(0.4, 1.65, 0.4), target: at(2.3, 0.85, 3.6), vfov_deg: 60.0 },
        View {
            name: "corridor",
            eye: dvec3(0.5, 1.6, 0.25),
            target: dvec3((length - 0.5).min(8.0), 1.3, 0.0),
            vfov_deg: 55.0,
        },
    ]
}

/// Rooms along one side of the corridor.
fn bays(options: &OfficeOptions) -> u32 {
    options.rooms.div_ceil(2)
}

/// Adds the whole building.
pub(super) fn build<W: Write>(options: &OfficeOptions, mesh: &mut ObjWriter<W>) {
    facade(options, mesh);
    for floor in 0..options.floors {
        for bay in 0..bays(options) {
            corridor(options, floor, bay, mesh);
            for side in 0..2 {
                let room = 2 * bay + side;
                if room < options.rooms {
                    let frame = room_frame(floor, bay, side);
                    shell(&frame, mesh);
                    let mut variation = Variation::of_room(options.seed, floor, room);
                    furnish(&frame, &mut variation, mesh);
                }
            }
        }
    }
}

/// Room coordinates: x along the corridor wall, z away from it, seen from the door.
fn room_frame(floor: u32, bay: u32, side: u32) -> Frame {
    let y = f64::from(floor) * (ROOM_HEIGHT + SLAB);
    let x = f64::from(bay) * BAY + 0.5 * WALL;
    let z = 0.5 * CORRIDOR_WIDTH + WALL;
    match side {
        0 => Frame::WORLD.quarter(dvec3(x, y, z), 0),
        _ => Frame::WORLD.quarter(dvec3(x + ROOM_WIDTH, y, -z), 2),
    }
}

/// The outside of the building; it keeps the walls closed and receives no light.
fn facade<W: Write>(options: &OfficeOptions, mesh: &mut ObjWriter<W>) {
    let depth = 0.5 * CORRIDOR_WIDTH + WALL + ROOM_DEPTH + WALL;
    let height = f64::from(options.floors) * (ROOM_HEIGHT + SLAB);
    let length = f64::from(bays(options)) * BAY;
    mesh.line("o facade");
    mesh.material("facade");
    mesh.cuboid(
        &Frame::WORLD,
        dvec3(-0.5 * WALL, -SLAB, -depth),
        dvec3(length + 0.5 * WALL, height, depth),
        0,
    );
}

/// The inner surfaces of a room, and the passage through the corridor wall.
fn shell<W: Write>(frame: &Frame, mesh: &mut ObjWriter<W>) {
    let (w, d, h) = (ROOM_WIDTH, ROOM_DEPTH, ROOM_HEIGHT);
    let at = dvec3;
    mesh.line("o room");
    mesh.material("carpet");
    mesh.panel(frame, [at(0., 0., 0.), at(0., 0., d), at(w, 0., d), at(w, 0., 0.)]);
    mesh.material("ceiling");
    mesh.panel(frame, [at(0., h, 0.), at(w, h, 0.), at(w, h, d), at(0., h, d)]);
    mesh.material("wall");
    mesh.panel(frame, [at(0., 0., 0.), at(0., h, 0.), at(0., h, d), at(0., 0., d)]);
    mesh.panel(frame, [at(w, 0., 0.), at(w, 0., d), at(w, h, d), at(w, h, 0.)]);
    mesh.panel(frame, [at(0., 0., d), at(0., h, d), at(w, h, d), at(w, 0., d)]);
    wall_with_door(frame, [0.0, w], mesh);
    let [left, right] = DOOR;
    let top = DOOR_HEIGHT;
    mesh.material("frame");
    mesh.panel(frame, [at(left, 0., -WALL), at(left, top, -WALL), at(left, top, 0.), at(left, 0., 0.)]);
    mesh.panel(frame, [at(right, 0., 0.), at(right, top, 0.), at(right, top, -WALL), at(right, 0., -WALL)]);
    mesh.panel(frame, [at(left, top, -WALL), at(right, top, -WALL), at(right, top, 0.), at(left, top, 0.)]);
    mesh.material("corridor_floor");
    mesh.panel(frame, [at(left, 0., 0.), at(right, 0., 0.), at(right, 0., -WALL), at(left, 0., -WALL)]);
}

/// A wall at local z = 0 that faces +z, with the door opening.
fn wall_with_door<W: Write>(frame: &Frame, [start, end]: [f64; 2], mesh: &mut ObjWriter<W>) {
    let [left, right] = DOOR;
    let mut part = |x0: f64, x1: f64, y0: f64, y1: f64| {
        mesh.panel(frame, [dvec3(x0, y0, 0.), dvec3(x1, y0, 0.), dvec3(x1, y1, 0.), dvec3(x0, y1, 0.)]);
    };
    part(start, left, 0.0, ROOM_HEIGHT);
    part(left, right, DOOR_HEIGHT, ROOM_HEIGHT);
    part(right, end, 0.0, ROOM_HEIGHT);
}

/// One bay of the corridor with its lamp, its walls and door frames.
fn corridor<W: Write>(options: &OfficeOptions, floor: u32, bay: u32, mesh: &mut ObjWriter<W>) {
    let last = bays(options) - 1;
    let y = f64::from(floor) * (ROOM_HEIGHT + SLAB);
    let x = f64::from(bay) * BAY;
    let frame = Frame::WORLD.quarter(dvec3(x, y, 0.0), 0);
    let start = if bay == 0 { 0.5 * WALL } else { 0.0 };
    let end = if bay == last { BAY - 0.5 * WALL } else { BAY };
    let (half, h) = (0.5 * CORRIDOR_WIDTH, ROOM_HEIGHT);
    let at = dvec3;
    mesh.line("o corridor");
    mesh.material("corridor_floor");
    mesh.panel(&frame, [at(start, 0., -half), at(start, 0., half), at(end, 0., half), at(end, 0., -half)]);
    mesh.material("ceiling");
    mesh.panel(&frame, [at(start, h, -half), at(end, h, -half), at(end, h, half), at(start, h, half)]);
    mesh.material("wall");
    if bay == 0 {
        mesh.panel(
            &frame,
            [at(start, 0., -half), at(start, h, -half), at(start, h, half), at(start, 0., half)],
        );
    }
    if bay == last {
        mesh.panel(&frame, [at(end, 0., half), at(end, h, half), at(end, h, -half), at(end, 0., -half)]);
    }
    for side in 0..2 {
        // The wall as the room behind it sees it, turned round: x runs from the room's other end.
        let (origin, quarters, ends) = match side {
            0 => (at(0.5 * WALL, 0., half), 0, [start - 0.5 * WALL, end - 0.5 * WALL]),
            _ => (at(BAY - 0.5 * WALL, 0., -half), 2, [BAY - 0.5 * WALL - end, BAY - 0.5 * WALL - start]),
        };
        let wall = frame.quarter(origin, quarters);
        mesh.material("wall");
        if 2 * bay + side < options.rooms {
            wall_behind_door(&wall, ends, mesh);
            door_frame(&wall, mesh);
        } else {
            let [x0, x1] = ends;
            mesh.panel(&wall, [at(x1, 0., 0.), at(x0, 0., 0.), at(x0, h, 0.), at(x1, h, 0.)]);
        }
    }
    ceiling_lamp(&frame, at(0.5 * BAY, h, 0.), [0.6, 0.15], mesh);
}

/// The corridor's side of a wall with a door: at local z = 0, facing −z.
fn wall_behind_door<W: Write>(frame: &Frame, [start, end]: [f64; 2], mesh: &mut ObjWriter<W>) {
    let [left, right] = DOOR;
    let mut part = |x0: f64, x1: f64, y0: f64, y1: f64| {
        mesh.panel(frame, [dvec3(x1, y0, 0.), dvec3(x0, y0, 0.), dvec3(x0, y1, 0.), dvec3(x1, y1, 0.)]);
    };
    part(start, left, 0.0, ROOM_HEIGHT);
    part(left, right, DOOR_HEIGHT, ROOM_HEIGHT);
    part(right, end, 0.0, ROOM_HEIGHT);
}

/// Three mouldings around the opening on the corridor side, and a name plate.
fn door_frame<W: Write>(frame: &Frame, mesh: &mut ObjWriter<W>) {
    let [left, right] = DOOR;
    let (wide, deep, top) = (0.07, 0.02, DOOR_HEIGHT);
    mesh.material("frame");
    mesh.cuboid(frame, dvec3(left - wide, 0., -deep), dvec3(left, top, 0.), FRONT | BOTTOM);
    mesh.cuboid(frame, dvec3(right, 0., -deep), dvec3(right + wide, top, 0.), FRONT | BOTTOM);
    mesh.cuboid(frame, dvec3(left - wide, top, -deep), dvec3(right + wide, top + wide, 0.), FRONT);
    mesh.material("metal");
    mesh.cuboid(frame, dvec3(left - 0.35, 1.5, -0.01), dvec3(left - 0.15, 1.6, 0.), FRONT);
}

/// A lamp under the ceiling: a housing of half sizes `half`, whose underside shines down.
pub(super) fn ceiling_lamp<W: Write>(frame: &Frame, center: DVec3, half: [f64; 2], mesh: &mut ObjWriter<W>) {
    let low = center - dvec3(half[0], 0.06, half[1]);
    let high = center + dvec3(half[0], 0.0, half[1]);
    mesh.material("metal");
    mesh.cuboid(frame, low, high, TOP | BOTTOM);
    mesh.material("lamp");
    mesh.cuboid(frame, low, high, TOP | LEFT | RIGHT | BACK | FRONT);
}
