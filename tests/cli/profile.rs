//! `profile`: a row for each run, the record and plot of the same, and what is wrong with its files.

use std::io::{BufRead, BufReader};
use std::process::Stdio;

use serde_json::Value;

use crate::run::{Folder, has_embree};

const POINTS: &str = "0 0 0 0 1 0\n0.5 0 0.5 0 1 0\n";
const REFERENCE: &str = "total_r,total_g,total_b,direct_r,direct_g,direct_b,\
se_total_r,se_total_g,se_total_b,se_direct_r,se_direct_g,se_direct_b\n\
2,2,2,1,1,1,0,0,0,0,0,0\n2,2,2,1,1,1,0,0,0,0,0,0\n";

const BASE: [&str; 7] = ["profile", "scene.toml", "--quality", "draft", "--repeat", "1", "-q"];

fn folder() -> Folder {
    let folder = Folder::with_scene();
    folder.write("points.txt", POINTS);
    folder.write("reference.csv", REFERENCE);
    folder
}

fn record(folder: &Folder) -> Value {
    serde_json::from_slice(&std::fs::read(folder.path("p.json")).expect("a record")).expect("JSON")
}

/// Which run is meant.
fn kind(run: &Value) -> (&str, &str, u64) {
    let text = |name: &str| run[name].as_str().expect("text");
    (text("strategy"), text("tracer"), run["rays"].as_u64().expect("a number"))
}

#[test]
fn every_run_is_a_row_a_record_and_a_point_of_the_plot() {
    let folder = folder();
    let options = ["--strategies", "adaptive,sampled", "--tracers", "fallback", "--rays", "4,16"];
    let files = ["--points", "points.txt", "--reference", "reference.csv", "-o", "p.json", "--plot", "p.svg"];
    let run = folder.run(&[&BASE[..], &options, &files].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let record = record(&folder);
    let runs = record["runs"].as_array().expect("runs");
    let kinds: Vec<_> = runs.iter().map(kind).collect();
    let expected =
        [("adaptive", 4), ("adaptive", 16), ("sampled", 4), ("sampled", 16)].map(|(s, r)| (s, "fallback", r));
    assert_eq!(kinds, expected);
    assert_eq!((&record["yardstick"], &record["format"]), (&3.into(), &3.into()), "sampled with 16 rays");
    assert_eq!(record["aim"], 0, "the first that was typed");
    assert_eq!(record["setup"]["lightshaft"], env!("CARGO_PKG_VERSION"));
    assert_eq!(record["setup"]["embree"], Value::Null, "it was not used");
    let setting = |name: &str| {
        let settings = record["setup"]["values"].as_array().expect("settings");
        settings.iter().find(|setting| setting["name"] == name).map(|setting| setting["value"].clone())
    };
    assert_eq!(setting("quality"), Some("draft".into()), "{record}");
    assert_eq!(setting("points"), Some("points.txt".into()), "{record}");
    assert!(["reference", "rays for a point", "materials"].iter().all(|name| setting(name).is_some()));
    for (name, value) in [
        ("strategies", "adaptive, sampled"),
        ("tracers", "fallback"),
        ("rays for a pair", "4, 16"),
        ("each run made", "once"),
    ] {
        assert_eq!(setting(name), Some(value.into()), "{name}");
    }
    let rows: Vec<&str> = run.stdout.lines().skip(4).take(4).collect();
    for (run, row) in runs.iter().zip(rows) {
        let number = |value: &Value| value.as_f64().filter(|&n| n > 0.0).unwrap_or_else(|| panic!("{run}"));
        let seconds = &run["visibility_seconds"];
        assert!(number(&seconds["min"]) <= number(&seconds["median"]), "{run}");
        assert!(number(&seconds["median"]) <= number(&seconds["max"]), "{run}");
        for name in ["rays_cast", "pairs_tested", "links", "solution_bytes"] {
            number(&run[name]);
        }
        let error = number(&run["irradiance_error"]["rms"]);
        assert!(row.contains(&format!("{:.2}", 100.0 * error)) && row.starts_with(kind(run).0), "{row}");
        assert!((0.0..0.5).contains(&number(&run["visibility_error"]["mean"])), "{run}");
    }
    let error = |index: usize| runs[index]["visibility_error"]["mean"].as_f64().expect("a number");
    assert!(error(3) < error(2), "more rays, a smaller error: {record}");
    assert!(runs[2]["certified_share"] == 0.0 && runs[2]["shafts_built"] == 0, "{}", runs[2]);
    assert!(
        run.stdout.contains("The aim is the visibility error of adaptive, fallback, 4 rays"),
        "{}",
        run.stdout
    );
    let plot = std::fs::read_to_string(folder.path("p.svg")).expect("a plot");
    assert!(plot.starts_with("<svg") && plot.trim_end().ends_with("</svg>"), "{plot}");
    assert!(["adaptive", "sampled"].iter().all(|label| plot.contains(label)), "{plot}");
}

/// Nothing typed is enough to say what is cheapest.
#[test]
fn the_default_compares_at_equal_error() {
    let folder = folder();
    for (options, strategies, aim, rays) in [
        (&["--quality", "draft"][..], &["adaptive", "root", "sampled"][..], 0, &[4, 16, 64][..]),
        (&["--quality", "normal", "--epsilon", "5e-3", "--certify"], &["adaptive", "root"], 1, &[4, 16, 64]),
        (
            &["--quality", "high", "--epsilon", "5e-3", "--certify"],
            &["adaptive", "root"],
            2,
            &[4, 16, 32, 64],
        ),
    ] {
        let base = ["profile", "scene.toml", "--repeat", "1", "-q", "--tracers", "fallback", "-o", "p.json"];
        let run = folder.run(&[&base[..], options].concat());
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
        let record = record(&folder);
        let kinds: Vec<_> = record["runs"].as_array().expect("runs").iter().map(kind).collect();
        let each = strategies.iter().flat_map(|&s| rays.iter().map(move |&rays| (s, "fallback", rays)));
        assert_eq!((kinds, &record["aim"]), (each.collect(), &aim.into()));
        let second = run.stdout.lines().nth(1).expect("words");
        assert!(
            second.starts_with("Cheapest at equal error: ") && second.contains("the largest step."),
            "{second}"
        );
        let third = run.stdout.lines().nth(2).expect("words");
        assert!(third.starts_with("Its whole solution takes "), "{third}");
    }
}

#[test]
fn what_is_named_twice_is_made_once_and_so_is_what_asks_no_tracer() {
    let folder = folder();
    let options = ["--strategies", "all,adaptive,all", "--tracers", "fallback,fallback", "--rays", "4,4"];
    let run = folder.run(&[&BASE[..], &options, &["--json", "p.json"]].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let kinds = |record: &Value| -> Vec<(String, String)> {
        let runs = record["runs"].as_array().expect("runs");
        runs.iter().map(|run| (kind(run).0.to_owned(), kind(run).1.to_owned())).collect()
    };
    let named = |strategy: &str, tracer: &str| (strategy.to_owned(), tracer.to_owned());
    assert_eq!(kinds(&record(&folder)), [named("all", "none"), named("adaptive", "fallback")]);
    if !has_embree(&folder) {
        return;
    }
    let options =
        ["--strategies", "all,root", "--tracers", "auto,embree,fallback", "--rays", "4", "-o", "p.json"];
    let run = folder.run(&[&BASE[..], &options].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let wanted = [named("all", "none"), named("root", "embree"), named("root", "fallback")];
    assert_eq!(kinds(&record(&folder)), wanted);
    // The line that names the library stands once for each time that it is used.
    let loud = ["profile", "scene.toml", "--quality", "draft", "--repeat", "1"];
    for tracers in ["auto,embree,fallback", "embree,auto", "auto"] {
        let options = ["--strategies", "root", "--tracers", tracers, "--rays", "4"];
        let run = folder.run(&[&loud[..], &options].concat());
        assert_eq!((run.code, run.stderr.to_lowercase().matches("embree 4").count()), (0, 1), "{run:?}");
    }
}

#[test]
fn whoever_ends_it_early_has_the_runs_that_were_made() {
    let folder = folder();
    // The last run takes very much longer than the others.
    let exact = ["profile", "scene.toml", "--quality", "high", "--min-size", "0.02", "--repeat", "1"];
    let options = ["--strategies", "adaptive", "--tracers", "fallback", "--rays", "4,8,1024", "-o", "p.json"];
    let typed = [&exact[..], &options].concat();
    let mut command = folder.command(&typed);
    let mut child = command.stderr(Stdio::piped()).spawn().expect("the binary starts");
    let mut told = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    let mut next = || told.find_map(|line| line.ok().filter(|line| line.starts_with("run ")));
    assert!(next().is_some_and(|line| line.starts_with("run 1 of 3: adaptive, fallback, 4 rays, ")));
    assert!(next().is_some_and(|line| line.starts_with("run 2 of 3: adaptive, fallback, 8 rays, ")));
    child.kill().expect("killed");
    child.wait().expect("it was a child");
    let record = record(&folder);
    let runs = record["runs"].as_array().expect("runs");
    assert_eq!((runs.len(), &record["runs_to_come"], &record["aim"]), (2, &1.into(), &0.into()), "{record}");
    assert!(runs.iter().all(|run| run["total_seconds"]["median"].as_f64() > Some(0.0)), "{record}");
}

#[test]
fn both_tracers_find_the_same_links() {
    let folder = folder();
    if !has_embree(&folder) {
        return;
    }
    let options = ["--strategies", "adaptive", "--tracers", "embree,fallback", "--rays", "4", "-o", "p.json"];
    let run = folder.run(&[&BASE[..], &options].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let record = record(&folder);
    let [embree, fallback] = [0, 1].map(|index| &record["runs"][index]);
    assert_eq!((kind(embree).1, kind(fallback).1), ("embree", "fallback"));
    for name in ["links", "pairs_tested", "rays_cast", "shafts_built", "certified_share"] {
        assert_eq!(embree[name], fallback[name], "{name}");
    }
}

#[test]
fn what_cannot_be_done_is_said_before_anything_is_solved() {
    let folder = folder();
    let before = folder.names();
    for (options, word) in [
        (&["--strategies", "best"][..], "best"),
        (&["--strategies", "adaptive,sampled", "--certify"], "--certify"),
        (&["--tracers", "magic"], "magic"),
        (&["--rays", "0"], "--rays"),
        (&["--rays", "16,,4"], "--rays"),
        (&["--repeat", "0"], "--repeat"),
        (&["--points", "points.txt"], "--reference"),
        (&["-o", "p.csv"], "--json p.csv: the name must end in .json"),
        (&["--json"], "--json"),
        (&["--plot", "p.png"], ".svg"),
        (&["--trace", "t.txt"], ".json"),
        (&["--trace", "a.json", "-o", "a.json"], "a.json"),
        (&["-o", "a.json", "--plot", "a.json"], ".svg"),
    ] {
        let run = folder.run(&[&BASE[..], options].concat());
        assert!(run.code == 2 && run.stderr.contains(word) && run.stdout.is_empty(), "{options:?}: {run:?}");
    }
    folder.write("short.csv", REFERENCE.lines().take(2).collect::<Vec<_>>().join("\n"));
    let files = ["--points", "points.txt", "--reference", "short.csv", "-o", "p.json"];
    folder.run(&[&BASE[..], &files].concat()).expect_error(4, &["short.csv", "1 rows for 2 points"]);
    let missing = ["-o", "none/p.json"];
    folder.run(&[&BASE[..], &missing].concat()).expect_error(6, &["none"]);
    std::fs::remove_file(folder.path("short.csv")).expect("our own file");
    assert_eq!(folder.names(), before, "nothing is left behind");
}

#[test]
fn where_the_work_went_adds_up() {
    let folder = folder();
    let options =
        ["--strategies", "adaptive,shaft", "--tracers", "fallback", "--rays", "4,16", "-o", "p.json"];
    let run = folder.run(&[&BASE[..], &options].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let record = record(&folder);
    for run in record["runs"].as_array().expect("runs") {
        let detail = &run["detail"];
        let rows = |list: &str| detail[list].as_array().unwrap_or_else(|| panic!("no {list}: {run}")).clone();
        let sum = |list: &str, field: &str| -> f64 {
            rows(list).iter().map(|row| row[field].as_f64().expect("a number")).sum()
        };
        // With one repeat the median is the run itself.
        let visibility = run["visibility_seconds"]["median"].as_f64().expect("a number");
        for list in ["steps", "answers", "levels"] {
            assert!((sum(list, "seconds") - visibility).abs() < 1e-6 + 1e-6 * visibility, "{list}: {run}");
        }
        let total = run["total_seconds"]["median"].as_f64().expect("a number");
        assert!(sum("phases", "seconds") >= total, "{run}");
        let names: Vec<Value> = rows("phases").iter().map(|row| row["name"].clone()).collect();
        assert!(["openness", "refine", "gather", "other"].iter().all(|&name| names.contains(&name.into())));
        let count = |name: &str| run[name].as_f64().expect("a number");
        assert_eq!(sum("answers", "rays"), count("rays_cast"));
        for list in ["rays_per_pair", "filter_calls_per_pair"] {
            assert_eq!(sum(list, "count"), count("pairs_tested"), "{list}: {run}");
        }
        assert_eq!(sum("candidates_per_shaft", "count"), count("shafts_built"), "{run}");
        let tested = ["visible", "invisible", "partial"].map(|class| sum("levels", class));
        assert_eq!(tested.iter().sum::<f64>(), count("pairs_tested"), "{run}");
    }
    for title in ["in visibility by step", "by phase", "by what settled them", "by size", "by their rays"] {
        assert!(run.stdout.contains(title), "{title}: {}", run.stdout);
    }
}

/// An event of a trace that lasts.
struct Event {
    name: String,
    kind: String,
    row: u64,
    start: f64,
    end: f64,
}

impl Event {
    fn of(event: &Value) -> Event {
        let text = |name: &str| event[name].as_str().expect("text").to_owned();
        let number = |name: &str| event[name].as_f64().expect("a number");
        let (start, length) = (number("ts"), number("dur"));
        assert!(start >= 0.0 && length >= 0.0, "{event}");
        let row = event["tid"].as_u64().expect("a row");
        Event { name: text("name"), kind: text("cat"), row, start, end: start + length }
    }

    /// Inside it but for the rounding of microseconds.
    fn holds(&self, other: &Event) -> bool {
        self.start - 0.01 <= other.start && other.end <= self.end + 0.01
    }

    fn is_apart_from(&self, other: &Event) -> bool {
        self.end <= other.start + 0.01 || other.end <= self.start + 0.01
    }
}

#[test]
fn a_trace_has_every_phase_and_the_work_in_it() {
    const THREADS: usize = 2;
    let folder = folder();
    let options =
        ["--strategies", "adaptive,sampled", "--tracers", "fallback", "--rays", "4", "--threads", "2"];
    let run = folder.run(&[&BASE[..], &options, &["-o", "p.json", "--trace", "t.json"]].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let trace: Value =
        serde_json::from_slice(&std::fs::read(folder.path("t.json")).expect("a trace")).expect("JSON");
    let events = trace["traceEvents"].as_array().expect("events");
    assert!(events.len() < 20_000, "{} events", events.len());
    assert!(events.iter().all(|event| event["ph"] == "X" || event["ph"] == "M"));
    let lasting: Vec<Event> = events.iter().filter(|event| event["ph"] == "X").map(Event::of).collect();
    // Events of one row are apart or one is in the other.
    for (index, one) in lasting.iter().enumerate() {
        for other in lasting[index + 1..].iter().filter(|other| other.row == one.row) {
            let nests = one.is_apart_from(other) || one.holds(other) || other.holds(one);
            assert!(nests, "{} and {} in row {}", one.name, other.name, one.row);
        }
    }
    let of_kind = |kind: &'static str| lasting.iter().filter(move |event| event.kind == kind);
    let known = [
        "load",
        "facets",
        "overlaps",
        "contacts",
        "build",
        "openness",
        "refine",
        "damping",
        "gather",
        "weigh",
        "stray light",
        "landings",
    ];
    for phase in of_kind("phase") {
        assert!(phase.row == 0 && known.contains(&phase.name.as_str()), "{}", phase.name);
    }
    // Work is done in its phase, and by no more than all threads.
    let holds = |phase: &Event, work: &Event| {
        let is_of = phase.name == work.name || (phase.name == "damping" && work.name == "gather");
        is_of && phase.holds(work)
    };
    for work in of_kind("work") {
        assert!((1..=THREADS as u64).contains(&work.row));
        assert!(of_kind("phase").any(|phase| holds(phase, work)), "{} at {} µs", work.name, work.start);
    }
    for phase in of_kind("phase") {
        let done: f64 =
            of_kind("work").filter(|work| holds(phase, work)).map(|work| work.end - work.start).sum();
        let most = THREADS as f64 * (phase.end - phase.start);
        assert!(done <= 1.001 * most + 1.0, "{}: {done} of {most} µs", phase.name);
    }
    for name in ["refine", "gather", "openness", "weigh"] {
        assert!(of_kind("work").any(|work| work.name == name), "nobody did {name}");
    }
    // The runs, with the phases that the record has.
    let record = record(&folder);
    let runs = record["runs"].as_array().expect("runs");
    let stages: Vec<&Event> = of_kind("stage").filter(|stage| stage.name != "errors").collect();
    assert_eq!(stages.len(), runs.len());
    for (stage, run) in stages.into_iter().zip(runs) {
        assert!(stage.name.starts_with(kind(run).0), "{}", stage.name);
        let mut all = 0.0;
        for phase in run["detail"]["phases"].as_array().expect("phases") {
            let (name, seconds) = (phase["name"].as_str(), phase["seconds"].as_f64().expect("a number"));
            all += seconds;
            let in_stage = of_kind("phase").filter(|p| Some(p.name.as_str()) == name && stage.holds(p));
            let traced: f64 = in_stage.map(|p| (p.end - p.start) * 1e-6).sum();
            assert!(
                name == Some("other") || (traced - seconds).abs() < 1e-5,
                "{name:?}: {traced}, not {seconds}"
            );
        }
        let length = (stage.end - stage.start) * 1e-6;
        assert!(length <= all + 1e-5, "the stage ends before what the record has: {length}, {all}");
    }
}
