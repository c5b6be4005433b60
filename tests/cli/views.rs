//! Several pictures of one solution: cameras, turntables and paths.

use std::path::Path;

use crate::render::render;
use crate::run::{Folder, Run, SCENE, names};
use crate::statistics::stats;

/// A folder with the small scene and its solution, `room.lsol`.
fn solved() -> Folder {
    let folder = Folder::with_scene();
    let run = folder.run(&["solve", "scene.toml", "-o", "room.lsol", "--quality", "draft", "-q"]);
    assert_eq!(run.code, 0, "{run:?}");
    folder
}

/// Renders from the solution; `options` are added.
fn view(folder: &Folder, output: &str, options: &[&str]) -> Run {
    let base = ["render", "scene.toml", "--solution", "room.lsol", "-o", output, "--samples", "2"];
    let run = folder.run(&[&base[..], options].concat());
    assert_eq!((run.code, run.stdout.as_str()), (0, ""), "{options:?}: {run:?}");
    run
}

fn bytes(folder: &Folder, name: &str) -> Vec<u8> {
    std::fs::read(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

const PATH: &str = "
[[keyframe]]
time = 0
eye = [0, 1, 4]
target = [0, 0.8, 0]

[[keyframe]]
time = 0.5
eye = [1, 1.2, 4]
target = [0, 0.8, 0]
vfov_deg = 30

[[keyframe]]
time = 1
eye = [3, 1, 3]
target = [0, 0.5, 0]
";

#[test]
fn each_of_several_cameras_gives_the_picture_that_it_gives_alone() {
    let folder = solved();
    let cameras = ["--camera", "side", "--camera", "main"];
    for kind in [&[][..], &["--view", "mesh"], &["--view", "links"], &["--final-gather"]] {
        let alone = ["side", "main"].map(|camera| {
            view(&folder, "alone.png", &[&["--camera", camera], kind].concat());
            bytes(&folder, "alone.png")
        });
        let run = view(&folder, "at %s.png", &[&cameras, kind, &["--stats", "a.json"]].concat());
        assert!(
            bytes(&folder, "at side.png") == alone[0] && bytes(&folder, "at main.png") == alone[1],
            "{kind:?}"
        );
        assert_eq!(stats(&folder, "a.json").frames, 2);
        if kind.contains(&"links") {
            assert!(run.stderr.contains("camera 'side': links over which"), "{run:?}");
        } else {
            assert_eq!(run.stderr.matches("exposure chosen").count(), 2, "{run:?}");
            assert!(run.stderr.contains("camera 'main'"), "{run:?}");
        }
        view(&folder, "pictures/100%%-%02d.png", &[&cameras, kind].concat());
        assert_eq!(names(&folder.path("pictures")), ["100%-01.png", "100%-02.png"]);
        assert!(bytes(&folder, "pictures/100%-02.png") == alone[1], "{kind:?}");
    }
    view(&folder, "%s.exr", &["--camera", "side"]);
    assert!(folder.path("side.exr").is_file(), "a script may have a list of one camera");
    view(&folder, "%d.exr", &[]);
    assert!(folder.path("%d.exr").is_file(), "one picture may be called anything");
}

#[test]
fn a_turntable_begins_where_the_camera_stands_and_does_not_repeat() {
    let folder = solved();
    for kind in [&[][..], &["--view", "mesh"], &["--final-gather"]] {
        view(&folder, "alone.exr", kind);
        view(&folder, "four/%d.exr", &[&["--turntable", "4", "--stats", "a.json"], kind].concat());
        assert_eq!(names(&folder.path("four")), ["1.exr", "2.exr", "3.exr", "4.exr"]);
        view(&folder, "two/%d.exr", &[&["--turntable", "2"], kind].concat());
        assert!(bytes(&folder, "four/1.exr") == bytes(&folder, "alone.exr"), "{kind:?}");
        // What was computed for another picture before has no say.
        assert!(bytes(&folder, "four/3.exr") == bytes(&folder, "two/2.exr"), "{kind:?}");
        assert!(bytes(&folder, "four/4.exr") != bytes(&folder, "four/1.exr"), "{kind:?}");
        let stats = stats(&folder, "a.json");
        assert_eq!(stats.frames, 4);
        assert!(stats.frames_per_second > 0.0 && stats.frames_per_second >= 4.0 / stats.seconds.render);
    }
    view(&folder, "around/%d.exr", &["--turntable", "3", "--around", "-1,1.5,-0.5", "--camera", "side"]);
    assert_eq!(names(&folder.path("around")).len(), 3);
}

#[test]
fn a_sequence_has_one_exposure_and_says_which() {
    let folder = solved();
    let told = view(&folder, "a/%d.png", &["--turntable", "5"]);
    let lines: Vec<&str> = told.stderr.lines().filter(|line| line.contains("exposure chosen")).collect();
    let [line] = lines[..] else { panic!("not one exposure: {told:?}") };
    let exposure = line.split(": ").nth(1).and_then(|rest| rest.split(' ').next()).expect("a number");
    view(&folder, "b/%d.png", &["--turntable", "5", "--exposure", exposure]);
    // It is told with four digits: at most a step in some channels.
    let open = |name: &str| image::open(folder.path(name)).expect("a picture").into_rgb8().into_raw();
    for number in 1..=5 {
        let pair = ["a", "b"].map(|set| open(&format!("{set}/{number}.png")));
        assert!(pair[0].iter().zip(&pair[1]).all(|(a, b)| a.abs_diff(*b) <= 1), "{number}");
    }
    let own = |name: &str| view(&folder, name, &["--camera", "side"]).stderr.contains(exposure);
    assert!(!own("c.png"), "another picture has another exposure");
    let told = view(&folder, "d/%d.png", &["--turntable", "5", "--view", "links"]);
    assert_eq!(told.stderr.matches("links over which").count(), 1, "one scale for all: {told:?}");
    let told = view(&folder, "e/%d.exr", &["--turntable", "2"]);
    assert!(!told.stderr.contains("exposure"), "radiance is not exposed: {told:?}");
}

#[test]
fn sequences_are_the_same_for_any_number_of_threads() {
    let folder = solved();
    folder.write("path.toml", PATH);
    for kind in [&["--view", "mesh"][..], &["--view", "partial"], &["--final-gather"], &[]] {
        let path = [&["--path", "path.toml", "--frames", "3"], kind].concat();
        view(&folder, "one/%d.png", &[&path[..], &["--threads", "1"]].concat());
        view(&folder, "three/%d.png", &[&path[..], &["--threads", "3"]].concat());
        for name in names(&folder.path("one")) {
            let both = ["one", "three"].map(|set| bytes(&folder, &format!("{set}/{name}")));
            assert!(both[0] == both[1], "{kind:?} {name}");
        }
    }
}

#[test]
fn a_path_meets_its_keyframes() {
    let folder = solved();
    folder.write("path.toml", PATH);
    view(&folder, "%03d.exr", &["--path", "path.toml", "--fps", "4"]);
    let made: Vec<String> = folder.names().into_iter().filter(|name| name.ends_with(".exr")).collect();
    assert_eq!(made, ["001.exr", "002.exr", "003.exr", "004.exr", "005.exr"]);
    view(&folder, "main.exr", &[]);
    assert!(bytes(&folder, "001.exr") == bytes(&folder, "main.exr"));
    // The last keyframe stands where the other camera does, and has the size of the first.
    view(&folder, "side.exr", &["--camera", "side", "--width", "64", "--height", "48"]);
    assert!(bytes(&folder, "005.exr") == bytes(&folder, "side.exr"));
    view(&folder, "n/%d.exr", &["--path", "path.toml", "--frames", "3"]);
    assert!(bytes(&folder, "n/2.exr") == bytes(&folder, "003.exr"));
    view(&folder, "d/%d.png", &["--path", "path.toml", "--width", "8"]);
    assert_eq!(names(&folder.path("d")).len(), 25, "24 a second when nothing is said");
}

#[test]
fn pictures_that_see_nothing_are_counted() {
    let folder = solved();
    // From (0, 1, 4) it looks away from the room; half around it looks back.
    let run = view(&folder, "%d.png", &["--turntable", "2", "--around", "0,1,9"]);
    assert!(run.stderr.contains("warning: 1.png is black"), "{run:?}");
    // The eye comes close behind the board and the wall, which are dark; the room is behind it.
    let run = view(&folder, "%d.png", &["--turntable", "3", "--around", "0,1,4000"]);
    assert!(run.stderr.contains("of 3 pictures are black, 1.png the first"), "{run:?}");
}

/// Expects that a run fails and that nothing has changed.
fn refused(folder: &Folder, output: &str, options: &[&str], code: i32, parts: &[&str]) {
    let before = folder.names();
    let base = ["render", "scene.toml", "--solution", "room.lsol", "-o", output, "-q"];
    let run = folder.run(&[&base[..], options].concat());
    assert_eq!(run.code, code, "{options:?}: {run:?}");
    assert!(run.stderr.starts_with("error: "), "{run:?}");
    for part in parts {
        assert!(run.stderr.contains(part), "{options:?}: no '{part}' in {run:?}");
    }
    assert_eq!(folder.names(), before, "{options:?}");
}

#[test]
fn options_that_make_no_sense_together_are_code_2() {
    let folder = solved();
    folder.write("path.toml", PATH);
    let two = &["--camera", "side", "--camera", "main"][..];
    let turn = &["--turntable", "3"][..];
    for (output, options, parts) in [
        ("a.png", two, &["a.png", "no place", "%s"][..]),
        ("a.png", turn, &["a.png", "no place", "%04d"]),
        ("%s.png", turn, &["%s is the name of a camera", "%04d"]),
        ("%04d/a.png", turn, &["no place"]),
        ("%d-%d.png", turn, &["two places"]),
        ("%x.png", turn, &["stands before"]),
        ("%s.png", &["--camera", "side", "--camera", "side"], &["side", "twice"]),
        ("%s.png", &["--camera", "side", "--camera", "none"], &["'none'", "main, side"]),
        ("%s.png", &["--camera", "../side", "--camera", "main"], &["'../side'", "%d"]),
        ("%d.png", &["--camera", "side", "--camera", "main", "--turntable", "3"], &["--camera once"]),
        ("%d.png", &["--turntable", "0"], &["--turntable", "10000"]),
        ("%d.png", &["--turntable", "1000000"], &["--turntable", "10000"]),
        ("%d.png", &["--turntable", "-3"], &["--turntable"]),
        ("%d.png", &["--turntable", "3", "--path", "path.toml"], &["--path"]),
        ("%d.png", &["--turntable", "3", "--frames", "3"], &["--path"]),
        ("%d.png", &["--path", "path.toml", "--around", "0,0,0"], &["--turntable"]),
        ("%d.png", &["--frames", "3"], &["--path"]),
        ("%d.png", &["--turntable", "3", "--fps", "3"], &["--fps"]),
        ("a.png", &["--fps", "3"], &["--fps"]),
        ("a.png", &["--around", "0,0,0"], &["--turntable"]),
        ("%d.png", &["--turntable", "3", "--around", "0,0"], &["three finite numbers"]),
        ("%d.png", &["--turntable", "3", "--around", "0,nan,0"], &["three finite numbers"]),
        ("%d.png", &["--turntable", "3", "--around", "0,7,4"], &["axis", "--around"]),
        ("%d.png", &["--turntable", "3", "--around", "0,1,4"], &["axis", "--around"]),
        ("%d.png", &["--turntable", "3", "--around", "1e300,1,4"], &["too far", "--around"]),
        ("%d.png", &["--path", "path.toml", "--frames", "0"], &["--frames"]),
        ("%d.png", &["--path", "path.toml", "--frames", "1000000"], &["--frames"]),
        ("%d.png", &["--path", "path.toml", "--frames", "3", "--fps", "3"], &["--fps"]),
        ("%d.png", &["--path", "path.toml", "--fps", "nan"], &["--fps"]),
        ("%d.png", &["--path", "path.toml", "--fps", "100000"], &["--fps", "1000"]),
        ("a.png", &["--video", "a.mp4"], &["--video", "--turntable"]),
        ("%d.png", &["--turntable", "3", "--video", "a.avi"], &["a.avi", ".mp4"]),
        ("%d.png", &["--turntable", "3", "--reference", "a.exr"], &["--reference"]),
        ("%d.toml", &["--turntable", "3", "--stats", "2.toml"], &["2.toml", ".json"]),
        ("%d.exr", &["--turntable", "3", "--exposure", "2"], &["--exposure", ".exr"]),
        ("a.json/%d.png", &["--turntable", "3", "--stats", "a.json"], &["a.json", "twice"]),
        ("a.mp4/%d.png", &["--turntable", "3", "--video", "a.mp4"], &["a.mp4", "twice"]),
    ] {
        let code = if output.ends_with(".toml") { 6 } else { 2 };
        let parts = if code == 6 { &[".png, .exr or .hdr"] } else { parts };
        refused(&folder, output, options, code, parts);
    }
}

#[test]
fn frames_never_go_over_what_is_read() {
    let folder = solved();
    std::fs::rename(folder.path("scene.toml"), folder.path("3.png")).expect("renamed");
    let run = folder.run(&["render", "3.png", "-o", "%d.png", "--turntable", "3", "-q"]);
    run.expect_error(2, &["3.png"]);
    folder.write("scene.toml", SCENE);
    folder.write("02.png", PATH);
    refused(&folder, "%02d.png", &["--path", "02.png", "--frames", "2"], 2, &["02.png", "twice"]);
    refused(&folder, "./%02d.png", &["--path", "02.png", "--frames", "2"], 2, &["02.png", "twice"]);
    view(&folder, "%02d.png", &["--path", "02.png", "--frames", "1"]);
}

#[test]
fn paths_that_cannot_be_followed_name_their_line() {
    let folder = solved();
    refused(&folder, "%d.png", &["--path", "none.toml"], 3, &["none.toml"]);
    std::fs::create_dir(folder.path("folder")).expect("a folder");
    refused(&folder, "%d.png", &["--path", "folder"], 3, &["folder"]);
    for (old, new, code, parts) in [
        ("time = 0.5", "time = = 1", 4, ["path.toml:8: ", ""]),
        ("time = 0.5", "moment = 1", 4, ["path.toml:8: ", "moment"]),
        ("eye = [1, 1.2, 4]\n", "", 4, ["path.toml:7: ", "eye"]),
        ("time = 0.5", "time = 2", 5, ["path.toml:14: ", "not after 2"]),
        ("time = 0.5", "time = nan", 5, ["path.toml:8: ", "NaN"]),
        ("eye = [1, 1.2, 4]", "eye = [0, 0.8, 0]", 5, ["path.toml:10: ", "same point"]),
        ("vfov_deg = 30", "vfov_deg = 0", 5, ["path.toml:11: ", "vfov_deg"]),
        ("vfov_deg = 30", "up = [1, 0.4, 4]", 5, ["path.toml:11: ", "parallel"]),
    ] {
        let text = PATH.replace(old, new);
        assert_ne!(text, PATH, "{old}");
        folder.write("path.toml", text);
        refused(&folder, "%d.png", &["--path", "path.toml", "--frames", "3"], code, &parts);
    }
    folder.write("path.toml", &PATH[..PATH.rfind("[[").expect("keyframes")]);
    view(&folder, "ok/%d.png", &["--path", "path.toml", "--frames", "2"]);
    folder.write("path.toml", &PATH[..3 + PATH[3..].find("[[").expect("keyframes")]);
    refused(&folder, "%d.png", &["--path", "path.toml"], 5, &["path.toml:2: ", "one [[keyframe]]"]);
    folder.write("path.toml", "");
    refused(&folder, "%d.png", &["--path", "path.toml"], 5, &["path.toml: ", "no [[keyframe]]"]);
    folder.write("path.toml", PATH.replace("time = 1", "time = 1e6"));
    refused(&folder, "%d.png", &["--path", "path.toml"], 2, &["path.toml", "24000001 pictures", "10000"]);
    folder.write("path.toml", PATH.replace("time = 1", "time = 1e9"));
    refused(&folder, "%d.png", &["--path", "path.toml", "--fps", "1000"], 2, &["path.toml", "10000"]);
}

#[test]
fn every_output_is_checked_before_the_scene_is_read() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("3.png")).expect("a folder");
    folder.write("file", "");
    let before = folder.names();
    for (output, part) in [
        ("%d.png", "3.png"),
        ("no/such/%d.png", "no"),
        ("file/%d.png", "file"),
        ("%d.jpg", ".png, .exr or .hdr"),
    ] {
        // The scene does not exist either: that would be code 3.
        folder.run(&["render", "scene.toml", "-o", output, "--turntable", "4"]).expect_error(6, &[part]);
    }
    assert_eq!(folder.names(), before);
    let folder = Folder::with_scene();
    let taken = "frames/2.png";
    std::fs::create_dir_all(folder.path(taken)).expect("a folder");
    folder
        .run(&["render", "scene.toml", "-o", "frames/%d.png", "--turntable", "2"])
        .expect_error(6, &[taken]);
    assert_eq!(names(Path::new(&folder.path("frames"))), ["2.png"]);
}

#[test]
fn a_picture_by_itself_counts_as_one() {
    let folder = Folder::with_scene();
    let run = render(&folder, "a.png", &["--stats", "a.json"]);
    assert_eq!(stats(&folder, "a.json").frames, 1);
    assert!(run.stderr.contains("pictures a second"), "{run:?}");
}
