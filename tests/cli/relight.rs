//! Other light for a solution file: what `relight` writes is read like any other, and never silently wrong.

use crate::run::{Folder, MESH, Run, SCENE};
use crate::statistics::stats;

/// A second lamp, which is off, and a rectangle that lies in the floor.
const MORE: &str = r#"
[[quad]]
name = "spot"
corners = [[-0.9, 1.5, 0.5], [-0.5, 1.5, 0.5], [-0.5, 1.5, 0.9], [-0.9, 1.5, 0.9]]
reflectance = [0, 0, 0]

[[quad]]
name = "tile"
corners = [[0.5, 0, 0.9], [0.9, 0, 0.9], [0.9, 0, 0.5], [0.5, 0, 0.5]]
reflectance = [0.2, 0.2, 0.2]
"#;

/// A folder with the scene and its solution, `room.lsol`.
fn solved() -> Folder {
    let folder = Folder::with_scene();
    folder.write("scene.toml", format!("{SCENE}{MORE}"));
    done(&folder, &["solve", "scene.toml", "-o", "room.lsol", "--quality", "draft"]);
    folder
}

/// Runs that end well.
fn done(folder: &Folder, arguments: &[&str]) -> Run {
    let run = folder.run(arguments);
    assert_eq!((run.code, run.stdout.as_str()), (0, ""), "{arguments:?}: {run:?}");
    run
}

fn relight(folder: &Folder, from: &str, to: &str, options: &[&str]) -> Run {
    done(folder, &[&["relight", from, "-o", to], options].concat())
}

fn bytes(folder: &Folder, name: &str) -> Vec<u8> {
    std::fs::read(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The radiance that is seen with a solution, all channels of all pixels.
fn seen(folder: &Folder, scene: &str, solution: &str) -> Vec<f32> {
    done(folder, &["render", scene, "--solution", solution, "-o", "seen.exr", "--samples", "4", "-q"]);
    image::open(folder.path("seen.exr")).expect("a picture").into_rgb32f().into_raw()
}

/// Mean difference relative to the mean of the first.
fn off(truth: &[f32], other: &[f32]) -> f32 {
    let sum: f32 = truth.iter().zip(other).map(|(a, b)| (a - b).abs()).sum();
    sum / truth.iter().sum::<f32>()
}

#[test]
fn a_name_that_is_gone_is_the_reason_and_a_link_leads_to_the_scene() {
    let folder = solved();
    relight(&folder, "room.lsol", "new.lsol", &["--set", "spot.radiance=[3, 2, 8]"]);
    let renamed = format!("{SCENE}{MORE}").replace("\"spot\"", "\"point\"");
    folder.write("renamed.toml", renamed);
    let arguments = ["render", "renamed.toml", "--solution", "new.lsol", "-o", "a.png"];
    folder.run(&arguments).expect_error(4, &["new.lsol: was relit", "'spot'", "'point'"]);
    // Names do not matter to what was not relit.
    done(&folder, &["render", "renamed.toml", "--solution", "room.lsol", "-o", "a.png", "--samples", "1"]);

    #[cfg(unix)]
    {
        std::fs::create_dir(folder.path("links")).expect("a folder");
        std::os::unix::fs::symlink("../new.lsol", folder.path("links/a.lsol")).expect("a link");
        relight(&folder, "links/a.lsol", "again.lsol", &["--set", "lamp.radiance=[1, 1, 1]"]);
    }
}

#[test]
fn a_relit_room_is_seen_with_its_own_lamps_and_walls() {
    let folder = solved();
    let changes =
        ["--set", "lamp.radiance=[3, 2, 8]", "--set", "default.reflectance=[.8,.2,.4]", "--stats", "a.json"];
    let told = relight(&folder, "room.lsol", "new.lsol", &changes);
    assert!(told.stderr.contains("relit in") && told.stderr.contains("links"), "{told:?}");
    let counted = stats(&folder, "a.json");
    let relit = counted.relit.expect("what became of the links");
    assert!(
        counted.links.total > 0 && relit.untested == 0 && relit.rays_cast < counted.visibility.rays_cast / 2
    );
    assert!((0.0..=1.0).contains(&relit.coarse));
    let lit = format!("{SCENE}{MORE}")
        .replace("[12, 11, 10]", "[3, 2, 8]")
        .replace("reflectance = [0.5, 0.5, 0.5]", "reflectance = [0.8, 0.2, 0.4]");
    folder.write("lit.toml", lit);
    done(&folder, &["solve", "lit.toml", "-o", "lit.lsol", "--quality", "draft", "-q"]);
    let [was, is, anew] = [("scene.toml", "room.lsol"), ("scene.toml", "new.lsol"), ("lit.toml", "lit.lsol")]
        .map(|(scene, solution)| seen(&folder, scene, solution));
    assert!(off(&anew, &was) > 0.3, "the light must change for this to say anything");
    assert!(off(&anew, &is) < 0.02, "{}", off(&anew, &is));
    // Whoever changes the scene, too, has the same.
    assert!(seen(&folder, "lit.toml", "new.lsol") == is);
    for command in [
        &["probe", "scene.toml", "--grid", "0.7", "-o", "a.csv"][..],
        &["render", "scene.toml", "-o", "a.png", "--view", "class"],
        &["render", "scene.toml", "-o", "a.png", "--final-gather", "--samples", "1"],
    ] {
        let told = done(&folder, &[command, &["--solution", "new.lsol"]].concat());
        assert!(told.stderr.contains("relit with 2 other materials"), "{told:?}");
    }
    let check = folder.run(&["check", "scene.toml", "--solution", "new.lsol"]);
    assert_eq!(check.code, 0, "{check:?}");
}

#[test]
fn changes_add_up_and_can_be_taken_back() {
    let folder = solved();
    relight(&folder, "room.lsol", "a.lsol", &["--set", "lamp.radiance=[1,1,1]", "-q"]);
    relight(&folder, "a.lsol", "b.lsol", &["--set", "default.reflectance=[.1,.1,.1]", "-q"]);
    let both = ["--set", "default.reflectance=[.1,.1,.1]", "--set", "lamp.radiance=[1,1,1]", "-q"];
    relight(&folder, "room.lsol", "both.lsol", &both);
    let [b, both] = ["b.lsol", "both.lsol"].map(|solution| seen(&folder, "scene.toml", solution));
    assert!(off(&both, &b) < 2e-3, "{}", off(&both, &b));
    let back = ["--set", "default.reflectance=[.5,.5,.5]", "--set", "lamp.radiance=[12,11,10]", "-q"];
    relight(&folder, "b.lsol", "back.lsol", &back);
    let [was, is] = ["room.lsol", "back.lsol"].map(|solution| seen(&folder, "scene.toml", solution));
    assert!(off(&was, &is) < 5e-3, "{}", off(&was, &is));
}

#[test]
fn a_lamp_that_was_off_throws_its_own_shadows() {
    let folder = solved();
    let told = relight(
        &folder,
        "room.lsol",
        "new.lsol",
        &["--set", "spot.radiance=[0,60,0]", "--set", "lamp.radiance=[0,0,0]", "--stats", "a.json"],
    );
    assert!(told.stderr.contains("shines now"), "{told:?}");
    assert!(stats(&folder, "a.json").relit.is_some_and(|relit| relit.untested > 0 && relit.rays_cast > 0));
    let lit = format!("{SCENE}{MORE}").replace("radiance = [12, 11, 10]", "radiance = [0, 0, 0]").replace(
        "reflectance = [0, 0, 0]\n\n[[quad]]\nname = \"tile\"",
        "radiance = [0, 60, 0]\nreflectance = [0, 0, 0]\n\n[[quad]]\nname = \"tile\"",
    );
    folder.write("lit.toml", lit);
    done(&folder, &["solve", "lit.toml", "-o", "lit.lsol", "--quality", "draft", "-q"]);
    let [is, anew] = [("scene.toml", "new.lsol"), ("lit.toml", "lit.lsol")]
        .map(|(scene, solution)| seen(&folder, scene, solution));
    assert!(anew.iter().sum::<f32>() > 0.0);
    assert!(off(&anew, &is) < 0.03, "{}", off(&anew, &is));
}

#[test]
fn the_same_for_any_number_of_threads() {
    let folder = solved();
    for (changes, names) in [
        (&["--set", "default.reflectance=[.9,.9,.9]"][..], ["a.lsol", "b.lsol"]),
        (&["--set", "spot.radiance=[5,5,5]"], ["c.lsol", "d.lsol"]),
        (&["--set", "lamp.radiance=[1,1,1]", "--refine"], ["e.lsol", "f.lsol"]),
    ] {
        for (threads, name) in ["1", "4"].iter().zip(names) {
            relight(&folder, "room.lsol", name, &[changes, &["--threads", threads, "-q"]].concat());
        }
        assert!(bytes(&folder, names[0]) == bytes(&folder, names[1]), "{changes:?}");
    }
}

/// Expects that a run fails, with one line, and that nothing has changed.
fn refused(folder: &Folder, arguments: &[&str], code: i32, parts: &[&str]) {
    let before = folder.names();
    folder.run(&[&["relight"], arguments, &["-q"]].concat()).expect_error(code, parts);
    assert_eq!(folder.names(), before, "{arguments:?}");
}

#[test]
fn what_cannot_be_changed_is_said_by_name() {
    let folder = solved();
    let lit = "lamp.radiance=[1,1,1]";
    for (changes, output, code, parts) in [
        (
            &["lamb.radiance=[1,1,1]"][..],
            "a.lsol",
            2,
            &["--set", "'lamb'", "did you mean 'lamp'", "'default'", "'spot'"][..],
        ),
        (&["lamp.radiance=[0,0,0]"], "a.lsol", 5, &["nothing emits light"]),
        (&["tile.radiance=[1,1,1]"], "a.lsol", 5, &["scene.toml", "lie in each other", "solve it again"]),
        (&[lit, "lamp.radiance=[2,1,1]"], "a.lsol", 2, &["--set lamp.radiance", "twice"]),
        (&[lit], "a.png", 2, &[".lsol"]),
        (&[lit], "room.lsol", 2, &["room.lsol", "twice"]),
        (&[lit], "nowhere/a.lsol", 6, &["nowhere"]),
    ] {
        let set: Vec<&str> = changes.iter().flat_map(|&change| ["--set", change]).collect();
        refused(&folder, &[&["room.lsol", "-o", output], &set[..]].concat(), code, parts);
    }
    for (options, part) in [
        (&["--set", "lamp.radiance=[1,1]"][..], "no colour"),
        (&["--set", "lamp.radiance=[-1,1,1]"], "negative"),
        (&["--set", "lamp.radiance=[nan,1,1]"], "not finite"),
        (&["--set", "lamp.glow=[1,1,1]"], "'glow'"),
        (&["--set", "lamp"], "NAME.radiance"),
        (&[], "--set"),
        (&["--set", lit, "--quality", "draft"], "--quality"),
    ] {
        let run = folder.run(&[&["relight", "room.lsol", "-o", "a.lsol"], options].concat());
        assert!(run.code == 2 && run.stderr.contains(part), "{options:?}: {run:?}");
    }
    let told = relight(&folder, "room.lsol", "a.lsol", &["--set", "default.reflectance=[1,1,1]"]);
    assert!(told.stderr.contains("warning: ") && told.stderr.contains("0.98"), "{told:?}");
}

#[test]
fn the_scene_is_found_from_the_solution_and_has_to_be_the_same() {
    let folder = solved();
    let change = ["--set", "lamp.radiance=[1,1,1]"];
    std::fs::create_dir(folder.path("light")).expect("a folder");
    relight(&folder, "room.lsol", "light/new.lsol", &[&change[..], &["-q"]].concat());
    relight(&folder, "light/new.lsol", "again.lsol", &["--set", "lamp.radiance=[2,2,2]", "-q"]);
    std::fs::create_dir(folder.path("moved")).expect("a folder");
    for name in ["scene.toml", "corner.obj"] {
        std::fs::rename(folder.path(name), folder.path(&format!("moved/{name}"))).expect("moved");
    }
    let from = ["room.lsol", "-o", "a.lsol"];
    refused(&folder, &[&from[..], &change].concat(), 3, &["scene.toml", "not there any more", "--scene"]);
    relight(&folder, "room.lsol", "a.lsol", &[&change[..], &["--scene", "moved/scene.toml", "-q"]].concat());
    folder.write("other.toml", SCENE.replace("corner.obj", "other.obj"));
    folder.write("other.obj", MESH.replace("v 0.4 0.5 0.4", "v 0.4 0.51 0.4"));
    let other = ["--scene", "other.toml"];
    refused(&folder, &[&from[..], &change, &other].concat(), 4, &["room.lsol", "geometry"]);
    refused(&folder, &["none.lsol", "-o", "a.lsol", "--set", change[1]], 3, &["none.lsol"]);
    let whole = bytes(&folder, "room.lsol");
    folder.write("half.lsol", &whole[..whole.len() / 2]);
    let half = ["half.lsol", "-o", "b.lsol", "--scene", "moved/scene.toml", "--set", change[1]];
    refused(&folder, &half, 4, &["half.lsol", "ends too early"]);
}
