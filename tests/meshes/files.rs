//! Small files of all kinds, and the scenes that they become.

use std::path::{Path, PathBuf};
use std::process::Command;

use glam::DVec3;
use lightshaft::progress::Silent;
use lightshaft::scene::{LoadOptions, Scene, SceneError, SceneErrorKind, load};
use serde_json::{Value, json};

/// A folder with some files; the first one is the scene.
pub(crate) struct Files(tempfile::TempDir, PathBuf);

impl Files {
    pub(crate) fn new(files: &[(&str, &[u8])]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, content) in files {
            std::fs::write(folder.path().join(name), content).unwrap();
        }
        let scene = folder.path().join(files[0].0);
        Self(folder, scene)
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs the program in the folder, to the end.
    pub(crate) fn run(&self, arguments: &[&str]) {
        let output = Command::new(env!("CARGO_BIN_EXE_lightshaft"))
            .args(arguments)
            .args(["-q", "--tracer", "fallback"])
            .current_dir(self.0.path())
            .output()
            .expect("a run");
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }

    /// Whether something emits or not.
    pub(crate) fn load(&self) -> Result<Scene, SceneError> {
        load_dark(&self.1)
    }

    /// Only if something emits.
    pub(crate) fn load_lit(&self) -> Result<Scene, SceneError> {
        load(&self.1, &LoadOptions::default(), &Silent)
    }
}

pub(crate) fn load_dark(path: &Path) -> Result<Scene, SceneError> {
    load(path, &LoadOptions { require_emitter: false, ..LoadOptions::default() }, &Silent)
}

/// The scene of one file.
#[track_caller]
pub(crate) fn scene(name: &str, content: &[u8]) -> Scene {
    Files::new(&[(name, content)]).load().unwrap_or_else(|error| panic!("{error}"))
}

/// Checks that the first file is refused, in words that begin and go on like that, with advice.
#[track_caller]
pub(crate) fn refused(files: &[(&str, &[u8])], kind: SceneErrorKind, start: &str) {
    let files = Files::new(files);
    let error = files.load().err().unwrap_or_else(|| panic!("must be refused: '{start}…'"));
    let message = error.to_string().replace(&format!("{}/", files.0.path().display()), "");
    assert!(message.starts_with(start), "expected '{start}…', found '{message}'");
    assert_eq!(error.kind(), kind, "{message}");
    assert!(message.contains("; "), "no advice in '{message}'");
    assert!(!message.contains('\n') && message.len() < 400, "{message}");
}

/// Whether one of the warnings has all these words.
#[track_caller]
pub(crate) fn assert_warned(scene: &Scene, words: &[&str]) {
    let is_it = |warning: &&String| words.iter().all(|word| warning.contains(word));
    assert!(scene.warnings.iter().any(|warning| is_it(&warning)), "{words:?} not in {:#?}", scene.warnings);
}

/// Corners of the triangles.
pub(crate) fn corners(scene: &Scene) -> Vec<[DVec3; 3]> {
    scene.triangles.iter().map(|t| t.vertices.map(|vertex| scene.positions[vertex as usize])).collect()
}

/// Of all triangles.
pub(crate) fn area(scene: &Scene) -> f64 {
    corners(scene).iter().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
}

/// A GLB.
pub(crate) fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let length = |bytes: usize| (bytes as u32).to_le_bytes();
    let mut file = b"glTF".to_vec();
    file.extend([2, 0, 0, 0]);
    file.extend(length(28 + text.len() + binary.len()));
    file.extend(length(text.len()));
    file.extend(b"JSON");
    file.extend(text);
    file.extend(length(binary.len()));
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}

pub(crate) fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Four corners of a square of side 1 on the floor, then the indices of two triangles that face up, as bytes; and a mesh of
/// them. Tests change some of it.
pub(crate) struct Square {
    pub(crate) json: Value,
    pub(crate) binary: Vec<u8>,
}

pub(crate) fn square() -> Square {
    let mut binary = floats(&[0., 0., 0., 0., 0., 1., 1., 0., 1., 1., 0., 0.]);
    binary.extend([0, 1, 2, 0, 2, 3]);
    let json = json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": binary.len()}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 6},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4},
            {"bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 6},
        ],
        "materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.25, 0.5, 0.75, 1.0]}}],
        "meshes": [{"name": "Floor", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "nodes": [{"name": "top", "mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    });
    Square { json, binary }
}

impl Square {
    pub(crate) fn glb(&self) -> Vec<u8> {
        glb(&self.json, &self.binary)
    }

    pub(crate) fn scene(&self) -> Scene {
        scene("a.glb", &self.glb())
    }

    /// Adds bytes, and a view of them; the view's number.
    pub(crate) fn add_view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len()});
        self.binary.extend(bytes);
        self.json["buffers"][0]["byteLength"] = json!(self.binary.len());
        push(&mut self.json["bufferViews"], view)
    }

    /// Adds an accessor; its number.
    pub(crate) fn add_accessor(&mut self, accessor: Value) -> usize {
        push(&mut self.json["accessors"], accessor)
    }
}

pub(crate) fn push(list: &mut Value, item: Value) -> usize {
    let list = list.as_array_mut().expect("a list");
    list.push(item);
    list.len() - 1
}
