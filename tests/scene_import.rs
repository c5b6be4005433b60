//! Scenes read from files: what is accepted, what is repaired and said, what is refused and with which
//! words. Files are made in fresh folders; the scenes of this repository are checked as they are.

use std::path::{Path, PathBuf};

use glam::DVec3;
use lightshaft::progress::Silent;
use lightshaft::scene::{LoadOptions, Scene, SceneError, SceneErrorKind, load};
use proptest::prelude::*;

/// A folder with some files; the first one is the scene.
struct Files(tempfile::TempDir, PathBuf);

impl Files {
    fn new(files: &[(&str, &[u8])]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, content) in files {
            std::fs::write(folder.path().join(name), content).unwrap();
        }
        let scene = folder.path().join(files[0].0);
        Self(folder, scene)
    }

    fn load(&self) -> Result<Scene, SceneError> {
        load(&self.1, &LoadOptions::default(), &Silent)
    }

    /// Without asking for an emitter.
    fn load_dark(&self) -> Result<Scene, SceneError> {
        load(&self.1, &LoadOptions { require_emitter: false, ..LoadOptions::default() }, &Silent)
    }

    /// The error's kind and its message without the folder.
    fn fault(&self) -> (SceneErrorKind, String) {
        let error = self.load().expect_err("the scene must be refused");
        let message = error.to_string();
        assert!(!message.contains('\n'), "more than one line: {message}");
        let folder = format!("{}/", self.0.path().display());
        (error.kind(), message.replace(&folder, ""))
    }
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\n";

fn dark(obj: &str) -> Scene {
    Files::new(&[("a.obj", obj.as_bytes())]).load_dark().unwrap()
}

#[track_caller]
fn refused(files: &[(&str, &[u8])], kind: SceneErrorKind, start: &str) {
    let (found, message) = Files::new(files).fault();
    assert_eq!(found, kind, "{message}");
    assert!(message.starts_with(start), "expected '{start}…', found '{message}'");
    assert!(message.contains("; "), "no advice in '{message}'");
}

#[test]
fn every_way_to_write_a_face_gives_the_same_polygon() {
    for face in [
        "f 1 2 3 4",
        "f -4 -3 -2 -1",
        "f 1/1 2/1 3/1 4/1",
        "f 1//1 2//1 3//1 4//1",
        "f 1/1/1 2/1/1 3/1/1 4/1/1",
        "f 1/9/9 2/9 3 4//7",
        "f\t1  2 3 4   # comment",
        "f 1 2 \\\n 3 4",
        "f +1 +2 +3 +4",
        "g a b\ns 1\no c\nf 1 2 3 4\nl 1 2 3\np 1",
    ] {
        for ending in ["\n", "\r\n", "\r"] {
            let text = format!("{SQUARE}vt 0 0\nvn 0 1 0\n{face}").replace('\n', ending);
            let scene = dark(&text);
            assert_eq!(scene.triangles.len(), 2, "{face:?} with {ending:?}");
            assert_eq!(scene.patch_count, 1);
            assert_eq!(scene.positions.len(), 4);
        }
    }
}

#[test]
fn every_way_to_write_a_number_is_read() {
    let scene = dark("v 1e-5 +1. .5\nv -.5 1E+2 2.e1 1 0 0\nv 3 3 3 0.5\nf 1 2 3\n");
    assert_eq!(
        scene.positions,
        [DVec3::new(1e-5, 1.0, 0.5), DVec3::new(-0.5, 100.0, 20.0), DVec3::splat(6.0)]
    );
}

#[test]
fn faces_may_stand_before_their_vertices() {
    assert_eq!(dark(&format!("g a\nf 1 2 3 4\ng b\n{SQUARE}")).triangles.len(), 2);
}

#[test]
fn a_quad_keeps_its_front_and_its_triangles_together() {
    let scene = dark(&format!("{SQUARE}f 4 3 2 1\nf 1 2 3\n"));
    // The third triangle lies on the first two's square, but is none of them.
    let patches: Vec<u32> = scene.triangles.iter().map(|t| t.patch).collect();
    assert_eq!(patches[..2], [0, 0]);
    for triangle in &scene.triangles[..2] {
        let [a, b, c] = triangle.vertices.map(|vertex| scene.positions[vertex as usize]);
        assert!((b - a).cross(c - a).y > 0.0);
    }
}

#[test]
fn concave_polygons_cover_their_area_and_no_more() {
    let scene = dark("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n");
    let area: f64 = scene
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.vertices.map(|vertex| scene.positions[vertex as usize]);
            0.5 * (b - a).cross(c - a).z
        })
        .sum();
    assert!((area - 3.0).abs() < 1e-12, "the L has area 3, not {area}");
    assert_eq!((scene.triangles.len(), scene.patch_count), (4, 1));
}

#[test]
fn points_lines_flat_triangles_and_duplicates_are_dropped_and_counted() {
    let scene = dark(&format!(
        "{SQUARE}f 1 2 3\nf 2 3 1\nf 3 2 1\nf 1 1 2\nf 1\nf 1 2\nf\np 1 2\nl 1 2 3\n\
         v 0.5 0 0.5\nf 1 5 3\nv 0 0 0\nf 6 2 3\n"
    ));
    assert_eq!(scene.triangles.len(), 1);
    assert_eq!(scene.counts.triangles_initial, 6);
    assert_eq!(scene.counts.dropped_duplicate, 3);
    assert_eq!(scene.counts.dropped_degenerate, 2);
    assert_eq!(scene.counts.skipped_faces, 5);
    assert_eq!(scene.patch_count, 1);
}

#[test]
fn of_duplicates_the_emitter_is_kept() {
    let mtl = b"newmtl grey\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0 0 0\nKe 3 2 1\n";
    for order in [["grey", "lamp"], ["lamp", "grey"]] {
        let [first, second] = order;
        let obj = format!("mtllib a.mtl\n{SQUARE}usemtl {first}\nf 1 2 3\nusemtl {second}\nf 3 2 1\n");
        let scene = Files::new(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl)]).load().unwrap();
        assert_eq!(scene.triangles.len(), 1);
        assert_eq!(scene.materials.len(), 1);
        assert_eq!(scene.materials[0].radiance, [3.0, 2.0, 1.0]);
    }
}

#[test]
fn materials_are_found_by_name_wherever_the_library_stands() {
    let obj = format!(
        "usemtl  dark wood\n{SQUARE}f 1 2 3\nmtllib first lib.mtl\nmtllib second.mtl third\\ lib.mtl\n\
         usemtl\tlamp # on\nf 1 3 4\nusemtl Material #3\nv 5 5 5\nf 1 2 5\n"
    );
    let files = Files::new(&[
        ("a.obj", obj.as_bytes()),
        ("first lib.mtl", b"newmtl dark wood\r\nKd .1 .2 .3 # brown\r\nd -halo 1\nillum 99999\n"),
        ("second.mtl", b"newmtl\tlamp\nKe 7\nmap_Kd a b.png\n"),
        ("third lib.mtl", b"newmtl Material #3\n\tKd 0.25\n"),
    ]);
    let scene = files.load().unwrap();
    let names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["dark wood", "lamp", "Material #3"]);
    assert_eq!(scene.materials[0].reflectance, [0.1, 0.2, 0.3]);
    assert_eq!(scene.materials[1].radiance, [7.0; 3]);
    assert_eq!(scene.materials[1].reflectance, [0.5; 3], "no Kd: grey");
    assert_eq!(scene.materials[2].reflectance, [0.25; 3]);
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
    assert!(scene.warnings[0].contains("1 texture(s) missing") && scene.warnings[0].contains("'a b.png'"));
    assert!(scene.warnings[1].contains("without Kd") && scene.warnings[1].contains("'lamp'"));
}

#[test]
fn names_have_no_control_characters() {
    let quad = r#"[[quad]]
name = "lamp\nsegment\u001b[31m"
corners = [[0, 2, 0], [1, 2, 0], [1, 2, 1], [0, 2, 1]]
radiance = [1, 1, 1]

[[camera]]
name = "door\nray 0 0\u009b"
eye = [0, 1, 4]
target = [0, 1, 0]"#;
    let description = format!("mesh = \"a.obj\"\n{quad}\n");
    let mesh = format!("{SQUARE}usemtl red\u{1b}[31m\nf 1 2 3 4\n");
    let scene = Files::new(&[("a.toml", description.as_bytes()), ("a.obj", mesh.as_bytes())]).load().unwrap();
    let names: Vec<&str> = scene.materials.iter().map(|material| material.name.as_str()).collect();
    assert!(names.contains(&"lamp segment [31m") && names.contains(&"red [31m"), "{names:?}");
    assert_eq!(
        (scene.cameras[0].name.as_str(), scene.rectangles[0].name.as_str()),
        ("door ray 0 0 ", "lamp segment [31m")
    );
}

#[test]
fn missing_libraries_and_materials_are_grey_with_a_warning() {
    let obj = format!("mtllib none.mtl\n{SQUARE}f 1 2 3\nusemtl ghost\nf 1 3 4\nbogus 1 2\n");
    let scene = dark(&obj);
    assert!(scene.materials.iter().all(|m| m.reflectance == [0.5; 3] && !m.is_emitter()));
    let said = |words: &str| scene.warnings.iter().filter(|w| w.contains(words)).count();
    assert_eq!(said("a.obj:1: material library 'none.mtl' not found"), 1, "{:?}", scene.warnings);
    assert_eq!(said("in no MTL file get grey reflectance 0.5: 'ghost'"), 1);
    assert_eq!(said("faces without a material"), 1);
    assert_eq!(said("a.obj:9: 1 line(s) ignored that are not OBJ statements, first 'bogus'"), 1);
    // Without an emitter the missing library is the likely reason.
    let (kind, message) = Files::new(&[("a.obj", obj.as_bytes())]).fault();
    assert_eq!(kind, SceneErrorKind::Invalid);
    assert!(message.contains("nothing emits light (material library not found: 'none.mtl')"), "{message}");
}

#[test]
fn bright_materials_are_clamped_with_one_warning() {
    let mut mtl = String::from("newmtl lamp\nKd 0.9 0.9 0.9\nKe 1 1 1\n");
    let mut obj = String::from("mtllib a.mtl\nusemtl lamp\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for i in 0..12 {
        mtl += &format!("newmtl m{i}\nKd 0.5 {} 0.5\n", 0.99 + f64::from(i));
        obj += &format!("usemtl m{i}\nv 0 0 {0}\nv 1 0 {0}\nv 0 1 {0}\nf -3 -2 -1\n", i + 1);
    }
    let scene = Files::new(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]).load().unwrap();
    assert_eq!(scene.materials[1].reflectance, [0.5, 0.98, 0.5]);
    assert_eq!(scene.warnings.len(), 1);
    assert!(scene.warnings[0].ends_with("'m7' and 4 more"), "{}", scene.warnings[0]);
}

#[test]
fn a_description_says_everything() {
    let toml = br#"
mesh = ["A.OBJ", "b.obj"]
meters_per_unit = 0.01
[[camera]]
name = "one"
eye = [0, 1, 3.9]
target = [0, 1, 0]
up = [0, 1, 0]
vfov_deg = 39.3
width = 512
height = 256
[[camera]]
eye = [0, 0, 1]
target = [0, 0, 0]
[[quad]]
name = "lamp"
corners = [[0,2,0],[1,2,0],[1,2,1],[0,2,1]]
reflectance = [0, 0, 0]
radiance = [12, 12, 12]
[material."default"]
reflectance = [0.5, 0.4, 0.3]
[material.glow]
radiance = [0, 0, 0]
"#;
    let files = Files::new(&[
        ("Scene.TOML", toml),
        ("A.OBJ", b"v 0 0 0\nv 1 0 0\nv 1 0 1\nf 1 2 3\n"),
        ("b.obj", b"mtllib b.mtl\nusemtl glow\nv 0 1 0\nv 1 1 0\nv 1 1 1\nf 1 2 3\n"),
        ("b.mtl", b"newmtl glow\nKd 0.1 0.1 0.1\nKe 5 5 5\nnewmtl spare\n"),
    ]);
    let scene = files.load().unwrap();
    assert_eq!(scene.meters_per_unit, 0.01);
    assert_eq!(scene.warnings, Vec::<String>::new());
    assert_eq!(scene.name, files.0.path().file_name().unwrap().to_string_lossy());
    let names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["default", "glow", "lamp"]);
    assert_eq!(scene.materials[0].reflectance, [0.5, 0.4, 0.3]);
    assert!(!scene.materials[1].is_emitter() && scene.materials[1].reflectance == [0.1; 3]);
    let [one, two] = scene.cameras.as_slice() else { panic!("two cameras") };
    assert_eq!((one.name.as_str(), one.vfov_deg, one.width, one.height), ("one", 39.3, 512, 256));
    assert_eq!((two.name.as_str(), two.up, two.vfov_deg, two.width), ("camera2", DVec3::Y, 45.0, 640));
    // Corners counter-clockwise from below: the lamp shines down.
    let lamp = scene.triangles.iter().find(|t| t.material == 2).unwrap();
    let [a, b, c] = lamp.vertices.map(|vertex| scene.positions[vertex as usize]);
    assert!((b - a).cross(c - a).y < 0.0);
}

const CAMERA: &str = "[[camera]]\nname = \"c\"\neye = [0, 0, 3]\ntarget = [0, 0, 0]\n";
const LAMP: &str = "[[quad]]\ncorners = [[0,2,0],[1,2,0],[1,2,1],[0,2,1]]\nradiance = [1, 1, 1]\n";

#[test]
fn a_faulty_description_names_its_line() {
    use SceneErrorKind::{Invalid, Io, Parse};
    let cases: &[(&str, SceneErrorKind, &str)] = &[
        ("", Invalid, "s.toml: neither mesh nor [[quad]]"),
        ("\n\nmesh = \"gone.obj\"", Io, "s.toml:3: mesh file 'gone.obj' not found"),
        ("mesh = [\n\"a.obj\",\n\"gone.obj\"]", Io, "s.toml:3: mesh file 'gone.obj'"),
        ("mesh = \"a.stl\"", Invalid, "s.toml:1: mesh 'a.stl' is no .obj, .glb, .gltf or .ply file"),
        ("mesh = 3", Parse, "s.toml:1: invalid type: integer `3`, expected the path of a mesh"),
        ("\nmash = \"a.obj\"", Parse, "s.toml:2: unknown field `mash`"),
        ("mesh = \"a.obj\"\nmeters_per_unit = 0", Invalid, "s.toml:2: meters_per_unit is 0"),
        ("meters_per_unit = nan", Invalid, "s.toml:1: meters_per_unit is NaN"),
        ("x = = 3", Parse, "s.toml:1: "),
        ("[[camera]]\neye = [0, 0]", Parse, "s.toml:2: invalid length 2"),
        (
            "[camera]\neye = [0, 0, 0]",
            Parse,
            "s.toml:1: invalid type: map, expected a sequence; write [[camera]]",
        ),
        ("[[camera]]\neye = [0, 0, 0]", Parse, "s.toml:1: missing field `target`"),
        ("[[camera]]\neye = [1, 2, 3]\ntarget = [1, 2, 3]", Invalid, "s.toml:3: eye and target are the same"),
        ("[[camera]]\neye = [inf, 2, 3]\ntarget = [1, 2, 3]", Invalid, "s.toml:2: eye is not finite"),
        ("CAMERAup = [0, 0, 0]", Invalid, "s.toml:5: up is zero"),
        ("CAMERAup = [0, 0, -7]", Invalid, "s.toml:5: up is parallel"),
        ("CAMERAvfov_deg = 180", Invalid, "s.toml:5: vfov_deg is 180"),
        ("CAMERAvfov_deg = nan", Invalid, "s.toml:5: vfov_deg is NaN"),
        ("CAMERAwidth = 0", Invalid, "s.toml:5: width is 0"),
        ("CAMERAheight = 65536", Invalid, "s.toml:5: height is 65536"),
        ("CAMERAwidth = 1.5", Parse, "s.toml:5: invalid type: floating point `1.5`"),
        ("CAMERAfov = 1", Parse, "s.toml:5: unknown field `fov`"),
        ("CAMERACAMERA", Invalid, "s.toml:6: another camera is called 'c' too"),
        ("LAMPreflectance = [0, -1, 0]", Invalid, "s.toml:4: reflectance [0.0, -1.0, 0.0] is negative"),
        (
            "[[quad]]\nradiance = [nan, 0, 0]\ncorners = [[0,2,0],[1,2,0],[1,2,1],[0,2,1]]",
            Invalid,
            "s.toml:2: radiance",
        ),
        (
            "[[quad]]\ncorners = [[0,0,0],[1,0,0],[1,1,0]]",
            Invalid,
            "s.toml:2: a quad has 4 corners and this one has 3",
        ),
        (
            "[[quad]]\ncorners = [[0,0,0],[1,0,0],[2,0,0],[3,0,0]]",
            Invalid,
            "s.toml:2: the corners lie on one line",
        ),
        (
            "[[quad]]\ncorners = [[0,0,0],[1,0,0],[0,1,0],[1,1,0]]",
            Invalid,
            "s.toml:2: the outline crosses itself",
        ),
        (
            "[[quad]]\ncorners = [[0,0,0],[1,0,0],[1,1,0.1],[0,1,0]]",
            Invalid,
            "s.toml:2: the corners do not lie in one plane",
        ),
        (
            "[[quad]]\ncorners = [[0,0,0],[nan,0,0],[1,1,0],[0,1,0]]",
            Invalid,
            "s.toml:2: a corner is not finite",
        ),
        (
            "mesh = \"a.obj\"\n[material.wod]\nradiance=[1,1,1]",
            Invalid,
            "s.toml:2: no material 'wod' in the mesh; did you mean 'wood'",
        ),
        ("LAMP[material.quad1]\nradiance=[1,1,1]", Invalid, "s.toml:4: 'quad1' is a quad"),
        (
            "LAMP[material.x]\nradiance=[1,1,1]",
            Invalid,
            "s.toml:4: no material 'x' in the mesh; the scene has no mesh materials",
        ),
        ("mesh = \"a.obj\"\n", Invalid, "s.toml: nothing emits light; give"),
        ("mesh = \"bad.obj\"\n", Parse, "bad.obj:4: vertex index out of range"),
        ("mesh = \"folder.obj\"\n", Io, "s.toml:1: mesh "),
    ];
    for (text, kind, start) in cases {
        let files = Files::new(&[
            ("s.toml", text.replace("CAMERA", CAMERA).replace("LAMP", LAMP).as_bytes()),
            ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl wood\nf 1 2 3\n"),
            ("bad.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
        ]);
        std::fs::create_dir(files.0.path().join("folder.obj")).unwrap();
        let (found, message) = files.fault();
        assert_eq!(found, *kind, "{message}");
        assert!(message.starts_with(start), "expected '{start}…', found '{message}'");
    }
    refused(&[("s.toml", b"mesh = \"\xff\"")], Parse, "s.toml:1: the text is not UTF-8");
    refused(&[("s.toml", b"\xff\xfem\0")], Parse, "s.toml:1: the file is UTF-16");
}

#[test]
fn a_faulty_mesh_names_its_line() {
    use SceneErrorKind::{Invalid, Parse};
    let cases: &[(&[u8], SceneErrorKind, &str)] = &[
        (b"", Invalid, "a.obj: no triangles"),
        (b"v 0 0 0\np 1\n", Invalid, "a.obj: no triangles, only 1 point(s)"),
        (b"v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n", Invalid, "a.obj: no triangles left: all have zero area"),
        (b"v 0 0 0\nv 1 0\n", Parse, "a.obj:2: a vertex needs 3 coordinates and has 2"),
        (b"v 0 0 0\nv 1 0,5 0\n", Parse, "a.obj:2: '0,5' is not a number; write a decimal point"),
        (b"v 0 0 0\nv 1 1+e2 0\n", Parse, "a.obj:2: '1+e2' is not a number"),
        (b"v 0 0 0\nv 1 nan 0\n", Parse, "a.obj:2: 'nan' is not finite"),
        (b"v 0 0 0\nv 1 1e999 0\n", Parse, "a.obj:2: '1e999' is not finite"),
        (b"v 0 0 1e200\n", Parse, "a.obj:1: coordinate 1e200 is beyond"),
        (b"v 0 0 1 1e-300\n", Parse, "a.obj:1: coordinate 1e0 is beyond"),
        (b"v 0 0 1 0\n", Parse, "a.obj:1: the vertex weight w is 0"),
        (b"v 0 0 1\n\nf 1 0 1\n", Parse, "a.obj:3: vertex index 0 in '0'"),
        (b"v 0 0 1\nf 1 2 1\n", Parse, "a.obj:2: vertex index out of range in '2': the file has 1"),
        (b"f -1 -1 -1\nv 0 0 0\n", Parse, "a.obj:1: vertex index out of range in '-1': only 0"),
        (b"v 0 0 1\nf 1 99999999999999999999 1\n", Parse, "a.obj:2: vertex index out of range"),
        (b"v 0 0 1\nf 1 1.0 1\n", Parse, "a.obj:2: '1.0' is not a face corner"),
        (b"v 0 0 1\nf 1 1/1/1/1 1\n", Parse, "a.obj:2: '1/1/1/1' is not a face corner"),
        (b"v 0 0 1\nf 1 /1 1\n", Parse, "a.obj:2: '/1' is not a face corner"),
        (b"\xfe\xff\0v", Parse, "a.obj:1: the file is UTF-16"),
        (b"v 0 0 0\nv \0 1", Parse, "a.obj:2: the line holds NUL bytes"),
    ];
    for (text, kind, start) in cases {
        refused(&[("a.obj", text)], *kind, start);
    }
    let endless = format!("{SQUARE}f{}\n", " 1".repeat(70_000));
    refused(&[("a.obj", endless.as_bytes())], Parse, "a.obj:5: the face has more than 65535 corners");
}

#[test]
fn a_faulty_library_names_its_line() {
    use SceneErrorKind::{Invalid, Parse};
    let obj = format!("mtllib a.mtl\nusemtl m\n{SQUARE}f 1 2 3\n");
    let cases: &[(&[u8], SceneErrorKind, &str)] = &[
        (b"newmtl m\nKd 0.5 0.5\n", Parse, "a.mtl:2: Kd: a colour needs 3 numbers and has 2"),
        (b"newmtl m\nKd\n", Parse, "a.mtl:2: Kd: a colour needs 3 numbers and has 0"),
        (b"newmtl m\nKe 1 x 1\n", Parse, "a.mtl:2: Ke: 'x' is not a number"),
        (b"newmtl m\nKe 1 inf 1\n", Parse, "a.mtl:2: Ke: 'inf' is not finite"),
        (b"newmtl m\nKe 1 1e200 1\n", Parse, "a.mtl:2: Ke: the number is too large"),
        (b"newmtl m\nKe 1 1e38 1\n", Parse, "a.mtl:2: Ke: the number is too large"),
        (b"newmtl m\nKd 1 -1 1\n", Invalid, "a.mtl:2: Kd is negative"),
        (b"newmtl m\nKd spectral a.rfl\n", Parse, "a.mtl:2: Kd: 'spectral' colours are not supported"),
        (b"new\0", Parse, "a.mtl:1: the line holds NUL bytes"),
    ];
    for (text, kind, start) in cases {
        refused(&[("a.obj", obj.as_bytes()), ("a.mtl", text)], *kind, start);
    }
}

#[test]
fn a_path_that_is_no_scene_says_what_it_is() {
    use SceneErrorKind::{Invalid, Io};
    refused(&[("a.mtl", b"")], Invalid, "a.mtl: is a material library; give the .obj");
    refused(&[("a.txt", b"")], Invalid, "a.txt: files of type '.txt' are not read; give");
    refused(&[("scene", b"")], Invalid, "scene: has no extension; give");
    let folder = tempfile::tempdir().unwrap();
    for name in ["gone.obj", "gone.toml", "gone.txt", "gone"] {
        let error = load(&folder.path().join(name), &LoadOptions::default(), &Silent).unwrap_err();
        assert_eq!(error.kind(), Io, "{error}");
        assert!(error.to_string().ends_with(&format!("{name}: file not found; check the path")), "{error}");
        assert_eq!(error.location(), (folder.path().join(name).as_path(), None));
    }
    let error = load(folder.path(), &LoadOptions::default(), &Silent).unwrap_err();
    assert_eq!(error.kind(), Io);
    assert!(error.to_string().contains("is a folder; give a file in it"), "{error}");
}

#[test]
fn odd_bytes_in_comments_and_names_do_not_stop_the_import() {
    let obj =
        b"# caf\xe9\nmtllib a.mtl\no \xff\xfe\nusemtl caf\xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 # \xe9\n";
    let mtl = b"# \xe9\nnewmtl caf\xe9\nKe 1 1 1\nKd 0 0 0\n";
    let scene = Files::new(&[("a.obj", obj), ("a.mtl", mtl)]).load().unwrap();
    assert_eq!(scene.materials[0].name, "caf\u{fffd}");
    assert_eq!(scene.warnings, Vec::<String>::new());
}

#[test]
fn the_scenes_of_this_repository_are_what_their_readmes_say() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for (name, triangles, is_closed) in
        [("cornell-box", 32, false), ("paper-1", 120, true), ("paper-2", 680, true), ("paper-3", 24, false)]
    {
        let scene = load(&scenes.join(name).join("scene.toml"), &LoadOptions::default(), &Silent).unwrap();
        assert_eq!(scene.name, name);
        assert_eq!(scene.warnings, Vec::<String>::new());
        assert_eq!(scene.counts.triangles_initial, triangles, "{name}");
        assert_eq!(scene.triangles.len() as u64, triangles, "{name} has triangles that are dropped");
        let readme = std::fs::read_to_string(scenes.join(name).join("README.md")).unwrap();
        assert!(readme.contains(&format!("{triangles} triangles")), "{name}");
        assert!(readme.contains(if is_closed { "**Closed**" } else { "**Open**" }), "{name}");
        for triangle in &scene.triangles {
            let [a, b, c] = triangle.vertices.map(|vertex| scene.positions[vertex as usize]);
            if scene.materials[triangle.material as usize].is_emitter() {
                assert!((b - a).cross(c - a).normalize().y < -0.999, "{name}: a lamp does not shine down");
            }
        }
    }
}

/// Breaks a good file in one of many ways.
fn mutated(good: &[u8], edits: &[(u16, u8, u8)]) -> Vec<u8> {
    const WORDS: [&[u8]; 16] = [
        b"-1",
        b"0",
        b"nan",
        b"1e400",
        b"99999999999",
        b"\n",
        b"\r",
        b"\\\n",
        b" ",
        b"/",
        b"#",
        b"\0",
        b"f ",
        b"usemtl ",
        b"[[",
        b"\xff",
    ];
    let mut bytes = good.to_vec();
    for &(place, kind, value) in edits {
        let at = usize::from(place) % (bytes.len() + 1);
        match kind % 5 {
            0 if at < bytes.len() => bytes[at] = value,
            1 => bytes.insert(at, value),
            2 => {
                let end = (at + usize::from(value) % 12).min(bytes.len());
                bytes.drain(at..end);
            }
            3 => {
                let word = WORDS[usize::from(value) % WORDS.len()];
                bytes.splice(at..at, word.iter().copied());
            }
            _ => {
                let end = (at + usize::from(value)).min(bytes.len());
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
        }
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1500,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(1),
        ..ProptestConfig::default()
    })]

    /// Whatever the files hold, loading ends in a valid scene or in one line; it never panics.
    #[test]
    fn no_mutation_makes_the_import_panic(
        which in 0usize..3,
        edits in proptest::collection::vec((any::<u16>(), any::<u8>(), any::<u8>()), 1..6),
    ) {
        let toml = format!(
            "mesh = \"a.obj\"\nmeters_per_unit = 0.5\n{CAMERA}up = [0, 1, 0]\nvfov_deg = 40\nwidth = 64\n\
             height = 48\n{LAMP}name = \"lamp\"\n[material.\"wood\"]\nreflectance = [0.5, 0.4, 0.3]\n"
        );
        let obj = format!(
            "# box\nmtllib a.mtl\no one\n{SQUARE}v 0.5 1e0 .5 1.0\nvt 0 0\nvn 0 1 0\nusemtl wood\nf 1 2 3 4\n\
             g two\nusemtl glow\nf -5/1/1 -4//1 -1\nf 2 3 5\nv 0 2 0\nv 1 2 0\nv 2 2 1\nv 1 2 3\nv 0.5 2 1\n\
             f 6 7 8 9 10\nl 1 2\n"
        );
        let mtl = "newmtl wood\nKd 0.5 0.4 0.3\nNs 10\nnewmtl glow\nKd 1 1 1\nKe 2 2 2\nmap_Kd x.png\n";
        let mut files = [toml.into_bytes(), obj.into_bytes(), mtl.as_bytes().to_vec()];
        files[which] = mutated(&files[which], &edits);
        let files = Files::new(&[("s.toml", &files[0]), ("a.obj", &files[1]), ("a.mtl", &files[2])]);
        match files.load() {
            Ok(scene) => {
                prop_assert!(!scene.triangles.is_empty() && !scene.cameras.is_empty());
                prop_assert!(scene.positions.iter().all(|p| p.is_finite()));
                let dropped = scene.counts.dropped_degenerate + scene.counts.dropped_duplicate;
                prop_assert_eq!(scene.counts.triangles_initial, scene.triangles.len() as u64 + dropped);
                for triangle in &scene.triangles {
                    prop_assert!(triangle.vertices.iter().all(|&v| (v as usize) < scene.positions.len()));
                    prop_assert!((triangle.material as usize) < scene.materials.len());
                    prop_assert!(triangle.patch < scene.patch_count);
                }
                for material in &scene.materials {
                    prop_assert!(material.reflectance.iter().all(|r| (0.0..=0.98).contains(r)));
                    prop_assert!(material.radiance.iter().all(|l| *l >= 0.0 && l.is_finite()));
                }
            }
            Err(error) => prop_assert!(!error.to_string().contains('\n'), "{}", error),
        }
    }
}
