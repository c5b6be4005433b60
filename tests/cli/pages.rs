//! `--html`: the pages of `compare` and `profile` as files. How they behave is looked at in `tests/pages`.

use crate::run::{Folder, SCENE, has_embree};

const PROFILE: [&str; 10] = [
    "profile",
    "--quality",
    "draft",
    "--repeat",
    "1",
    "--rays",
    "4",
    "--tracers",
    "fallback",
    "--strategies",
];

#[test]
fn a_page_of_a_profile_is_one_file_with_all_runs() {
    let folder = Folder::with_scene();
    folder.write("room.toml", SCENE);
    let options = ["adaptive,sampled", "room.toml", "-q", "--html", "a.html", "--threads", "2"];
    let run = folder.run(&[&PROFILE[..], &options].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    assert_eq!(folder.names(), ["a.html", "corner.obj", "room.toml", "scene.toml"]);
    let page = std::fs::read_to_string(folder.path("a.html")).expect("a page");
    for part in [
        "<title>room: where visibility time goes</title>",
        "sampled, fallback, 4 rays",
        "<svg ",
        "lightshaft profile --quality draft --repeat 1",
        "fingerprint ",
        ">quality</th><td>draft<",
        ">materials</th><td>fingerprint ",
        env!("CARGO_PKG_VERSION"),
    ] {
        assert!(page.contains(part), "{part} is missing:\n{page}");
    }
    let above = folder.path("a.html").parent().expect("a folder").to_string_lossy().into_owned();
    assert!(!page.contains(&above), "where the test runs was not typed:\n{page}");
}

#[test]
fn a_page_of_a_comparison_has_the_pictures_and_what_it_was_made_with() {
    let folder = Folder::with_scene();
    if !has_embree(&folder) {
        return;
    }
    let options = [
        "--quality",
        "draft",
        "--rays",
        "2000",
        "--repeat",
        "1",
        "--solves",
        "1",
        "--html",
        "a.html",
        "--width",
        "24",
    ];
    let run = folder.run(&[&["compare", "scene.toml", "-q"][..], &options].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let page = std::fs::read_to_string(folder.path("a.html")).expect("a page");
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 3, "{page}");
    for part in
        ["The tracers agree.", "mean FLIP", "main, 24 × 18 pixels", "--rays 2000", "4.", "type=\"range\""]
    {
        assert!(page.contains(part), "{part} is missing:\n{page}");
    }
}

/// A scene takes its name from its file, and materials from the mesh: neither may become part of the page.
#[cfg(unix)]
#[test]
fn names_of_files_become_text() {
    let folder = Folder::with_scene();
    let name = "<img src=x onerror=alert(1)>&'.toml";
    folder.write(name, SCENE);
    let run = folder.run(&[&PROFILE[..], &["adaptive", name, "-q", "--html", "a.html"]].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let page = std::fs::read_to_string(folder.path("a.html")).expect("a page");
    assert!(
        page.contains("&lt;img src=x onerror=alert(1)&gt;&amp;") && !page.contains("<img src=x"),
        "{page}"
    );
    // The heat maps.
    assert_eq!(page.matches("<img").count(), 4, "{page}");
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 4, "{page}");
}

/// A name may hold what works on a terminal, or ends a line of one.
#[cfg(unix)]
#[test]
fn control_characters_of_names_are_nowhere_raw() {
    let folder = Folder::with_scene();
    let name = "a\u{1b}[31mb\u{7}.toml";
    folder.write(name, SCENE);
    let files = ["--html", "a.html", "--plot", "a.svg", "--json", "a.json"];
    let run = folder.run(&[&PROFILE[..], &["adaptive", name], &files].concat());
    assert_eq!(run.code, 0, "{run:?}");
    let read = |name: &str| std::fs::read_to_string(folder.path(name)).expect("written");
    for text in [run.stdout.clone(), run.stderr.clone(), read("a.html"), read("a.svg"), read("a.json")] {
        assert!(!text.contains(|c: char| c.is_control() && !"\n\t".contains(c)), "{text:?}");
    }
    assert!(read("a.html").contains(r"$'a\033[31mb\007.toml'"), "{}", read("a.html"));
    folder.run(&["compare", name, "--replay", "no\u{1b}ne"]).expect_error(3, &["no"]);
}

#[test]
fn a_page_that_cannot_be_written_is_said_before_anything_is_solved() {
    let folder = Folder::with_scene();
    let before = folder.names();
    for (options, code, part) in
        [(&["--html", "a.htm"][..], 2, ".html"), (&["--html", "no/a.html"], 6, "no/a.html")]
    {
        folder.run(&[&["compare", "scene.toml", "-q"][..], options].concat()).expect_error(code, &[part]);
        folder
            .run(&[&PROFILE[..], &["adaptive", "scene.toml", "-q"], options].concat())
            .expect_error(code, &[part]);
    }
    let run = folder.run(&["compare", "scene.toml", "--replay", "a.replay", "--html", "a.html"]);
    assert!(run.code == 2 && run.stderr.contains("--html"), "{run:?}");
    assert_eq!(folder.names(), before);
}
