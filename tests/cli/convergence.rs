//! `convergence`: a row for each setting, and what is wrong with its files.

use crate::run::Folder;

const POINTS: &str = "0 0 0 0 1 0\n0.5 0 0.5 0 1 0\n";
const HEADER: &str = "total_r,total_g,total_b,direct_r,direct_g,direct_b,\
se_total_r,se_total_g,se_total_b,se_direct_r,se_direct_g,se_direct_b\n";
const ROW: &str = "2,2,2,1,1,1,0,0,0,0,0,0\n";

fn folder(rows: usize) -> Folder {
    let folder = Folder::with_scene();
    folder.write("points.txt", POINTS);
    folder.write("reference.csv", format!("{HEADER}{}", ROW.repeat(rows)));
    folder
}

const BASE: [&str; 6] =
    ["convergence", "scene.toml", "--points", "points.txt", "--reference", "reference.csv"];

#[test]
fn every_setting_is_a_row_a_record_and_a_point_of_the_plot() {
    let folder = folder(2);
    let options = ["--quality", "draft", "--settings", "3", "-o", "c.json", "--plot", "c.svg", "-q"];
    let run = folder.run(&[&BASE[..], &options].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let record: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path("c.json")).expect("a record")).expect("JSON");
    let rungs = record["rungs"].as_array().expect("settings");
    assert_eq!((rungs.len(), record["points"].as_u64()), (3, Some(2)));
    let number = |index: usize, name: &str| rungs[index][name].as_f64().expect("a number");
    // Draft is the last; half a step coarser than draft is the first, and values follow in even ratios.
    assert!((number(2, "epsilon") / 5e-3 - 1.0).abs() < 1e-12);
    assert!((number(0, "epsilon") / 5e-2 - 1.0).abs() < 1e-12);
    assert!((number(0, "epsilon") * number(2, "epsilon") / number(1, "epsilon").powi(2) - 1.0).abs() < 1e-12);
    for (index, rung) in rungs.iter().enumerate() {
        assert!(number(index, "seconds") > 0.0 && number(index, "links") > 0.0, "{rung}");
        let error = rung["total"]["rms"].as_f64().expect("an error");
        let row = run.stdout.lines().nth(2 + index).expect("a row");
        assert!(row.contains(&format!("{:.2}", 100.0 * error)), "{error} is not in: {row}");
    }
    let plot = std::fs::read_to_string(folder.path("c.svg")).expect("a plot");
    assert!(plot.starts_with("<svg") && plot.trim_end().ends_with("</svg>"), "{plot}");
    for label in ["time of the solution (s)", "error, root mean square"] {
        assert!(plot.contains(label), "{label}");
    }
    // Three points; where times are alike there is no room for the labels of all.
    assert_eq!(plot.matches("<circle").count(), 3, "{plot}");
    let labels = ["ε 5.0e-2", "ε 1.6e-2", "ε 5.0e-3"];
    assert!(labels.iter().any(|label| plot.contains(label)), "{plot}");
}

#[test]
fn files_that_do_not_fit_are_named_before_anything_is_solved() {
    let folder = folder(1);
    folder.run(&BASE).expect_error(4, &["reference.csv", "1 rows for 2 points"]);
    folder.write("reference.csv", format!("{HEADER}{}", ROW.replace(['1', '2'], "0").repeat(2)));
    folder.run(&BASE).expect_error(4, &["reference.csv", "no point gets any light"]);
    for hostile in ["1e308", "nan", "-1"] {
        folder.write("reference.csv", format!("{HEADER}{ROW}{}", ROW.replacen('2', hostile, 1)));
        let run = folder.run(&[&BASE[..], &["--plot", "c.svg"]].concat());
        run.expect_error(4, &["reference.csv:3: ", hostile, "total_r"]);
    }
    for (options, word) in [
        (["--plot", "c.png"], ".svg"),
        (["-o", "c.csv"], ".json"),
        (["--settings", "1"], "--settings"),
        (["--plot", "reference.csv"], ".svg"),
    ] {
        let run = folder.run(&[&BASE[..], &options].concat());
        assert!(run.code == 2 && run.stderr.contains(word), "{options:?}: {run:?}");
    }
    assert_eq!(folder.names(), ["corner.obj", "points.txt", "reference.csv", "scene.toml"]);
}

#[cfg(target_os = "linux")]
#[test]
fn an_answer_that_cannot_be_given_leaves_no_files() {
    let folder = folder(2);
    let names = folder.names();
    let full = std::fs::File::options().write(true).open("/dev/full").expect("a full device");
    let options = ["--quality", "draft", "--settings", "2", "-o", "c.json", "--plot", "c.svg", "-q"];
    let output = folder.command(&[&BASE[..], &options].concat()).stdout(full).output().expect("it runs");
    assert_eq!(output.status.code(), Some(6), "{output:?}");
    assert_eq!(folder.names(), names);
}
