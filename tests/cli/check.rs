//! `check`: its table, its JSON, and the exit code that says whether the solution is right.

use serde_json::Value;

use crate::run::{Folder, Run, SCENE};

fn check(folder: &Folder, options: &[&str]) -> Run {
    folder.run(&[&["check", "scene.toml", "--quality", "draft"][..], options].concat())
}

fn json(folder: &Folder, name: &str) -> Value {
    let text = std::fs::read_to_string(folder.path(name)).expect("the findings");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn a_right_solution_is_code_0_with_a_table_on_standard_output() {
    let folder = Folder::with_scene();
    let run = check(&folder, &[]);
    assert_eq!(run.code, 0, "{run:?}");
    for part in ["limits of --quality draft", "energy balance", "row sums", "no link", "0 failed"] {
        assert!(run.stdout.contains(part), "{part} is missing:\n{}", run.stdout);
    }
    assert_eq!(folder.names(), ["corner.obj", "scene.toml"]);
}

#[test]
fn the_json_has_the_findings_of_the_table() {
    let folder = Folder::with_scene();
    let run = check(&folder, &["--json", "a.json"]);
    let value = json(&folder, "a.json");
    assert_eq!(value["passed"], true);
    assert_eq!(value["quality"], "draft");
    let findings = value["findings"].as_array().expect("a list");
    assert!(findings.len() > 15, "{value}");
    let documented = include_str!("../../docs/check.md");
    for finding in findings {
        let name = finding["name"].as_str().expect("a name");
        assert!(run.stdout.contains(name), "{name} is not in the table:\n{}", run.stdout);
        assert!(documented.contains(&format!("| {name} |")), "docs/check.md does not explain {name}");
        for field in finding.as_object().expect("a record").keys() {
            assert!(documented.contains(&format!("`{field}`")), "docs/check.md does not explain {field}");
        }
        assert_ne!(finding["verdict"], "failed", "{finding}");
    }
    let kinds = value["kinds"].as_array().expect("a list");
    assert!(kinds.iter().any(|kind| kind["linked"].as_f64().is_some_and(|share| share > 0.1)), "{value}");
}

#[test]
fn what_is_wrong_is_code_8_and_named_after_the_table() {
    let folder = Folder::with_scene();
    // In a furnace of light-coloured walls one iteration leaves most of the light on its way.
    folder
        .write("scene.toml", SCENE.replace("reflectance = [0.5, 0.5, 0.5]", "reflectance = [0.9, 0.9, 0.9]"));
    let run = check(&folder, &["--iterations", "1", "--json", "a.json"]);
    assert_eq!(run.code, 8, "{run:?}");
    assert!(run.stdout.contains("FAILED"), "{}", run.stdout);
    let line = run.stderr.lines().find(|line| line.starts_with("error: ")).expect("an error");
    assert!(line.contains("still changing (light)"), "{line}");
    assert_eq!(json(&folder, "a.json")["passed"], false);
}

#[test]
fn a_finding_that_looked_at_nothing_does_not_pass_and_is_no_failure() {
    let folder = Folder::with_scene();
    // Nothing is proved by this strategy.
    let run = check(&folder, &["--visibility", "sampled", "--json", "a.json"]);
    assert_eq!(run.code, 0, "{run:?}");
    let row = run.stdout.lines().find(|line| line.contains("proved visible, yet blocked")).expect("a row");
    assert!(
        row.ends_with("not looked at") && run.stdout.contains(" failed, 1 not looked at"),
        "{}",
        run.stdout
    );
    let value = json(&folder, "a.json");
    let findings = value["findings"].as_array().expect("a list");
    let finding = findings.iter().find(|finding| finding["looked_at"] == 0).expect("a finding");
    assert_eq!(finding["name"], "proved visible, yet blocked");
    assert_eq!((&finding["verdict"], &value["passed"]), (&"not looked at".into(), &true.into()));
}

#[test]
fn quiet_leaves_the_exit_code() {
    let folder = Folder::with_scene();
    let run = check(&folder, &["--quiet"]);
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (0, "", ""));
    let run = check(&folder, &["--quiet", "--iterations", "1"]);
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.lines().count()), (8, "", 1), "{run:?}");
}

#[test]
fn bad_input_has_the_codes_of_render() {
    let folder = Folder::with_scene();
    folder.write("bad.toml", "mesh = [");
    let before = folder.names();
    for (arguments, code, part) in [
        (&["check", "scene.toml", "--certify", "--visibility", "sampled"][..], 2, "--certify"),
        (&["check", "scene.toml", "--json", "scene.toml"], 2, "scene.toml"),
        (&["check", "nowhere.toml"], 3, "nowhere.toml"),
        (&["check", "bad.toml"], 4, "bad.toml"),
        (&["check", "nowhere.toml", "--json", "no/a.json"], 6, "no/a.json"),
    ] {
        folder.run(arguments).expect_error(code, &[part]);
    }
    let run = folder.run(&["check"]);
    assert_eq!(run.code, 2, "{run:?}");
    assert_eq!(folder.names(), before);
}
