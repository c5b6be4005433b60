//! `probe`: its tables, grids and comparison with a reference.

use serde_json::Value;

use crate::run::{Folder, MESH, Run, SCENE};

/// What a row of the CSV holds in which column.
const HEADER: &str = "x,y,z,nx,ny,nz,total_r,total_g,total_b,direct_r,direct_g,direct_b";

fn probe(folder: &Folder, options: &[&str]) -> Run {
    folder.run(
        &[&["probe", "scene.toml", "--quality", "draft", "--samples", "256", "-q"][..], options].concat(),
    )
}

/// The rows for these points, below their header.
fn rows(folder: &Folder, points: &str, options: &[&str]) -> Vec<Vec<f64>> {
    folder.write("points.txt", points);
    rows_of(&probe(folder, &[&["--points", "points.txt"][..], options].concat()))
}

fn rows_of(run: &Run) -> Vec<Vec<f64>> {
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let cells = |line: &str| line.split(',').map(|cell| cell.parse().expect("a number")).collect();
    run.stdout.lines().skip(1).map(cells).collect()
}

#[test]
fn rows_are_in_the_order_of_the_points_below_the_header() {
    let folder = Folder::with_scene();
    folder.write("points.txt", "# floor\n0.8 0 0.8 0 1 0\n\n-0.5 0 0.25 0 2 0 # and\n0.5 1 -1 0 0 1\n");
    let run = probe(&folder, &["--points", "points.txt"]);
    let lines: Vec<&str> = run.stdout.lines().collect();
    assert_eq!((lines.len(), lines[0]), (4, HEADER), "{run:?}");
    for (line, place) in lines[1..].iter().zip(["0.8,0,0.8,0,1,0,", "-0.5,0,0.25,0,1,0,", "0.5,1,-1,0,0,1,"])
    {
        assert!(line.starts_with(place) && line.split(',').count() == 12, "{line}");
    }
    for row in rows_of(&run) {
        assert!((0..3).all(|i| row[6 + i] > row[9 + i] && row[9 + i] > 0.0), "{row:?}");
    }
    let file = probe(&folder, &["--points", "points.txt", "-o", "a.csv"]);
    assert_eq!((file.code, file.stdout.as_str()), (0, ""), "{file:?}");
    assert_eq!(std::fs::read_to_string(folder.path("a.csv")).expect("the table"), run.stdout);
}

#[test]
fn the_answer_at_a_point_depends_on_nothing_but_the_point() {
    let folder = Folder::with_scene();
    let (here, there) = ("0.8 0 0.8 0 1 0\n", "0.3 0 0.1 1 1 0\n");
    let alone = rows(&folder, here, &[]);
    let among = rows(&folder, &format!("{there}{there}{here}{there}{here}"), &[]);
    assert_eq!([&among[2], &among[4]], [&alone[0]; 2]);
    assert_eq!([&among[1], &among[3]], [&among[0]; 2]);
    for length in ["0 1e-300 0", "-0 7 -0", "0 1e300 0"] {
        assert_eq!(rows(&folder, &format!("{there}0.8 -0 0.8 {length}"), &[])[1], alone[0], "{length}");
    }
    let oblique = rows(&folder, "0.8 0.3 0.8 0.1 0.7 0.3\n0.8 0.3 0.8 0.3 2.1 0.9\n", &[]);
    assert_eq!(oblique[0][6..], oblique[1][6..]);
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let folder = Folder::with_scene();
    let answers = ["1", "2"].map(|threads| probe(&folder, &["--grid", "0", "--threads", threads]).stdout);
    assert!(answers[0].lines().count() == 401 && answers[0] == answers[1], "{}", answers[0]);
}

#[test]
fn bad_points_are_code_4_with_their_line() {
    let folder = Folder::with_scene();
    for (points, line, part) in [
        ("0 0 0 0 1 0\n\n# x\n0 0 0 0 0 0\n", ":4: ", "length zero"),
        ("0 0 nan 0 1 0\n", ":1: ", "'nan' is not finite"),
        ("0 0 0 0 1 0\n0 0 0 0 1e999 0\n", ":2: ", "'1e999' is not finite"),
        ("0 0 0 0 1\n", ":1: ", "5 numbers"),
        ("0 0 0 0 1 0 0\n", ":1: ", "7 numbers"),
        ("0,0,0,0,1,0\n", ":1: ", "is not a number"),
        ("", ": ", "holds no points"),
        ("# nothing\n\n  # here\n", ": ", "holds no points"),
    ] {
        folder.write("points.txt", points);
        let run = probe(&folder, &["--points", "points.txt", "-o", "a.csv"]);
        run.expect_error(4, &[&format!("points.txt{line}"), part]);
    }
    folder.write("points.txt", b"0 0 0 0 1 0\n0 0 0 0 \xff 0\n");
    probe(&folder, &["--points", "points.txt"]).expect_error(4, &["points.txt:2: ", "UTF-8"]);
    probe(&folder, &["--points", "none.txt"]).expect_error(3, &["none.txt"]);
    assert_eq!(folder.names(), ["corner.obj", "points.txt", "scene.toml"]);
}

/// A closed box of side 0.2, its middle at (0.7, 0.3, 0.7).
const BOX: &str = "\
v 0.6 0.2 0.6
v 0.8 0.2 0.6
v 0.8 0.2 0.8
v 0.6 0.2 0.8
v 0.6 0.4 0.6
v 0.8 0.4 0.6
v 0.8 0.4 0.8
v 0.6 0.4 0.8
f -8 -7 -6 -5
f -4 -1 -2 -3
f -8 -4 -3 -7
f -7 -3 -2 -6
f -6 -2 -1 -5
f -5 -1 -4 -8
";

/// Straight from an emitter nothing gets in. By way of links a little does, where rays stand for proofs: 0.03 % of
/// the light on the box.
#[test]
fn it_is_dark_in_a_closed_box() {
    let folder = Folder::with_scene();
    folder.write("corner.obj", format!("{MESH}{BOX}"));
    folder.write(
        "points.txt",
        "0.7 0.5 0.7 0 1 0\n0.7 0.3 0.7 0 1 0\n0.61 0.21 0.61 1 2 3\n0.7 0.4 0.7 0 -1 0\n",
    );
    let found = rows_of(&folder.run(&["probe", "scene.toml", "-q", "--points", "points.txt"]));
    let outside = found[0][6];
    assert!(outside > 0.5, "{found:?}");
    for row in &found[1..] {
        assert!(row[6..9].iter().all(|&total| (0.0..2e-3 * outside).contains(&total)), "{row:?}");
        assert_eq!(row[9..], [0.0; 3]);
    }
}

/// A room of 4 × 3 × 4 with a lamp below the ceiling and a box of side `size` on the floor, closed by it.
fn room_with_box(size: f64) -> String {
    let mut scene = String::new();
    let mut quad = |origin: [f64; 3], u: [f64; 3], v: [f64; 3], light: &str| {
        let corner = |i: f64, j: f64| [0, 1, 2].map(|k| origin[k] + i * u[k] + j * v[k]);
        let corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        scene.push_str(&format!("[[quad]]\ncorners = {corners:?}\n{light}\n"));
    };
    let (x, y, z) = ([4.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0]);
    for (origin, u, v) in
        [([0.0; 3], x, y), ([0.0; 3], y, z), ([0.0; 3], z, x), (x, z, y), (y, x, z), (z, y, x)]
    {
        quad(origin, u, v, "reflectance = [0.5, 0.5, 0.5]");
    }
    let (x, y, z) = ([size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, size]);
    let at = |x: f64, y: f64, z: f64| [1.3 + x, y, 2.4 + z];
    for (origin, u, v) in [
        (at(0.0, 0.0, 0.0), y, x),
        (at(0.0, 0.0, 0.0), z, y),
        (at(size, 0.0, 0.0), y, z),
        (at(0.0, size, 0.0), z, x),
        (at(0.0, 0.0, size), x, y),
    ] {
        quad(origin, u, v, "reflectance = [0.5, 0.5, 0.5]");
    }
    quad([1.5, 2.9, 1.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], "radiance = [9, 9, 9]");
    scene
}

/// The floor has elements inside and outside of the box, whose walls cut them apart: 0.15 and 0.3 % got in where
/// the box is as wide as an eighth of the floor, 1 and 2 % before elements were cut along short contacts.
#[test]
fn little_light_gets_into_a_box_that_stands_on_the_floor() {
    let folder = Folder::with_scene();
    folder.write("box.toml", room_with_box(0.5));
    folder.write("points.txt", "2 0 2.7 0 1 0\n1.55 0 2.65 0 1 0\n1.55 0.49 2.65 0 -1 0\n");
    let found = rows_of(&folder.run(&["probe", "box.toml", "-q", "--points", "points.txt"]));
    let outside = found[0][6];
    assert!(outside > 0.5, "{found:?}");
    for row in &found[1..] {
        assert!(row[6] < 5e-3 * outside && row[9] == 0.0, "{row:?}, {outside} outside");
    }
}

#[test]
fn there_is_next_to_no_light_far_away() {
    let folder = Folder::with_scene();
    let points =
        ["0 -1e6 0 0 1 0", "0 1e6 0 0 1 0", "1e18 0 0 -1 0 0", "-1e30 1e30 5 1 -1 0", "1e300 0 0 -1 0 0"];
    for row in rows(&folder, &points.join("\n"), &[]) {
        assert!(row[6..].iter().all(|light| (0.0..1e-9).contains(light)), "{row:?}");
    }
    // A lamp of radiance 12 and area 0.36, seen over 10 m at 45° to both normals.
    let row =
        &rows(&folder, &format!("{0} {1} 0 -1 0 0", 10.0 / 2f64.sqrt(), 2.0 - 10.0 / 2f64.sqrt()), &[])[0];
    let expected = 12.0 * 0.36 * 0.5 / 100.0;
    assert!((row[9] / expected - 1.0).abs() < 2e-3, "{row:?} for {expected}");
}

#[test]
fn lux_are_683_times_the_weights_of_the_channels() {
    let folder = Folder::with_scene();
    let points = "0.8 0 0.8 0 1 0\n-0.5 0 0.25 0 2 0\n";
    let (watts, lux) = (rows(&folder, points, &[]), rows(&folder, points, &["--lux"]));
    assert_eq!(watts.len(), lux.len());
    for (watts, lux) in watts.iter().zip(&lux) {
        assert_eq!((watts[..6].to_vec(), lux.len()), (lux[..6].to_vec(), 8));
        for (channels, lux) in [(&watts[6..9], lux[6]), (&watts[9..12], lux[7])] {
            let expected = 683.0 * (0.2126 * channels[0] + 0.7152 * channels[1] + 0.0722 * channels[2]);
            assert!((lux / expected - 1.0).abs() < 1e-6, "{lux} lx for {channels:?} W/m²");
        }
    }
    folder.write("points.txt", points);
    let run = probe(&folder, &["--points", "points.txt", "--lux"]);
    assert!(run.stdout.starts_with("x,y,z,nx,ny,nz,total_lux,direct_lux\n"), "{}", run.stdout);
}

fn json(folder: &Folder, name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder.path(name)).expect("a record")).expect("JSON")
}

#[test]
fn the_json_has_the_documented_fields_and_the_answers_of_the_csv() {
    let folder = Folder::with_scene();
    let points = "0.8 0 0.8 0 1 0\n-0.5 0 0.25 0 2 0\n";
    let (watts, lux) = (rows(&folder, points, &[]), rows(&folder, points, &["--lux"]));
    assert_eq!(probe(&folder, &["--points", "points.txt", "-o", "a.json"]).code, 0);
    let run = json(&folder, "a.json");
    let documented = include_str!("../../docs/probe.md");
    let answers = run["points"].as_array().expect("a list");
    for name in run.as_object().into_iter().chain(answers[0].as_object()).flat_map(|record| record.keys()) {
        assert!(documented.contains(&format!("`{name}`")), "docs/probe.md does not explain {name}");
    }
    assert!(run["reference"].is_null() && run["samples"] == 256, "{run}");
    assert_eq!(answers.len(), 2);
    for ((answer, watts), lux) in answers.iter().zip(&watts).zip(&lux) {
        let numbers = |name: &str| -> Vec<f64> {
            let list = answer[name].as_array().expect(name).iter();
            list.map(|x| x.as_f64().expect("a number")).collect()
        };
        assert_eq!([numbers("position"), numbers("normal")].concat(), watts[..6]);
        let is_near = |a: &f64, b: &f64| (a / b - 1.0).abs() < 1e-6;
        let light = [numbers("total"), numbers("direct")].concat();
        assert!(light.iter().zip(&watts[6..]).all(|(a, b)| is_near(a, b)), "{answer}: {watts:?}");
        for (name, lux) in [("total_lux", lux[6]), ("direct_lux", lux[7])] {
            assert!(is_near(&answer[name].as_f64().expect(name), &lux), "{answer}: {lux}");
        }
    }
}

#[test]
fn a_grid_is_the_middles_of_the_cells_of_a_rectangle_or_a_plane() {
    let folder = Folder::with_scene();
    let places = |options: &[&str]| -> Vec<Vec<f64>> {
        rows_of(&probe(&folder, options)).into_iter().map(|row| row[..6].to_vec()).collect()
    };
    let lamp = places(&["--grid", "lamp", "--spacing", "0.3"]);
    let expected = [(-0.15, -0.15), (0.15, -0.15), (-0.15, 0.15), (0.15, 0.15)];
    let is_at =
        |place: &[f64], expected: [f64; 6]| place.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
    assert_eq!(lamp.len(), expected.len());
    for (place, (x, z)) in lamp.iter().zip(expected) {
        assert!(is_at(place, [x, 2.0, z, 0.0, -1.0, 0.0]), "{place:?}");
    }
    let plane = places(&["--grid", "1", "--spacing", "0.5"]);
    assert_eq!(plane.len(), 16);
    for (index, place) in plane.iter().enumerate() {
        let (row, column) = ((index / 4) as f64, (index % 4) as f64);
        assert!(
            is_at(place, [0.5 * row - 0.75, 1.0, 0.5 * column - 0.75, 0.0, 1.0, 0.0]),
            "{index}: {place:?}"
        );
    }
    // Without a spacing, 20 cells along the longer side.
    assert_eq!(places(&["--grid", "lamp"]).len(), 400);
}

#[test]
fn grids_that_cannot_be_are_code_2() {
    let folder = Folder::with_scene();
    for (options, parts) in [
        (&["--grid", "desk"][..], &["'desk'", "lamp"][..]),
        (&["--grid", "2.5"], &["2.5", "from 0 to 2"]),
        (&["--grid", "inf"], &["finite"]),
        (&["--grid", "lamp", "--spacing", "1e-6"], &["--spacing"]),
    ] {
        probe(&folder, options).expect_error(2, parts);
    }
}

#[test]
fn rectangles_are_found_by_name_before_a_name_is_read_as_a_number() {
    let folder = Folder::with_scene();
    for name in ["0.5", "nan"] {
        folder.write("scene.toml", SCENE.replace("\"lamp\"", &format!("{name:?}")));
        let found = rows_of(&probe(&folder, &["--grid", name, "--spacing", "0.6"]));
        assert_eq!(found.len(), 1, "{name}");
        assert!(found[0][..3] == [0.0, 2.0, 0.0] && found[0][4] < -0.99, "{name}: {found:?}");
    }
    let second = SCENE.split("[[quad]]").nth(1).expect("the lamp").replace("2, ", "1.9, ");
    folder.write("scene.toml", format!("{SCENE}\n[[quad]]{second}"));
    probe(&folder, &["--grid", "lamp"]).expect_error(2, &["2 rectangles are named 'lamp'", "own name"]);
}

const REFERENCE: &str = "total_r,total_g,total_b,direct_r,direct_g,direct_b,\
se_total_r,se_total_g,se_total_b,se_direct_r,se_direct_g,se_direct_b\n";

#[test]
fn a_reference_is_compared_in_one_line_each_for_total_and_direct() {
    let folder = Folder::with_scene();
    let found = rows(&folder, "0.8 0 0.8 0 1 0\n-0.5 0 0.25 0 1 0\n", &[]);
    let compared = |total: f64, direct: f64| {
        let mut text = REFERENCE.to_owned();
        for row in &found {
            let cells = (6..12).map(|i| row[i] * if i < 9 { total } else { direct });
            text += &cells.map(|x| format!("{x:e},")).collect::<String>();
            text += "0,0,0,0,0,0\n";
        }
        folder.write("reference.csv", text);
        let options = ["--points", "points.txt", "--reference", "reference.csv", "-o", "a.json"];
        let base = ["probe", "scene.toml", "--quality", "draft", "--samples", "256"];
        let run = folder.run(&[&base[..], &options].concat());
        assert_eq!(run.code, 0, "{run:?}");
        let line =
            |name: &str| run.stderr.lines().find(|line| line.starts_with(name)).expect(name).to_owned();
        (line("total "), line("direct "), json(&folder, "a.json")["reference"].take())
    };
    // Half of what is found, and a quarter.
    let (total, direct, record) = compared(0.5, 0.25);
    assert!(total.contains("+100.00 % mean") && direct.contains("+300.00 % mean"), "{total}\n{direct}");
    for (line, name) in [(&total, "total"), (&direct, "direct")] {
        let figure = |name: &str, field: &str| record[name][field].as_f64().expect(field);
        let (rms, worst) = (100.0 * figure(name, "rms"), 100.0 * figure(name, "worst"));
        assert!(line.contains(&format!("error {rms:6.2} % root mean square")), "{line}: {record}");
        let at = figure(name, "worst_at") as usize + 1;
        assert!(line.ends_with(&format!("{worst:.2} % at point {at}")), "{line}: {record}");
    }
    let (total, _, record) = compared(1.0, 1.0);
    assert!(total.contains(" 0.00 % root mean square"), "{total}");
    assert!(record["direct"]["rms"].as_f64().is_some_and(|rms| rms < 1e-6), "{record}");
    let (total, direct, record) = compared(1.0, 0.0);
    assert!(total.contains('%') && !direct.contains('%') && direct.contains(" - "), "{total}\n{direct}");
    assert!(record["direct"]["rms"].is_null() && record["total"]["rms"].is_f64(), "{record}");
}

/// A penumbra with its closed form, at the default settings.
#[test]
fn the_penumbra_of_the_project_is_exact_to_a_hundredth() {
    let folder = Folder::new();
    let scene = |file: &str| format!("{}/scenes/penumbra/{file}", env!("CARGO_MANIFEST_DIR"));
    let [description, points, reference] = ["scene.toml", "points.txt", "irradiance.csv"].map(scene);
    let run = folder.run(&[
        "probe",
        &description,
        "--points",
        &points,
        "--reference",
        &reference,
        "-o",
        "a.json",
        "-q",
    ]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let record = json(&folder, "a.json");
    for name in ["total", "direct"] {
        let figure = |field: &str| record["reference"][name][field].as_f64().expect(field);
        assert!(figure("rms") < 0.003 && figure("worst") < 0.01, "{name}: {record}");
    }
}

/// Where the answer has no place for it, the comparison is told even if nothing else is.
#[test]
fn a_quiet_probe_still_tells_how_far_it_is_from_the_reference() {
    let folder = Folder::with_scene();
    folder.write("points.txt", "0.8 0 0.8 0 1 0\n");
    folder.write("reference.csv", format!("{REFERENCE}1,1,1,1,1,1,0,0,0,0,0,0\n"));
    for (output, lines) in [("a.csv", 2), ("a.json", 0)] {
        let options = ["--points", "points.txt", "--reference", "reference.csv", "-o", output];
        let run = probe(&folder, &options);
        assert_eq!((run.code, run.stderr.lines().count()), (0, lines), "{run:?}");
    }
}

/// Nothing is loaded or solved for them.
#[test]
fn bad_points_are_found_before_the_scene_is_read() {
    let folder = Folder::new();
    folder.write("points.txt", "0 0 0 0 0 0\n");
    let run = folder.run(&["probe", "none.toml", "--points", "points.txt"]);
    run.expect_error(4, &["points.txt:1: ", "length zero"]);
}

#[test]
fn a_reference_of_other_points_or_of_no_light_is_code_4() {
    let folder = Folder::with_scene();
    folder.write("points.txt", "0.8 0 0.8 0 1 0\n-0.5 0 0.25 0 1 0\n");
    let row = |light: &str| format!("{}0,0,0,0,0,0\n", format!("{light},").repeat(6));
    for (table, parts) in [
        (row("1"), ["reference.csv: ", "1 rows for 2 points"]),
        (row("1e-320").repeat(2), ["reference.csv:1: ", "no point gets any light"]),
        (row("1") + &row("1e31"), ["reference.csv:3: ", "'1e31' in column 'total_r'"]),
    ] {
        folder.write("reference.csv", format!("{REFERENCE}{table}"));
        let options = ["--points", "points.txt", "--reference", "reference.csv"];
        probe(&folder, &options).expect_error(4, &parts);
    }
    folder.write("reference.csv", format!("x,y,z,{REFERENCE}0.8,0,0.8,{}-0.5,0,0.3,{}", row("1"), row("1")));
    let options = ["--points", "points.txt", "--reference", "reference.csv"];
    let parts = ["reference.csv:3: is for -0.5 0 0.3, but point 2 is -0.5 0 0.25"];
    probe(&folder, &options).expect_error(4, &parts);
}
