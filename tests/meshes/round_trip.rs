//! What we export is read again: the scene is the same.

use std::path::Path;

use glam::DVec3;

use crate::files::{Files, area, assert_warned, load_dark};
use lightshaft::scene::Scene;

/// Triangles of a GLB, as its JSON says.
fn written(files: &Files, name: &str) -> usize {
    let bytes = std::fs::read(files.path(name)).expect("a GLB");
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("4 bytes")) as usize;
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).expect("JSON");
    let primitives = json["meshes"][0]["primitives"].as_array().expect("primitives");
    let corners = |primitive: &serde_json::Value| {
        let accessor = primitive["indices"].as_u64().expect("a number") as usize;
        json["accessors"][accessor]["count"].as_u64().expect("a number") as usize
    };
    primitives.iter().map(corners).sum::<usize>() / 3
}

#[test]
fn an_exported_box_is_the_box() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell-box/scene.toml");
    let files = Files::new(&[("none", b"")]);
    files.run(&["solve", scene, "-o", "box.lsol", "--quality", "draft", "--one-sided"]);
    files.run(&["export", "box.lsol", "--glb", "box.glb", "--ply", "box.ply", "--scene", scene]);
    let original = load_dark(scene.as_ref()).expect("the box");
    let meters = original.meters_per_unit;
    for name in ["box.glb", "box.ply"] {
        let read = load_dark(&files.path(name)).unwrap_or_else(|error| panic!("{error}"));
        // One-sided: every surface is there once.
        let expected = area(&original) * meters * meters;
        assert!(
            (area(&read) / expected - 1.0).abs() < 1e-5,
            "{name}: {} instead of {expected} m²",
            area(&read)
        );
        let counts = read.counts;
        assert_eq!((counts.dropped_duplicate, counts.dropped_degenerate), (0, 0), "{name}");
        assert_eq!(read.triangles.len(), written(&files, "box.glb"), "{name}");
        let bounds = |positions: &[DVec3], unit: f64| {
            let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
            [low * unit, positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max) * unit]
        };
        let (found, expected) = (bounds(&read.positions, 1.0), bounds(&original.positions, meters));
        let off = found.iter().zip(expected).map(|(a, b)| (*a - b).length()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{name}: {found:?} instead of {expected:?}");
        if name == "box.ply" {
            // The light is in the colours: walls are not all alike.
            assert!(read.materials.len() > 20, "{name}: {} colours", read.materials.len());
        } else {
            let names = |scene: &Scene| {
                let mut names: Vec<_> =
                    scene.materials.iter().map(|m| (m.name.clone(), m.reflectance)).collect();
                names.sort_by(|a, b| a.0.cmp(&b.0));
                names
            };
            assert_eq!(names(&read), names(&original));
            assert_warned(&read, &["light in the colours is left out"]);
            let [camera, read] = [&original.cameras[0], &read.cameras[0]];
            assert_eq!(read.name, camera.name);
            assert!((read.eye - camera.eye * meters).length() < 1e-6);
            let ahead = |camera: &lightshaft::scene::Camera| (camera.target - camera.eye).normalize();
            assert!((ahead(read) - ahead(camera)).length() < 1e-6);
            assert!((read.vfov_deg - camera.vfov_deg).abs() < 1e-4);
        }
    }
}

/// Total irradiance at some points of the box, in metres.
fn light(files: &Files, scene: &str) -> Vec<f64> {
    files.run(&["probe", scene, "--points", "points.txt", "-o", "points.csv", "--samples", "1024"]);
    let table = std::fs::read_to_string(files.path("points.csv")).expect("a table");
    let row = |line: &str| -> Vec<f64> {
        line.split(',').skip(6).take(3).map(|number| number.parse().expect("a number")).collect()
    };
    table.lines().skip(1).flat_map(row).collect()
}

#[test]
fn what_was_baked_is_baked_again_with_the_same_light() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell-box/scene.toml");
    // On the floor, at both walls, at the back, and between.
    let points = "0.45 0.001 0.1 0 1 0\n0.002 0.3 0.1 1 0 0\n0.54 0.3 0.1 -1 0 0\n0.28 0.45 0.55 0 0 -1\n0.28 0.4 0.28 0 1 0\n";
    let files = Files::new(&[("points.txt", points.as_bytes())]);
    let export = |scene: &str, options: &[&str], glb: &str| {
        files.run(&[&["solve", scene, "-o", "a.lsol", "--quality", "draft"], options].concat());
        files.run(&["export", "a.lsol", "--glb", glb, "--scene", scene]);
    };
    // Both sides of everything are there.
    export(scene, &[], "first.glb");
    let [original, first] =
        [Path::new(scene), &files.path("first.glb")].map(|scene| load_dark(scene).expect("the box"));
    let expected = area(&original) * original.meters_per_unit.powi(2);
    assert!((area(&first) / expected - 1.0).abs() < 0.03, "{} instead of {expected} m²", area(&first));
    assert!(first.triangles.len() < written(&files, "first.glb") && first.counts.dropped_duplicate == 0);
    export("first.glb", &[], "second.glb");
    let [before, after] = ["first.glb", "second.glb"].map(|scene| light(&files, scene));
    let off: Vec<f64> = before.iter().zip(&after).map(|(before, after)| after / before - 1.0).collect();
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    assert!(
        mean.abs() < 0.01 && off.iter().all(|off| off.abs() < 0.02),
        "{off:?}: {after:?} instead of {before:?}"
    );
}

#[test]
fn of_too_many_materials_a_model_says_nothing() {
    let mut obj = String::from("mtllib a.mtl\n");
    let mut mtl = String::from("newmtl lamp\nKd 0\nKe 5\n");
    for i in 0..130 {
        let x = f64::from(i);
        obj += &format!("v {x} 0 0\nv {x} 0 1\nv {} 0 1\nusemtl m{i}\nf -3 -2 -1\n", x + 0.9);
        mtl += &format!("newmtl m{i}\nKd {}\n", x / 200.0);
    }
    obj += "v 0 3 0\nv 130 3 0\nv 130 3 1\nv 0 3 1\nusemtl lamp\nf -4 -3 -2 -1\n";
    let files = Files::new(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]);
    for (options, is_told) in [(&["--one-sided"][..], true), (&[], false)] {
        files.run(&[&["solve", "a.obj", "-o", "a.lsol", "--quality", "draft"], options].concat());
        files.run(&["export", "a.lsol", "--glb", "a.glb"]);
        let read = load_dark(&files.path("a.glb")).expect("a scene");
        assert_eq!(read.materials.iter().any(|material| material.is_emitter()), is_told);
        assert_eq!(read.materials.iter().all(|material| material.name == "light"), !is_told);
        assert_warned(&read, &[if is_told { "is left out" } else { "taken for reflectance" }]);
    }
}
