//! What `--stats` writes: the documented fields, and the same numbers whatever the number of threads.

use serde_json::Value;

use crate::render::render;
use crate::run::{Folder, has_embree};
use lightshaft::report::stats::Stats;

/// Every field by its record; scripts rely on these names.
const FIELDS: [(&str, &[&str]); 8] = [
    (
        "",
        &[
            "tracer",
            "embree_version",
            "strategy",
            "threads",
            "iterations",
            "energy_error_w",
            "frames",
            "frames_per_second",
        ],
    ),
    (
        "scene",
        &[
            "triangles_initial",
            "triangles_final",
            "patches",
            "elements",
            "clusters",
            "facets",
            "covered_facets",
            "materials",
            "dropped_degenerate",
            "dropped_duplicate",
        ],
    ),
    (
        "links",
        &[
            "total",
            "visible",
            "invisible",
            "partial",
            "certified_visible",
            "certified_invisible",
            "inherited",
        ],
    ),
    (
        "visibility",
        &[
            "pairs_tested",
            "shafts_built",
            "nodes_tested",
            "empty_shafts",
            "single_blockers",
            "fused_blockers",
            "rays_cast",
            "rays_avoided",
            "filter_calls",
            "filter_rejects",
            "culling_anomalies",
            "candidates_mean",
            "seconds",
        ],
    ),
    ("energy", &["emitted_w", "absorbed_w", "escaped_w", "corrected_w", "balance_error"]),
    ("reference", &["relative_rmse", "relative_bias", "flip", "smoothed_relative_rmse", "smoothed_flip"]),
    ("memory", &["peak_rss_bytes", "links_bytes", "elements_bytes"]),
    ("seconds", &["load", "build", "refine", "solve", "render", "total"]),
];

/// The statistics of a run, read as a program reads them.
pub(crate) fn stats(folder: &Folder, name: &str) -> Stats {
    serde_json::from_value(json(folder, name)).expect("the documented schema")
}

fn json(folder: &Folder, name: &str) -> Value {
    let text = std::fs::read_to_string(folder.path(name)).expect("statistics");
    serde_json::from_str(&text).expect("JSON")
}

/// The names of every value that is not a record, sorted.
fn names_of(value: &Value) -> Vec<String> {
    let mut names = Vec::new();
    for (name, inner) in value.as_object().expect("a record") {
        match inner.as_object() {
            Some(record) => names.extend(record.keys().map(|field| format!("{name}.{field}"))),
            None => names.push(name.clone()),
        }
    }
    names.sort();
    names
}

#[test]
fn the_fields_are_the_documented_ones() {
    let folder = Folder::with_scene();
    render(&folder, "b.exr", &[]);
    render(&folder, "a.png", &["--stats", "a.json", "--reference", "b.exr"]);
    let value = json(&folder, "a.json");
    let mut expected: Vec<String> = FIELDS
        .iter()
        .flat_map(|(record, fields)| {
            let dot = if record.is_empty() { "" } else { "." };
            fields.iter().map(move |field| format!("{record}{dot}{field}"))
        })
        .collect();
    expected.sort();
    assert_eq!(names_of(&value), expected);
    for name in expected {
        let field = name.split('.').fold(&value, |value, part| &value[part]);
        match name.as_str() {
            "tracer" | "strategy" => assert!(field.is_string(), "{name}: {field}"),
            "embree_version" => assert!(field.is_string() || field.is_null(), "{name}: {field}"),
            "energy.corrected_w" | "reference.relative_bias" => {
                assert!(field.as_f64().is_some_and(f64::is_finite), "{name}: {field}")
            }
            _ => assert!(field.as_f64().is_some_and(|n| n >= 0.0), "{name}: {field}"),
        }
    }
}

#[test]
fn the_tracer_is_embree_where_it_is_usable() {
    let folder = Folder::with_scene();
    let is_usable = has_embree(&folder);
    render(&folder, "a.png", &["--stats", "a.json"]);
    let stats = stats(&folder, "a.json");
    assert_eq!(stats.tracer, if is_usable { "embree" } else { "fallback" });
    assert_eq!(stats.embree_version.is_some(), is_usable);
    // The board is in the way of some rays, and what they hit is put to the filter.
    assert!(stats.links.partial > 0 && stats.visibility.filter_calls > 0, "{stats:?}");
}

#[test]
fn the_fallback_says_so_when_it_is_asked_for() {
    let folder = Folder::with_scene();
    let run = render(&folder, "a.png", &["--stats", "a.json", "--tracer", "fallback"]);
    assert!(!run.stderr.contains("warning: "), "what was asked for needs no warning: {}", run.stderr);
    let stats = stats(&folder, "a.json");
    assert_eq!((stats.tracer.as_str(), stats.embree_version), ("fallback", None));
}

#[test]
fn without_embree_one_warning_and_the_fallback() {
    let folder = Folder::with_scene();
    let run = render(&folder, "a.png", &["--embree-lib", "no-such-embree.so", "--stats", "a.json"]);
    let about: Vec<&str> = run.stderr.lines().filter(|line| line.to_lowercase().contains("embree")).collect();
    let [warning] = about[..] else { panic!("not one line about it: {run:?}") };
    assert!(warning.starts_with("warning: Embree is not usable") && warning.contains("doctor"), "{warning}");
    let stats = stats(&folder, "a.json");
    assert_eq!((stats.tracer.as_str(), stats.embree_version), ("fallback", None));
}

#[test]
fn statistics_say_what_was_asked_for_and_add_up() {
    let folder = Folder::with_scene();
    render(&folder, "a.png", &["--stats", "a.json", "--threads", "1", "--visibility", "shaft"]);
    let stats = stats(&folder, "a.json");
    assert_eq!((stats.strategy.as_str(), stats.threads), ("shaft", 1));
    assert_eq!(stats.visibility.culling_anomalies, 0);
    assert_eq!(stats.links.total, stats.links.visible + stats.links.invisible + stats.links.partial);
    let phases = &stats.seconds;
    let sum = phases.load + phases.build + phases.refine + phases.solve + phases.render;
    assert!(sum <= phases.total * 1.05 + 0.01, "phases take {sum} s of {} s", phases.total);
}

#[test]
fn the_number_of_threads_changes_no_bit_and_no_count() {
    let folder = Folder::with_scene();
    let tracers = if has_embree(&folder) { &["embree", "fallback"][..] } else { &["fallback"] };
    for tracer in tracers {
        for (threads, name) in [("1", "one"), ("2", "two")] {
            let (picture, json) = (format!("{name}.png"), format!("{name}.json"));
            render(&folder, &picture, &["--threads", threads, "--stats", &json, "--tracer", tracer]);
        }
        let bytes = |name: &str| std::fs::read(folder.path(name)).expect("readable");
        assert!(bytes("one.png") == bytes("two.png"), "the picture depends on the number of threads");
        let counts = |name: &str| {
            let mut value = json(&folder, name);
            let record = value.as_object_mut().expect("a record");
            for measured in ["threads", "seconds", "memory", "frames_per_second"] {
                assert!(record.remove(measured).is_some(), "no {measured}");
            }
            let visibility = record["visibility"].as_object_mut().expect("a record");
            assert!(visibility.remove("seconds").is_some(), "no time of visibility");
            value
        };
        assert_eq!(counts("one.json"), counts("two.json"), "{tracer}");
        let sizes = |name: &str| {
            let memory = stats(&folder, name).memory;
            (memory.links_bytes, memory.elements_bytes)
        };
        assert_eq!(sizes("one.json"), sizes("two.json"), "{tracer}");
    }
}
