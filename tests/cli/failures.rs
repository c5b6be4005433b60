//! What cannot be rendered: one line of error, the exit code of its kind, and nothing left behind.

use crate::run::{Folder, MESH, SCENE};

/// Renders `scene` in `folder` and expects that the folder is as before.
fn fails(folder: &Folder, scene: &str, code: i32, parts: &[&str]) {
    let before = folder.names();
    folder.run(&["render", scene, "-o", "out.png", "--stats", "out.json"]).expect_error(code, parts);
    assert_eq!(folder.names(), before, "a failed run left something behind");
}

#[test]
fn missing_scene_is_code_3() {
    fails(&Folder::new(), "nowhere.toml", 3, &["nowhere.toml"]);
    fails(&Folder::new(), "nowhere.obj", 3, &["nowhere.obj"]);
}

#[test]
fn a_folder_as_scene_is_code_3() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("room.toml")).expect("a folder");
    fails(&folder, "room.toml", 3, &["room.toml"]);
}

#[test]
fn missing_mesh_of_a_scene_is_code_3_and_named() {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE);
    fails(&folder, "scene.toml", 3, &["corner.obj"]);
}

#[test]
fn malformed_description_is_code_4_with_file_and_line() {
    let folder = Folder::with_scene();
    folder.write("scene.toml", "mesh = \"corner.obj\"\n\nmeters_per_unit = = 1\n");
    fails(&folder, "scene.toml", 4, &["scene.toml", "3"]);
}

#[test]
fn malformed_mesh_is_code_4() {
    let folder = Folder::with_scene();
    folder.write("bad.obj", MESH.replace("v 1 0 1", "v 1 x 1"));
    fails(&folder, "bad.obj", 4, &["bad.obj"]);
}

#[test]
fn binary_rubbish_is_code_4_on_one_line() {
    let folder = Folder::new();
    folder.write("bad.toml", [0xff, 0xfe, 0x00, 0x1b, 0x5b, 0x33, 0x31, 0x6d]);
    fails(&folder, "bad.toml", 4, &["bad.toml"]);
}

#[test]
fn a_mesh_without_triangles_is_code_5() {
    let folder = Folder::new();
    folder.write("empty.obj", "v 0 0 0\n");
    fails(&folder, "empty.obj", 5, &["empty.obj"]);
}

#[test]
fn a_scene_without_light_is_code_5() {
    let folder = Folder::with_scene();
    let dark = &SCENE[..SCENE.find("[[quad]]").expect("the lamp")];
    folder.write("scene.toml", dark);
    fails(&folder, "scene.toml", 5, &["emi"]);
}

#[test]
fn a_camera_that_looks_at_itself_is_code_5() {
    let folder = Folder::with_scene();
    folder.write("scene.toml", SCENE.replace("target = [0, 0.8, 0]", "target = [0, 1, 4]"));
    fails(&folder, "scene.toml", 5, &["eye"]);
}

#[test]
fn a_camera_without_pixels_is_code_5() {
    let folder = Folder::with_scene();
    folder.write("scene.toml", SCENE.replace("width = 64", "width = 0"));
    fails(&folder, "scene.toml", 5, &["width"]);
}

#[test]
fn an_output_in_a_missing_folder_is_code_6() {
    let folder = Folder::with_scene();
    let run = folder.run(&["render", "scene.toml", "-o", "no/such/a.png"]);
    run.expect_error(6, &["no/such"]);
    assert_eq!(folder.names(), ["corner.obj", "scene.toml"]);
}

#[test]
fn outputs_that_cannot_be_written_are_code_6_and_found_before_the_scene_is_read() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("taken.png")).expect("a folder");
    folder.write("file", "");
    let before = folder.names();
    for (output, part) in [
        ("taken.png", "taken.png"),
        ("file/a.png", "file"),
        ("a.jpg", ".png, .exr or .hdr"),
        ("a", ".png, .exr or .hdr"),
        ("no/a.exr", "no"),
    ] {
        // The scene does not exist either: that would be code 3.
        folder.run(&["render", "scene.toml", "-o", output]).expect_error(6, &[part]);
    }
    folder
        .run(&["render", "scene.toml", "-o", "a.png", "--stats", "no/stats.json"])
        .expect_error(6, &["no/stats.json"]);
    assert_eq!(folder.names(), before);
}

#[cfg(target_os = "linux")]
#[test]
fn an_output_where_nobody_may_write_is_code_6() {
    Folder::with_scene()
        .run(&["render", "scene.toml", "-o", "/proc/a.png"])
        .expect_error(6, &["/proc/a.png"]);
}

#[cfg(unix)]
#[test]
fn an_output_in_a_folder_without_write_permission_is_code_6_before_the_scene_is_read() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let shut = folder.path("shut");
    std::fs::create_dir(&shut).expect("a folder");
    std::fs::set_permissions(&shut, std::fs::Permissions::from_mode(0o555)).expect("rights");
    if std::fs::write(shut.join("probe"), "").is_ok() {
        // Rights do not bind root.
        return;
    }
    // The scene does not exist: were it read first, that would be code 3.
    folder.run(&["render", "scene.toml", "-o", "shut/a.png"]).expect_error(6, &["shut/a.png"]);
}

#[test]
fn a_read_only_picture_is_not_replaced() {
    let folder = Folder::with_scene();
    folder.write("a.png", "old");
    let mut rights = folder.path("a.png").metadata().expect("metadata").permissions();
    rights.set_readonly(true);
    std::fs::set_permissions(folder.path("a.png"), rights).expect("rights");
    folder.run(&["render", "scene.toml", "-o", "a.png"]).expect_error(6, &["a.png", "read-only"]);
    assert_eq!(std::fs::read(folder.path("a.png")).expect("readable"), b"old");
}

#[test]
fn a_name_too_long_is_code_6_before_the_scene_is_read() {
    let name = format!("{}.png", "a".repeat(300));
    Folder::new().run(&["render", "scene.toml", "-o", &name]).expect_error(6, &["cannot write"]);
}

/// A file that may not grow is a full disk that needs no disk.
#[cfg(unix)]
#[test]
fn a_full_disk_is_code_6_for_every_kind_of_output() {
    for output in ["a.png", "a.exr", "a.csv"] {
        let folder = Folder::with_scene();
        let verb = if output == "a.csv" { "probe --grid 1 --spacing 0.02" } else { "render --width 200" };
        let program = env!("CARGO_BIN_EXE_lightshaft");
        let line = format!(
            "trap '' XFSZ; ulimit -f 1; exec {program} {verb} --quality draft -q scene.toml -o {output}"
        );
        let run = folder.finished(std::process::Command::new("sh").args(["-c", &line]));
        run.expect_error(6, &[output, "cannot write: "]);
        assert_eq!(folder.names(), ["corner.obj", "scene.toml"]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_killed_run_leaves_nothing_half_written() {
    use rustix::fs::{Mode, OFlags, open};
    let folder = Folder::new();
    let flags = OFlags::TMPFILE | OFlags::RDWR;
    if open(folder.path(""), flags, Mode::RUSR).is_err() {
        // The file system knows no files without a name.
        return;
    }
    let office = ["generate", "office", "--floors", "30", "--rooms", "50", "-o", "."];
    let mut child = folder.command(&office).spawn().expect("the binary starts");
    let files = format!("/proc/{}/fd", child.id());
    let is_writing = || {
        let mut open = std::fs::read_dir(&files).expect("its files").flatten();
        open.any(|file| std::fs::read_link(file.path()).is_ok_and(|to| to.starts_with(folder.path(""))))
    };
    while !is_writing() {
        assert_eq!(child.try_wait().expect("its state"), None, "it ended before it was killed");
    }
    child.kill().expect("killed");
    child.wait().expect("its end");
    assert_eq!(folder.names(), Vec::<String>::new());
}

#[test]
fn an_old_picture_survives_a_failed_run() {
    let folder = Folder::new();
    folder.write("out.png", "old");
    folder.write("scene.toml", "mesh = [");
    folder.run(&["render", "scene.toml", "-o", "out.png"]).expect_error(4, &["scene.toml"]);
    assert_eq!(std::fs::read(folder.path("out.png")).expect("readable"), b"old");
    assert_eq!(folder.names(), ["out.png", "scene.toml"]);
}

#[test]
fn embree_that_is_demanded_and_not_there_is_code_7() {
    let folder = Folder::with_scene();
    let run = folder.run(&[
        "render",
        "scene.toml",
        "-o",
        "a.png",
        "--tracer",
        "embree",
        "--embree-lib",
        "no-such-embree.so",
    ]);
    run.expect_error(7, &["Embree", "no-such-embree.so"]);
    assert_eq!(folder.names(), ["corner.obj", "scene.toml"]);
}

#[test]
fn doctor_says_on_both_ways_that_embree_is_missing() {
    let run = Folder::new().run(&["doctor", "--embree-lib", "no-such-embree.so"]);
    assert_eq!(run.code, 7, "{run:?}");
    assert!(run.stdout.contains("fallback"), "{run:?}");
    assert!(run.stderr.starts_with("error: ") && run.stderr.lines().count() == 1, "{run:?}");
}

#[test]
fn an_office_is_not_written_over_somebodys_files() {
    let folder = Folder::with_scene();
    let before = folder.names();
    let office = ["generate", "office", "--floors", "1", "--rooms", "1", "-o"];
    folder.run(&[&office[..], &["."]].concat()).expect_error(6, &["scene.toml", "not generated"]);
    folder.run(&[&office[..], &["scene.toml"]].concat()).expect_error(6, &["scene.toml"]);
    folder.run(&[&office[..], &["scene.toml/deep"]].concat()).expect_error(6, &["scene.toml/deep"]);
    assert_eq!(folder.names(), before);
    assert_eq!(std::fs::read_to_string(folder.path("scene.toml")).expect("readable"), SCENE);
}

#[test]
fn an_office_too_large_to_write_is_code_2() {
    let folder = Folder::new();
    let run = folder.run(&["generate", "office", "--floors", "1000", "--rooms", "1000", "-o", "new"]);
    run.expect_error(2, &["1000000 rooms", "at most"]);
    assert_eq!(folder.names(), Vec::<String>::new());
}

#[test]
fn a_unit_that_no_scene_has_is_refused_with_its_line() {
    let folder = Folder::with_scene();
    folder.write("scene.toml", SCENE.replace("meters_per_unit = 1.0", "meters_per_unit = 1e300"));
    folder
        .run(&["render", "scene.toml", "-o", "a.png"])
        .expect_error(5, &["scene.toml:3", "meters_per_unit"]);
}

#[test]
fn a_vertex_so_far_away_that_the_lamp_vanishes_is_named() {
    let folder = Folder::with_scene();
    folder.write("corner.obj", format!("{MESH}v 0 0 1e9\nf 1 2 11\n"));
    folder
        .run(&["render", "scene.toml", "-o", "a.png"])
        .expect_error(5, &["scene.toml", "0e0 0e0 1e9", "precision"]);
    assert_eq!(folder.names(), ["corner.obj", "scene.toml"]);
}

#[test]
fn a_picture_of_nothing_is_a_warning() {
    let folder = Folder::with_scene();
    folder.write("scene.toml", SCENE.replace("target = [0, 0.8, 0]", "target = [0, 1, 9]"));
    let run = folder.run(&["render", "scene.toml", "-o", "a.png", "--quality", "draft"]);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.stderr.contains("warning: the picture is black: camera 'main'"), "{}", run.stderr);
}
