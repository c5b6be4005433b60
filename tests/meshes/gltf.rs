//! What is read of glTF.

use glam::DVec3;
use lightshaft::scene::SceneErrorKind;
use serde_json::json;

use crate::files::{Files, area, assert_warned, corners, floats, refused, scene, square};

#[test]
fn a_square_is_a_square() {
    let scene = square().scene();
    assert_eq!(scene.name, "a");
    assert_eq!((scene.triangles.len(), scene.positions.len(), area(&scene)), (2, 4, 1.0));
    for [a, b, c] in corners(&scene) {
        assert!((b - a).cross(c - a).y > 0.0, "it faces up");
    }
    let paint = &scene.materials[0];
    assert_eq!((paint.name.as_str(), paint.reflectance), ("paint", [0.25, 0.5, 0.75]));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    // A camera is derived, as for any mesh.
    assert_eq!(scene.cameras.len(), 1);
}

#[test]
fn data_stands_in_the_text_or_beside_it() {
    use base64::Engine;
    let mut square = square();
    let expected = square.scene();
    let text = base64::engine::general_purpose::STANDARD.encode(&square.binary);
    let uri = |uri: &str| json!({"byteLength": square.binary.len(), "uri": uri});
    let inline = uri(&format!("data:application/octet-stream;base64,{text}"));
    let bare = uri(&format!("DATA:;base64,{}", text.trim_end_matches('=')));
    let beside = uri("my%20data.bin");
    for buffer in [inline, bare, beside] {
        square.json["buffers"] = json!([buffer]);
        let content = square.json.to_string();
        let files = Files::new(&[("a.gltf", content.as_bytes()), ("my data.bin", &square.binary)]);
        let scene = files.load().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(corners(&scene), corners(&expected));
        // So that no output replaces it.
        let is_outside = content.contains("my%20data");
        assert_eq!(scene.files.contains(&files.path("my data.bin")), is_outside);
    }
}

#[test]
fn emission_times_strength_is_radiance() {
    let mut square = square();
    square.json["extensionsRequired"] = json!(["KHR_materials_emissive_strength"]);
    square.json["materials"][0]["emissiveFactor"] = json!([1.0, 0.5, 0.25]);
    let radiance = |square: &crate::files::Square| square.scene().materials[0].radiance;
    assert_eq!(radiance(&square), [1.0, 0.5, 0.25]);
    square.json["materials"][0]["extensions"] =
        json!({"KHR_materials_emissive_strength": {"emissiveStrength": 8.0}});
    assert_eq!(radiance(&square), [8.0, 4.0, 2.0]);
    assert!(square.scene().warnings.is_empty());
    square.json["materials"][0]["doubleSided"] = json!(true);
    assert_warned(&square.scene(), &["leaves the front", "'paint'"]);
    // It would shine all over if the texture did not count.
    square.json["materials"][0]["emissiveTexture"] = json!({"index": 0});
    square.json["textures"] = json!([{"source": 0}]);
    square.json["images"] = json!([{"uri": "a.png"}]);
    assert_eq!(radiance(&square), [0.0; 3]);
    assert_warned(&square.scene(), &["nothing is emitted", "'paint'"]);
}

#[test]
fn bright_colours_are_clamped_and_what_is_no_diffuse_surface_is_said() {
    let mut square = square();
    square.json["materials"] = json!([{
        "name": "glass",
        "alphaMode": "BLEND",
        "extensions": {"KHR_materials_unlit": {}, "KHR_materials_transmission": {"transmissionFactor": 1.0}},
    }]);
    let scene = square.scene();
    assert_eq!(scene.materials[0].reflectance, [0.98; 3]);
    assert_warned(&scene, &["clamped", "'glass'"]);
    assert_warned(&scene, &["opaque", "'glass'"]);
    assert_warned(&scene, &["unlit", "'glass'"]);
    // Without a material: grey, as in OBJ files.
    square.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("material");
    let scene = square.scene();
    assert_eq!((scene.materials[0].name.as_str(), scene.materials[0].reflectance), ("default", [0.5; 3]));
}

#[test]
fn colours_of_vertices_multiply_the_base_colour() {
    let mut square = square();
    // Red is 1 at two corners of the first triangle, and nowhere in the second.
    let colours = [[0.6f32, 1.0, 1.0], [0.6, 1.0, 1.0], [0.0, 1.0, 1.0], [0.0, 1.0, 1.0]];
    let view = square.add_view(&floats(colours.as_flattened()));
    let accessor =
        square.add_accessor(json!({"bufferView": view, "componentType": 5126, "type": "VEC3", "count": 4}));
    square.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(accessor);
    let scene = square.scene();
    let reflectance =
        |triangle: usize| scene.materials[scene.triangles[triangle].material as usize].reflectance;
    let [first, second] = [reflectance(0), reflectance(1)];
    assert!(
        (first[0] - 0.25 * 0.4).abs() < 2e-3 && (second[0] - 0.25 * 0.2).abs() < 2e-3,
        "{first:?} {second:?}"
    );
    assert_eq!((first[1], first[2]), (0.5, 0.75));
    assert!(scene.materials.iter().all(|material| material.name == "paint"));

    // The same in bytes, which are linear too, with alpha.
    let bytes: Vec<u8> =
        colours.iter().flat_map(|[r, g, b]| [r, g, b, &1.0].map(|c| (c * 255.0) as u8)).collect();
    let view = square.add_view(&bytes);
    square.json["accessors"][accessor] =
        json!({"bufferView": view, "componentType": 5121, "normalized": true, "type": "VEC4", "count": 4});
    let again = square.scene();
    assert_eq!(again.materials.len(), 2);
    assert!((again.materials[0].reflectance[0] - first[0]).abs() < 1e-3);
}

#[test]
fn strips_and_fans_are_the_triangles_that_they_stand_for() {
    let expected = area(&square().scene());
    // Around the corners 0, 1, 2, 3; a strip goes to and fro.
    for (mode, order) in [(5, [1u8, 2, 0, 3]), (6, [0, 1, 2, 3])] {
        let mut square = square();
        let view = square.add_view(&order);
        square.json["accessors"][1] =
            json!({"bufferView": view, "componentType": 5121, "type": "SCALAR", "count": 4});
        square.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        let scene = square.scene();
        assert_eq!((scene.triangles.len(), area(&scene)), (2, expected), "mode {mode}");
        for [a, b, c] in corners(&scene) {
            assert!((b - a).cross(c - a).y > 0.0, "mode {mode}: a triangle faces down");
        }
    }
    // Without indices the corners follow one another.
    let mut square = square();
    let primitive = square.json["meshes"][0]["primitives"][0].as_object_mut().unwrap();
    primitive.remove("indices");
    primitive.insert("mode".to_owned(), json!(6));
    assert_eq!(corners(&square.scene()).len(), 2);
}

#[test]
fn points_and_lines_are_left_out_and_counted() {
    for (mode, skipped) in [(0, 6), (1, 3), (2, 6), (3, 5)] {
        let mut square = square();
        let mut other = square.json["meshes"][0]["primitives"][0].clone();
        other["mode"] = json!(mode);
        crate::files::push(&mut square.json["meshes"][0]["primitives"], other);
        let scene = square.scene();
        assert_eq!((scene.triangles.len(), scene.counts.skipped_faces), (2, skipped), "mode {mode}");
        assert_warned(&scene, &["skipped"]);
        square.json["meshes"][0]["primitives"].as_array_mut().unwrap().remove(0);
        refused(&[("a.glb", &square.glb())], SceneErrorKind::Invalid, "a.glb: no triangles, only");
    }
}

#[test]
fn what_has_no_positions_is_left_out_and_what_has_no_data_is_zeros() {
    let mut square = square();
    let other = json!({"attributes": {}, "indices": 1});
    crate::files::push(&mut square.json["meshes"][0]["primitives"], other);
    let colours = square.add_accessor(json!({"componentType": 5126, "type": "VEC3", "count": 4}));
    square.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colours);
    let scene = square.scene();
    assert_eq!((scene.triangles.len(), scene.materials[0].reflectance), (2, [0.0; 3]));
    assert_warned(&scene, &["1 primitive(s) without positions skipped"]);
}

#[test]
fn sparse_values_take_the_place_of_others() {
    let mut square = square();
    let places = square.add_view(&[2, 0, 3, 0]);
    let values = square.add_view(&floats(&[3., 0., 1., 3., 0., 0.]));
    let sparse = json!({
        "count": 2,
        "indices": {"bufferView": places, "componentType": 5123},
        "values": {"bufferView": values},
    });
    square.json["accessors"][0]["sparse"] = sparse;
    assert_eq!(area(&square.scene()), 3.0, "the square is three times as wide");
    // What is not stored is zero.
    square.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(corners(&square.scene()), [[DVec3::ZERO, DVec3::new(3.0, 0.0, 1.0), DVec3::X * 3.0]]);
}

#[test]
fn whole_numbers_are_positions_too() {
    let mut square = square();
    square.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    // Rows of 3 bytes, 4 bytes apart.
    let view = square.add_view(&[0, 0, 0, 9, 0, 0, 127, 9, 127, 0, 127, 9, 127, 0, 0, 9]);
    square.json["bufferViews"][view]["byteStride"] = json!(4);
    square.json["accessors"][0] =
        json!({"bufferView": view, "componentType": 5120, "normalized": true, "type": "VEC3", "count": 4});
    assert_eq!(area(&square.scene()), 1.0);
    square.json["accessors"][0]["normalized"] = json!(false);
    assert_eq!(area(&square.scene()), 127.0 * 127.0);
}

#[test]
fn skins_shapes_animations_and_lamps_without_surface_are_left_out_and_said() {
    let mut square = square();
    let expected = corners(&square.scene());
    square.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
    square.json["meshes"][0]["weights"] = json!([1.0]);
    square.json["skins"] = json!([{"joints": [0]}]);
    square.json["nodes"][0]["skin"] = json!(0);
    square.json["animations"] = json!([{"channels": [], "samplers": []}]);
    square.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    square.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    square.json["extensionsUsed"] = json!(["KHR_lights_punctual", "EXT_mesh_gpu_instancing"]);
    let scene = square.scene();
    assert_eq!(corners(&scene), expected);
    for words in [
        ["1 skinned", "at rest"],
        ["1 morphed", "at rest"],
        ["1 animation", "left out"],
        ["1 point, spot or directional", "left out"],
        ["not read", "EXT_mesh_gpu_instancing"],
    ] {
        assert_warned(&scene, &words);
    }
    let error = Files::new(&[("a.glb", &square.glb())]).load_lit().expect_err("no lamp").to_string();
    assert!(
        error.contains("nothing emits light (1 point, spot or directional light(s) have no surface);"),
        "{error}"
    );
}

#[test]
fn a_description_uses_meshes_of_every_kind_and_changes_their_materials() {
    let square = square();
    let toml =
        "mesh = ['a.GLB', 'b.obj']\n[material.paint]\nreflectance = [0.1, 0.2, 0.3]\nradiance = [1, 2, 3]\n";
    let obj = b"v 0 5 0\nv 1 5 0\nv 0 5 1\nf 1 2 3\n";
    let scene =
        Files::new(&[("s.toml", toml.as_bytes()), ("a.GLB", &square.glb()), ("b.obj", obj)]).load_lit();
    let scene = scene.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.triangles.len(), 3);
    assert_eq!(scene.materials[0].radiance, [1.0, 2.0, 3.0]);
    refused(
        &[("s.toml", b"\nmesh = 'a.stl'\n"), ("a.stl", b"")],
        SceneErrorKind::Invalid,
        "s.toml:2: mesh 'a.stl' is no .obj, .glb, .gltf or .ply file; export",
    );
    // A fault inside has the file's name, a file that is not there the description's line.
    refused(
        &[("s.toml", b"mesh = 'a.glb'\n"), ("a.glb", b"glTF")],
        SceneErrorKind::Parse,
        "a.glb: the file is cut off",
    );
}

#[test]
fn a_scene_of_one_file_is_lit() {
    let mut square = square();
    square.json["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
    let scene = scene("room.glb", &square.glb());
    assert!(scene.materials[0].is_emitter());
    assert_eq!(scene.positions[1], DVec3::Z);
}
