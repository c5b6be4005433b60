//! Runs the real binary in a fresh folder and keeps what it said.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A corner of a room: floor, wall and a board that throws a shadow from the mesh, a lamp from the
/// description, two cameras.
pub(crate) const SCENE: &str = r#"
mesh = "corner.obj"
meters_per_unit = 1.0

[[camera]]
name = "main"
eye = [0, 1, 4]
target = [0, 0.8, 0]
up = [0, 1, 0]
vfov_deg = 45
width = 64
height = 48

[[camera]]
name = "side"
eye = [3, 1, 3]
target = [0, 0.5, 0]
up = [0, 1, 0]
vfov_deg = 45
width = 40
height = 40

[material.default]
reflectance = [0.5, 0.5, 0.5]

[[quad]]
name = "lamp"
corners = [[-0.3, 2, -0.3], [0.3, 2, -0.3], [0.3, 2, 0.3], [-0.3, 2, 0.3]]
reflectance = [0, 0, 0]
radiance = [12, 11, 10]
"#;

/// The mesh of [`SCENE`].
pub(crate) const MESH: &str = "\
v -1 0 -1
v 1 0 -1
v 1 0 1
v -1 0 1
v -1 2 -1
v 1 2 -1
v -0.4 0.5 -0.4
v 0.4 0.5 -0.4
v 0.4 0.5 0.4
v -0.4 0.5 0.4
f 4 3 2 1
f 1 2 6 5
f 10 9 8 7
";

/// A folder of its own for one test, removed with it.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    /// An empty folder.
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    /// A folder with `scene.toml` and its mesh.
    pub(crate) fn with_scene() -> Self {
        let folder = Self::new();
        folder.write("scene.toml", SCENE);
        folder.write("corner.obj", MESH);
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect("the test folder is writable");
    }

    /// The names of what is in the folder, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        names(self.0.path())
    }

    /// Runs the binary with these arguments, in this folder, without a terminal.
    pub(crate) fn run(&self, arguments: &[&str]) -> Run {
        self.finished(&mut self.command(arguments))
    }

    /// Runs a command in this folder to its end.
    pub(crate) fn finished(&self, command: &mut Command) -> Run {
        let output = command.current_dir(self.0.path()).output().expect("the binary starts");
        Run {
            code: output.status.code().expect("an exit code, not a signal"),
            stdout: String::from_utf8(output.stdout).expect("text on standard output"),
            stderr: String::from_utf8(output.stderr).expect("text on standard error"),
        }
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lightshaft"));
        command.args(arguments).current_dir(self.0.path()).env_remove("RUST_BACKTRACE").stdin(Stdio::null());
        command
    }
}

/// Whether the binary finds a usable Embree here; fails the test when one is required and it does not.
pub(crate) fn has_embree(folder: &Folder) -> bool {
    let doctor = folder.run(&["doctor"]);
    let is_required = std::env::var_os("LIGHTSHAFT_REQUIRE_EMBREE").is_some_and(|value| value == "1");
    assert!(doctor.code == 0 || !is_required, "Embree is required here:\n{}", doctor.stdout);
    doctor.code == 0
}

pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// What a run of the binary gave.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Run {
    /// Fails the test unless the run ended with `code` and one line `error: …` that holds `parts`.
    /// Other lines on standard error may only be warnings.
    pub(crate) fn expect_error(&self, code: i32, parts: &[&str]) {
        assert_eq!(self.code, code, "{self:?}");
        let lines: Vec<&str> = self.stderr.lines().filter(|line| !line.starts_with("warning: ")).collect();
        let [line] = lines[..] else { panic!("not one line of error: {self:?}") };
        assert!(line.starts_with("error: "), "{line}");
        for part in parts {
            assert!(line.contains(part), "'{part}' is not in: {line}");
        }
        assert_eq!(self.stdout, "", "an error belongs on standard error");
    }
}
