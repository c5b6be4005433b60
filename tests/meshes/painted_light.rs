//! Light from walls with pictures: each piece of a wall sends out what the picture has there.

use std::process::Command;

use image::{Rgb, RgbImage};

use crate::files::Files;
use crate::textures::encoded;

/// What the bright half reflects, encoded and linear.
const BRIGHT: (u8, f64) = (230, 0.791_298);

/// A room of 4 × 3 × 4 with dark walls, and a lamp that shines at the wall at z = 0, which is bright for x below 2 and black
/// beyond: as one wall with a picture, or as two.
fn room(picture: &RgbImage) -> Files {
    let walls = "mtllib a.mtl\nv 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 4\nv 4 0 4\nv 4 3 4\nv 0 3 4\nv 2 0 0\nv 2 3 0\n\
                 vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl dark\nf 1 5 6 2\nf 4 3 7 8\nf 1 4 8 5\nf 2 6 7 3\nf 5 8 7 6\n";
    let painted = format!("{walls}usemtl wall\nf 1/1 2/2 3/3 4/4\n");
    let halves = format!("{walls}usemtl bright\nf 1 9 10 4\nusemtl black\nf 9 2 3 10\n");
    let bright = BRIGHT.1;
    let mtl = format!(
        "newmtl dark\nKd 0.1\nnewmtl wall\nmap_Kd halves.png\nnewmtl bright\nKd {bright}\nnewmtl black\nKd 0\n"
    );
    let toml = |mesh: &str| {
        format!(
            "mesh = '{mesh}'\n[[camera]]\nname = 'a'\neye = [2, 1.5, 3.9]\ntarget = [2, 1.5, 0]\nup = [0, 1, 0]\n\
             vfov_deg = 60\nwidth = 32\nheight = 24\n[[quad]]\nname = 'lamp'\nreflectance = [0, 0, 0]\n\
             radiance = [9, 9, 9]\ncorners = [[1.5, 2.5, 1.5], [2.5, 2.5, 1.5], [2.5, 1, 1.5], [1.5, 1, 1.5]]\n"
        )
    };
    Files::new(&[
        ("painted.toml", toml("painted.obj").as_bytes()),
        ("halves.toml", toml("halves.obj").as_bytes()),
        ("painted.obj", painted.as_bytes()),
        ("halves.obj", halves.as_bytes()),
        ("a.mtl", mtl.as_bytes()),
        ("halves.png", &encoded(picture, image::ImageFormat::Png)),
        // At the back of the room, and at its sides near the wall: left, right.
        ("points.txt", b"0.2 1.5 3.99 0 0 -1\n3.8 1.5 3.99 0 0 -1\n0.01 1.5 1 1 0 0\n3.99 1.5 1 -1 0 0\n"),
    ])
}

fn halves() -> RgbImage {
    RgbImage::from_fn(256, 4, |x, _| Rgb([if x < 128 { BRIGHT.0 } else { 0 }; 3]))
}

/// Reflected light at the points.
fn reflected(files: &Files, arguments: &[&str]) -> Vec<f64> {
    files.run(&[&["probe"], arguments, &["--points", "points.txt", "-o", "points.csv"]].concat());
    let table = std::fs::read_to_string(files.path("points.csv")).expect("a table");
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map(|number| number.parse().expect("a number")).collect();
        numbers[6] - numbers[9]
    };
    table.lines().skip(1).map(row).collect()
}

#[track_caller]
fn assert_near(found: &[f64], expected: &[f64], most: f64) {
    let off = found.iter().zip(expected).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    assert!(off < most, "{found:?} instead of {expected:?}: {off}");
}

#[test]
fn each_half_of_a_wall_sends_out_what_its_half_of_the_picture_has() {
    let files = room(&halves());
    let [painted, halves] = ["painted.toml", "halves.toml"].map(|scene| reflected(&files, &[scene]));
    assert!(halves[0] > 2.5 * halves[1] && halves[2] > 2.5 * halves[3], "{halves:?}");
    assert_near(&painted, &halves, 0.03);
    // Energy, and what leaves each element.
    files.run(&["check", "painted.toml", "--quality", "draft"]);
}

#[test]
fn solutions_remember_pictures_and_relighting_replaces_them() {
    let files = room(&halves());
    let painted = reflected(&files, &["painted.toml", "--quality", "draft"]);
    files.run(&["solve", "painted.toml", "-o", "a.lsol", "--quality", "draft"]);
    let stored = ["painted.toml", "--solution", "a.lsol"];
    assert_eq!(reflected(&files, &stored), painted);

    // Twice the lamp is twice the light of the same walls.
    files.run(&["relight", "a.lsol", "--set", "lamp.radiance=[18,18,18]", "-o", "b.lsol"]);
    let twice: Vec<f64> = painted.iter().map(|light| 2.0 * light).collect();
    assert_near(&reflected(&files, &["painted.toml", "--solution", "b.lsol"]), &twice, 0.01);
    // A wall of one colour is even, and then that with the picture again.
    files.run(&["relight", "b.lsol", "--set", "wall.reflectance=[0.4,0.4,0.4]", "-o", "c.lsol"]);
    let even = reflected(&files, &["painted.toml", "--solution", "c.lsol"]);
    assert!((even[0] / even[1] - 1.0).abs() < 0.05 && (even[2] / even[3] - 1.0).abs() < 0.05, "{even:?}");

    // The same mean, the other way round.
    let turned = encoded(&image::imageops::flip_horizontal(&halves()), image::ImageFormat::Png);
    std::fs::write(files.path("halves.png"), turned).expect("a picture");
    let output = Command::new(env!("CARGO_BIN_EXE_lightshaft"))
        .args(["probe", "painted.toml", "--solution", "a.lsol", "--points", "points.txt"])
        .current_dir(files.path(""))
        .output()
        .expect("a run");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && message.contains("other materials"), "{message}");
}

#[test]
fn what_is_exported_has_the_picture_by_element() {
    let files = room(&halves());
    files.run(&["solve", "painted.toml", "-o", "a.lsol", "--quality", "draft", "--one-sided"]);
    files.run(&["export", "a.lsol", "--ply", "a.ply"]);
    let bytes = std::fs::read(files.path("a.ply")).expect("a PLY");
    let end = bytes.windows(11).position(|eleven| eleven == b"end_header\n").expect("a header") + 11;
    let header = String::from_utf8_lossy(&bytes[..end]);
    let count = header.lines().find_map(|line| line.strip_prefix("element vertex ")).expect("vertices");
    let count: usize = count.parse().expect("a number");
    // Three doubles, three bytes, three floats.
    let (mut bright, mut black) = (0.0, 0.0);
    for vertex in bytes[end..].as_chunks::<39>().0.iter().take(count) {
        let number = |at: usize| f64::from_le_bytes(vertex[at..at + 8].try_into().expect("8 bytes"));
        let exitance = f32::from_le_bytes(vertex[27..31].try_into().expect("4 bytes"));
        if number(16).abs() < 1e-6 && (number(8) - 1.5).abs() < 1.0 {
            // What touches the border, or the other end of a picture that repeats, mixes a pixel.
            match number(0) {
                ..1.7 => bright = f32::max(bright, exitance),
                2.3..3.7 => black = f32::max(black, exitance),
                _ => {}
            }
        }
    }
    assert!(bright > 1.0 && black < 0.02 * bright, "{bright} beside {black}");
}
