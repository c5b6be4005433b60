//! Successful runs of the binary: the files they leave, what they print, and that they repeat.

use std::path::Path;

use crate::run::{Folder, Run};
use lightshaft::report::stats::Stats;

/// Renders the small scene at low cost; `options` are added.
fn render(folder: &Folder, output: &str, options: &[&str]) -> Run {
    let base = ["render", "scene.toml", "-o", output, "--quality", "draft", "--samples", "1"];
    let run = folder.run(&[&base[..], options].concat());
    assert_eq!(run.code, 0, "{run:?}");
    assert_eq!(run.stdout, "", "standard output is for answers, not for reports");
    run
}

fn size(path: &Path) -> (u32, u32) {
    image::image_dimensions(path).expect("a picture")
}

fn stats(folder: &Folder, name: &str) -> Stats {
    let text = std::fs::read_to_string(folder.path(name)).expect("statistics");
    serde_json::from_str(&text).expect("the documented schema")
}

#[test]
fn pictures_have_the_size_asked_for_and_nothing_else_is_left() {
    let folder = Folder::with_scene();
    render(&folder, "a.png", &[]);
    render(&folder, "b.exr", &["--camera", "side"]);
    render(&folder, "c.png", &["--width", "32"]);
    render(&folder, "d.png", &["--width", "20", "--height", "10"]);
    assert_eq!(size(&folder.path("a.png")), (64, 48));
    assert_eq!(size(&folder.path("b.exr")), (40, 40));
    assert_eq!(size(&folder.path("c.png")), (32, 24));
    assert_eq!(size(&folder.path("d.png")), (20, 10));
    assert_eq!(folder.names(), ["a.png", "b.exr", "c.png", "corner.obj", "d.png", "scene.toml"]);
}

#[test]
fn something_is_lit() {
    let folder = Folder::with_scene();
    render(&folder, "a.exr", &[]);
    let picture = image::open(folder.path("a.exr")).expect("a picture").into_rgb32f();
    let lit = picture.pixels().filter(|p| p.0.iter().all(|c| c.is_finite() && *c > 0.0)).count();
    assert!(lit > 300, "only {lit} of {} pixels are lit", picture.pixels().count());
    assert!(picture.pixels().all(|p| p.0.iter().all(|c| c.is_finite() && *c >= 0.0)));
}

#[test]
fn an_old_picture_is_replaced() {
    let folder = Folder::with_scene();
    folder.write("a.png", "old");
    render(&folder, "a.png", &[]);
    assert_eq!(size(&folder.path("a.png")), (64, 48));
}

#[test]
fn statistics_say_what_was_asked_for() {
    let folder = Folder::with_scene();
    render(&folder, "a.png", &["--stats", "a.json", "--threads", "1", "--visibility", "shaft"]);
    let stats = stats(&folder, "a.json");
    assert_eq!((stats.strategy.as_str(), stats.threads), ("shaft", 1));
    assert_eq!(stats.visibility.culling_anomalies, 0);
    assert_eq!(stats.links.total, stats.links.visible + stats.links.invisible + stats.links.partial);
    assert_eq!(stats.tracer == "embree", stats.embree_version.is_some());
    let phases = &stats.seconds;
    let sum = phases.load + phases.build + phases.refine + phases.solve + phases.render;
    assert!(sum <= phases.total * 1.05 + 0.01, "phases take {sum} s of {} s", phases.total);
}

#[test]
fn quiet_says_nothing_at_all() {
    let folder = Folder::with_scene();
    let run = render(&folder, "a.png", &["--quiet", "--embree-lib", "no-such-embree.so"]);
    assert_eq!(run.stderr, "");
}

#[test]
fn the_table_goes_to_standard_error_without_a_bar() {
    let folder = Folder::with_scene();
    let run = render(&folder, "a.png", &[]);
    for row in ["initial triangles", "fully visible", "energy error (W)", "culling anomalies", "refine (s)"] {
        assert!(run.stderr.contains(row), "{row} is missing:\n{}", run.stderr);
    }
    assert!(!run.stderr.contains(['\r', '\u{1b}']), "a bar was drawn where there is no terminal");
}

#[test]
fn without_embree_one_warning_and_the_fallback() {
    let folder = Folder::with_scene();
    let run = render(&folder, "a.png", &["--embree-lib", "no-such-embree.so", "--stats", "a.json"]);
    let about: Vec<&str> = run.stderr.lines().filter(|line| line.contains("Embree")).collect();
    let [warning] = about[..] else { panic!("not one line about it: {run:?}") };
    assert!(warning.starts_with("warning: "), "{warning}");
    let stats = stats(&folder, "a.json");
    assert_eq!((stats.tracer.as_str(), stats.embree_version), ("fallback", None));
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let folder = Folder::with_scene();
    render(&folder, "one.exr", &["--threads", "1"]);
    render(&folder, "four.exr", &["--threads", "4"]);
    let bytes = |name: &str| std::fs::read(folder.path(name)).expect("readable");
    assert!(bytes("one.exr") == bytes("four.exr"), "the picture depends on the number of threads");
}

#[test]
fn every_strategy_and_tracer_renders() {
    let folder = Folder::with_scene();
    for strategy in ["all", "root", "shaft", "adaptive", "sampled"] {
        render(&folder, "a.png", &["--visibility", strategy, "--tracer", "fallback", "--stats", "a.json"]);
        assert_eq!(stats(&folder, "a.json").strategy, strategy);
    }
}

#[test]
fn exposure_multiplies() {
    let folder = Folder::with_scene();
    let mean = |exposure: &str| {
        render(&folder, "a.png", &["--exposure", exposure]);
        let picture = image::open(folder.path("a.png")).expect("a picture").into_rgb8();
        picture.as_raw().iter().map(|&b| f64::from(b)).sum::<f64>() / picture.as_raw().len() as f64
    };
    let (dark, bright) = (mean("0.01"), mean("1"));
    assert!(dark < bright, "{dark} at a hundredth of the exposure of {bright}");
}

#[test]
fn an_office_is_the_same_every_time() {
    let folder = Folder::new();
    for name in ["one", "two"] {
        let run = folder.run(&["generate", "office", "--floors", "1", "--rooms", "2", "-o", name]);
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
        assert!(run.stdout.contains("scene.toml"), "{}", run.stdout);
    }
    let (one, two) = (crate::run::names(&folder.path("one")), crate::run::names(&folder.path("two")));
    assert!(one.contains(&"scene.toml".to_owned()) && one.len() >= 2, "{one:?}");
    assert_eq!(one, two);
    for name in one {
        let bytes = |which: &str| std::fs::read(folder.path(which).join(&name)).expect("readable");
        assert!(bytes("one") == bytes("two"), "{name} differs between two runs");
    }
}
