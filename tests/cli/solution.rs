//! Solution files: written by `solve`, read by `--solution` of other commands, refused when they do not fit.

use crate::layers::Channels;
use crate::run::{Folder, MESH, Run, SCENE};
use crate::statistics::stats;

const DRAFT: [&str; 2] = ["--quality", "draft"];

/// A folder with the small scene and its solution, `room.lsol`.
fn solved(options: &[&str]) -> Folder {
    let folder = Folder::with_scene();
    solve(&folder, "room.lsol", options);
    folder
}

fn solve(folder: &Folder, output: &str, options: &[&str]) -> Run {
    let run = folder.run(&[&["solve", "scene.toml", "-o", output][..], &DRAFT, options].concat());
    assert_eq!((run.code, run.stdout.as_str()), (0, ""), "{run:?}");
    run
}

fn bytes(folder: &Folder, name: &str) -> Vec<u8> {
    std::fs::read(folder.path(name)).expect("a file")
}

/// Runs that end well.
fn run(folder: &Folder, arguments: &[&str]) -> Run {
    let run = folder.run(arguments);
    assert_eq!(run.code, 0, "{arguments:?}: {run:?}");
    run
}

#[test]
fn a_picture_of_a_file_is_that_of_its_scene_byte_by_byte() {
    for options in
        [&["--tracer", "fallback"][..], &["--tracer", "auto"], &["--tracer", "auto", "--one-sided"]]
    {
        let folder = solved(options);
        assert_eq!(folder.names(), ["corner.obj", "room.lsol", "scene.toml"]);
        for view in [
            &["--camera", "side"][..],
            &["--view", "mesh"],
            &["--view", "class"],
            &["--view", "partial"],
            &["--width", "37", "--samples", "3"],
        ] {
            let render = &["render", "scene.toml", "-o"][..];
            run(&folder, &[render, &["a.exr"], &DRAFT, options, view].concat());
            let tracer = &options[..2];
            let stored = ["b.exr", "--solution", "room.lsol", "--threads", "3"];
            run(&folder, &[render, &stored, tracer, view].concat());
            assert!(bytes(&folder, "a.exr") == bytes(&folder, "b.exr"), "{options:?} {view:?}");
        }
    }
}

/// Elements for display change what interpolation shows, and nothing else.
#[test]
fn a_local_pass_is_for_what_is_shown() {
    let folder = solved(&[]);
    let told = solve(&folder, "shown.lsol", &["--local-pass", "--stats", "a.json", "--threads", "2"]);
    assert_eq!(told.code, 0, "{told:?}");
    let stats = stats(&folder, "a.json");
    let pass = stats.local_pass.expect("what was made");
    assert!(pass.elements > stats.scene.elements && pass.bytes > 0 && pass.seconds > 0.0, "{pass:?}");
    solve(&folder, "again.lsol", &["--local-pass", "--threads", "1"]);
    assert!(bytes(&folder, "shown.lsol") == bytes(&folder, "again.lsol"));
    let made = |command: &[&str], output: &str, solution: &str| {
        let (name, rest) = command.split_first().expect("a command");
        let typed = [&[name, "scene.toml", "--solution", solution, "-o", output][..], rest].concat();
        run(&folder, &typed);
        bytes(&folder, output)
    };
    for (command, output, is_same) in [
        (&["render", "--samples", "2"][..], "a.exr", false),
        (&["render", "--samples", "2", "--final-gather"], "a.exr", true),
        (&["render", "--samples", "2", "--view", "mesh"], "a.exr", true),
        (&["render", "--samples", "2", "--view", "partial"], "a.exr", true),
        (&["probe", "--grid", "0.5", "--spacing", "0.4", "--samples", "64"], "a.csv", true),
    ] {
        let [with, without] = ["shown.lsol", "room.lsol"].map(|solution| made(command, output, solution));
        assert_eq!(with == without, is_same, "{command:?}");
    }
    // Elements of layers are those that links have, whatever is shown.
    let layers = ["render", "--samples", "1", "--layers"];
    let [with, without] = [("a.exr", "shown.lsol"), ("b.exr", "room.lsol")].map(|(picture, solution)| {
        made(&layers, picture, solution);
        Channels::of(&folder, picture)
    });
    for name in ["element.id", "class.id"] {
        assert_eq!(with.ids(name), without.ids(name), "{name}");
    }
    assert!(with.floats("irradiance.R") != without.floats("irradiance.R"));
    // What is gathered is exposed by itself, in a sequence too.
    let turned = ["shown", "room"].map(|name| {
        let (solution, pictures) = (format!("{name}.lsol"), format!("{name}-%d.png"));
        let typed = ["render", "scene.toml", "--solution", &solution, "-o", &pictures, "--final-gather"];
        run(&folder, &[&typed[..], &["--turntable", "2", "--width", "24", "--samples", "1"]].concat());
        bytes(&folder, &format!("{name}-1.png"))
    });
    assert!(turned[0] == turned[1], "the exposure is that of elements for display");
    // A model is made of what is shown.
    for solution in ["shown.lsol", "room.lsol"] {
        run(&folder, &["export", solution, "--ply", &format!("{solution}.ply"), "-q"]);
    }
    let [with, without] = ["shown.lsol.ply", "room.lsol.ply"].map(|name| bytes(&folder, name).len());
    assert!(with > without, "{with} and {without} bytes");
    // Other light is not that of before.
    let other = ["relight", "shown.lsol", "--set", "lamp.radiance=[9,9,9]", "-o"];
    let told = run(&folder, &[&other[..], &["relit.lsol"]].concat());
    assert!(told.stderr.contains("--local-pass"), "{told:?}");
    let told = run(&folder, &[&other[..], &["relit-shown.lsol", "--local-pass"]].concat());
    assert!(!told.stderr.contains("--local-pass"), "{told:?}");
    let [with, without] = ["relit-shown.lsol", "relit.lsol"].map(|name| bytes(&folder, name).len());
    assert!(with > without, "{with} and {without} bytes");
}

#[test]
fn the_cost_of_solving_is_not_in_the_file() {
    let folder = solved(&[]);
    let view = ["render", "scene.toml", "--solution", "room.lsol", "-o", "a.png", "--view", "cost"];
    folder.run(&view).expect_error(2, &["--view cost", "solution file"]);
}

#[test]
fn statistics_are_those_of_the_solution_without_its_clocks() {
    let folder = Folder::with_scene();
    let told = solve(&folder, "room.lsol", &["--stats", "a.json", "--threads", "2"]);
    assert!(told.stderr.contains("initial triangles"), "{told:?}");
    let again = run(
        &folder,
        &[
            "render",
            "scene.toml",
            "--solution",
            "room.lsol",
            "-o",
            "b.png",
            "--stats",
            "b.json",
            "--threads",
            "2",
        ],
    );
    assert!(again.stderr.contains("room.lsol: solved by lightshaft"), "{again:?}");
    let (mut first, mut second) = (stats(&folder, "a.json"), stats(&folder, "b.json"));
    assert!(first.seconds.refine > 0.0 && first.visibility.seconds > 0.0);
    assert_eq!((second.seconds.refine, second.seconds.solve, second.visibility.seconds), (0.0, 0.0, 0.0));
    assert_eq!((first.frames, first.frames_per_second, second.frames), (0, 0.0, 1));
    for stats in [&mut first, &mut second] {
        (stats.frames, stats.frames_per_second) = (0, 0.0);
        stats.seconds = Default::default();
        stats.visibility.seconds = 0.0;
        stats.memory.peak_rss_bytes = 0;
    }
    assert_eq!(format!("{first:?}"), format!("{second:?}"));
}

#[test]
fn points_and_checks_take_a_file_too() {
    let folder = solved(&[]);
    folder.write("points.txt", "0 0.01 0 0 1 0\n0.5 0.3 -0.9 0 0 1\n");
    let probe = ["probe", "scene.toml", "--points", "points.txt", "-q"];
    let first = run(&folder, &[&probe[..], &DRAFT].concat());
    let second = run(&folder, &[&probe[..], &["--solution", "room.lsol"]].concat());
    assert!(!first.stdout.is_empty());
    assert_eq!(first.stdout, second.stdout);
    let check = ["check", "scene.toml"];
    let first = folder.run(&[&check[..], &DRAFT].concat());
    let second = folder.run(&[&check[..], &["--solution", "room.lsol"]].concat());
    assert_eq!((first.code, first.stdout), (second.code, second.stdout));
}

#[test]
fn the_same_scene_makes_the_same_file() {
    let folder = solved(&["--threads", "1"]);
    solve(&folder, "again.lsol", &["--threads", "4", "--quiet"]);
    assert!(bytes(&folder, "room.lsol") == bytes(&folder, "again.lsol"));
}

#[test]
fn options_of_solving_do_not_go_with_a_file() {
    let folder = solved(&[]);
    for option in [
        &["--quality", "draft"][..],
        &["--epsilon", "0.1"],
        &["--rays", "4"],
        &["--min-size", "0.1"],
        &["--iterations", "9"],
        &["--visibility", "adaptive"],
        &["--certify"],
        &["--one-sided"],
    ] {
        let commands: [&[&str]; 3] = [
            &["render", "scene.toml", "-o", "a.png"],
            &["probe", "scene.toml", "--grid", "0"],
            &["check", "scene.toml"],
        ];
        for command in commands {
            let run = folder.run(&[command, &["--solution", "room.lsol"], option].concat());
            assert_eq!(run.code, 2, "{run:?}");
            assert!(run.stderr.contains("--solution") && run.stderr.contains(option[0]), "{run:?}");
        }
    }
    assert_eq!(folder.names(), ["corner.obj", "room.lsol", "scene.toml"]);
}

/// Renders from a file and expects that it is refused and nothing has changed.
fn refused(folder: &Folder, scene: &str, solution: &str, code: i32, parts: &[&str]) {
    folder.write("a.png", "old");
    let before = folder.names();
    folder
        .run(&["render", scene, "--solution", solution, "-o", "a.png", "--stats", "a.json", "-q"])
        .expect_error(code, parts);
    assert_eq!(folder.names(), before);
    assert_eq!(bytes(folder, "a.png"), b"old");
}

#[test]
fn files_that_do_not_fit_are_named_with_what_to_do() {
    let folder = solved(&[]);
    refused(&folder, "scene.toml", "none.lsol", 3, &["none.lsol"]);
    std::fs::create_dir(folder.path("folder.lsol")).expect("a folder");
    refused(&folder, "scene.toml", "folder.lsol", 3, &["folder.lsol", "not a regular file"]);
    for content in ["", "v 0 0 0\nv 1 0 0\n"] {
        folder.write("text.lsol", content);
        refused(&folder, "scene.toml", "text.lsol", 4, &["text.lsol", "no solution file", "solve"]);
    }
    let whole = bytes(&folder, "room.lsol");
    folder.write("half.lsol", &whole[..whole.len() / 2]);
    refused(&folder, "scene.toml", "half.lsol", 4, &["half.lsol", "ends too early", "solve again"]);
    for (name, at) in [("first.lsol", 20), ("middle.lsol", whole.len() / 2), ("last.lsol", whole.len() - 1)] {
        let mut damaged = whole.clone();
        damaged[at] ^= 4;
        folder.write(name, &damaged);
        refused(&folder, "scene.toml", name, 4, &[name, "damaged", "solve again"]);
    }
    let mut newer = whole;
    newer[8] += 1;
    let sum = crc32fast::hash(&newer[..32]).to_le_bytes();
    newer[32..36].copy_from_slice(&sum);
    folder.write("newer.lsol", &newer);
    refused(
        &folder,
        "scene.toml",
        "newer.lsol",
        4,
        &["newer.lsol", "newer lightshaft", "format 4", "solve again"],
    );

    folder.write("dark.toml", SCENE.replace("reflectance = [0.5,", "reflectance = [0.4,"));
    refused(&folder, "dark.toml", "room.lsol", 4, &["room.lsol", "materials", "solve again"]);
    folder.write("dim.toml", SCENE.replace("radiance = [12,", "radiance = [11,"));
    refused(&folder, "dim.toml", "room.lsol", 4, &["room.lsol", "materials", "solve again"]);
    folder.write("other.toml", SCENE.replace("corner.obj", "other.obj"));
    folder.write("other.obj", MESH.replace("v 0.4 0.5 0.4", "v 0.4 0.51 0.4"));
    refused(&folder, "other.toml", "room.lsol", 4, &["room.lsol", "geometry", "solve again"]);
    // Other cameras see the same light.
    folder.write("views.toml", SCENE.replace("name = \"main\"", "name = \"front\""));
    run(&folder, &["render", "views.toml", "--solution", "room.lsol", "-o", "b.png", "--camera", "front"]);
}

#[test]
fn outputs_are_checked_before_anything_is_solved() {
    let folder = Folder::with_scene();
    for (output, code, part) in
        [("room.png", 2, ".lsol"), ("nowhere/room.lsol", 6, "nowhere"), ("scene.toml", 2, "scene.toml")]
    {
        folder.run(&["solve", "scene.toml", "-o", output]).expect_error(code, &[part]);
    }
    std::fs::rename(folder.path("scene.toml"), folder.path("scene.lsol")).expect("renamed");
    folder.run(&["solve", "scene.lsol", "-o", "scene.lsol"]).expect_error(2, &["scene.lsol"]);
    assert_eq!(folder.names(), ["corner.obj", "scene.lsol"]);
}
