//! Where the nodes of glTF put meshes and cameras.

use glam::{DMat4, DQuat, DVec3};
use lightshaft::scene::SceneErrorKind;
use serde_json::{Value, json};

use crate::files::{Files, Square, area, assert_warned, corners, floats, glb, push, refused, square};

/// Corners of a cube of side 2 around the origin, and its triangles, facing outwards.
const CUBE: [[f32; 3]; 8] = [
    [-1., -1., -1.],
    [1., -1., -1.],
    [1., 1., -1.],
    [-1., 1., -1.],
    [-1., -1., 1.],
    [1., -1., 1.],
    [1., 1., 1.],
    [-1., 1., 1.],
];
const SIDES: [[u8; 3]; 12] = [
    [0, 2, 1],
    [0, 3, 2],
    [4, 5, 6],
    [4, 6, 7],
    [0, 1, 5],
    [0, 5, 4],
    [2, 3, 7],
    [2, 7, 6],
    [1, 2, 6],
    [1, 6, 5],
    [0, 4, 7],
    [0, 7, 3],
];

/// One cube on a shelf of nodes: scaled, turned by a third of a circle about the diagonal, mirrored. All numbers are exact in
/// single precision.
fn cubes() -> Vec<u8> {
    let mut binary = floats(CUBE.as_flattened());
    binary.extend(SIDES.as_flattened());
    let json = json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": binary.len()}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 96},
            {"buffer": 0, "byteOffset": 96, "byteLength": 36},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 8},
            {"bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 36},
        ],
        "materials": [
            {"name": "wood", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.125, 1]}},
            {"name": "lamp", "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}, "emissiveFactor": [1, 1, 1],
             "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}},
        ],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]},
            {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 1}]},
        ],
        "nodes": [
            {"translation": [4, 0, 0], "scale": [2, 1, 0.5], "children": [1, 2]},
            {"rotation": [0.5, 0.5, 0.5, 0.5], "mesh": 0, "translation": [0, 0.5, 0]},
            {"scale": [-0.5, 0.25, 1], "mesh": 1, "translation": [0, 4, 1]},
            // Columns: x, y, z, and where it is.
            {"matrix": [2, 0, 0, 0, 0, -2, 0, 0, 0, 0, 2, 0, -4, 0, 0, 1], "mesh": 0},
        ],
        "scenes": [{"nodes": [2]}, {"nodes": [0, 3]}],
        "scene": 1,
    });
    glb(&json, &binary)
}

/// The same three cubes as OBJ, transformed by other means.
fn cubes_as_obj() -> String {
    let top = DMat4::from_translation(DVec3::X * 4.0) * DMat4::from_scale(DVec3::new(2.0, 1.0, 0.5));
    let wood =
        DMat4::from_translation(DVec3::Y * 0.5) * DMat4::from_quat(DQuat::from_xyzw(0.5, 0.5, 0.5, 0.5));
    let lamp =
        DMat4::from_translation(DVec3::new(0.0, 4.0, 1.0)) * DMat4::from_scale(DVec3::new(-0.5, 0.25, 1.0));
    let other = DMat4::from_translation(DVec3::X * -4.0) * DMat4::from_scale(DVec3::new(2.0, -2.0, 2.0));
    let mut obj = "mtllib a.mtl\n".to_owned();
    for (number, (material, world, is_mirrored)) in
        [("wood", top * wood, false), ("lamp", top * lamp, true), ("wood", other, true)]
            .into_iter()
            .enumerate()
    {
        for corner in CUBE {
            let [x, y, z] = world.transform_point3(DVec3::from_array(corner.map(f64::from))).to_array();
            obj += &format!("v {x} {y} {z}\n");
        }
        obj += &format!("usemtl {material}\n");
        for [a, b, c] in SIDES {
            let [a, b, c] = if is_mirrored { [a, c, b] } else { [a, b, c] };
            let [a, b, c] = [a, b, c].map(|corner| usize::from(corner) + 1 + 8 * number);
            obj += &format!("f {a} {b} {c}\n");
        }
    }
    obj
}

const MTL: &[u8] = b"newmtl wood\nKd 0.5 0.25 0.125\nnewmtl lamp\nKd 0 0 0\nKe 4 4 4\n";

#[test]
fn nodes_put_meshes_where_other_means_put_them() {
    let gltf = Files::new(&[("a.glb", &cubes())]).load_lit().unwrap_or_else(|error| panic!("{error}"));
    let obj =
        Files::new(&[("a.obj", cubes_as_obj().as_bytes()), ("a.mtl", MTL)]).load_lit().expect("a scene");
    assert_eq!(corners(&gltf), corners(&obj));
    assert_eq!(gltf.materials, obj.materials);
    let material =
        |scene: &lightshaft::scene::Scene| scene.triangles.iter().map(|t| t.material).collect::<Vec<_>>();
    assert_eq!(material(&gltf), material(&obj));
    // Faces of a cube look away from its middle.
    for cube in corners(&gltf).chunks(12) {
        let middle = cube.as_flattened().iter().sum::<DVec3>() / 36.0;
        for [a, b, c] in cube {
            assert!((b - a).cross(c - a).dot(*a - middle) > 0.0, "a face looks inwards");
        }
    }
}

#[test]
fn a_solution_of_the_one_fits_the_other() {
    let files = Files::new(&[("a.glb", &cubes()), ("b.obj", cubes_as_obj().as_bytes()), ("a.mtl", MTL)]);
    files.run(&["solve", "a.glb", "-o", "a.lsol", "--quality", "draft"]);
    files.run(&["solve", "b.obj", "-o", "b.lsol", "--quality", "draft"]);
    // It has fingerprints of triangles, materials and tree: a file of another scene is refused.
    for (scene, solution, picture) in
        [("b.obj", "a.lsol", "ab.exr"), ("a.glb", "b.lsol", "ba.exr"), ("b.obj", "b.lsol", "bb.exr")]
    {
        files.run(&[
            "render",
            scene,
            "--solution",
            solution,
            "-o",
            picture,
            "--width",
            "40",
            "--height",
            "30",
        ]);
    }
    let bytes = |name: &str| std::fs::read(files.path(name)).expect("a picture");
    assert!(bytes("ab.exr") == bytes("bb.exr") && bytes("ba.exr") == bytes("bb.exr"), "the light differs");
}

/// The square with these nodes, all of them at the top.
fn with_nodes(nodes: Value) -> Square {
    let mut square = square();
    square.json["nodes"] = nodes;
    square
}

#[test]
fn of_several_scenes_the_default_one_counts_then_the_first_then_all_nodes() {
    let mut square =
        with_nodes(json!([{"mesh": 0}, {"mesh": 0, "scale": [3, 1, 1]}, {"mesh": 0, "scale": [1, 1, 9]}]));
    square.json["scenes"] = json!([{"nodes": [0]}, {"nodes": [1]}]);
    square.json["scene"] = json!(1);
    assert_eq!(area(&square.scene()), 3.0);
    square.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(area(&square.scene()), 1.0);
    square.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(area(&square.scene()), 13.0);
}

#[test]
fn meshes_without_nodes_and_scenes_stand_at_the_origin() {
    let mut square = square();
    let all = square.json.as_object_mut().expect("an object");
    all.retain(|key, _| !["nodes", "scenes", "scene"].contains(&key.as_str()));
    let again = square.json["meshes"][0].clone();
    push(&mut square.json["meshes"], again);
    let scene = square.scene();
    assert_eq!((scene.counts.triangles_initial, area(&scene)), (4, 1.0));
    assert_warned(&scene, &["2 mesh(es) without a scene", "at the origin"]);
    // Nodes that show none, or a scene without nodes, are an answer too.
    square.json["nodes"] = json!([{"name": "none"}]);
    refused(&[("a.glb", &square.glb())], SceneErrorKind::Invalid, "a.glb: no triangles");
}

#[test]
fn nodes_that_are_no_tree_are_refused() {
    let cycle = with_nodes(json!([{"children": [1]}, {"name": "round", "children": [0], "mesh": 0}]));
    refused(
        &[("a.glb", &cycle.glb())],
        SceneErrorKind::Parse,
        "a.glb: node 0 '': has two parents or is its own",
    );
    let mut diamond = with_nodes(
        json!([{"children": [1, 2]}, {"children": [3]}, {"children": [3]}, {"name": "shared", "mesh": 0}]),
    );
    refused(&[("a.glb", &diamond.glb())], SceneErrorKind::Parse, "a.glb: node 3 'shared': has two parents");
    diamond.json["nodes"] = json!([{"mesh": 0}]);
    diamond.json["scenes"][0]["nodes"] = json!([0, 0]);
    refused(&[("a.glb", &diamond.glb())], SceneErrorKind::Parse, "a.glb: node 0 '': has two parents");
    let own = with_nodes(json!([{"children": [0], "mesh": 0}]));
    refused(&[("a.glb", &own.glb())], SceneErrorKind::Parse, "a.glb: node 0 '': has two parents");
}

#[test]
fn a_tower_of_nodes_is_no_matter_of_stack() {
    let tall = 200_000;
    let mut nodes: Vec<Value> = (1..tall).map(|next| json!({"children": [next]})).collect();
    nodes.push(json!({"mesh": 0}));
    assert_eq!(area(&with_nodes(json!(nodes)).scene()), 1.0);
}

#[test]
fn transformations_that_make_no_sense_are_refused() {
    for (node, what) in [
        (json!({"mesh": 0, "rotation": [0, 0, 0, 0]}), "a.glb: node 0 '': its rotation is zero"),
        (
            json!({"mesh": 0, "scale": [1e30, 1, 1]}),
            "a.glb: mesh 0 'Floor', primitive 0: vertex 2 is not finite",
        ),
    ] {
        refused(&[("a.glb", &with_nodes(json!([node])).glb())], SceneErrorKind::Parse, what);
    }
    // Squeezed to nothing: no triangle is left.
    let flat = with_nodes(json!([{"mesh": 0, "scale": [0, 1, 1]}]));
    refused(&[("a.glb", &flat.glb())], SceneErrorKind::Invalid, "a.glb: no triangles left");
}

#[test]
fn repeated_meshes_are_as_many_as_the_limit_says() {
    // A large primitive in a small file: its corners are one vertex, over and over.
    let mut square = square();
    let view = square.add_view(&vec![0; 300_000]);
    square.json["accessors"][1] =
        json!({"bufferView": view, "componentType": 5121, "type": "SCALAR", "count": 300_000});
    let nodes: Vec<Value> = (0..200).map(|_| json!({"mesh": 0})).collect();
    square.json["scenes"][0]["nodes"] = json!((0..200).collect::<Vec<_>>());
    square.json["nodes"] = json!(nodes);
    refused(
        &[("a.glb", &square.glb())],
        SceneErrorKind::Invalid,
        "a.glb: mesh 0 'Floor': more than 16777216 triangles, with all that nodes repeat; split",
    );
}

#[test]
fn cameras_see_what_the_file_says() {
    let mut square = square();
    square.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1, "aspectRatio": 1.5}},
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 2, "znear": 1}},
        {"type": "perspective", "name": "lens", "perspective": {"yfov": 7.0, "znear": 0.1}},
    ]);
    // A quarter turn about x: it looks down.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let nodes = [
        json!({"camera": 0, "name": "above", "translation": [0.5, 4, 0.5], "rotation": [-half, 0, 0, half]}),
        json!({"camera": 1, "name": "flat"}),
        json!({"camera": 2}),
        json!({"camera": 0, "name": "above", "scale": [2, 2, 2], "translation": [0, 0, 5]}),
        json!({"camera": 0}),
    ];
    for node in nodes {
        let number = push(&mut square.json["nodes"], node);
        push(&mut square.json["scenes"][0]["nodes"], json!(number));
    }
    let scene = square.scene();
    let names: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["above", "above 2", "camera3"]);
    assert_warned(&scene, &["camera 'flat' is left out", "orthographic"]);
    assert_warned(&scene, &["camera 'lens' is left out", "field of view"]);
    let above = &scene.cameras[0];
    assert_eq!((above.eye, above.width, above.height), (DVec3::new(0.5, 4.0, 0.5), 720, 480));
    assert!((above.vfov_deg - 1f64.to_degrees()).abs() < 1e-5);
    assert!((above.target - DVec3::new(0.5, 0.0, 0.5)).length() < 1e-5, "it looks at the floor: {above:?}");
    assert!((above.up - DVec3::NEG_Z).length() < 1e-6, "{above:?}");

    // Those of a description come first, and stand for those of their names.
    let toml = "mesh = 'a.glb'\n[[camera]]\nname = 'above 2'\neye = [0,9,9]\ntarget = [0,0,0]\n";
    let scene = Files::new(&[("s.toml", toml.as_bytes()), ("a.glb", &square.glb())]).load().expect("a scene");
    let names: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["above 2", "above", "camera3"]);
    assert_eq!(scene.cameras[0].eye, DVec3::new(0.0, 9.0, 9.0));
}
