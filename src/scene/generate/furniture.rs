//! What stands in a room: desks, chairs, shelves, door leaf, window with blinds, radiator, board, lamps.
//! Furniture has its own coordinates: x along its width, z towards whoever uses it.

use std::io::Write;

use glam::{DVec3, dvec3};

use super::building::{DOOR, DOOR_HEIGHT, ROOM_DEPTH, ROOM_HEIGHT, ROOM_WIDTH, ceiling_lamp};
use super::obj_writer::ObjWriter;
use super::shapes::{BACK, BOTTOM, FRONT, Frame, TOP};
use super::small_things::{books, cup, desk_things, plant, waste_basket};
use super::variation::Variation;

/// Adds everything in one room.
pub(super) fn furnish<W: Write>(frame: &Frame, variation: &mut Variation, mesh: &mut ObjWriter<W>) {
    lamps(frame, mesh);
    door_leaf(frame, variation, mesh);
    window(frame, variation, mesh);
    radiator(frame, mesh);
    board_and_clock(frame, mesh);
    // Along the left wall the user looks to −x, along the right wall to +x.
    workplace(&frame.quarter(dvec3(0.05, 0., 3.7), 1), variation, mesh);
    workplace(&frame.quarter(dvec3(ROOM_WIDTH - 0.05, 0., 3.7), 3), variation, mesh);
    shelf(&frame.quarter(dvec3(ROOM_WIDTH, 0., 1.95), 3), variation, mesh);
    if variation.once_in(2) {
        workplace(&frame.quarter(dvec3(0.05, 0., 1.95), 1), variation, mesh);
    } else {
        shelf(&frame.quarter(dvec3(0.0, 0., 2.0), 1), variation, mesh);
    }
    plant(frame, dvec3(0.3, 0., ROOM_DEPTH - 0.3), variation, mesh);
    if variation.once_in(3) {
        plant(frame, dvec3(ROOM_WIDTH - 0.3, 0., ROOM_DEPTH - 0.3), variation, mesh);
    }
}

fn lamps<W: Write>(frame: &Frame, mesh: &mut ObjWriter<W>) {
    for x in [1.0, ROOM_WIDTH - 1.0] {
        for z in [1.4, 3.6] {
            ceiling_lamp(frame, dvec3(x, ROOM_HEIGHT, z), [0.15, 0.6], mesh);
        }
    }
}

/// The leaf stands open into the room, at some angle.
fn door_leaf<W: Write>(frame: &Frame, variation: &mut Variation, mesh: &mut ObjWriter<W>) {
    let width = DOOR[1] - DOOR[0] - 0.02;
    // Closed, the leaf would run from its hinge towards −x; it opens towards +z.
    let angle = variation.between(0.35, 1.4);
    let leaf = frame.quarter(dvec3(DOOR[1] - 0.01, 0., 0.01), 2).turn(DVec3::ZERO, angle);
    mesh.material("door");
    mesh.cuboid(&leaf, dvec3(0., 0.01, -0.04), dvec3(width, DOOR_HEIGHT - 0.01, 0.), 0);
    mesh.material("metal");
    mesh.cuboid(&leaf, dvec3(width - 0.18, 1.0, 0.), dvec3(width - 0.04, 1.03, 0.05), BACK);
    mesh.cuboid(&leaf, dvec3(width - 0.18, 1.0, -0.09), dvec3(width - 0.04, 1.03, -0.04), FRONT);
}

/// A dark closed panel in a frame, behind slats that are let down some way.
fn window<W: Write>(frame: &Frame, variation: &mut Variation, mesh: &mut ObjWriter<W>) {
    let z = ROOM_DEPTH;
    let (left, right, sill, top) = (0.6, ROOM_WIDTH - 0.6, 0.9, 2.4);
    mesh.material("window");
    mesh.cuboid(frame, dvec3(left, sill, z - 0.01), dvec3(right, top, z), FRONT);
    mesh.material("frame");
    let bar = |mesh: &mut ObjWriter<W>, x0: f64, x1: f64, y0: f64, y1: f64| {
        mesh.cuboid(frame, dvec3(x0, y0, z - 0.06), dvec3(x1, y1, z - 0.012), FRONT);
    };
    bar(mesh, left, right, sill, sill + 0.06);
    bar(mesh, left, right, top - 0.06, top);
    for x in [left, 0.5 * (left + right) - 0.03, right - 0.06] {
        bar(mesh, x, x + 0.06, sill + 0.061, top - 0.061);
    }
    mesh.cuboid(
        frame,
        dvec3(left - 0.05, sill - 0.03, z - 0.18),
        dvec3(right + 0.05, sill - 0.002, z),
        FRONT,
    );
    mesh.material("blind");
    let slats = variation.between(8.0, 30.0) as u32;
    for slat in 0..slats {
        let y = top + 0.02 - 0.045 * f64::from(slat);
        let low = dvec3(left - 0.02, y - 0.003, z - 0.13);
        mesh.cuboid(frame, low, dvec3(right + 0.02, y, z - 0.09), 0);
    }
    mesh.cuboid(frame, dvec3(left - 0.03, top + 0.04, z - 0.14), dvec3(right + 0.03, top + 0.1, z), FRONT);
}

fn radiator<W: Write>(frame: &Frame, mesh: &mut ObjWriter<W>) {
    let z = ROOM_DEPTH - 0.06;
    mesh.material("frame");
    for fin in 0..18 {
        let x = 0.95 + 0.11 * f64::from(fin);
        mesh.cuboid(frame, dvec3(x, 0.15, z - 0.1), dvec3(x + 0.08, 0.7, z), 0);
    }
    for y in [0.2, 0.62] {
        mesh.cuboid(frame, dvec3(0.93, y, z + 0.005), dvec3(2.95, y + 0.03, z + 0.035), 0);
    }
}

/// On the corridor wall, beside and above the door.
fn board_and_clock<W: Write>(frame: &Frame, mesh: &mut ObjWriter<W>) {
    mesh.material("paper");
    mesh.cuboid(frame, dvec3(0.65, 1.0, 0.), dvec3(2.2, 2.0, 0.02), BACK);
    mesh.material("metal");
    mesh.cuboid(frame, dvec3(0.65, 0.97, 0.), dvec3(2.2, 0.995, 0.08), BACK);
    mesh.material("dark_metal");
    let clock = frame.quarter(dvec3(3.15, 2.35, 0.), 0);
    mesh.cuboid(&clock, dvec3(-0.12, -0.12, 0.), dvec3(0.12, 0.12, 0.03), BACK);
    mesh.material("paper");
    mesh.cuboid(&clock, dvec3(-0.1, -0.1, 0.03), dvec3(0.1, 0.1, 0.035), BACK);
}

/// A desk against the wall with everything on and around it, and a chair.
fn workplace<W: Write>(frame: &Frame, variation: &mut Variation, mesh: &mut ObjWriter<W>) {
    desk(frame, mesh);
    desk_things(frame, variation, mesh);
    cup(frame, dvec3(variation.between(0.3, 0.6), DESK_TOP, variation.between(0.35, 0.65)), mesh);
    waste_basket(frame, dvec3(0.58, 0., 0.95), mesh);
    let place = dvec3(variation.between(-0.3, -0.1), 0., variation.between(0.95, 1.1));
    let angle = variation.between(-0.6, 0.6);
    let fabric = variation.choose(&["fabric_blue", "fabric_red", "plastic"]);
    chair(&frame.turn(place, angle), fabric, mesh);
}

/// Height of the top of a desk.
pub(super) const DESK_TOP: f64 = 0.74;

/// 1.5 m wide and 0.8 m deep, centred on x, its back at z = 0: top, legs, panel and drawers.
fn desk<W: Write>(frame: &Frame, mesh: &mut ObjWriter<W>) {
    let under = DESK_TOP - 0.03;
    mesh.material("desk");
    mesh.cuboid(frame, dvec3(-0.75, under, 0.), dvec3(0.75, DESK_TOP, 0.8), 0);
    mesh.cuboid(frame, dvec3(-0.66, 0.3, 0.06), dvec3(0.66, under, 0.08), TOP);
    mesh.material("metal");
    for x in [-0.72, 0.67] {
        for z in [0.03, 0.72] {
            mesh.cuboid(frame, dvec3(x, 0., z), dvec3(x + 0.05, under, z + 0.05), TOP | BOTTOM);
        }
    }
    mesh.material("frame");
    mesh.cuboid(frame, dvec3(0.22, 0.05, 0.15), dvec3(0.62, 0.6, 0.7), 0);
    for drawer in 0..3 {
        let y = 0.07 + 0.178 * f64::from(drawer);
        mesh.material("desk");
        mesh.cuboid(frame, dvec3(0.23, y, 0.7), dvec3(0.61, y + 0.165, 0.715), BACK);
        mesh.material("metal");
        mesh.cuboid(frame, dvec3(0.36, y + 0.12, 0.715), dvec3(0.48, y + 0.135, 0.735), BACK);
    }
}

/// An office chair facing −z: five feet on castors, column, seat, back and arm rests.
fn chair<W: Write>(frame: &Frame, fabric: &'static str, mesh: &mut ObjWriter<W>) {
    mesh.material("dark_metal");
    for foot in 0..5 {
        let angle = f64::from(foot) * std::f64::consts::TAU / 5.0;
        let arm = frame.turn(DVec3::ZERO, angle);
        mesh.cuboid(&arm, dvec3(-0.02, 0.07, 0.05), dvec3(0.02, 0.1, 0.3), 0);
        mesh.cuboid(&arm, dvec3(-0.015, 0., 0.25), dvec3(0.015, 0.07, 0.29), TOP | BOTTOM);
    }
    mesh.tube(frame, dvec3(0., 0.06, 0.), 0.36, [0.045, 0.03], 12);
    mesh.cuboid(frame, dvec3(-0.03, 0.44, 0.2), dvec3(0.03, 0.47, 0.27), 0);
    mesh.cuboid(frame, dvec3(-0.03, 0.47, 0.24), dvec3(0.03, 0.75, 0.26), BOTTOM);
    mesh.material(fabric);
    mesh.cuboid(frame, dvec3(-0.24, 0.42, -0.24), dvec3(0.24, 0.5, 0.2), 0);
    mesh.cuboid(frame, dvec3(-0.22, 0.6, 0.17), dvec3(0.22, 1.02, 0.235), 0);
    mesh.material("plastic");
    for x in [-0.29, 0.24] {
        mesh.cuboid(frame, dvec3(x, 0.64, -0.15), dvec3(x + 0.05, 0.67, 0.12), 0);
        mesh.cuboid(frame, dvec3(x + 0.01, 0.45, -0.03), dvec3(x + 0.04, 0.64, 0.01), TOP);
    }
}

/// A bookshelf 1.2 m wide against the wall at z = 0, with five boards of books.
fn shelf<W: Write>(frame: &Frame, variation: &mut Variation, mesh: &mut ObjWriter<W>) {
    let (half, deep, high, thick) = (0.6, 0.3, 2.0, 0.02);
    mesh.material("desk");
    mesh.cuboid(frame, dvec3(-half, 0., 0.), dvec3(-half + thick, high, deep), BOTTOM | BACK);
    mesh.cuboid(frame, dvec3(half - thick, 0., 0.), dvec3(half, high, deep), BOTTOM | BACK);
    let inner = half - thick;
    mesh.cuboid(frame, dvec3(-inner, 0., 0.), dvec3(inner, high - 0.05, 0.01), BOTTOM | BACK);
    for board in 0..6 {
        let y = 0.06 + 0.37 * f64::from(board);
        mesh.material("desk");
        mesh.cuboid(frame, dvec3(-inner, y, 0.011), dvec3(inner, y + thick, deep), 0);
        if board < 5 {
            books(frame, dvec3(-inner + 0.005, y + thick, 0.03), 2.0 * inner - 0.01, variation, mesh);
        }
    }
}
