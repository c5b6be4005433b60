//! Two rooms joined by a small opening. All walls of the first are black and shine alike, so whoever looks
//! into it sees its exitance in every direction, however deep it is; all walls of the second are black.
//! What the second receives is that exitance times the form factor of the opening, exactly.

use crate::boxes::Rectangles;

/// Radiance of the walls of the first room.
pub(crate) const RADIANCE: f64 = 2.0;

/// Lower and upper y and z of the opening.
pub(crate) const OPENING: [f64; 2] = [0.8, 1.2];

/// Material of the wall of the second room that faces the opening.
pub(crate) const FAR_WALL: u32 = 2;

/// Rooms of 2 × 2 × 2 on both sides of x = 0; the opening is a square of 0.4 in the wall between them, and
/// `shutter` is the part of it that is shut.
pub(crate) fn two_rooms(shutter: f64) -> Rectangles {
    let mut scene = Rectangles::new("two rooms");
    let shining = scene.material(0.0, RADIANCE as f32);
    let [black, far] = [0, 1].map(|_| scene.material(0.0, 0.0));
    assert_eq!(far, FAR_WALL);
    for wall in 0..6 {
        if wall != 1 {
            scene.wall([-2.0, 0.0, 0.0], [0.0, 2.0, 2.0], true, shining, wall);
        }
        if wall != 0 {
            scene.wall([0.0; 3], [2.0; 3], true, if wall == 1 { far } else { black }, wall);
        }
    }
    // The wall between them shines into the first room only.
    let [low, high] = OPENING;
    let shut = high - shutter * (high - low);
    for (y, z) in [
        ([0.0, 2.0], [0.0, low]),
        ([0.0, 2.0], [shut, 2.0]),
        ([0.0, low], [low, shut]),
        ([high, 2.0], [low, shut]),
    ] {
        let corner = |i: usize, j: usize| [0.0, y[i], z[j]];
        scene.quad([corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)], shining);
    }
    scene
}
