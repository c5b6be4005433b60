//! What a run is made with, as its page and its record tell it.

use std::borrow::Cow;
use std::ffi::OsString;
use std::path::Path;

use super::config::RunConfig;
use super::solved::Loaded;
use crate::export::Quality;
use crate::hierarchy::{Fingerprint, Hierarchy};
use crate::report::setup::{Setting, Setup};
use crate::scene::Camera;
use crate::visibility::Strategy;

/// Names the library where it is not typed.
const LIBRARY: &str = "LIGHTSHAFT_EMBREE_LIB";

/// Versions, the scene and the settings, whatever the verb. Files are named as they were typed.
pub(super) fn setup(config: &RunConfig, loaded: &Loaded, hierarchy: &Hierarchy) -> Setup {
    let solve = &config.solve;
    let min_size = solve.min_size.map_or_else(
        || format!("from the size of the rooms, {} elements across two walls", solve.resolution),
        |size| format!("{size} scene units"),
    );
    let sides = if solve.one_sided { "their front" } else { "both sides" };
    let fingerprint = |of: u64| format!("fingerprint {of:016x}");
    let materials = Fingerprint::of(hierarchy, loaded.scene.meters_per_unit).materials;
    let embree = loaded.embree_version();
    // An option goes before it.
    let library = std::env::var_os(LIBRARY).filter(|_| embree.is_some() && config.embree_lib.is_none());
    let library = library.map(|path| Setting::new(LIBRARY, path.to_string_lossy()));
    let values = [
        Setting::new("system", format!("{} on {}", std::env::consts::OS, std::env::consts::ARCH)),
        Setting::new("threads", rayon::current_num_threads().to_string()),
        Setting::new("scene", format!("{}, {}", loaded.scene.name, config.scene.display())),
        Setting::new("geometry", fingerprint(hierarchy.mesh.fingerprint())),
        Setting::new("materials", fingerprint(materials)),
        Setting::new("triangles", loaded.scene.counts.triangles_initial.to_string()),
        Setting::new("quality", Quality::from(solve.quality).name()),
        Setting::new("epsilon", solve.epsilon.to_string()),
        Setting::new("contrast of shadows", solve.contrast.to_string()),
        Setting::new("smallest element", min_size),
        Setting::new("most iterations", solve.iterations.to_string()),
        Setting::new("inherited", if solve.certify { "proofs only" } else { "proofs and samples" }),
        Setting::new("surfaces reflect from", sides),
    ];
    Setup {
        lightshaft: env!("CARGO_PKG_VERSION").to_owned(),
        embree,
        command: command_line(std::env::args_os()),
        values: library.into_iter().chain(values).collect(),
    }
}

/// How visibility is decided, where it is the same for all that is solved.
pub(super) fn visibility(config: &RunConfig) -> [Setting; 2] {
    let strategy = Strategy::from(config.solve.strategy).name();
    [Setting::new("visibility", strategy), Setting::new("rays for a pair", config.solve.rays.to_string())]
}

/// What is seen.
pub(super) fn view(camera: &Camera, samples: u32) -> [Setting; 2] {
    let size = format!("{}, {} × {} pixels", camera.name, camera.width, camera.height);
    [Setting::new("camera", size), Setting::new("samples per pixel", samples.to_string())]
}

/// Where light is compared with a reference, and with how many rays.
pub(super) fn reference(points: &Path, reference: &Path, samples: u32) -> [Setting; 3] {
    [
        Setting::new("points", points.display().to_string()),
        Setting::new("reference", reference.display().to_string()),
        Setting::new("rays for a point", samples.to_string()),
    ]
}

/// The command as typed, but for the place of the program.
fn command_line(typed: impl Iterator<Item = OsString>) -> String {
    let words = typed.skip(1).map(|word| quoted(&word.to_string_lossy()).into_owned());
    ["lightshaft".to_owned()].into_iter().chain(words).collect::<Vec<_>>().join(" ")
}

/// In a form that a shell reads as one word.
fn quoted(word: &str) -> Cow<'_, str> {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.into();
    }
    if !word.contains(char::is_control) {
        return format!("'{}'", word.replace('\'', r"'\''")).into();
    }
    // What cannot be shown is spelled out, byte by byte.
    let spelled = |c: char| match c {
        '\'' | '\\' => format!("\\{c}"),
        c if c.is_control() => c.to_string().bytes().map(|byte| format!("\\{byte:03o}")).collect(),
        c => c.to_string(),
    };
    format!("$'{}'", word.chars().map(spelled).collect::<String>()).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_shown_is_spelled_out() {
        let line = command_line(["lightshaft", "a\u{1b}[31m'b\\", "x\ny"].iter().map(OsString::from));
        assert_eq!(line, r"lightshaft $'a\033[31m\'b\\' $'x\012y'");
    }

    #[test]
    fn a_shell_reads_the_words_that_were_typed() {
        let typed =
            ["/home/me/bin/lightshaft", "compare", "my room.toml", "it's", "", "$(x)", "--rays=4", "a<b>"];
        let line = command_line(typed.iter().map(OsString::from));
        assert_eq!(line, r"lightshaft compare 'my room.toml' 'it'\''s' '' '$(x)' --rays=4 'a<b>'");
    }
}
