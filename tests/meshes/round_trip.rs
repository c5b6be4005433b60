//! What we export is read again: the scene is the same.

use glam::DVec3;

use crate::files::{Files, area, load_dark};

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
        // The light is in the colours: walls are not all alike.
        assert!(read.materials.len() > 20, "{name}: {} colours", read.materials.len());
        if name == "box.glb" {
            let [camera, read] = [&original.cameras[0], &read.cameras[0]];
            assert_eq!(read.name, camera.name);
            assert!((read.eye - camera.eye * meters).length() < 1e-6);
            let ahead = |camera: &lightshaft::scene::Camera| (camera.target - camera.eye).normalize();
            assert!((ahead(read) - ahead(camera)).length() < 1e-6);
            assert!((read.vfov_deg - camera.vfov_deg).abs() < 1e-4);
        }
    }
}
