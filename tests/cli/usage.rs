//! The binary's answers to what is typed: help, version, bad arguments.

use std::process::Stdio;

use crate::run::{Folder, MESH};

#[test]
fn help_is_an_answer_and_not_an_error() {
    let folder = Folder::new();
    for arguments in
        [&["--help"][..], &["-h"], &["help"], &["render", "--help"], &["generate", "office", "--help"]]
    {
        let run = folder.run(arguments);
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{arguments:?}");
        assert!(run.stdout.contains("Usage: lightshaft"), "{}", run.stdout);
    }
}

/// The long options named in `text`, sorted.
fn options_in<'a>(text: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let is_name = |c: char| c.is_ascii_lowercase() || c == '-';
    let mut options: Vec<&str> = text
        .flat_map(|line| line.match_indices("--").map(move |(at, _)| &line[at..]))
        .map(|rest| &rest[..rest.find(|c| !is_name(c)).unwrap_or(rest.len())])
        .collect();
    options.sort_unstable();
    options.dedup();
    options
}

#[test]
fn the_readme_has_every_option_of_render_and_no_other() {
    let help = Folder::new().run(&["render", "--help"]).stdout;
    let declared = help.lines().filter(|line| line.trim_start().starts_with('-'));
    let mut declared = options_in(declared);
    declared.retain(|&option| option != "--help");
    assert!(declared.len() >= 20, "{declared:?}");
    let table = include_str!("../../README.md").split("\n## Options of `render`").nth(1).expect("the table");
    let rows = table.lines().filter(|line| line.starts_with("| `-"));
    assert_eq!(options_in(rows.filter_map(|row| row.split(" | ").next())), declared);
}

#[test]
fn help_has_the_exit_codes() {
    let help = Folder::new().run(&["render", "--help"]).stdout;
    for line in ["Exit codes:", "   3  an input file", "  70  a fault"] {
        assert!(help.contains(line), "{line}:\n{help}");
    }
}

/// A script believes the code, and whoever reads only the help must not expect it of light that rounding moved.
#[test]
fn help_and_readme_agree_on_when_tracers_disagree() {
    let rule = "code is 9 when a ray is wrong, or links or light differ though no ray does";
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let help = words(&Folder::new().run(&["compare", "--help"]).stdout);
    assert!(help.contains(rule), "{help}");
    assert!(words(include_str!("../../README.md")).contains(rule));
}

#[test]
fn version_is_the_packages() {
    let run = Folder::new().run(&["--version"]);
    assert_eq!((run.code, run.stdout.trim()), (0, concat!("lightshaft ", env!("CARGO_PKG_VERSION"))));
}

#[test]
fn bad_arguments_are_code_2_and_say_what_is_wrong() {
    let folder = Folder::with_scene();
    let before = folder.names();
    for (arguments, word) in [
        (&["paint"][..], "paint"),
        (&["render"], "SCENE"),
        (&["render", "scene.toml"], "--output"),
        (&["render", "scene.toml", "-o"], "--output"),
        (&["render", "scene.toml", "-o", "a.png", "--rays", "0"], "--rays"),
        (&["render", "scene.toml", "-o", "a.png", "--epsilon", "nan"], "--epsilon"),
        (&["render", "scene.toml", "-o", "a.png", "--min-size", "-1"], "--min-size"),
        (&["render", "scene.toml", "-o", "a.png", "--width", "0"], "--width"),
        (&["render", "scene.toml", "-o", "a.png", "--exposure", "inf"], "--exposure"),
        (&["render", "scene.toml", "-o", "a.png", "--visibility", "none"], "adaptive"),
        (&["render", "scene.toml", "-o", "a.png", "--quality", "best"], "normal"),
        (&["render", "scene.toml", "-o", "a.png", "--tracer", "optix"], "fallback"),
        (&["render", "scene.toml", "-o", "a.png", "--colour"], "--colour"),
        (&["generate"], "office"),
        (&["generate", "office", "--floors", "1", "-o", "b"], "--rooms"),
        (&["generate", "office", "--floors", "0", "--rooms", "1", "-o", "b"], "--floors"),
        (&["generate", "office", "--floors", "1", "--rooms", "9999", "-o", "b"], "--rooms"),
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, 2, "{arguments:?}: {run:?}");
        assert!(run.stderr.contains(word), "'{word}' is not in the answer to {arguments:?}: {}", run.stderr);
        assert_eq!(run.stdout, "", "{arguments:?}");
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn options_against_each_other_are_one_line() {
    let folder = Folder::with_scene();
    let base = ["render", "scene.toml", "-o", "a.png"];
    for (options, word) in [
        (&["--certify", "--visibility", "sampled"][..], "--certify"),
        (&["--tracer", "fallback", "--embree-lib", "x.so"], "--embree-lib"),
        (&["--stats", "a.png"], "a.png"),
        (&["--stats", "scene.toml"], "scene.toml"),
        (&["--stats", "corner.obj"], ".json"),
    ] {
        folder.run(&[&base[..], options].concat()).expect_error(2, &[word]);
    }
    assert_eq!(folder.names(), ["corner.obj", "scene.toml"]);
}

#[test]
fn what_the_scene_is_read_from_is_never_written_over() {
    let folder = Folder::with_scene();
    const LIBRARY: &str = "newmtl white\nKd 0.8 0.8 0.8\n";
    folder.write("library.json", LIBRARY);
    folder.write("corner.obj", format!("mtllib library.json\n{MESH}"));
    for arguments in [
        &["render", "scene.toml", "-o", "a.png", "--stats", "library.json"][..],
        &["check", "scene.toml", "--json", "./library.json"],
        &["probe", "scene.toml", "--grid", "0.5", "-o", "library.json"],
    ] {
        folder.run(arguments).expect_error(2, &["library.json"]);
        assert_eq!(std::fs::read_to_string(folder.path("library.json")).expect("the library"), LIBRARY);
    }
    folder.run(&["check", "scene.toml", "--json", "corner.obj"]).expect_error(2, &["corner.obj", ".json"]);
    assert_eq!(folder.names(), ["corner.obj", "library.json", "scene.toml"]);
}

#[test]
fn spacing_belongs_to_a_grid() {
    let folder = Folder::with_scene();
    folder.write("points.txt", "0 0 0 0 1 0\n");
    let run = folder.run(&["probe", "scene.toml", "--points", "points.txt", "--spacing", "0.5"]);
    run.expect_error(2, &["--spacing"]);
}

#[test]
fn an_unknown_camera_is_told_which_there_are() {
    let folder = Folder::with_scene();
    let run = folder.run(&["render", "scene.toml", "-o", "a.png", "--camera", "top"]);
    run.expect_error(2, &["'top'", "main", "side"]);
    assert_eq!(folder.names(), ["corner.obj", "scene.toml"]);
}

#[test]
fn a_reader_that_leaves_early_is_no_panic() {
    let folder = Folder::new();
    for arguments in [&["render", "--help"][..], &["doctor"], &["render", "missing.toml", "-o", "a.png"]] {
        let mut child = folder
            .command(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary starts");
        drop(child.stdout.take());
        drop(child.stderr.take());
        let code = child.wait().expect("it ends").code();
        assert!(matches!(code, Some(0 | 3 | 7)), "{arguments:?} ended with {code:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_answer_that_cannot_be_written_is_code_6() {
    let folder = Folder::with_scene();
    folder.write("points.txt", "0 0 0 0 1 0\n");
    for arguments in [
        &["probe", "scene.toml", "--points", "points.txt", "--quality", "draft", "-q"][..],
        &["check", "scene.toml", "--quality", "draft"],
        &["doctor"],
    ] {
        let full = std::fs::File::options().write(true).open("/dev/full").expect("a full device");
        let output = folder.command(arguments).stdout(full).output().expect("the binary runs");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(6), "{arguments:?}: {stderr}");
        assert!(stderr.contains("error: standard output: cannot write"), "{arguments:?}: {stderr}");
    }
}

/// Files are written before anything is said.
#[cfg(target_os = "linux")]
#[test]
fn an_answer_that_cannot_be_written_costs_no_file() {
    let folder = Folder::with_scene();
    let quick = ["--quality", "draft", "--repeat", "1", "--threads", "2"];
    let profile = ["profile", "scene.toml", "--strategies", "adaptive", "--tracers", "fallback"];
    let of_profile = ["--json", "p.json", "--plot", "p.svg", "--html", "p.html", "--trace", "t.json"];
    let compare = ["compare", "scene.toml", "--rays", "100"];
    let of_compare = ["--json", "c.json", "--html", "c.html", "--replay-file", "c.replay"];
    let with_embree = crate::run::has_embree(&folder).then_some((&compare[..], &of_compare[..]));
    for (arguments, files) in [(&profile[..], &of_profile[..])].into_iter().chain(with_embree) {
        let full = std::fs::File::options().write(true).open("/dev/full").expect("a full device");
        let all = [arguments, &quick, files].concat();
        let output = folder.command(&all).stdout(full).output().expect("the binary runs");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(6), "{arguments:?}: {stderr}");
        for file in files.iter().skip(1).step_by(2) {
            assert!(folder.path(file).is_file(), "{file} is missing");
        }
    }
}
