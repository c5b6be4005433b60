//! What lies on desks and shelves: keyboards, screens, paper, cups, books, plants. This is where most of
//! the triangles are, as in real interiors.

use std::io::Write;

use glam::{DVec3, dvec3};

use super::furniture::DESK_TOP;
use super::obj_writer::ObjWriter;
use super::shapes::{BACK, BOTTOM, Frame, TOP};
use super::variation::Variation;

/// Screen, keyboard, mouse, paper and a desk lamp that is switched off.
pub(super) fn desk_things<W: Write>(frame: &Frame, variation: &mut Variation, mesh: &mut ObjWriter<W>) {
    let middle = variation.between(-0.3, -0.1);
    let desk = frame.quarter(dvec3(middle, DESK_TOP, 0.), 0);
    screen(&desk.turn(dvec3(0., 0., 0.2), variation.between(-0.25, 0.25)), mesh);
    keyboard(&desk.turn(dvec3(0., 0., 0.52), variation.between(-0.08, 0.08)), mesh);
    mesh.material("plastic");
    mesh.cuboid(&desk, dvec3(0.28, 0., 0.5), dvec3(0.34, 0.03, 0.6), BOTTOM);
    mesh.material("paper");
    let stack = variation.between(0.01, 0.12);
    let sheets = frame.turn(dvec3(0.5, DESK_TOP, 0.18), variation.between(-0.3, 0.3));
    mesh.cuboid(&sheets, dvec3(-0.105, 0., -0.148), dvec3(0.105, stack, 0.148), BOTTOM);
    desk_lamp(&frame.quarter(dvec3(-0.62, DESK_TOP, 0.15), 0), mesh);
}

fn screen<W: Write>(frame: &Frame, mesh: &mut ObjWriter<W>) {
    mesh.material("plastic");
    mesh.cuboid(frame, dvec3(-0.12, 0., -0.1), dvec3(0.12, 0.015, 0.1), BOTTOM);
    mesh.cuboid(frame, dvec3(-0.02, 0.015, -0.05), dvec3(0.02, 0.2, -0.03), TOP | BOTTOM);
    mesh.cuboid(frame, dvec3(-0.27, 0.12, -0.028), dvec3(0.27, 0.46, 0.012), 0);
    mesh.material("window");
    mesh.cuboid(frame, dvec3(-0.26, 0.14, 0.012), dvec3(0.26, 0.45, 0.014), BACK);
}

/// Five rows of fourteen keys.
fn keyboard<W: Write>(frame: &Frame, mesh: &mut ObjWriter<W>) {
    mesh.material("dark_metal");
    mesh.cuboid(frame, dvec3(-0.22, 0., -0.07), dvec3(0.22, 0.018, 0.07), BOTTOM);
    mesh.material("frame");
    for row in 0..5 {
        for column in 0..14 {
            let low = dvec3(-0.21 + 0.03 * f64::from(column), 0.018, -0.06 + 0.0245 * f64::from(row));
            mesh.cuboid(frame, low, low + dvec3(0.026, 0.008, 0.02), BOTTOM);
        }
    }
}

/// A round foot, an arm and a conical shade open below.
fn desk_lamp<W: Write>(frame: &Frame, mesh: &mut ObjWriter<W>) {
    mesh.material("dark_metal");
    mesh.cylinder(frame, DVec3::ZERO, 0.02, 0.08, 20);
    mesh.tube(frame, dvec3(0., 0.02, 0.), 0.36, [0.008, 0.008], 8);
    mesh.material("metal");
    // One sheet of metal: both of its sides reflect.
    mesh.tube(frame, dvec3(0., 0.3, 0.), 0.14, [0.1, 0.03], 20);
    mesh.disc(frame, dvec3(0., 0.44, 0.), 0.03, 20, true);
}

/// A mug with coffee in it.
pub(super) fn cup<W: Write>(frame: &Frame, base: DVec3, mesh: &mut ObjWriter<W>) {
    mesh.material("paper");
    mesh.vessel(frame, base, 0.095, [0.035, 0.04], 16);
    mesh.material("dark_metal");
    mesh.disc(frame, base + DVec3::Y * 0.07, 0.035, 16, true);
    mesh.material("paper");
    mesh.cuboid(frame, base + dvec3(0.041, 0.02, -0.005), base + dvec3(0.065, 0.075, 0.005), 0);
}

pub(super) fn waste_basket<W: Write>(frame: &Frame, base: DVec3, mesh: &mut ObjWriter<W>) {
    mesh.material("dark_metal");
    mesh.vessel(frame, base, 0.32, [0.11, 0.14], 20);
}

/// Books side by side on one board, of runs of one colour, with a gap here and there.
pub(super) fn books<W: Write>(
    frame: &Frame,
    start: DVec3,
    width: f64,
    variation: &mut Variation,
    mesh: &mut ObjWriter<W>,
) {
    const COVERS: [&str; 6] =
        ["fabric_red", "fabric_blue", "book_green", "book_ochre", "paper", "dark_metal"];
    let mut x = 0.0;
    let mut left_of_colour = 0;
    loop {
        let thick = variation.between(0.018, 0.055);
        if x + thick > width {
            break;
        }
        if left_of_colour == 0 {
            mesh.material(variation.choose(&COVERS));
            left_of_colour = variation.between(2.0, 8.0) as u32;
        }
        left_of_colour -= 1;
        let size = dvec3(thick, variation.between(0.2, 0.32), variation.between(0.16, 0.24));
        let low = start + DVec3::X * x;
        mesh.cuboid(frame, low, low + size, BOTTOM);
        x += thick + 0.0015;
        if variation.once_in(9) {
            x += variation.between(0.02, 0.15);
        }
    }
}

/// A pot with earth and leaves around a stem.
pub(super) fn plant<W: Write>(
    frame: &Frame,
    base: DVec3,
    variation: &mut Variation,
    mesh: &mut ObjWriter<W>,
) {
    mesh.material("pot");
    mesh.vessel(frame, base, 0.3, [0.11, 0.15], 24);
    mesh.material("leaf");
    mesh.tube(frame, base + DVec3::Y * 0.25, 0.6, [0.012, 0.008], 8);
    let leaves = variation.between(16.0, 40.0) as u32;
    for leaf in 0..leaves {
        let angle = 2.4 * f64::from(leaf) + variation.between(-0.3, 0.3);
        let height = 0.35 + 0.5 * f64::from(leaf) / f64::from(leaves);
        let length = variation.between(0.12, 0.26);
        let rise = variation.between(-0.05, 0.15);
        let stalk = frame.turn(base + DVec3::Y * height, angle);
        // A flat rhombus, a little off the stem.
        let tip = dvec3(0., rise, 0.02 + length);
        let middle = dvec3(0., 0.5 * rise, 0.02 + 0.5 * length);
        let wide = dvec3(0.2 * length, 0., 0.);
        mesh.panel(&stalk, [dvec3(0., 0., 0.02), middle + wide, tip, middle - wide]);
    }
}
