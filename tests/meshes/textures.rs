//! Pictures as base colours: light is exchanged with their mean, what is seen are their texels.

use std::io::Cursor;
use std::process::Command;

use glam::DVec3;
use image::{ImageFormat, Rgb, RgbImage};
use lightshaft::scene::{Material, Scene};
use serde_json::json;

use crate::files::{Files, Square, assert_warned, corners, floats, square};

/// Four texels, encoded: white and black above, red and blue below.
fn quarters() -> RgbImage {
    let texels = [[255, 255, 255], [0, 0, 0], [255, 0, 0], [0, 0, 255]];
    RgbImage::from_fn(2, 2, |x, y| Rgb(texels[(2 * y + x) as usize]))
}

pub(crate) fn encoded(picture: &RgbImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).expect("a picture");
    bytes.into_inner()
}

/// The square with a picture in its data; `places` of the corners (0, 0), (0, 1), (1, 1) and (1, 0) of x and z.
fn painted(picture: &[u8], places: [[f32; 2]; 4]) -> Square {
    let mut square = square();
    let view = square.add_view(picture);
    square.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    square.json["textures"] = json!([{"source": 0}]);
    let view = square.add_view(&floats(places.as_flattened()));
    let accessor =
        square.add_accessor(json!({"bufferView": view, "componentType": 5126, "type": "VEC2", "count": 4}));
    square.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(accessor);
    square.json["materials"][0]["pbrMetallicRoughness"] =
        json!({"baseColorFactor": [0.5, 0.5, 0.8, 1], "baseColorTexture": {"index": 0}});
    square
}

/// The picture's left upper corner at the origin, u along x, v along z.
const FLAT: [[f32; 2]; 4] = [[0., 0.], [0., 1.], [1., 1.], [1., 0.]];

fn material(scene: &Scene, triangle: usize) -> &Material {
    &scene.materials[scene.triangles[triangle].material as usize]
}

#[track_caller]
fn assert_near(found: [f32; 3], expected: [f32; 3]) {
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off < 4e-3, "{found:?} instead of {expected:?}");
}

#[test]
fn a_floor_reflects_the_mean_and_shows_the_texels() {
    let scene = painted(&encoded(&quarters(), ImageFormat::Png), FLAT).scene();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    // The picture lies on both triangles in the same way: they can become one facet.
    assert_eq!((scene.materials.len(), scene.triangles.len()), (1, 2));
    let floor = material(&scene, 0);
    let off =
        floor.reflectance.iter().zip([0.25, 0.125, 0.4]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off < 0.02, "{:?}", floor.reflectance);
    for (x, z, expected) in [
        (0.25, 0.25, [0.5, 0.5, 0.8]),
        (0.75, 0.25, [0.0, 0.0, 0.0]),
        (0.25, 0.75, [0.5, 0.0, 0.0]),
        (0.75, 0.75, [0.0, 0.0, 0.8]),
        (0.5, 0.25, [0.25, 0.25, 0.4]),
    ] {
        assert_near(floor.reflectance_at(DVec3::new(x, 0.0, z)), expected);
    }
}

#[test]
fn nodes_transforms_and_wraps_move_the_picture() {
    let mut square = painted(&encoded(&quarters(), ImageFormat::Png), FLAT);
    let at =
        |square: &Square, x: f64, z: f64| material(&square.scene(), 0).reflectance_at(DVec3::new(x, 0.0, z));
    square.json["nodes"][0]["scale"] = json!([4, 1, -2]);
    assert_near(at(&square, 1.0, -0.5), [0.5, 0.5, 0.8]);
    assert_near(at(&square, 1.0, -1.5), [0.5, 0.0, 0.0]);
    square.json["nodes"][0]["scale"] = json!([1, 1, 1]);

    // A quarter turn: what was along u is against v.
    let transform = json!({"KHR_texture_transform": {"rotation": std::f32::consts::FRAC_PI_2}});
    square.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = transform;
    square.json["extensionsRequired"] = json!(["KHR_texture_transform"]);
    // u' = v, v' = −u: (¼, ¾) shows (¾, −¼), which repeats as (¾, ¾).
    assert_near(at(&square, 0.25, 0.75), [0.0, 0.0, 0.8]);
    assert_near(at(&square, 0.75, 0.75), [0.0, 0.0, 0.0]);
    square.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33071}]);
    square.json["textures"][0]["sampler"] = json!(0);
    assert_near(at(&square, 0.25, 0.75), [0.0, 0.0, 0.0]);

    let transform = json!({"KHR_texture_transform": {"scale": [2, 1], "offset": [0.5, 0]}});
    square.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = transform;
    square.json["samplers"] = json!([{"wrapS": 33648, "wrapT": 33071}]);
    // u' = 2 · 0.625 + 0.5 = 1.75, mirrored to 0.25.
    assert_near(at(&square, 0.625, 0.25), [0.5, 0.5, 0.8]);
}

#[test]
fn where_a_picture_lies_otherwise_is_another_material_of_the_same_name() {
    let places = [[0., 0.], [0., 1.], [1., 1.], [0.9, 0.]];
    let scene = painted(&encoded(&quarters(), ImageFormat::Png), places).scene();
    assert_eq!(scene.materials.len(), 2);
    assert_eq!(scene.materials[0].name, scene.materials[1].name);
    // A description that says what is reflected leaves no picture.
    let toml = "mesh = 'a.glb'\n[material.paint]\nreflectance = [0.1, 0.2, 0.3]\n";
    let square = painted(&encoded(&quarters(), ImageFormat::Png), places);
    let scene = Files::new(&[("s.toml", toml.as_bytes()), ("a.glb", &square.glb())]).load().expect("a scene");
    assert_near(material(&scene, 0).reflectance_at(DVec3::ZERO), [0.1, 0.2, 0.3]);
}

#[test]
fn without_places_on_it_a_picture_counts_as_its_mean() {
    let mut square = painted(&encoded(&quarters(), ImageFormat::Png), FLAT);
    square.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    let scene = square.scene();
    assert_near(material(&scene, 0).reflectance, [0.25, 0.125, 0.4]);
    assert!(material(&scene, 0).painting.is_none());
}

#[test]
fn a_jpeg_is_read_too_and_emission_is_even() {
    let grey = RgbImage::from_pixel(16, 16, Rgb([188, 188, 188]));
    let mut square = painted(&encoded(&grey, ImageFormat::Jpeg), FLAT);
    square.json["materials"][0]["emissiveFactor"] = json!([1, 0.5, 0]);
    square.json["materials"][0]["emissiveTexture"] = json!({"index": 0});
    let scene = square.scene();
    assert_near(material(&scene, 0).reflectance, [0.2515, 0.2515, 0.4023]);
    assert_near(material(&scene, 0).radiance, [0.503, 0.2515, 0.0]);
    assert_warned(&scene, &["even", "'paint'"]);
}

#[test]
fn emission_of_an_mtl_with_a_picture_is_even_and_never_silently_dark() {
    let obj = b"mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n";
    let picture = encoded(&quarters(), ImageFormat::Png);
    for (mtl, expected, words) in [
        ("Kd 0.5\nKe 4 8 8\nmap_Ke glow.png", [2.0, 2.0, 4.0], "is even"),
        ("Kd 0.5\nmap_Ke -clamp on glow.png # bright", [0.5, 0.25, 0.5], "is even"),
        ("Kd 0.5\nKe 0 0 0\nmap_Ke glow.png", [0.0; 3], "nothing is emitted"),
        ("Kd 0.5\nKe 4 8 8\nmap_Ke none.png", [4.0, 8.0, 8.0], "1 texture(s) missing"),
        ("Kd 0.5\nmap_Ke none.png", [0.0; 3], "1 texture(s) missing"),
    ] {
        let mtl = format!("newmtl a\n{mtl}\n");
        let files = Files::new(&[("a.obj", obj), ("a.mtl", mtl.as_bytes()), ("glow.png", &picture)]);
        let scene = files.load().unwrap_or_else(|error| panic!("{error}"));
        assert_near(scene.materials[0].radiance, expected);
        assert_near(scene.materials[0].reflectance, [0.5; 3]);
        assert_warned(&scene, &["a.mtl: ", words]);
        assert_eq!(scene.files.contains(&files.path("glow.png")), mtl.contains("glow.png"), "{mtl}");
    }
}

#[test]
fn pictures_that_cannot_be_read_are_a_warning() {
    let whole = encoded(&RgbImage::from_fn(64, 64, |x, y| Rgb([x as u8, y as u8, 9])), ImageFormat::Png);
    // 100 000 × 100 000 pixels, says the header; its checksum is right.
    let mut giant = whole.clone();
    giant[16..24].copy_from_slice(&[0, 1, 0x86, 0xa0, 0, 1, 0x86, 0xa0]);
    let checksum = crc32fast::hash(&giant[12..29]).to_be_bytes();
    giant[29..33].copy_from_slice(&checksum);
    let cut = &whole[..whole.len() / 2];
    let jpeg = encoded(&RgbImage::from_fn(64, 64, |x, y| Rgb([x as u8, y as u8, 9])), ImageFormat::Jpeg);
    for (picture, why) in [
        (&giant[..], "100000 × 100000 pixels, and at most 67108864"),
        (cut, "cannot be decoded"),
        (b"GIF89a", "neither PNG nor JPEG"),
        (b"\x89PNG\r\n\x1a\n", "cannot be decoded"),
        (b"\xff\xd8\xff\xe0", "cannot be decoded"),
        // Most of its light is there.
        (&jpeg[..jpeg.len() - 40], "is cut off"),
    ] {
        let mut square = painted(picture, FLAT);
        let scene = square.scene();
        assert_warned(&scene, &["texture: ", why]);
        assert_warned(&scene, &["textures are missing", "'paint'"]);
        assert_near(material(&scene, 0).reflectance, [0.5, 0.5, 0.8]);
        // White would be as bright as nothing is.
        square.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, 1]);
        assert_near(material(&square.scene(), 0).reflectance, [0.5; 3]);
    }
    let mut square = painted(&whole, FLAT);
    for (uri, why) in
        [("none.png", "not found"), ("/etc/hostname", "relative path"), ("data:;base64,§", "base64")]
    {
        square.json["images"] = json!([{"uri": uri}]);
        assert_warned(&square.scene(), &["texture: ", why]);
    }
    square.json["images"] = json!([{"bufferView": 0}]);
    square.json["textures"] = json!([{"extensions": {"EXT_texture_webp": {"source": 0}}}]);
    assert_warned(&square.scene(), &["texture: ", "no picture that is read"]);
}

#[test]
fn a_picture_of_an_mtl_without_places_counts_as_its_mean() {
    let obj = b"mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n";
    let picture = encoded(&quarters(), ImageFormat::Png);
    for (mtl, expected) in [
        ("Kd 0.5 0.5 0.8\nmap_Kd my picture.png", [0.25, 0.125, 0.4]),
        ("map_Kd -s 1 1 1 -clamp on my picture.png\nKd 0.5 0.5 0.8", [0.25, 0.125, 0.4]),
        ("map_Kd C:\\textures\\my picture.png", [0.5, 0.25, 0.5]),
        ("map_Kd my picture.png # of oak", [0.5, 0.25, 0.5]),
        ("Kd 0.5 0.5 0.8\nmap_Kd none.png", [0.5, 0.5, 0.8]),
        ("map_Kd a.mtl", [0.5; 3]),
        ("Kd 0.1 0.2 0.3\nmap_Kd my picture.png.txt", [0.1, 0.2, 0.3]),
        ("map_Kd", [0.5; 3]),
    ] {
        let mtl = format!("newmtl a\n{mtl}\n");
        let files = Files::new(&[
            ("a.obj", obj),
            ("a.mtl", mtl.as_bytes()),
            ("my picture.png", &picture),
            ("my picture.png.txt", b"x"),
        ]);
        let scene = files.load().unwrap_or_else(|error| panic!("{error}"));
        assert_near(scene.materials[0].reflectance, expected);
        // What cannot be read is not written over either.
        for name in ["my picture.png", "my picture.png.txt"] {
            let is_named =
                mtl.trim_end().lines().any(|line| line.ends_with(name) || line.contains(&format!("{name} ")));
            assert_eq!(scene.files.contains(&files.path(name)), is_named, "{mtl}");
        }
        if mtl.contains("none.png") {
            assert_warned(&scene, &["1 texture(s) missing", "'none.png' (file not found)"]);
        }
    }
}

#[test]
fn an_obj_shows_the_picture_where_its_corners_are_on_it() {
    let picture = encoded(&quarters(), ImageFormat::Png);
    // u along x; v upwards on the picture, along z.
    let start = "mtllib a.mtl\nv 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nusemtl a # floor\n";
    let load = |rest: &str, options: &str| {
        let obj = format!("{start}{rest}");
        let mtl = format!("newmtl a\nKd 0.5 0.5 0.8\nmap_Kd {options}my picture.png\n");
        let files = [("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes()), ("my picture.png", &picture[..])];
        Files::new(&files).load().unwrap_or_else(|error| panic!("{error}"))
    };
    let at = |scene: &Scene, x: f64, z: f64| material(scene, 0).reflectance_at(DVec3::new(x, 0.0, z));
    let places = "vt 0 0\nvt 0 1 0\nvt 1 1\nvt 1\n";
    for faces in ["f 1/1 2/2 3/3 4/4\n", "f -4/-4/1 -3/-3/1 -2/-2/1 -1/-1/1\n"] {
        for text in [format!("{places}{faces}"), format!("l 1/1 2/2\n{places}vn 0 1 0\n{faces}f 1 2\n")] {
            let scene = load(&text, "");
            assert!(scene.warnings.iter().all(|warning| warning.contains("skipped")), "{:?}", scene.warnings);
            assert_eq!((scene.materials.len(), scene.triangles.len()), (1, 2), "{text}");
            assert_near(at(&scene, 0.25, 0.75), [0.5, 0.5, 0.8]);
            assert_near(at(&scene, 0.75, 0.75), [0.0; 3]);
            assert_near(at(&scene, 0.25, 0.25), [0.5, 0.0, 0.0]);
            assert_near(at(&scene, 0.75, 0.25), [0.0, 0.0, 0.8]);
        }
    }
    let quad = format!("{places}f 1/1 2/2 3/3 4/4\n");
    // Half the picture from its middle on, to the right: black where u is 1 and beyond.
    let scene = load(&quad, "-clamp on -s 0.5 1 -o 0.5 0 0 ");
    assert_near(at(&scene, 0.95, 0.75), [0.0; 3]);
    assert_near(at(&load(&quad, "-s 2 1 1 "), 0.625, 0.75), [0.5, 0.5, 0.8]);

    // A corner without a place that there is: the triangles at it have the mean.
    for bad in [
        "f 1/1 2/2 3/3 4\n",
        "f 1/1 2/2 3/3 4/9\n",
        "f 1/1 2/2 3/3 4//1\n",
        "f 1/1 2/2 3/3 4/-9\n",
        "f 1/1 2/2 3/3 4/0\n",
    ] {
        let scene = load(&format!("{places}{bad}"), "");
        assert_eq!(scene.materials.len(), 2, "{bad}");
        assert!(material(&scene, 0).painting.is_some() && material(&scene, 1).painting.is_none(), "{bad}");
        assert_near(material(&scene, 1).reflectance, [0.25, 0.125, 0.4]);
    }
    let odd = load("vt x\nvt nan 1\nvt 1e999 1\nvt\nf 1/1 2/2 3/3 4/4\n", "");
    assert_eq!((odd.materials.len(), odd.triangles.len()), (1, 2));
    assert!(material(&odd, 0).painting.is_none());
}

#[test]
fn a_rendered_floor_shows_its_texels() {
    // Black and white halves: x up to one half is white.
    let halves = RgbImage::from_fn(2, 1, |x, _| Rgb([255 * (1 - x as u8); 3]));
    let square = painted(&encoded(&halves, ImageFormat::Png), FLAT);
    let toml = "mesh = 'a.glb'\n[[camera]]\nname = 'above'\neye = [0.5, 2, 0.5]\ntarget = [0.5, 0, 0.5]\nup = [0, 0, -1]\n\
                vfov_deg = 26\nwidth = 32\nheight = 32\n[[quad]]\nname = 'lamp'\nreflectance = [0, 0, 0]\nradiance = [9, 9, 9]\n\
                corners = [[-3, 5, -3], [4, 5, -3], [4, 5, 4], [-3, 5, 4]]\n";
    let files = Files::new(&[("s.toml", toml.as_bytes()), ("a.glb", &square.glb())]);
    assert_eq!(corners(&files.load().expect("a scene")).len(), 4);
    for mode in ["--reconstruct", "--final-gather"] {
        let output = Command::new(env!("CARGO_BIN_EXE_lightshaft"))
            .args([
                "render",
                "s.toml",
                "-o",
                "a.exr",
                "--quality",
                "draft",
                "-q",
                "--tracer",
                "fallback",
                mode,
            ])
            .current_dir(files.path(""))
            .output()
            .expect("a run");
        assert!(output.status.success(), "{mode}: {}", String::from_utf8_lossy(&output.stderr));
        let picture = image::open(files.path("a.exr")).expect("a picture").into_rgb32f();
        let at = |x: u32| picture.get_pixel(x, 16).0;
        let (white, black) = (at(7), at(24));
        // In the middle of the texels, under a wide lamp: nearly all of the factor, and nearly nothing.
        assert!(white[0] > 1.0 && (white[2] / white[0] - 1.6).abs() < 0.01, "{mode}: {white:?}");
        assert!(black[0] < 0.05 * white[0], "{mode}: {black:?} beside {white:?}");
    }
}
