//! Videos, with a program in the place of ffmpeg that keeps what it is told.
#![cfg(unix)]

use std::os::unix::fs::PermissionsExt;

use crate::run::{Folder, Run};

/// Appends its arguments to `told`, one a line, and copies what it gets to the last of them.
const KEEPS: &str = r#"#!/bin/sh
[ "$1" = -version ] && exit 0
for last; do echo "$last" >> told; done
/bin/cat > "$last"
"#;

/// Likewise, but fails after the trial, having read all of the video.
const FAILS_AT_THE_END: &str = r#"#!/bin/sh
[ "$1" = -version ] && exit 0
for last; do :; done
/bin/cat > "$last"
if [ -e tried ]; then echo "no space left" >&2; exit 3; fi
: > tried
"#;

/// Likewise, having read a little of the video.
const GIVES_UP: &str = r#"#!/bin/sh
[ "$1" = -version ] && exit 0
for last; do :; done
if [ -e tried ]; then /usr/bin/head -c 10 > "$last"; echo "no space left" >&2; exit 3; fi
: > tried
/bin/cat > "$last"
"#;

/// A folder with the scene and this program.
fn with_program(text: &str) -> Folder {
    let folder = Folder::with_scene();
    std::fs::create_dir(folder.path("bin")).expect("a folder");
    folder.write("bin/ffmpeg", text);
    std::fs::set_permissions(folder.path("bin/ffmpeg"), PermissionsExt::from_mode(0o755)).expect("rights");
    folder
}

fn run(folder: &Folder, options: &[&str]) -> Run {
    let base = ["render", "scene.toml", "--quality", "draft", "--samples", "1", "-q"];
    let mut command = folder.command(&[&base[..], options].concat());
    folder.finished(command.env("PATH", folder.path("bin")))
}

#[test]
fn a_video_has_the_bytes_of_the_pictures_in_their_order() {
    let folder = with_program(KEEPS);
    let name = "my room; $(rm *) %d.mp4";
    let run = run(&folder, &["-o", "f/%d.png", "--turntable", "3", "--video", name, "--fps", "12.5"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let mut expected = Vec::new();
    for number in 1..=3 {
        let picture = image::open(folder.path(&format!("f/{number}.png"))).expect("a picture");
        expected.extend(picture.into_rgb8().into_raw());
    }
    assert!(std::fs::read(folder.path(name)).expect("a video") == expected);
    let told = std::fs::read_to_string(folder.path("told")).expect("arguments");
    for pair in ["-video_size\n64x48\n", "-framerate\n12.5\n", "-pixel_format\nrgb24\n", "-f\nmp4\n"] {
        assert_eq!(told.matches(pair).count(), 2, "not in the trial and the video: {pair}\n{told}");
    }
    assert_eq!(folder.names(), ["bin", "corner.obj", "f", name, "scene.toml", "told"]);
}

#[test]
fn a_video_of_radiance_is_exposed() {
    let folder = with_program(KEEPS);
    let turn = ["--turntable", "2", "--video", "a.mp4"];
    let bright = |exposure: &str| {
        let run = run(&folder, &[&["-o", "%d.exr", "--exposure", exposure], &turn[..]].concat());
        assert_eq!(run.code, 0, "{run:?}");
        let bytes = std::fs::read(folder.path("a.mp4")).expect("a video");
        bytes.iter().map(|&byte| u64::from(byte)).sum::<u64>()
    };
    let (dark, light) = (bright("0.01"), bright("1"));
    assert!(dark < light, "{dark} {light}");
    let run = run(&folder, &[&["-o", "%d.exr", "--view", "class"], &turn[..]].concat());
    assert_eq!(run.code, 0, "{run:?}");
}

#[test]
fn without_the_program_nothing_is_begun() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("bin")).expect("a folder");
    // The scene does not exist either: that would be code 3.
    let run = run(&folder, &["-o", "%d.png", "--turntable", "3", "--video", "a.mp4"]);
    run.expect_error(6, &["a.mp4", "no program ffmpeg", "PATH"]);
    assert_eq!(folder.names(), ["bin"]);
}

#[test]
fn a_program_that_refuses_is_found_before_anything_is_solved() {
    for (text, part) in [
        ("#!/bin/sh\nexit 1\n", "-version"),
        ("#!/bin/sh\n[ $1 = -version ] && exit 0\necho Unknown encoder >&2\nexit 1\n", "Unknown encoder"),
        ("#!/bin/sh\n[ $1 = -version ] && exit 0\n/bin/cat > /dev/null\n", "wrote nothing"),
        ("#!/bin/sh\n[ $1 = -version ] && exit 0\nkill -9 $$\n", "signal"),
        ("no program", "ffmpeg"),
    ] {
        let folder = with_program(text);
        folder.write("a.mp4", "old");
        let run = run(&folder, &["-o", "f/%d.png", "--turntable", "3", "--video", "a.mp4"]);
        run.expect_error(6, &["a.mp4", part]);
        assert_eq!(folder.names(), ["a.mp4", "bin", "corner.obj", "scene.toml"]);
        assert_eq!(std::fs::read(folder.path("a.mp4")).expect("readable"), b"old");
    }
}

#[test]
fn a_program_that_gives_up_later_leaves_the_old_video() {
    for text in [GIVES_UP, FAILS_AT_THE_END] {
        let folder = with_program(text);
        folder.write("a.mp4", "old");
        // More than a pipe holds, so that writing to it fails, and not only its end.
        let size = ["--width", "400", "--height", "300"];
        let turn = ["-o", "f/%d.png", "--turntable", "3", "--video", "a.mp4"];
        run(&folder, &[&turn[..], &size].concat()).expect_error(6, &["a.mp4", "no space left"]);
        assert_eq!(std::fs::read(folder.path("a.mp4")).expect("readable"), b"old");
        assert_eq!(folder.names(), ["a.mp4", "bin", "corner.obj", "f", "scene.toml", "tried"]);
    }
}

#[test]
fn a_video_may_go_into_the_folder_that_is_made_for_the_pictures() {
    let folder = with_program(KEEPS);
    let turn = ["-o", "f/%d.png", "--turntable", "2", "--video", "./f/a.mp4", "--stats", "f/a.json"];
    let run = run(&folder, &turn);
    assert_eq!(run.code, 0, "{run:?}");
    let mut names: Vec<_> = std::fs::read_dir(folder.path("f"))
        .expect("the folder")
        .map(|entry| entry.expect("a file").file_name().into_string().expect("a name"))
        .collect();
    names.sort();
    assert_eq!(names, ["1.png", "2.png", "a.json", "a.mp4"]);
}

#[test]
fn a_video_that_cannot_be_written_is_found_first() {
    let folder = with_program(KEEPS);
    let run = run(&folder, &["-o", "%d.png", "--turntable", "3", "--video", "no/a.mp4"]);
    run.expect_error(6, &["no/a.mp4"]);
    assert_eq!(folder.names(), ["bin", "corner.obj", "scene.toml"]);
}
