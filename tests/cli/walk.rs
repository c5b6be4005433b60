//! `export --html`: what is packed in a page to walk through, by a reader of the tests' own, and what cannot be written. How
//! the page looks and behaves is looked at in `tests/pages`.

use std::io::Read;
use std::process::Command;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;

use crate::run::{Folder, SCENE};

/// A folder with a solved scene, and something that passes for three.js in `three`.
fn solved() -> Folder {
    let folder = Folder::with_scene();
    with_library(&folder);
    // A name that must not become part of the page.
    folder.write("room.toml", SCENE.replace("\"side\"", "\"</script><b>side\""));
    let run = folder.run(&["solve", "room.toml", "-o", "room.lsol", "--quality", "draft", "-q"]);
    assert_eq!(run.code, 0, "{run:?}");
    folder
}

fn with_library(folder: &Folder) {
    std::fs::create_dir_all(folder.path("three/build")).expect("a folder");
    folder.write("three/build/three.module.js", "// Three.js Authors\nimport {} from './three.core.js';");
    folder.write("three/build/three.core.js", "// Three.js Authors\nexport const REVISION = '0';");
    folder.write("three/LICENSE", "Terms of <three>");
}

fn page(folder: &Folder, name: &str, options: &[&str]) -> String {
    let arguments = ["export", "room.lsol", "--html", name, "--three", "three", "-q"];
    let run = folder.run(&[&arguments, options].concat());
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (0, "", ""), "{run:?}");
    std::fs::read_to_string(folder.path(name)).expect("a page")
}

fn unpacked(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let deflated = STANDARD.decode(text).expect("base64");
    flate2::read::ZlibDecoder::new(&deflated[..]).read_to_end(&mut bytes).expect("deflated");
    bytes
}

/// A corner: where it is, in metres, its light and its mark.
#[derive(Clone, Copy, Debug)]
struct Corner {
    position: DVec3,
    light: DVec3,
    mark: f64,
}

/// The triangles of a page.
fn triangles(page: &str) -> Vec<[Corner; 3]> {
    let mut triangles = Vec::new();
    for script in page.split("<script type=\"application/octet-stream\" class=\"part\" ").skip(1) {
        let number = |name: &str| -> usize {
            let value =
                script.split(&format!("data-{name}=\"")).nth(1).and_then(|rest| rest.split('"').next());
            value.and_then(|digits| digits.parse().ok()).unwrap_or_else(|| panic!("no {name}"))
        };
        let (vertices, count) = (number("vertices"), number("triangles"));
        let content =
            script.split('>').nth(1).and_then(|rest| rest.strip_suffix("</script")).expect("a script");
        let bytes = unpacked(content);
        assert_eq!(bytes.len(), 20 * vertices + 6 * count);
        let mut at = 0;
        let mut read = |count: usize, planes: usize| -> Vec<u32> {
            let mut value = 0u32;
            let values = (0..count).map(|i| {
                let byte = |plane: usize| u32::from(bytes[at + plane * count + i]) << (8 * plane);
                value = value.wrapping_add((0..planes).map(byte).sum());
                value & (u32::MAX >> (32 - 8 * planes))
            });
            let values = values.collect();
            at += planes * count;
            values
        };
        let axes = [0; 3].map(|_| read(vertices, 4));
        let channels = [0; 4].map(|_| read(vertices, 2));
        let half = |bits: u32| half::f16::from_bits(bits as u16).to_f64();
        let corner = |index: u32| {
            let index = index as usize;
            Corner {
                position: DVec3::from_array(
                    [0, 1, 2].map(|i: usize| f64::from(f32::from_bits(axes[i][index]))),
                ),
                light: DVec3::from_array([0, 1, 2].map(|i: usize| half(channels[i][index]))),
                mark: half(channels[3][index]),
            }
        };
        let corners: Vec<Corner> = read(3 * count, 2).into_iter().map(corner).collect();
        triangles.extend(corners.chunks(3).map(|corners| [corners[0], corners[1], corners[2]]));
    }
    triangles
}

#[test]
fn a_page_holds_the_scene_with_all_of_its_light() {
    let folder = solved();
    let page = page(&folder, "room.html", &["--exposure", "2"]);
    let triangles = triangles(&page);
    let area = triangles
        .iter()
        .map(|[a, b, c]| 0.5 * (b.position - a.position).cross(c.position - a.position).length());
    let area: f64 = area.sum();
    // Floor, wall, board and lamp, both sides.
    assert!((area - 2.0 * (4.0 + 4.0 + 0.64 + 0.36)).abs() < 1e-4, "{area}");
    // Brighter than any screen, and not cut off.
    let brightest = triangles.iter().flatten().fold(DVec3::ZERO, |most, corner| most.max(corner.light));
    assert!(brightest.distance(2.0 * DVec3::new(12.0, 11.0, 10.0)) < 0.02, "{brightest}");
    let dimmest = triangles.iter().flatten().filter(|corner| corner.light.min_element() > 0.0);
    assert!(dimmest.map(|corner| corner.light.max_element()).fold(f64::INFINITY, f64::min) < 0.5);
    // The middle of an element, which is last, knows its class; corners know nothing.
    for [a, b, middle] in &triangles {
        assert_eq!((a.mark, b.mark), (0.0, 0.0));
        assert!((1.0..=4.0).contains(&middle.mark) && middle.mark.fract() == 0.0, "{}", middle.mark);
    }
    assert!(triangles.iter().any(|[.., middle]| middle.mark != triangles[0][2].mark), "several classes");
}

#[test]
fn a_page_needs_nothing_else_and_names_are_text() {
    let folder = solved();
    let page = page(&folder, "room.html", &[]);
    for part in [
        "<title>room – lightshaft</title>",
        ">main</option>",
        "&lt;/script&gt;&lt;b&gt;side</option>",
        "\\u003c/script>\\u003cb>side",
        "Terms of &lt;three&gt;",
        "\"tone\":\"filmic\"",
        "partly visible",
        "default-src 'none'",
    ] {
        assert!(page.contains(part), "{part} is missing");
    }
    for part in ["<b>side", "http:", "https:", " src=", "@import"] {
        assert!(!page.contains(part), "{part} is there");
    }
    let library =
        page.split("id=\"three-core\">").nth(1).and_then(|rest| rest.split('<').next()).expect("a library");
    assert!(String::from_utf8_lossy(&unpacked(library)).contains("REVISION = '0'"));
    assert!(self::page(&folder, "plain.html", &["--tone", "plain"]).contains("\"tone\":\"plain\""));
}

#[test]
fn the_same_page_for_any_number_of_threads() {
    let folder = solved();
    let [one, three] = ["1", "3"].map(|threads| page(&folder, "room.html", &["--threads", threads]));
    assert!(one == three);
}

/// Expects that a run fails, with one line, and that nothing has changed.
fn refused(folder: &Folder, command: &mut Command, code: i32, parts: &[&str]) {
    let before = folder.names();
    folder.finished(command).expect_error(code, parts);
    assert_eq!(folder.names(), before, "{command:?}");
}

#[test]
fn a_missing_or_foreign_library_is_said_before_the_work() {
    let folder = Folder::new();
    with_library(&folder);
    // There is no solution: the library is looked for first.
    let export = |options: &[&str]| {
        let mut command =
            folder.command(&[&["export", "none.lsol", "--html", "a.html", "-q"], options].concat());
        command.env_remove("LIGHTSHAFT_THREE");
        command
    };
    refused(&folder, &mut export(&["--three", "nowhere"]), 3, &["nowhere", "three.module.js", "--three"]);
    refused(&folder, export(&[]).env("LIGHTSHAFT_THREE", "nowhere"), 3, &["nowhere", "LIGHTSHAFT_THREE"]);
    refused(&folder, export(&["--three", "three"]).env("LIGHTSHAFT_THREE", "nowhere"), 3, &["none.lsol"]);
    folder.write("three/build/three.core.js", "export const REVISION = '0';");
    refused(&folder, &mut export(&["--three", "three"]), 4, &["three.core.js", "no module of three.js"]);
    folder.write("three/build/three.core.js", [0xff; 40]);
    refused(&folder, &mut export(&["--three", "three"]), 4, &["three.core.js"]);
    // The program may have a copy of its own.
    let bare = folder.finished(&mut export(&[]));
    let part = if bare.stderr.contains("none.lsol") { "none.lsol" } else { "--three or LIGHTSHAFT_THREE" };
    bare.expect_error(3, &[part]);
    refused(
        &folder,
        &mut folder.command(&["export", "none.lsol", "--html", "a.htm", "-q"]),
        2,
        &["--html", ".html"],
    );
    let run = folder.run(&["export", "none.lsol", "--glb", "a.glb", "--three", "three"]);
    assert_eq!(run.code, 2, "{run:?}");
}

#[test]
fn a_page_that_cannot_be_written_leaves_nothing() {
    let folder = solved();
    for (name, parts) in [("nowhere/a.html", "nowhere"), ("three.html", "not a regular file")] {
        std::fs::create_dir_all(folder.path("three.html")).expect("a folder");
        let arguments = ["export", "room.lsol", "--html", name, "--three", "three", "-q"];
        refused(&folder, &mut folder.command(&arguments), 6, &[parts]);
    }
}
