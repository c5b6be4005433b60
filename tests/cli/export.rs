//! Models for other programs: what is in a GLB and a PLY is the scene with its light, seen through the cameras of the
//! GLB as in our own pictures. A small reader and a ray caster of the tests' own share no code with the program.

use std::collections::HashSet;

use glam::{DMat4, DQuat, DVec2, DVec3};
use serde_json::Value;

use crate::run::{Folder, MESH, Run, SCENE};

/// A camera that sees the board from below, so that its back counts.
const BELOW: &str = r#"
[[camera]]
name = "below"
eye = [0.3, 0.15, 1.8]
target = [0, 0.5, 0]
up = [0, 1, 0]
vfov_deg = 60
width = 48
height = 36
"#;

/// Area of what [`SCENE`] shows, both sides: floor, wall, board and lamp.
const AREA: f64 = 2.0 * (4.0 + 4.0 + 0.64 + 0.36);

/// A folder with the scene and its solution, `room.lsol`. A unit of length is `meters`.
fn solved(meters: &str) -> Folder {
    let folder = Folder::with_scene();
    let unit = format!("meters_per_unit = {meters}");
    folder.write("scene.toml", format!("{SCENE}{BELOW}").replace("meters_per_unit = 1.0", &unit));
    done(&folder, &["solve", "scene.toml", "-o", "room.lsol", "--quality", "draft", "-q"]);
    folder
}

fn done(folder: &Folder, arguments: &[&str]) -> Run {
    let run = folder.run(arguments);
    assert_eq!((run.code, run.stdout.as_str()), (0, ""), "{arguments:?}: {run:?}");
    run
}

fn bytes(folder: &Folder, name: &str) -> Vec<u8> {
    std::fs::read(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// A corner, in metres, and its colour.
type Corner = (DVec3, DVec3);

struct Model {
    triangles: Vec<[Corner; 3]>,
    json: Value,
}

fn number(value: &Value) -> usize {
    value.as_u64().unwrap_or_else(|| panic!("{value} is no number")) as usize
}

fn vector(value: &Value) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|i| value[i].as_f64().expect("a coordinate")))
}

fn u32_at(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("4 bytes")) as usize
}

fn f32_at(bytes: &[u8], at: usize) -> f64 {
    f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().expect("4 bytes")))
}

fn u16_at(bytes: &[u8], at: usize) -> usize {
    usize::from(u16::from_le_bytes(bytes[at..at + 2].try_into().expect("2 bytes")))
}

impl Model {
    fn read(folder: &Folder, name: &str) -> Model {
        let file = bytes(folder, name);
        assert_eq!((&file[..4], u32_at(&file, 4), u32_at(&file, 8)), (&b"glTF"[..], 2, file.len()));
        let length = u32_at(&file, 12);
        assert_eq!(&file[16..20], b"JSON");
        let json: Value = serde_json::from_slice(&file[20..20 + length]).expect("JSON");
        let chunk = &file[20 + length..];
        assert_eq!((u32_at(chunk, 0), &chunk[4..8]), (chunk.len() - 8, &b"BIN\0"[..]));
        let mut model = Model { triangles: Vec::new(), json };
        model.triangles = model.triangles_in(&chunk[8..]);
        model
    }

    fn triangles_in(&self, binary: &[u8]) -> Vec<[Corner; 3]> {
        let json = &self.json;
        let at = |accessor: &Value| {
            let accessor = &json["accessors"][number(accessor)];
            let view = &json["bufferViews"][number(&accessor["bufferView"])];
            let begin = number(&view["byteOffset"]) + accessor["byteOffset"].as_u64().unwrap_or(0) as usize;
            (begin, view["byteStride"].as_u64().unwrap_or(2) as usize, number(&accessor["count"]))
        };
        let top = &json["nodes"][number(&json["scenes"][0]["nodes"][0])];
        let origin = vector(&top["translation"]);
        let mut triangles = Vec::new();
        for primitive in json["meshes"][0]["primitives"].as_array().expect("primitives") {
            let (positions, stride, count) = at(&primitive["attributes"]["POSITION"]);
            let (colors, _, _) = at(&primitive["attributes"]["COLOR_0"]);
            let (indices, _, corners) = at(&primitive["indices"]);
            let corner = |index: usize| {
                let vertex = u16_at(binary, indices + 2 * index);
                assert!(vertex < count);
                let position = [0, 4, 8].map(|axis| f32_at(binary, positions + stride * vertex + axis));
                let color = [0, 2, 4].map(|c| u16_at(binary, colors + stride * vertex + c) as f64 / 65535.0);
                (origin + DVec3::from_array(position), DVec3::from_array(color))
            };
            triangles.extend((0..corners / 3).map(|triangle| [0, 1, 2].map(|i| corner(3 * triangle + i))));
        }
        triangles
    }

    /// Where the camera of this name stands and how it is turned, and its projection.
    fn camera(&self, name: &str) -> (DMat4, &Value) {
        let nodes = self.json["nodes"].as_array().expect("nodes");
        let top = &nodes[number(&self.json["scenes"][0]["nodes"][0])];
        let node =
            nodes.iter().find(|node| node["name"] == name && node["camera"].is_u64()).expect("a camera");
        let turn = [0, 1, 2, 3].map(|i| node["rotation"][i].as_f64().expect("a quaternion"));
        let place = vector(&node["translation"]) + vector(&top["translation"]);
        let world = DMat4::from_rotation_translation(DQuat::from_array(turn), place);
        (world, &self.json["cameras"][number(&node["camera"])]["perspective"])
    }

    /// The colour that a ray meets first; triangles are seen from their front only.
    fn color_along(&self, origin: DVec3, direction: DVec3) -> DVec3 {
        let (mut nearest, mut color) = (f64::INFINITY, DVec3::ZERO);
        for [(a, color_a), (b, color_b), (c, color_c)] in &self.triangles {
            let (u, v, from) = (*b - *a, *c - *a, origin - *a);
            let normal = u.cross(v);
            let facing = -normal.dot(direction);
            if facing <= 0.0 {
                continue;
            }
            let t = normal.dot(from) / facing;
            let across = from.cross(direction);
            let at = DVec2::new(-v.dot(across), u.dot(across)) / -facing;
            if t > 0.0 && t < nearest && at.x >= 0.0 && at.y >= 0.0 && at.x + at.y <= 1.0 {
                nearest = t;
                color = *color_a * (1.0 - at.x - at.y) + *color_b * at.x + *color_c * at.y;
            }
        }
        color
    }

    fn area(&self) -> f64 {
        area(self.triangles.iter().map(|corners| corners.map(|(position, _)| position)))
    }
}

fn area(triangles: impl Iterator<Item = [DVec3; 3]>) -> f64 {
    triangles.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
}

/// Share of pixels in which the model differs by more than a hundredth from our own picture, and the mean difference of
/// the others relative to the mean of the picture.
fn off(folder: &Folder, model: &Model, camera: &str, exposure: f64) -> (f64, f64) {
    let own = format!("{camera}.exr");
    let render = ["render", "scene.toml", "--solution", "room.lsol", "--samples", "1", "-q"];
    done(folder, &[&render[..], &["--camera", camera, "-o", &own]].concat());
    let own = image::open(folder.path(&own)).expect("a picture").into_rgb32f();
    let (world, lens) = model.camera(camera);
    let aspect = f64::from(own.width()) / f64::from(own.height());
    let tangent = (0.5 * lens["yfov"].as_f64().expect("an angle")).tan();
    assert!((lens["aspectRatio"].as_f64().expect("a ratio") - aspect).abs() < 1e-6);
    let (mut differing, mut difference, mut sum) = (0, 0.0, 0.0);
    for (x, y, pixel) in own.enumerate_pixels() {
        let u = 2.0 * (f64::from(x) + 0.5) / f64::from(own.width()) - 1.0;
        let v = 1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(own.height());
        let direction = world.transform_vector3(DVec3::new(u * tangent * aspect, v * tangent, -1.0));
        let seen = model.color_along(world.w_axis.truncate(), direction) / exposure;
        let own = DVec3::from_array(pixel.0.map(f64::from));
        let off = (seen - own).abs().max_element();
        sum += own.max_element();
        if off > 0.01 * own.max_element().max(0.1) {
            differing += 1;
        } else {
            difference += off;
        }
    }
    assert!(sum > 0.0, "a black picture says nothing");
    (f64::from(differing) / f64::from(own.width() * own.height()), difference / sum)
}

#[test]
fn a_glb_shows_through_its_cameras_what_we_show() {
    let folder = solved("0.5");
    let told = done(&folder, &["export", "room.lsol", "--glb", "room.glb", "--exposure", "0.05"]);
    let mut model = Model::read(&folder, "room.glb");
    assert!(told.stderr.contains(&format!("room.glb: {} triangles", model.triangles.len())), "{told:?}");
    assert!((model.area() / 0.25 - AREA).abs() < 1e-4, "{} of {AREA}", model.area() / 0.25);
    assert_eq!(model.json["scenes"][0]["extras"]["exposure"].as_f64().map(|x| x as f32), Some(0.05));
    assert_eq!(model.json["scenes"][0]["extras"]["tone"], "plain");
    for camera in ["main", "side", "below"] {
        let (differing, mean) = off(&folder, &model, camera, 0.05);
        assert!(differing < 0.02 && mean < 2e-3, "{camera}: {differing} {mean}");
    }
    // With the sides of a surface swapped, or light a tenth brighter, the comparison has to notice.
    for triangle in &mut model.triangles {
        triangle.swap(0, 1);
    }
    assert!(off(&folder, &model, "below", 0.05).0 > 0.2);
    model = Model::read(&folder, "room.glb");
    assert!(off(&folder, &model, "main", 0.05 * 1.1).0 > 0.2);
}

#[test]
fn elements_meet_without_a_crack() {
    let folder = solved("1.0");
    done(&folder, &["export", "room.lsol", "--glb", "room.glb", "-q"]);
    let mut model = Model::read(&folder, "room.glb");
    assert!(model.triangles.len() > 500, "too coarse to tell: {}", model.triangles.len());
    assert_eq!(lone_edges(&model), 0);
    // Two triangles in the place of one, and not of its neighbour, have to be noticed.
    let [a, b, c] = model.triangles.swap_remove(100);
    let middle = ((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0);
    model.triangles.extend([[a, middle, c], [middle, b, c]]);
    assert!(lone_edges(&model) > 0);
}

/// How many edges have no counterpart the other way round. Where elements meet that is an edge of the neighbour, and along
/// the outline of a surface one of its other side.
fn lone_edges(model: &Model) -> usize {
    let key = |(p, _): Corner| p.to_array().map(f64::to_bits);
    let edges = model.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let edges: HashSet<_> = edges.map(|(a, b)| (key(a), key(b))).collect();
    edges.iter().filter(|&&(a, b)| !edges.contains(&(b, a))).count()
}

struct Ply {
    header: String,
    triangles: Vec<[DVec3; 3]>,
    exitance: Vec<DVec3>,
}

fn read_ply(folder: &Folder, name: &str) -> Ply {
    let file = bytes(folder, name);
    let end = b"end_header\n";
    let length = file.windows(end.len()).position(|window| window == end).expect("a header") + end.len();
    let header = String::from_utf8(file[..length].to_vec()).expect("text");
    let count = |element: &str| -> usize {
        let line = header.lines().find_map(|line| line.strip_prefix(element)).expect("a count");
        line.trim().parse().expect("a count")
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    assert_eq!(file.len(), length + 39 * vertices + 13 * faces);
    let f64_at = |at: usize| f64::from_le_bytes(file[at..at + 8].try_into().expect("8 bytes"));
    let at = |vertex: usize| length + 39 * vertex;
    let position = |vertex| DVec3::from_array([0, 8, 16].map(|axis| f64_at(at(vertex) + axis)));
    let exitance = |vertex| DVec3::from_array([27, 31, 35].map(|c| f32_at(&file, at(vertex) + c)));
    let triangles = (0..faces).map(|face| {
        let begin = at(vertices) + 13 * face;
        assert_eq!(file[begin], 3);
        [1, 5, 9].map(|i| position(u32_at(&file, begin + i)))
    });
    Ply { triangles: triangles.collect(), exitance: (0..vertices).map(exitance).collect(), header }
}

#[test]
fn a_ply_has_the_same_triangles_and_their_exitance() {
    let folder = solved("1.0");
    let models = ["--glb", "room.glb", "--ply", "room.ply", "--exposure", "0.05", "-q"];
    done(&folder, &[&["export", "room.lsol"][..], &models].concat());
    let (glb, ply) = (Model::read(&folder, "room.glb"), read_ply(&folder, "room.ply"));
    assert!(
        ply.header.contains("property float exitance_red\n") && ply.header.contains("times 0.05, tone plain")
    );
    assert_eq!(ply.triangles.len(), glb.triangles.len());
    // In the GLB they are in the order of materials.
    let in_order = |mut triangles: Vec<[DVec3; 3]>| {
        triangles
            .sort_by_key(|corners| corners.map(|corner| (corner * 16384.0).round().as_i64vec3().to_array()));
        triangles
    };
    let others = in_order(glb.triangles.iter().map(|corners| corners.map(|(corner, _)| corner)).collect());
    for (ours, theirs) in in_order(ply.triangles.clone()).iter().zip(&others) {
        assert!(ours.iter().zip(theirs).all(|(a, b)| a.distance(*b) < 1e-6), "{ours:?} {theirs:?}");
    }
    assert!((area(ply.triangles.iter().copied()) - AREA).abs() < 1e-4);
    // The lamp is black but for what it sends out: π times its radiance.
    let brightest = ply.exitance.iter().fold(DVec3::ZERO, |most, exitance| most.max(*exitance));
    assert!(brightest.distance(std::f64::consts::PI * DVec3::new(12.0, 11.0, 10.0)) < 1e-3, "{brightest}");
    let most = glb.triangles.iter().flatten().fold(DVec3::ZERO, |most, (_, color)| most.max(*color));
    assert!((most - 0.05 * DVec3::new(12.0, 11.0, 10.0)).abs().max_element() < 1e-4, "{most}");
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let folder = solved("1.0");
    for (threads, name) in [("1", "a"), ("3", "b")] {
        let [glb, ply] = ["glb", "ply"].map(|kind| format!("{name}.{kind}"));
        done(&folder, &["export", "room.lsol", "--glb", &glb, "--ply", &ply, "--threads", threads, "-q"]);
    }
    assert!(bytes(&folder, "a.glb") == bytes(&folder, "b.glb"));
    assert!(bytes(&folder, "a.ply") == bytes(&folder, "b.ply"));
    done(&folder, &["export", "room.lsol", "--glb", "c.glb", "--exposure", "0.07", "--tone", "filmic", "-q"]);
    done(&folder, &["export", "room.lsol", "--glb", "d.glb", "--exposure", "0.07", "-q"]);
    let [plain, filmic] = ["d.glb", "c.glb"].map(|name| Model::read(&folder, name));
    assert!(plain.triangles.iter().zip(&filmic.triangles).any(|(a, b)| a[0].1.distance(b[0].1) > 0.05));
}

#[test]
fn digits_are_kept_far_from_the_origin() {
    let folder = Folder::new();
    let far = |line: &str| match line.strip_prefix("v ") {
        Some(rest) => {
            let at: Vec<f64> = rest.split(' ').map(|word| word.parse().expect("a number")).collect();
            format!("v {} {} {}\n", at[0] + 1e7, at[1], at[2] - 3e7)
        }
        None => format!("{line}\n"),
    };
    folder.write("corner.obj", MESH.lines().map(far).collect::<String>());
    let (x, z) = ([9_999_999.7, 10_000_000.3], [-30_000_000.3, -29_999_999.7]);
    let corners = [(x[0], z[0]), (x[1], z[0]), (x[1], z[1]), (x[0], z[1])].map(|(x, z)| [x, 2.0, z]);
    let lamp = format!("mesh = \"corner.obj\"\n[[quad]]\ncorners = {corners:?}\nradiance = [12, 11, 10]\n");
    folder.write("scene.toml", lamp);
    done(&folder, &["solve", "scene.toml", "-o", "room.lsol", "--quality", "draft", "-q"]);
    done(&folder, &["export", "room.lsol", "--glb", "room.glb", "--ply", "room.ply", "-q"]);
    let model = Model::read(&folder, "room.glb");
    assert!((model.area() - AREA).abs() < 1e-3, "{}", model.area());
    assert!((area(read_ply(&folder, "room.ply").triangles.into_iter()) - AREA).abs() < 1e-3);
}

/// Expects that a run fails, with one line, and that nothing has changed.
fn refused(folder: &Folder, arguments: &[&str], code: i32, parts: &[&str]) {
    let before = folder.names();
    folder.run(&[&["export"], arguments, &["-q"]].concat()).expect_error(code, parts);
    assert_eq!(folder.names(), before, "{arguments:?}");
}

#[test]
fn what_cannot_be_exported_is_said_and_nothing_is_left() {
    let folder = solved("1.0");
    let whole = bytes(&folder, "room.lsol");
    folder.write("half.lsol", &whole[..whole.len() / 2]);
    std::fs::create_dir(folder.path("folder.glb")).expect("a folder");
    for (arguments, code, parts) in [
        (&["room.lsol", "--glb", "room.gltf"][..], 2, &["--glb", ".glb"][..]),
        (&["room.lsol", "--ply", "room.glb"], 2, &["--ply", ".ply"]),
        (&["room.lsol", "--glb", "nowhere/room.glb"], 6, &["nowhere"]),
        (&["room.lsol", "--glb", "folder.glb"], 6, &["folder.glb", "not a regular file"]),
        (&["room.lsol", "--glb", "a.glb", "--ply", "nowhere/a.ply"], 6, &["nowhere"]),
        (&["room.lsol", "--glb", "a.glb", "--exposure", "1e300"], 2, &["--exposure"]),
        (&["none.lsol", "--glb", "a.glb"], 3, &["none.lsol"]),
        (&["half.lsol", "--glb", "a.glb"], 4, &["half.lsol", "ends too early"]),
        (&["scene.toml", "--glb", "a.glb"], 4, &["scene.toml", "no solution file"]),
        (&["room.lsol", "--glb", "a.glb", "--scene", "none.toml"], 3, &["none.toml"]),
    ] {
        refused(&folder, arguments, code, parts);
    }
    for arguments in [&["room.lsol"][..], &["room.lsol", "--glb", "a.glb", "--exposure", "0"]] {
        let run = folder.run(&[&["export"], arguments].concat());
        assert_eq!(run.code, 2, "{arguments:?}: {run:?}");
    }
}
