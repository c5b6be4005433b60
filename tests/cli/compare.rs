//! `compare`: its words, tables and files, replay files, and what is wrong with its input.

use serde_json::Value;

use crate::run::{Folder, Run, has_embree};

const QUICK: [&str; 8] = ["--quality", "draft", "--rays", "2000", "--repeat", "1", "--solves", "1"];

fn compare(folder: &Folder, options: &[&str]) -> Run {
    folder.run(&[&["compare", "scene.toml", "-q"][..], &QUICK, options].concat())
}

fn record(folder: &Folder, name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder.path(name)).expect("a record")).expect("JSON")
}

#[test]
fn tracers_that_agree_are_code_0_with_words_before_tables() {
    let folder = Folder::with_scene();
    if !has_embree(&folder) {
        return;
    }
    let run = folder.run(&[&["compare", "scene.toml"][..], &QUICK].concat());
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.stdout.contains("embree and fallback"), "{}", run.stdout);
    let at =
        |part: &str| run.stdout.find(part).unwrap_or_else(|| panic!("{part} is missing:\n{}", run.stdout));
    assert!(at("The tracers agree.") < at("shadow rays  "), "{}", run.stdout);
    for part in ["links", "exitance, mean", "picture, largest", "solve (s)", "memory of solving (MB)"] {
        at(part);
    }
    assert_eq!(folder.names(), ["corner.obj", "scene.toml"]);
}

#[test]
fn every_field_of_the_record_is_documented() {
    let folder = Folder::with_scene();
    if !has_embree(&folder) {
        return;
    }
    let run = compare(&folder, &["--json", "a.json"]);
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (0, "", ""), "{run:?}");
    let value = record(&folder, "a.json");
    let documented = include_str!("../../docs/compare.md");
    let mut names: Vec<&String> = value.as_object().expect("a record").keys().collect();
    for inner in ["links", "exitance", "picture", "setup"] {
        names.extend(value[inner].as_object().expect("a record").keys());
    }
    for inner in ["rays", "worst"] {
        let first = value[inner].as_array().expect("a list").first();
        names.extend(first.and_then(Value::as_object).into_iter().flat_map(|record| record.keys()));
    }
    assert!(names.len() > 30, "{names:?}");
    for name in names {
        assert!(documented.contains(&format!("`{name}`")), "docs/compare.md does not explain {name}");
    }
    let kinds: Vec<&str> =
        value["rays"].as_array().expect("a list").iter().filter_map(|tally| tally["name"].as_str()).collect();
    assert_eq!((kinds.first(), kinds.last()), (Some(&"shadow rays"), Some(&"all")));
    for kind in kinds {
        assert!(documented.contains(kind), "docs/compare.md does not explain {kind}");
    }
    assert_eq!((&value["agree"], &value["format"], &value["repeats"]), (&true.into(), &3.into(), &1.into()));
    assert!(value["setup"]["embree"].as_str().is_some_and(|version| version.starts_with("4.")), "{value}");
    let all = value["rays"].as_array().and_then(|rays| rays.last()).expect("a sum");
    assert_eq!(all["wrong"], serde_json::json!([0, 0]));
    assert!(all["traced"].as_u64() > Some(2000), "{all}");
    for times in ["solve_seconds", "render_seconds"] {
        assert!(
            value[times].as_array().is_some_and(|both| both.iter().all(|t| t["median"].as_f64() > Some(0.0)))
        );
    }
    let solution = value["solution_bytes"].as_array().expect("two numbers");
    assert!(solution.iter().all(|bytes| bytes.as_u64() > Some(1000)), "{value}");
}

/// Nothing is left out: what both are asked is all that the solver says it cast in two solutions.
#[test]
fn every_shadow_ray_of_both_solutions_is_asked_of_both() {
    let folder = Folder::with_scene();
    if !has_embree(&folder) {
        return;
    }
    assert_eq!(compare(&folder, &["--json", "a.json"]).code, 0);
    let mut cast = 0;
    for tracer in ["embree", "fallback"] {
        let options =
            ["render", "scene.toml", "-q", "--quality", "draft", "-o", "a.png", "--stats", "b.json"];
        assert_eq!(folder.run(&[&options[..], &["--tracer", tracer]].concat()).code, 0);
        cast += record(&folder, "b.json")["visibility"]["rays_cast"].as_u64().expect("a number");
    }
    let compared = &record(&folder, "a.json")["rays"][0];
    assert_eq!(
        (&compared["name"], compared["traced"].as_u64()),
        (&"shadow rays".into(), Some(cast)),
        "{compared}"
    );
}

#[test]
fn what_is_found_does_not_depend_on_the_threads() {
    let folder = Folder::with_scene();
    if !has_embree(&folder) {
        return;
    }
    for threads in ["1", "3"] {
        let files = [format!("{threads}.json"), format!("{threads}.replay")];
        let options = ["--threads", threads, "--json", &files[0], "--replay-file", &files[1]];
        assert_eq!(compare(&folder, &options).code, 0);
    }
    let [one, three] = ["1.json", "3.json"].map(|name| record(&folder, name));
    for field in ["rays", "worst", "links", "exitance", "picture"] {
        assert_eq!(one[field], three[field], "{field}");
    }
    let [one, three] = ["1.replay", "3.replay"].map(|name| std::fs::read(folder.path(name)).expect("a file"));
    assert_eq!(one, three);
}

#[test]
fn three_pictures_of_one_size_go_to_a_folder_that_is_made() {
    let folder = Folder::with_scene();
    if !has_embree(&folder) {
        return;
    }
    let options = ["-o", "pictures", "--camera", "side", "--width", "20"];
    assert_eq!(compare(&folder, &options).code, 0);
    let names = crate::run::names(&folder.path("pictures"));
    assert_eq!(names, ["difference.png", "fallback.png", "native.png"]);
    for name in names {
        let picture = image::open(folder.path("pictures").join(&name)).expect("a picture").to_rgb8();
        assert_eq!(picture.dimensions(), (20, 20), "{name}");
        let brightest = picture.pixels().map(|pixel| pixel.0[0]).max();
        assert_eq!(brightest > Some(50), name != "difference.png", "{name}: {brightest:?}");
    }
    // Once more over what is there.
    assert_eq!(compare(&folder, &options).code, 0);
}

/// A file of rays for the scene: some of its own, and what is added.
fn recorded(folder: &Folder, added: &str) -> String {
    assert_eq!(compare(folder, &["--replay-file", "a.replay"]).code, 0);
    with_added(&std::fs::read_to_string(folder.path("a.replay")).expect("a replay file"), added)
}

/// With lines more, and a head that fits.
fn with_added(text: &str, added: &str) -> String {
    let parts: Vec<&str> = text.splitn(4, '\n').collect();
    let [version, geometry, _, body] = parts[..] else { panic!("{text}") };
    let body = body.to_owned() + added;
    let count = body.lines().filter(|line| !line.starts_with('#')).count();
    format!("{version}\n{geometry}\nrays {count} crc32 {:08x}\n{body}", crc32fast::hash(body.as_bytes()))
}

#[test]
fn recorded_rays_are_traced_again_one_by_one() {
    let folder = Folder::with_scene();
    if !has_embree(&folder) {
        return;
    }
    let text = recorded(
        &folder,
        "segment 0 -0.9 0 0.01 0.9 0 - - - by hand\nsegment 0 5 0 0.01 6 0 0 - - by hand\n\
         segment 0 -0.9 0 0.01 0.9 0 - - none by hand\n",
    );
    folder.write("b.replay", &text);
    let run = folder.run(&["compare", "scene.toml", "--replay", "b.replay"]);
    assert_eq!(run.code, 0, "{run:?}");
    let rays = text.lines().skip(3).filter(|line| !line.starts_with('#')).count();
    assert!(run.stdout.contains(&format!("{rays} rays of b.replay")), "{}", run.stdout);
    let last = run.stdout.split(&format!("\n{}. by hand", rays - 2)).nth(1).expect("the first of the three");
    let parts: Vec<&str> = last.split("\n\n").collect();
    let [first, second, third] = parts[..] else { panic!("{last}") };
    for part in ["embree: facet", "fallback: facet", "referee: facet", "material default", "(right)"] {
        assert!(first.contains(part), "{part} is missing: {first}");
    }
    for part in ["embree: clear (right)", "referee: clear", "an end is on facet 0"] {
        assert!(second.contains(part), "{part} is missing: {second}");
    }
    for part in ["embree: clear (right)", "referee: clear", "within 0 candidates"] {
        assert!(third.contains(part), "{part} is missing: {third}");
    }
}

/// The kept ray: Embree calls it blocked, though it passes the facet far beside. It is known, and no disagreement.
#[test]
fn the_ray_that_is_kept_of_the_cornell_box_is_seen_edge_on() {
    let folder = Folder::with_scene();
    if !has_embree(&folder) {
        return;
    }
    let file = |name: &str| format!("{}/scenes/cornell-box/{name}", env!("CARGO_MANIFEST_DIR"));
    let run = folder.run(&["compare", &file("scene.toml"), "--replay", &file("edge-on.replay")]);
    assert_eq!(run.code, 0, "{run:?}");
    for part in ["1 ray of ", "fallback: clear (right)", "referee: clear", "in the plane of a triangle"] {
        assert!(run.stdout.contains(part), "{part} is missing: {}", run.stdout);
    }
    assert!(!run.stdout.contains("WRONG"), "{}", run.stdout);
}

#[test]
fn replay_files_that_do_not_fit_are_code_4_and_say_why() {
    let folder = Folder::with_scene();
    if !has_embree(&folder) {
        return;
    }
    let text = recorded(&folder, "segment 0 0 0 1 0 0 - - - by hand\n");
    let lines = text.lines().count();
    for (name, content, parts) in [
        ("version.replay", text.replace("replay 2\n", "replay 7\n"), vec!["version 7", "version 2"]),
        ("half.replay", text[..text.len() / 2].to_owned(), vec!["cut off or changed"]),
        (
            "line.replay",
            with_added(&text, "segment 0 0 zero 1 0 0 - - - by hand\n"),
            vec![&*format!(":{}:", lines + 1), "'zero'"],
        ),
        ("mesh.replay", "v 0 0 0\n".to_owned(), vec![":1:", "lightshaft replay"]),
        ("empty.replay", String::new(), vec![":1:"]),
        ("zero.replay", with_added(&text, "ray 0 0 0 0 0 0 by hand\n"), vec!["1e-12 to 1e9 far"]),
        ("huge.replay", with_added(&text, "ray 0 0 0 1e38 1e38 0 by hand\n"), vec!["1e-12 to 1e9 far"]),
        ("kind.replay", with_added(&text, "ray 0 0 0 1 0 0 by \u{1b}[31mhand\n"), vec!["control characters"]),
    ] {
        folder.write(name, content);
        let parts = [&[name][..], &parts].concat();
        folder.run(&["compare", "scene.toml", "-q", "--replay", name]).expect_error(4, &parts);
    }
    // The lamp is moved.
    let scene = std::fs::read_to_string(folder.path("scene.toml")).expect("the scene");
    folder.write("other.toml", scene.replace(", 2, ", ", 1.9, "));
    let run = folder.run(&["compare", "other.toml", "-q", "--replay", "a.replay"]);
    run.expect_error(4, &["a.replay", "other geometry"]);
    folder.run(&["compare", "nowhere.toml"]).expect_error(3, &["nowhere.toml"]);
    folder.run(&["compare", "scene.toml", "-q", "--replay", "none.replay"]).expect_error(3, &["none.replay"]);
}

#[test]
fn replay_files_are_looked_at_before_all_else_and_only_as_far_as_they_may_go() {
    let folder = Folder::with_scene();
    let replay = |file: &str| folder.run(&["compare", "nowhere.toml", "--replay", file]);
    folder.write("version.replay", "lightshaft replay 7\n");
    replay("version.replay").expect_error(4, &["version.replay", "version 7"]);
    std::fs::create_dir(folder.path("folder.replay")).expect("a folder");
    replay("folder.replay").expect_error(3, &["folder.replay", "not a regular file"]);
    if cfg!(unix) {
        let made = std::process::Command::new("mkfifo").arg(folder.path("pipe.replay")).status();
        assert!(made.expect("mkfifo").success());
        for file in ["pipe.replay", "/dev/zero"] {
            replay(file).expect_error(3, &[file, "not a regular file"]);
        }
    }
}

#[test]
fn options_that_have_no_say_in_a_replay_are_refused() {
    let folder = Folder::with_scene();
    for option in [
        &["--camera", "side"][..],
        &["--solves", "2"],
        &["--width", "9"],
        &["--height", "9"],
        &["--samples", "2"],
        &["--quality", "draft"],
        &["--epsilon", "0.1"],
        &["--min-size", "0.1"],
        &["--iterations", "9"],
        &["--certify"],
        &["--pair-rays", "4"],
        &["--visibility", "root"],
    ] {
        let run = folder.run(&[&["compare", "scene.toml", "--replay", "a.replay"][..], option].concat());
        assert!(run.code == 2 && run.stderr.contains(option[0]), "{option:?}: {run:?}");
    }
    // The sides are part of the geometry.
    let run = folder.run(&["compare", "scene.toml", "--replay", "a.replay", "--one-sided"]);
    run.expect_error(3, &["a.replay"]);
}

#[test]
fn without_embree_it_says_so_with_code_7() {
    let folder = Folder::with_scene();
    let run = compare(&folder, &["--embree-lib", "none.so"]);
    run.expect_error(7, &["Embree is not usable", "doctor"]);
}

#[test]
fn what_cannot_be_done_is_said_before_anything_is_solved() {
    let folder = Folder::with_scene();
    folder.write("taken", "");
    let before = folder.names();
    for (options, code, part) in [
        (&["--visibility", "all"][..], 2, "--visibility all"),
        (&["--certify", "--visibility", "sampled"], 2, "--certify"),
        (&["--json", "a.txt"], 2, ".json"),
        (&["--json", "a.json", "--replay-file", "a.json"], 2, "a.json"),
        (&["--replay-file", "scene.toml"], 2, "scene.toml"),
        (&["--json", "no/a.json"], 6, "no/a.json"),
        (&["--replay-file", "no/a.replay"], 6, "no/a.replay"),
        (&["-o", "taken"], 6, "taken"),
        (&["-o", "no/pictures"], 6, "no"),
    ] {
        compare(&folder, options).expect_error(code, &[part]);
    }
    for options in
        [&["--repeat", "0"][..], &["--solves", "0"], &["--replay", "a.replay"], &["--pair-rays", "0"]]
    {
        let run = compare(&folder, options);
        assert!(run.code == 2 && run.stderr.contains(options[0]), "{run:?}");
    }
    assert_eq!(folder.names(), before);
}
