//! PLY as meshes.

use lightshaft::scene::SceneErrorKind::{Invalid, Parse};
use proptest::prelude::*;

use crate::files::{Files, area, assert_warned, corners, refused, scene};

const HEAD: &str = "ply\nformat ascii 1.0\ncomment of a test\nelement vertex 4\nproperty float x\nproperty float y\n\
                    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
const SQUARE: &str = "0 0 0\n0 0 1\n1 0 1\n1 0 0\n4 0 1 2 3\n";

fn text() -> String {
    format!("{HEAD}{SQUARE}")
}

/// The same square with corners in doubles and numbers in `ushort`, in the byte order that is asked for.
fn binary(is_big: bool) -> Vec<u8> {
    let order = if is_big { "big" } else { "little" };
    let mut file = format!(
        "ply\r\nformat binary_{order}_endian 1.0\r\nelement vertex 4\r\nproperty double x\r\nproperty uchar quality\r\n\
         property double y\r\nproperty double z\r\nelement extra 2\r\nproperty list uint short numbers\r\n\
         element face 1\r\nproperty list uchar ushort vertex_index\r\nend_header\r\n"
    )
    .into_bytes();
    let double = |x: f64| if is_big { x.to_be_bytes() } else { x.to_le_bytes() };
    let short = |x: u16| if is_big { x.to_be_bytes() } else { x.to_le_bytes() };
    let long = |x: u32| if is_big { x.to_be_bytes() } else { x.to_le_bytes() };
    for [x, z] in [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]] {
        file.extend(double(x));
        file.push(7);
        file.extend(double(0.0));
        file.extend(double(z));
    }
    for count in [0, 2] {
        file.extend(long(count));
        (0..count).for_each(|_| file.extend(short(9)));
    }
    file.push(4);
    (0..4).for_each(|corner| file.extend(short(corner)));
    file
}

#[test]
fn text_and_binary_of_both_orders_give_the_same_square() {
    let expected = scene("a.ply", text().as_bytes());
    assert_eq!((expected.triangles.len(), expected.patch_count, area(&expected)), (2, 1, 1.0));
    for [a, b, c] in corners(&expected) {
        assert!((b - a).cross(c - a).y > 0.0, "it faces up");
    }
    for is_big in [false, true] {
        assert_eq!(corners(&scene("a.PLY", &binary(is_big))), corners(&expected));
    }
    let windows = text().replace('\n', "\r\n");
    assert_eq!(corners(&scene("a.ply", windows.as_bytes())), corners(&expected));
}

#[test]
fn numbers_comments_and_lines_may_be_written_in_any_way() {
    let expected = corners(&scene("a.ply", text().as_bytes()));
    let other = text()
        .replace(SQUARE, "0 .0 0.\n0 -.0 +1\n+1. 0 1.0e0\n10.e-1 0 0\n+4 0 1 2 3\n")
        .replace("of a test", "of a caf\u{e9}");
    let latin: Vec<u8> = other.chars().map(|c| c as u8).collect();
    for file in [other.clone().into_bytes(), latin, other.replace('\n', "\r").into_bytes()] {
        assert_eq!(corners(&scene("a.ply", &file)), expected);
    }
    // Data after a header with CR alone.
    let crlf = binary(false);
    let end = crlf.windows(12).position(|twelve| twelve == b"end_header\r\n").expect("a header") + 12;
    let head: Vec<u8> = crlf[..end].iter().copied().filter(|&byte| byte != b'\n').collect();
    assert_eq!(corners(&scene("a.ply", &[&head, &crlf[end..]].concat())), expected);
}

#[test]
fn a_polygon_is_split_and_keeps_together() {
    let file = text()
        .replace("vertex 4", "vertex 6")
        .replace(SQUARE, "0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n6 0 1 2 3 4 5\n");
    let scene = scene("a.ply", file.as_bytes());
    assert_eq!((scene.triangles.len(), scene.patch_count, area(&scene)), (4, 1, 3.0));
}

#[test]
fn the_material_is_called_like_the_file_and_the_description_changes_it() {
    let dark = scene("bunny.ply", text().as_bytes());
    assert_eq!((dark.materials[0].name.as_str(), dark.materials[0].reflectance), ("bunny", [0.5; 3]));
    assert_warned(&dark, &["grey reflectance 0.5"]);
    refused(
        &[("s.toml", b"mesh = 'b.ply'\n[material.c]\n"), ("b.ply", text().as_bytes())],
        Invalid,
        "s.toml:2: no material 'c'",
    );
    let toml = "mesh = 'bunny.ply'\n[material.bunny]\nreflectance = [0.1, 0.2, 0.3]\nradiance = [3, 2, 1]\n";
    let lit = Files::new(&[("s.toml", toml.as_bytes()), ("bunny.ply", text().as_bytes())]).load_lit();
    let lit = lit.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((lit.materials[0].reflectance, lit.materials[0].radiance), ([0.1, 0.2, 0.3], [3.0, 2.0, 1.0]));
    assert!(lit.warnings.is_empty(), "{:?}", lit.warnings);
    let error = Files::new(&[("bunny.ply", text().as_bytes())]).load_lit().expect_err("no lamp").to_string();
    assert!(error.contains("nothing emits light"), "{error}");
}

#[test]
fn colours_of_bytes_are_srgb_and_meet_in_the_middle() {
    let colours = "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face";
    let coloured = text().replace("element face", colours);
    let coloured = coloured.replace("0 0 0\n", "0 0 0 255 0 188\n").replace("0 0 1\n", "0 0 1 0 0 188\n");
    let coloured =
        coloured.replace("\n1 0 1\n", "\n1 0 1 0 0 188\n").replace("\n1 0 0\n", "\n1 0 0 255 0 188\n");
    let reflectance = scene("a.ply", coloured.as_bytes()).materials[0].reflectance;
    // Half of the corners are white in red; sRGB 188 is 0.5029 of white.
    let expected = [0.5, 0.0, 0.5029];
    let is_near = reflectance.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 3e-3);
    assert!(is_near, "{reflectance:?}");

    // The colour of a face counts more than those of its corners; floats are linear.
    let list = "property list uchar int vertex_indices\n";
    let faces = coloured
        .replace(list, &format!("{list}property float red\nproperty float green\nproperty float blue\n"));
    let faces = faces.replace("4 0 1 2 3\n", "4 0 1 2 3 0.25 0.5 2\n");
    let reflectance = scene("a.ply", faces.as_bytes()).materials[0].reflectance;
    assert!((reflectance[0] - 0.25).abs() < 3e-3 && reflectance[2] == 0.98, "{reflectance:?}");
    refused(
        &[("a.ply", coloured.replace("0 0 1 0 0 188", "0 0 1 0 0 388").as_bytes())],
        Parse,
        "a.ply:15: 'vertex' cannot",
    );
}

#[test]
fn points_and_short_faces_are_skipped_and_counted() {
    let points = text()
        .replace("element face 1\nproperty list uchar int vertex_indices\n", "")
        .replace("4 0 1 2 3\n", "");
    refused(&[("a.ply", points.as_bytes())], Invalid, "a.ply: no triangles, only 4 point(s)");
    let short = text().replace("face 1", "face 3").replace("4 0 1 2 3\n", "4 0 1 2 3\n2 0 1\n0\n");
    let scene = scene("a.ply", short.as_bytes());
    assert_eq!((scene.triangles.len(), scene.counts.skipped_faces), (2, 2));
    assert_warned(&scene, &["2 face(s) with fewer than 3 corners skipped"]);
}

#[test]
fn what_is_damaged_is_refused() {
    let with = |from: &str, to: &str| text().replace(from, to);
    for (file, start) in [
        (String::new(), "a.ply:1: does not begin with 'ply'"),
        ("plyx\n".to_owned(), "a.ply:1: 'header' cannot be read"),
        ("ply\nformat ascii 1.0\n".to_owned(), "a.ply:3: the file ends before the last of 'header'"),
        (with("ascii", "utf8"), "a.ply:2: 'header' cannot be read: Couldn't parse line: 'format utf8 1.0'"),
        (with("property float y\n", ""), "a.ply: has no vertices with x, y and z"),
        (with("element vertex 4", "element corner 4"), "a.ply: has no vertices with x, y and z"),
        (with("vertex_indices", "corners"), "a.ply: has no list vertex_indices of faces"),
        (with("vertex 4", "vertex 4000000000"), "a.ply: the file is cut off: it has"),
        (with("face 1", "face 18446744073709551615"), "a.ply: the file is cut off: it has"),
        (with("face 1", "face 99999999999999999999"), "a.ply:8: 'header' cannot be read: Invalid element"),
        (
            with("element face", "element none 4000000000\nelement face"),
            "a.ply: element 'none' has no properties",
        ),
        (with("face 1", "face 2"), "a.ply:16: the file ends before the last of 'face'"),
        (with("4 0 1 2 3", "4 0 1 2 4"), "a.ply: polygon 0: vertex 4 is none of the 4"),
        (with("4 0 1 2 3", "4 0 1 2 -1"), "a.ply: polygon 0: vertex -1 is none of the 4"),
        (with("4 0 1 2 3", "9 0 1 2 3"), "a.ply:15: 'face' cannot be read"),
        (with("4 0 1 2 3", "4000000000 0 1 2 3"), "a.ply:15: 'face' cannot be read"),
        (with("4 0 1 2 3", "-4 0 1 2 3"), "a.ply:15: 'face' cannot be read"),
        (with("1 0 1\n", "1 nan 1\n"), "a.ply:13: 'vertex' cannot be read"),
        (with("1 0 1\n", "1 1e30 1\n"), "a.ply: vertex 2 is not finite or too far away"),
        (with("1 0 1\n", "1 1e60 1\n"), "a.ply: vertex 2 is not finite or too far away"),
        (with("list uchar int", "list uchar float"), "a.ply:15: 'face' cannot be read"),
        (with("comment of a test", "comment \u{1b}[31m§"), "a.ply: nothing"),
    ] {
        match start.ends_with("nothing") {
            true => assert_eq!(scene("a.ply", file.as_bytes()).triangles.len(), 2),
            false => refused(&[("a.ply", file.as_bytes())], Parse, start),
        }
    }
    let mut endless = b"ply\ncomment ".to_vec();
    endless.resize(3 << 20, b'x');
    refused(&[("a.ply", &endless)], Parse, "a.ply:");
    // A list of four billion numbers that are not there.
    let mut list = binary(false);
    let length = list.len();
    list.truncate(length - 9 - 8);
    list.extend([0xff; 4]);
    refused(&[("a.ply", &list)], Parse, "a.ply");
    let many = format!("65536{}\n", " 0".repeat(65_536));
    refused(
        &[("a.ply", text().replace("4 0 1 2 3\n", &many).replace("uchar int", "int int").as_bytes())],
        Parse,
        "a.ply: a face has more than 65535",
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

    /// Whatever happens to a file on its way, the answer is a scene or one line.
    #[test]
    fn damaged_files_are_read_or_refused(
        kind in 0..3,
        place in 0usize..1000,
        byte: u8,
        cut in prop::option::of(0usize..1000),
    ) {
        let mut file = match kind {
            0 => text().into_bytes(),
            1 => binary(false),
            _ => binary(true),
        };
        let length = file.len();
        file[place % length] = byte;
        file.truncate(cut.map_or(length, |cut| cut % length));
        if let Err(error) = Files::new(&[("a.ply", &file)]).load() {
            prop_assert!(!error.to_string().contains('\n'), "{}", error);
        }
    }
}
