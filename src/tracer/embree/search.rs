//! Where a library may be: the places, in the order in which they are tried.

use std::{
    env, fs,
    path::{Path, PathBuf},
};

use super::error::{Attempt, Origin, Refusal};

/// Names the system's loader is asked for.
#[cfg(target_os = "windows")]
const SYSTEM_NAMES: &[&str] = &["embree4.dll"];
#[cfg(target_os = "macos")]
const SYSTEM_NAMES: &[&str] = &["libembree4.4.dylib", "libembree4.dylib"];
#[cfg(not(any(target_os = "windows", target_os = "macos")))]
const SYSTEM_NAMES: &[&str] = &["libembree4.so.4", "libembree4.so"];

/// One step of the search.
#[derive(Debug)]
pub(super) enum Step {
    /// Open this file (or ask the system's loader for this name).
    Open(Origin, PathBuf),
    /// There is nothing to open here.
    Skip(Attempt),
}

/// What the search depends on, so that a test can set it without touching the process.
#[derive(Debug, Default)]
pub(super) struct Surroundings {
    pub(super) option: Option<PathBuf>,
    pub(super) variable: Option<PathBuf>,
    pub(super) embree_dir: Option<PathBuf>,
    pub(super) executable: Option<PathBuf>,
    pub(super) provisioned: Option<PathBuf>,
}

impl Surroundings {
    /// Those of this process.
    pub(super) fn of_process(option: Option<&Path>) -> Self {
        let variable = |name| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        Surroundings {
            option: option.map(Path::to_owned),
            variable: variable("LIGHTSHAFT_EMBREE_LIB"),
            embree_dir: variable("EMBREE_DIR"),
            executable: env::current_exe().ok(),
            provisioned: option_env!("LIGHTSHAFT_PROVISIONED_EMBREE").map(PathBuf::from),
        }
    }

    /// The steps in order. A library named outright (option, variable) is the only one tried: the user
    /// asked for it, and another in its place would be a silent surprise.
    pub(super) fn steps(&self) -> Vec<Step> {
        if let Some(path) = &self.option {
            return named(Origin::Option, path);
        }
        if let Some(path) = &self.variable {
            return named(Origin::Variable, path);
        }
        let mut steps = Vec::new();
        match &self.embree_dir {
            Some(folder) => {
                let folders = library_folders(folder);
                in_folders(Origin::EmbreeDir, &folder.join("lib*"), &folders, &mut steps);
            }
            None => steps.push(nothing(Origin::EmbreeDir, None, "not set")),
        }
        if let Some(folder) = self.executable.as_deref().and_then(Path::parent) {
            let folders = [folder.to_owned(), folder.join("../lib")];
            in_folders(Origin::Executable, folder, &folders, &mut steps);
        }
        match &self.provisioned {
            Some(path) if path.is_file() => steps.push(Step::Open(Origin::Provisioned, path.clone())),
            Some(path) => steps.push(nothing(Origin::Provisioned, Some(path), "the file is gone")),
            None => steps.push(nothing(Origin::Provisioned, None, "nothing was provisioned")),
        }
        steps.extend(SYSTEM_NAMES.iter().map(|name| Step::Open(Origin::System, name.into())));
        steps
    }
}

/// The file itself, the libraries in it when it is a folder, or a name for the system's loader.
fn named(origin: Origin, path: &Path) -> Vec<Step> {
    if path.is_dir() {
        let mut steps = Vec::new();
        in_folders(origin, path, &[path.to_owned()], &mut steps);
        return steps;
    }
    // A bare name in the working folder would otherwise be looked for on the system's path.
    vec![Step::Open(origin, path.canonicalize().unwrap_or_else(|_| path.to_owned()))]
}

fn nothing(origin: Origin, place: Option<&Path>, why: &'static str) -> Step {
    Step::Skip(Attempt { origin, place: place.map(Path::to_owned), refusal: Refusal::Nothing(why) })
}

/// Adds every Embree in the folders, by name, each file once however many links lead to it.
fn in_folders(origin: Origin, place: &Path, folders: &[PathBuf], steps: &mut Vec<Step>) {
    let mut files: Vec<PathBuf> = Vec::new();
    for folder in folders {
        for file in sorted_entries(folder).filter(|path| is_embree(path)) {
            let Ok(file) = file.canonicalize() else { continue };
            if !files.contains(&file) {
                files.push(file);
            }
        }
    }
    if files.is_empty() {
        steps.push(nothing(origin, Some(place), "no libembree4 is there"));
    }
    steps.extend(files.into_iter().map(|file| Step::Open(origin, file)));
}

/// `lib`, `lib64`, … and the folder of this architecture in them.
fn library_folders(root: &Path) -> Vec<PathBuf> {
    let mut folders = Vec::new();
    for folder in sorted_entries(root).filter(|path| file_name(path).starts_with("lib") && path.is_dir()) {
        let multiarch = folder.join(format!("{}-linux-gnu", env::consts::ARCH));
        folders.push(folder);
        folders.push(multiarch);
    }
    // Windows keeps its libraries with the programs.
    if cfg!(windows) {
        folders.push(root.join("bin"));
    }
    folders
}

fn sorted_entries(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let mut paths: Vec<PathBuf> =
        fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths.into_iter()
}

fn file_name(path: &Path) -> &str {
    path.file_name().and_then(|name| name.to_str()).unwrap_or_default()
}

/// `libembree4.so`, `libembree4.so.4`, `libembree4-4aef3270.so.4`, `libembree4.dylib`, `embree4.dll`.
fn is_embree(path: &Path) -> bool {
    let name = file_name(path);
    if cfg!(windows) {
        return name.eq_ignore_ascii_case("embree4.dll");
    }
    let has_suffix = if cfg!(target_os = "macos") { name.ends_with(".dylib") } else { name.contains(".so") };
    name.starts_with("libembree4") && has_suffix
}

/// The file behind a function of a loaded library, as the kernel mapped it.
#[cfg(target_os = "linux")]
pub(super) fn mapped_file(address: usize) -> Option<PathBuf> {
    let maps = fs::read_to_string("/proc/self/maps").ok()?;
    maps.lines().find_map(|line| {
        let (range, rest) = line.split_once(' ')?;
        let (start, end) = range.split_once('-')?;
        let start = usize::from_str_radix(start, 16).ok()?;
        let end = usize::from_str_radix(end, 16).ok()?;
        let path = &rest[rest.find('/')?..];
        (start..end).contains(&address).then(|| PathBuf::from(path))
    })
}

/// Not known on this system.
#[cfg(not(target_os = "linux"))]
pub(super) fn mapped_file(_address: usize) -> Option<PathBuf> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(path: &Path) {
        fs::create_dir_all(path.parent().expect("has a parent")).expect("temporary folder");
        fs::write(path, b"").expect("temporary file");
    }

    fn opened(surroundings: &Surroundings) -> Vec<(Origin, PathBuf)> {
        let open = |step| match step {
            Step::Open(origin, path) => Some((origin, path)),
            Step::Skip(_) => None,
        };
        surroundings
            .steps()
            .into_iter()
            .filter_map(open)
            .filter(|(origin, _)| *origin != Origin::System)
            .collect()
    }

    #[test]
    fn a_named_library_is_the_only_one_tried_and_the_option_comes_first() {
        let mut surroundings = Surroundings {
            option: Some("/nowhere/a.so".into()),
            variable: Some("/nowhere/b.so".into()),
            provisioned: Some("/nowhere/c.so".into()),
            ..Surroundings::default()
        };
        assert_eq!(opened(&surroundings), [(Origin::Option, "/nowhere/a.so".into())]);
        surroundings.option = None;
        assert_eq!(opened(&surroundings), [(Origin::Variable, "/nowhere/b.so".into())]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_order_is_embree_dir_executable_provisioned() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let root = folder.path().canonicalize().expect("exists");
        let expected = [
            (Origin::EmbreeDir, root.join("embree/lib/libembree4.so.4")),
            (Origin::EmbreeDir, root.join("embree/lib64/libembree4.so")),
            (Origin::Executable, root.join("app/bin/libembree4-4aef3270.so.4")),
            (Origin::Executable, root.join("app/lib/libembree4.so")),
            (Origin::Provisioned, root.join("copy/libembree4.so.4")),
        ];
        for (_, path) in &expected {
            touch(path);
        }
        // Things with similar names that are not libraries.
        touch(&root.join("app/bin/libembree4_sys.rlib"));
        touch(&root.join("app/bin/libembree3.so.3"));
        let surroundings = Surroundings {
            embree_dir: Some(root.join("embree")),
            executable: Some(root.join("app/bin/lightshaft")),
            provisioned: Some(root.join("copy/libembree4.so.4")),
            ..Surroundings::default()
        };
        assert_eq!(opened(&surroundings), expected);
    }

    #[test]
    fn every_empty_place_is_named() {
        let said: Vec<String> = Surroundings { executable: Some("/nowhere/x".into()), ..Default::default() }
            .steps()
            .into_iter()
            .filter_map(|step| match step {
                Step::Skip(attempt) => Some(attempt.to_string()),
                Step::Open(..) => None,
            })
            .collect();
        assert_eq!(
            said,
            [
                "EMBREE_DIR: not set",
                "/nowhere (beside the executable): no libembree4 is there",
                "provisioned by the build: nothing was provisioned",
            ]
        );
    }
}
