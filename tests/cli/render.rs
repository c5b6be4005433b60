//! Successful runs of the binary: the files they leave, what they print, and that they repeat.

use std::path::Path;

use crate::run::{Folder, MESH, Run, has_embree};
use crate::statistics::stats;

/// Renders the small scene at low cost; `options` are added.
pub(crate) fn render(folder: &Folder, output: &str, options: &[&str]) -> Run {
    render_file(folder, "scene.toml", output, options)
}

/// Renders any scene at low cost.
fn render_file(folder: &Folder, scene: &str, output: &str, options: &[&str]) -> Run {
    let base = ["render", scene, "-o", output, "--quality", "draft", "--samples", "1"];
    let run = folder.run(&[&base[..], options].concat());
    assert_eq!(run.code, 0, "{run:?}");
    assert_eq!(run.stdout, "", "standard output is for answers, not for reports");
    run
}

fn pixels(folder: &Folder, name: &str) -> image::RgbImage {
    image::open(folder.path(name)).expect("a picture").into_rgb8()
}

/// Pixels that have colour in them.
fn lit_share(picture: &image::RgbImage) -> f64 {
    let lit = picture.pixels().filter(|p| p.0.iter().any(|&c| c > 0)).count();
    lit as f64 / picture.pixels().len() as f64
}

fn size(path: &Path) -> (u32, u32) {
    image::image_dimensions(path).expect("a picture")
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
fn an_exr_holds_radiance_as_it_is() {
    let folder = Folder::with_scene();
    render(&folder, "a.exr", &[]);
    let picture = image::open(folder.path("a.exr")).expect("a picture").into_rgb32f();
    let lit = picture.pixels().filter(|p| p.0.iter().all(|c| *c > 0.0)).count();
    assert!(lit > 300, "only {lit} of {} pixels are lit", picture.pixels().len());
    assert!(picture.pixels().all(|p| p.0.iter().all(|c| c.is_finite() && *c >= 0.0)));
    // The lamp reflects nothing, so it is seen with the radiance that the scene gives it.
    let brightest = picture.pixels().map(|p| p.0).max_by(|a, b| a[0].total_cmp(&b[0]));
    assert_eq!(brightest, Some([12.0, 11.0, 10.0]));
}

#[test]
fn an_old_picture_is_replaced_in_one_step() {
    let folder = Folder::with_scene();
    folder.write("a.png", "old");
    std::fs::hard_link(folder.path("a.png"), folder.path("kept.png")).expect("a second name");
    render(&folder, "a.png", &[]);
    assert_eq!(size(&folder.path("a.png")), (64, 48));
    // The old file was not written to: a reader that has it open keeps the whole old picture.
    assert_eq!(std::fs::read(folder.path("kept.png")).expect("readable"), b"old");
}

#[test]
fn the_view_of_the_mesh_is_another_picture() {
    let folder = Folder::with_scene();
    render(&folder, "shaded.png", &[]);
    render(&folder, "mesh.png", &["--view", "mesh"]);
    let (shaded, mesh) = (pixels(&folder, "shaded.png"), pixels(&folder, "mesh.png"));
    assert_eq!(shaded.dimensions(), mesh.dimensions());
    let others = shaded.pixels().zip(mesh.pixels()).filter(|(a, b)| a != b).count();
    assert!(others * 4 > shaded.pixels().len(), "only {others} pixels differ");
    // The surfaces are grey, so what is blue or green in the view of the mesh is the class of a link.
    let is_coloured = |p: &&image::Rgb<u8>| p.0[1].max(p.0[2]) > p.0[0].saturating_add(30);
    assert_eq!(shaded.pixels().filter(is_coloured).count(), 0);
    assert!(mesh.pixels().filter(is_coloured).count() > 100, "no visible links are shown");
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
fn every_strategy_and_tracer_renders() {
    let folder = Folder::with_scene();
    let tracers = if has_embree(&folder) { &["embree", "fallback"][..] } else { &["fallback"] };
    for tracer in tracers {
        for strategy in ["all", "root", "shaft", "adaptive", "sampled"] {
            render(&folder, "a.png", &["--visibility", strategy, "--tracer", tracer, "--stats", "a.json"]);
            let stats = stats(&folder, "a.json");
            assert_eq!((stats.strategy.as_str(), stats.tracer.as_str()), (strategy, *tracer));
            assert_eq!(stats.visibility.culling_anomalies, 0);
            let lit = lit_share(&pixels(&folder, "a.png"));
            assert!(lit > 0.2, "{strategy} on {tracer}: only {lit} of the picture is lit");
        }
    }
}

#[test]
fn a_bare_mesh_is_enough_when_its_materials_emit() {
    let folder = Folder::new();
    folder.write("room.mtl", "newmtl wall\nKd 0.7 0.6 0.5\nnewmtl lamp\nKd 0 0 0\nKe 9 9 9\n");
    let lamp = "v -0.3 1.9 -0.3\nv 0.3 1.9 -0.3\nv 0.3 1.9 0.3\nv -0.3 1.9 0.3\nusemtl lamp\nf -4 -3 -2 -1\n";
    folder.write("room.obj", format!("mtllib room.mtl\nusemtl wall\n{MESH}{lamp}"));
    let run = render_file(&folder, "room.obj", "a.png", &["--width", "64", "--stats", "a.json"]);
    let about_files = |line: &&str| line.starts_with("warning: ") && line.contains("room.");
    assert_eq!(run.stderr.lines().find(about_files), None);
    let stats = stats(&folder, "a.json");
    assert_eq!((stats.scene.triangles_initial, stats.scene.materials), (8, 2));
    assert_eq!(size(&folder.path("a.png")), (64, 48));
    let lit = lit_share(&pixels(&folder, "a.png"));
    assert!(lit > 0.2, "only {lit} of the picture is lit");
}

#[test]
fn a_generated_office_renders_from_both_its_cameras() {
    let folder = Folder::new();
    let office = folder.run(&["generate", "office", "--floors", "1", "--rooms", "1", "-o", "office"]);
    assert_eq!(office.code, 0, "{office:?}");
    for camera in ["room", "corridor"] {
        let options = ["--camera", camera, "--width", "64", "--stats", "a.json"];
        render_file(&folder, "office/scene.toml", "a.png", &options);
        let stats = stats(&folder, "a.json");
        assert!(office.stdout.contains(&format!("{} triangles", stats.scene.triangles_initial)));
        assert_eq!(stats.visibility.culling_anomalies, 0);
        // The building is closed, so every ray ends on something; only the darkest corners stay black.
        let lit = lit_share(&pixels(&folder, "a.png"));
        assert!(lit > 0.9, "{camera}: only {lit} of the picture is lit");
    }
}

#[test]
fn exposure_multiplies() {
    let folder = Folder::with_scene();
    let mean = |exposure: &str| {
        render(&folder, "a.png", &["--exposure", exposure]);
        let picture = pixels(&folder, "a.png");
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

#[test]
fn heat_maps_are_pictures_with_a_legend() {
    let folder = Folder::with_scene();
    render(&folder, "a.png", &[]);
    let shaded = pixels(&folder, "a.png");
    for (view, words) in [
        ("cost", ["rays/m²", "dark violet", "yellow"]),
        ("links", ["links over which", "dark violet", "yellow"]),
        ("class", ["cost the most", "blue", "orange"]),
        ("partial", ["partial links", "dark violet", "yellow"]),
    ] {
        let run = render(&folder, "a.png", &["--view", view, "--threads", "1"]);
        for word in words {
            assert!(run.stderr.contains(word), "{view}: no '{word}' in {}", run.stderr);
        }
        assert!(!run.stderr.contains("--exposure"), "colours are not exposed: {}", run.stderr);
        let bytes = std::fs::read(folder.path("a.png")).expect("a picture");
        let map = pixels(&folder, "a.png");
        let others = shaded.pixels().zip(map.pixels()).filter(|(a, b)| a != b).count();
        assert!(others * 4 > shaded.pixels().len(), "{view}: only {others} pixels differ");
        let spread = |p: &image::Rgb<u8>| p.0.iter().max().unwrap_or(&0) - p.0.iter().min().unwrap_or(&0);
        assert!(map.pixels().filter(|p| spread(p) > 30).count() > 300, "{view} has no colours");
        render(&folder, "a.png", &["--view", view, "--threads", "3"]);
        assert!(std::fs::read(folder.path("a.png")).expect("a picture") == bytes, "{view} on three threads");
        render(&folder, "a.exr", &["--view", view]);
        let linear = image::open(folder.path("a.exr")).expect("a picture").into_rgb32f();
        assert!(linear.pixels().all(|p| p.0.iter().all(|c| (0.0..=1.0).contains(c))), "{view}");
    }
}

#[test]
fn a_final_gather_is_another_picture_and_the_last_word_counts() {
    let folder = Folder::with_scene();
    let solved = folder.run(&["solve", "scene.toml", "-o", "a.lsol", "--quality", "draft"]);
    assert_eq!(solved.code, 0, "{solved:?}");
    render(&folder, "plain.png", &[]);
    render(&folder, "reconstructed.png", &["--final-gather", "--reconstruct"]);
    render(&folder, "gathered.png", &["--reconstruct", "--final-gather"]);
    let stored = [
        "render",
        "scene.toml",
        "-o",
        "stored.png",
        "--solution",
        "a.lsol",
        "--samples",
        "1",
        "--final-gather",
    ];
    assert_eq!(folder.run(&stored).code, 0);
    let file = |name: &str| std::fs::read(folder.path(name)).expect("a picture");
    assert_eq!(file("plain.png"), file("reconstructed.png"));
    assert_ne!(file("plain.png"), file("gathered.png"));
    assert_eq!(file("gathered.png"), file("stored.png"), "a stored solution is gathered from as a new one");
    for options in [&["--view", "mesh", "--final-gather"][..], &["--gather-rays", "64"]] {
        let run = folder.run(&[&["render", "scene.toml", "-o", "no.png"], options].concat());
        assert_eq!(run.code, 2, "{run:?}");
        assert!(run.stderr.contains("--final-gather"), "{run:?}");
    }
    assert!(!folder.path("no.png").exists());
}

#[test]
fn a_picture_is_compared_with_its_reference() {
    let folder = Folder::with_scene();
    render(&folder, "right.exr", &["--width", "40"]);
    let run = render(&folder, "same.png", &["--reference", "right.exr", "--stats", "same.json"]);
    assert!(run.stderr.contains("against the reference: relative RMSE 0.00 %"), "{run:?}");
    assert_eq!(size(&folder.path("same.png")), (40, 30), "a picture has the size of its reference");
    let same = stats(&folder, "same.json").reference.expect("a comparison");
    assert_eq!((same.relative_rmse, same.flip), (0.0, 0.0));
    render(&folder, "other.png", &["--reference", "right.exr", "--stats", "other.json", "--final-gather"]);
    let other = stats(&folder, "other.json").reference.expect("a comparison");
    assert!(other.relative_rmse > 0.0 && other.flip > 0.0 && other.smoothed_flip > 0.0, "{other:?}");
    render(&folder, "alone.png", &["--stats", "alone.json"]);
    assert!(stats(&folder, "alone.json").reference.is_none());

    folder.write("text.exr", "no picture");
    for (reference, code) in [("missing.exr", 3), ("text.exr", 4), (".", 3)] {
        let run = folder.run(&["render", "scene.toml", "-o", "no.png", "--reference", reference]);
        run.expect_error(code, &[reference]);
    }
    let sized =
        folder.run(&["render", "scene.toml", "-o", "no.png", "--reference", "right.exr", "--width", "8"]);
    assert_eq!(sized.code, 2, "{sized:?}");
    let view =
        folder.run(&["render", "scene.toml", "-o", "no.png", "--reference", "right.exr", "--view", "mesh"]);
    view.expect_error(2, &["--reference"]);
    assert!(!folder.path("no.png").exists());
}
