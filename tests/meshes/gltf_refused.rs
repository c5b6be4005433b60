//! glTF that is broken, hostile, or of a kind that is not read.

use lightshaft::scene::SceneErrorKind::{Invalid, Io, Parse};
use lightshaft::scene::{SceneErrorKind, load};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::files::{Files, floats, glb, refused, square};

/// The square with something changed at a place of the JSON.
#[track_caller]
fn changed(place: &str, value: Value, kind: SceneErrorKind, start: &str) {
    let mut square = square();
    *square.json.pointer_mut(place).unwrap_or_else(|| panic!("no {place}")) = value;
    refused(&[("a.glb", &square.glb())], kind, &format!("a.glb: {start}"));
}

const PRIMITIVE: &str = "mesh 0 'Floor', primitive 0";

#[test]
fn counts_and_offsets_beyond_the_data_are_refused_before_anything_is_made() {
    let four_billion = json!(4_000_000_000u64);
    let at = |accessor: usize| format!("{PRIMITIVE}: accessor {accessor}: ");
    for (place, value, start) in [
        ("/accessors/0/count", four_billion.clone(), at(0) + "4000000000 elements of 12 bytes do not fit"),
        ("/accessors/1/count", four_billion.clone(), at(1) + "4000000000 elements of 1 bytes do not fit"),
        ("/accessors/0/count", json!(u64::MAX), at(0) + "18446744073709551615 elements"),
        (
            "/bufferViews/0/byteLength",
            json!(1000),
            at(0) + "bufferView 0 reaches beyond its buffer of 54 bytes",
        ),
        (
            "/bufferViews/0/byteLength",
            json!(47),
            at(0) + "4 elements of 12 bytes do not fit into bufferView 0 of 47",
        ),
        ("/bufferViews/1/byteOffset", json!(u64::MAX), at(1) + "bufferView 1 reaches beyond"),
        ("/bufferViews/1/byteOffset", json!(49), at(1) + "bufferView 1 reaches beyond"),
        ("/buffers/0/byteLength", four_billion.clone(), "buffer 0: has 56 of 4000000000 bytes".to_owned()),
    ] {
        changed(place, value, Parse, &start);
    }
    let mut square = square();
    square.json["accessors"][0]["byteOffset"] = json!(u64::MAX);
    refused(&[("a.glb", &square.glb())], Parse, &format!("a.glb: {PRIMITIVE}: accessor 0: 4 elements"));
    square.json["accessors"][0]["byteOffset"] = json!(0);
    square.json["bufferViews"][0]["byteStride"] = json!(4);
    refused(
        &[("a.glb", &square.glb())],
        Parse,
        &format!("a.glb: {PRIMITIVE}: accessor 0: bufferView 0 has elements of 12 bytes, 4 bytes apart"),
    );
}

#[test]
fn what_only_changes_are_stored_of_cannot_be_of_any_size() {
    let mut square = square();
    let places = square.add_view(&[0, 0, 0, 0]);
    let values = square.add_view(&floats(&[3., 0., 1.]));
    square.json["accessors"][0] = json!({
        "componentType": 5126, "type": "VEC3", "count": 3_000_000_000u64,
        "sparse": {"count": 1, "indices": {"bufferView": places, "componentType": 5125}, "values": {"bufferView": values}},
    });
    square.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
    refused(
        &[("a.glb", &square.glb())],
        Parse,
        &format!("a.glb: {PRIMITIVE}: claims 3000000000 vertices and stores none"),
    );
    square.json["accessors"][0]["sparse"]["count"] = json!(3_000_000_000u64);
    refused(
        &[("a.glb", &square.glb())],
        Parse,
        &format!("a.glb: {PRIMITIVE}: accessor 0: 3000000000 elements of 4"),
    );
    square.json["accessors"][0]["sparse"]["count"] = json!(1);
    square.json["accessors"][0]["sparse"]["indices"]["byteOffset"] = json!(u64::MAX);
    refused(&[("a.glb", &square.glb())], Parse, &format!("a.glb: {PRIMITIVE}: accessor 0: 1 elements of 4"));
}

#[test]
fn sparse_places_are_in_order_and_in_range() {
    for places in [[3u8, 2], [2, 2], [2, 4]] {
        let mut square = square();
        let view = square.add_view(&places);
        let values = square.add_view(&floats(&[0.; 6]));
        square.json["accessors"][0]["sparse"] = json!({"count": 2, "indices": {"bufferView": view, "componentType": 5121}, "values": {"bufferView": values}});
        refused(
            &[("a.glb", &square.glb())],
            Parse,
            &format!("a.glb: {PRIMITIVE}: accessor 0: has sparse indices out"),
        );
    }
}

#[test]
fn numbers_that_stand_for_nothing_are_refused() {
    for (place, value, start) in [
        ("/meshes/0/primitives/0/attributes/POSITION", json!(9), "meshes[0].primitives[0]: no such accessor"),
        (
            "/meshes/0/primitives/0/attributes",
            json!({"POSITION": 0, "COLOR_0": 9}),
            "meshes[0].primitives[0].attributes",
        ),
        ("/meshes/0/primitives/0/indices", json!(9), "meshes[0].primitives[0].indices names something"),
        ("/meshes/0/primitives/0/material", json!(9), "meshes[0].primitives[0].material names something"),
        (
            "/meshes/0/primitives/0/indices",
            json!(0),
            "mesh 0 'Floor', primitive 0: indices are no stored whole numbers",
        ),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(1),
            "mesh 0 'Floor', primitive 0: positions are no vectors",
        ),
        ("/accessors/0/bufferView", json!(9), "accessors[0].bufferView names something"),
        ("/accessors/0/type", json!("MAT4"), "mesh 0 'Floor', primitive 0: accessor 0: holds matrices"),
        ("/accessors/0/type", json!("VEC9"), "accessors[0].type has a value that glTF does not know"),
        ("/accessors/0/componentType", json!(7), "accessors[0].componentType has a value"),
        ("/accessors/1/count", json!(5), "mesh 0 'Floor', primitive 0: 5 corners are no triangles"),
        (
            "/accessors/0/count",
            json!(3),
            "mesh 0 'Floor', primitive 0: index 5 is 3, and there are 3 vertices",
        ),
        ("/bufferViews/0/buffer", json!(4), "bufferViews[0].buffer names something"),
        ("/nodes/0/mesh", json!(4), "nodes[0].mesh names something"),
        ("/scenes/0/nodes", json!([4]), "scenes[0].nodes[0] names something"),
        ("/scene", json!(4), "scene names something"),
        ("/asset/version", json!("1.0"), "glTF version 1.0 is not read"),
    ] {
        changed(place, value, Parse, start);
    }
}

#[test]
fn colours_and_positions_are_numbers() {
    for bad in [f32::NAN, f32::INFINITY, 1e30] {
        let mut square = square();
        square.binary[4..8].copy_from_slice(&bad.to_le_bytes());
        refused(&[("a.glb", &square.glb())], Parse, &format!("a.glb: {PRIMITIVE}: vertex 0 is not finite"));
    }
    let mut square = square();
    let view = square.add_view(&floats(&[f32::NAN; 12]));
    let colours = json!({"bufferView": view, "componentType": 5126, "type": "VEC3", "count": 4});
    let accessor = square.add_accessor(colours);
    square.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(accessor);
    refused(
        &[("a.glb", &square.glb())],
        Parse,
        &format!("a.glb: {PRIMITIVE}: a colour of vertex 0, 1 or 2 is not"),
    );
    square.json["accessors"][accessor]["count"] = json!(3);
    refused(&[("a.glb", &square.glb())], Parse, &format!("a.glb: {PRIMITIVE}: colours do not fit"));
    let factor = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    changed(
        factor,
        json!([-1, 0, 0, 1]),
        Invalid,
        "material 0 'paint': base colour [-1.0, 0.0, 0.0] is negative",
    );
    let lamp = json!([{"emissiveFactor": [1, 1, 1],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": -2}}}]);
    changed("/materials", lamp, Invalid, "material 0 'material0': emission [-2.0, -2.0, -2.0] is negative");
}

#[test]
fn extensions_that_hold_the_geometry_are_refused_with_what_to_do() {
    for (name, advice) in [
        ("KHR_draco_mesh_compression", "without compression"),
        ("EXT_meshopt_compression", "without compression"),
        ("KHR_texture_basisu", "without them"),
        ("my\nown", "without them"),
    ] {
        let mut square = square();
        square.json["extensionsRequired"] = json!([name]);
        let start = format!(
            "a.glb: needs the extension(s) '{}', which are not read; export it {advice}",
            name.escape_debug()
        );
        refused(&[("a.glb", &square.glb())], Invalid, &start);
    }
}

#[test]
fn data_is_only_taken_from_beside_the_file() {
    let mut square = square();
    let mut with = |uri: &str, kind, start: &str| {
        square.json["buffers"][0]["uri"] = json!(uri);
        refused(
            &[("a.gltf", square.json.to_string().as_bytes())],
            kind,
            &format!("a.gltf: buffer 0: {start}"),
        );
    };
    with("/etc/hostname", Parse, "'/etc/hostname' is not a relative path");
    with("%2Fetc%2Fhostname", Parse, "'%2Fetc%2Fhostname' is not a relative path");
    with("file:///etc/hostname", Parse, "'file:///etc/hostname' is not a relative path");
    with("http://there/a.bin", Parse, "'http://there/a.bin' is not a relative path");
    with("", Parse, "'' is not a relative path");
    with("../none/a.bin", Io, "'../none/a.bin': file not found");
    with("none.bin", Io, "'none.bin': file not found");
    with(".", Io, "'.': is a folder");
    with("%ff", Parse, "'%ff' is no UTF-8");
    with("data:text/plain,abc", Parse, "'data:text/plain,abc' is not data in base64");
    with("data:;base64,§", Parse, "its base64 is damaged");
    with("data:;base64,AAAA", Parse, "has 3 of 54 bytes");
    square.json["buffers"] = json!([{"byteLength": 54}]);
    refused(
        &[("a.gltf", square.json.to_string().as_bytes())],
        Parse,
        "a.gltf: buffer 0: has no data in the file",
    );
}

#[test]
fn what_is_no_gltf_is_refused() {
    for (content, start) in [
        (&b""[..], "a.gltf:1: the JSON is no glTF 2.0"),
        (b"{", "a.gltf:1: the JSON is no glTF 2.0"),
        (b"{}", "a.gltf:1: the JSON is no glTF 2.0 (column 2: missing field `asset`)"),
        (b"\n\n[1, 2]", "a.gltf:3: the JSON is no glTF 2.0"),
        (b"glTF", "a.gltf: the file is cut off after 4 bytes"),
        (b"glTF\x01\0\0\0\x0c\0\0\0", "a.gltf: GLB version 1 is not read"),
        (b"glTF\x02\0\0\0\0\0\0\0", "a.gltf: the GLB does not begin with a whole chunk"),
        (b"glTF\x02\0\0\0\x0c\0\0\0", "a.gltf: the GLB does not begin with a whole chunk"),
        (
            b"glTF\x02\0\0\0\x14\0\0\0\xff\xff\xff\xffJSON",
            "a.gltf: the GLB does not begin with a whole chunk",
        ),
        (b"glTF\x02\0\0\0\x14\0\0\0\0\0\0\0BIN\0", "a.gltf: the GLB does not begin with a whole chunk"),
        (b"\xff\xfe{\0", "a.gltf:1: the JSON is no glTF 2.0"),
    ] {
        refused(&[("a.gltf", content)], Parse, start);
    }
    // Nested deeper than any reader goes.
    let deep = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"extras\":{}", "[".repeat(100_000));
    refused(&[("a.gltf", deep.as_bytes())], Parse, "a.gltf:1: the JSON is no glTF 2.0");
    let many = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{}{{}}]}}", "{},".repeat(1 << 22));
    refused(&[("a.gltf", many.as_bytes())], Invalid, "a.gltf: the JSON has more than 4194304 objects");
    let third = glb(&square().json, &square().binary);
    let mut longer = third.clone();
    longer[8..12].copy_from_slice(&(third.len() as u32 + 1).to_le_bytes());
    refused(&[("a.glb", &longer)], Parse, "a.glb: the file is cut off: it has");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    /// Whatever happens to a file on its way, the answer is a scene or one line.
    #[test]
    fn damaged_files_are_read_or_refused(
        place in 0usize..2000,
        byte: u8,
        cut in prop::option::of(0usize..2000),
    ) {
        let mut square = square();
        let places = square.add_view(&[0, 3]);
        let values = square.add_view(&floats(&[0., 0., 0., 2., 0., 0.]));
        square.json["accessors"][0]["sparse"] =
            json!({"count": 2, "indices": {"bufferView": places, "componentType": 5121}, "values": {"bufferView": values}});
        let mut file = square.glb();
        let length = file.len();
        file[place % length] = byte;
        file.truncate(cut.map_or(length, |cut| cut % length));
        let files = Files::new(&[("a.glb", &file)]);
        if let Err(error) = load(&files.path("a.glb"), &Default::default(), &lightshaft::progress::Silent) {
            prop_assert!(!error.to_string().contains('\n'), "{}", error);
        }
    }
}
