//! What a run is made with, as its page tells it.

use std::borrow::Cow;
use std::ffi::OsString;

use super::config::RunConfig;
use super::solved::Loaded;
use crate::hierarchy::Hierarchy;
use crate::report::html::Setup;
use crate::scene::Camera;
use crate::visibility::Strategy;

/// Versions, the scene and the settings, whatever the verb. Files are named as they were typed.
pub(super) fn setup(config: &RunConfig, loaded: &Loaded, hierarchy: &Hierarchy) -> Setup {
    let solve = &config.solve;
    let embree = loaded.embree_version().unwrap_or_else(|| "not used".to_owned());
    let min_size = solve.min_size.map_or_else(
        || format!("from the size of the rooms, {} elements across two walls", solve.resolution),
        |size| format!("{size} scene units"),
    );
    let sides = if solve.one_sided { "their front" } else { "both sides" };
    let values = vec![
        ("lightshaft", env!("CARGO_PKG_VERSION").to_owned()),
        ("Embree", embree),
        ("system", format!("{} on {}", std::env::consts::OS, std::env::consts::ARCH)),
        ("threads", rayon::current_num_threads().to_string()),
        ("scene", format!("{}, {}", loaded.scene.name, config.scene.display())),
        ("geometry", format!("fingerprint {:016x}", hierarchy.mesh.fingerprint())),
        ("triangles", loaded.scene.counts.triangles_initial.to_string()),
        ("epsilon", solve.epsilon.to_string()),
        ("contrast of shadows", solve.contrast.to_string()),
        ("smallest element", min_size),
        ("most iterations", solve.iterations.to_string()),
        ("inherited", if solve.certify { "proofs only" } else { "proofs and samples" }.to_owned()),
        ("surfaces reflect from", sides.to_owned()),
    ];
    Setup { command: command_line(std::env::args_os()), values }
}

/// How visibility is decided, where it is the same for all that is solved.
pub(super) fn visibility(config: &RunConfig) -> [(&'static str, String); 2] {
    let strategy = Strategy::from(config.solve.strategy).name();
    [("visibility", strategy.to_owned()), ("rays for a pair", config.solve.rays.to_string())]
}

/// What is seen.
pub(super) fn view(camera: &Camera, samples: u32) -> [(&'static str, String); 2] {
    let size = format!("{}, {} × {} pixels", camera.name, camera.width, camera.height);
    [("camera", size), ("samples per pixel", samples.to_string())]
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
    format!("'{}'", word.replace('\'', r"'\''")).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_the_words_that_were_typed() {
        let typed =
            ["/home/me/bin/lightshaft", "compare", "my room.toml", "it's", "", "$(x)", "--rays=4", "a<b>"];
        let line = command_line(typed.iter().map(OsString::from));
        assert_eq!(line, r"lightshaft compare 'my room.toml' 'it'\''s' '' '$(x)' --rays=4 'a<b>'");
    }
}
