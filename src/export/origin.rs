//! How a solution was made, for those who find its file later.

use crate::radiosity::{Record, SolveOptions};
use crate::scene::MaterialChange;
use crate::unfinished::folder_of;
use crate::visibility::{Strategy, VisibilityOptions};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::{Component, Path};

/// How exact a solution is meant to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// For a first look.
    Draft,
    /// For pictures.
    Normal,
    /// For references.
    High,
}

impl Quality {
    /// As it is stored.
    pub fn name(self) -> &'static str {
        match self {
            Quality::Draft => "draft",
            Quality::Normal => "normal",
            Quality::High => "high",
        }
    }
}

/// How a solution was made. The light does not depend on any of it any more, but on what was changed in the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Version of lightshaft.
    pub program: String,
    /// `embree` or `fallback`.
    pub tracer: String,
    /// What sets the options that were not given.
    pub quality: Quality,
    /// `all`, `root`, `shaft`, `adaptive` or `sampled`.
    pub strategy: String,
    /// See [`SolveOptions::epsilon`].
    pub epsilon: f64,
    /// See [`SolveOptions::contrast`].
    pub contrast: f64,
    /// See [`SolveOptions::min_size`].
    pub min_size: Option<f64>,
    /// See [`SolveOptions::resolution`].
    pub resolution: f64,
    /// Visibility rays for a pair.
    pub rays: u32,
    /// Most iterations.
    pub iterations: u32,
    /// Whether only proved visibility was inherited.
    pub certify: bool,
    /// The file of the scene, seen from the folder of the solution file, with `/` between folders; absent where there is
    /// no such path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// The materials that are not as the files of the scene have them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<MaterialChange>,
}

/// All strategies, by whose names they are stored.
const STRATEGIES: [Strategy; 5] =
    [Strategy::All, Strategy::Root, Strategy::Shaft, Strategy::Adaptive, Strategy::Sampled];

impl Origin {
    /// Made by this program with these options; `tracer` by name.
    pub fn new(options: &SolveOptions, quality: Quality, tracer: &str) -> Origin {
        Origin {
            program: env!("CARGO_PKG_VERSION").to_owned(),
            tracer: tracer.to_owned(),
            quality,
            strategy: options.visibility.strategy.name().to_owned(),
            epsilon: options.epsilon,
            contrast: options.contrast,
            min_size: options.min_size,
            resolution: options.resolution,
            rays: options.visibility.rays,
            iterations: options.iterations,
            certify: options.visibility.certify,
            scene: None,
            changes: Vec::new(),
        }
    }

    /// The same in a solution file at `file`, of the scene at `scene`.
    pub fn at(self, file: &Path, scene: &Path) -> Origin {
        Origin { scene: seen_from(folder_of(file), scene), ..self }
    }

    /// What it was solved with; `None` for a strategy that this program does not know.
    pub fn options(&self) -> Option<SolveOptions> {
        let strategy = STRATEGIES.into_iter().find(|strategy| strategy.name() == self.strategy)?;
        Some(SolveOptions {
            epsilon: self.epsilon,
            contrast: self.contrast,
            min_size: self.min_size,
            resolution: self.resolution,
            iterations: self.iterations,
            visibility: VisibilityOptions { strategy, rays: self.rays, certify: self.certify },
            record: Record::Nothing,
        })
    }

    /// Whether every name in it is one, and can be shown as it is, and every number makes sense.
    pub(super) fn is_sound(&self) -> bool {
        let is_positive = |number: f64| number.is_finite() && number > 0.0;
        [&self.program, &self.tracer, &self.strategy].iter().all(|name| is_name(name))
            && self.scene.as_ref().is_none_or(|path| !path.contains(char::is_control))
            && self.changes.iter().all(MaterialChange::is_sound)
            && [self.epsilon, self.contrast, self.resolution].into_iter().all(is_positive)
            && self.min_size.is_none_or(is_positive)
            && (1..=MOST_RAYS).contains(&self.rays)
    }
}

/// No solution was made with more rays for a pair.
const MOST_RAYS: u32 = 1024;

/// The way from a folder to a file; `None` when there is none that text can hold.
fn seen_from(folder: &Path, file: &Path) -> Option<String> {
    let folder = folder.canonicalize().ok()?;
    // Of the file its folder only: what it names lies beside the name that was given, and not where a link leads to.
    let file = folder_of(file).canonicalize().ok()?.join(file.file_name()?);
    let [from, to] = [&folder, &file].map(|path| path.components().collect::<Vec<Component<'_>>>());
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return None;
    }
    let mut names = vec![".."; from.len() - common];
    for component in &to[common..] {
        names.push(component.as_os_str().to_str()?);
    }
    Some(names.join("/")).filter(|path| !path.contains(char::is_control))
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Origin { program, tracer, strategy, epsilon, rays, .. } = self;
        let quality = self.quality.name();
        write!(
            f,
            "solved by lightshaft {program} on {tracer}: quality {quality}, epsilon {epsilon}, {rays} rays, {strategy}"
        )?;
        match self.changes.len() {
            0 => Ok(()),
            1 => write!(f, "; relit with 1 other material"),
            count => write!(f, "; relit with {count} other materials"),
        }
    }
}

/// Short, and of characters that no terminal takes for anything else.
pub(super) fn is_name(text: &str) -> bool {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-.+_".contains(c);
    (1..=32).contains(&text.len()) && text.chars().all(is_plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_to_a_scene_goes_over_what_both_have_in_common() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("rooms/hall")).expect("folders");
        std::fs::create_dir(at("light")).expect("a folder");
        for (file, scene, expected) in [
            ("a.lsol", "room.toml", "room.toml"),
            ("light/a.lsol", "rooms/hall/scene.toml", "../rooms/hall/scene.toml"),
            ("rooms/a.lsol", "rooms/hall/scene.toml", "hall/scene.toml"),
            ("rooms/hall/a.lsol", "light/../room.toml", "../../room.toml"),
        ] {
            assert_eq!(
                seen_from(folder_of(&at(file)), &at(scene)).as_deref(),
                Some(expected),
                "{file} {scene}"
            );
        }
        assert_eq!(seen_from(folder.path(), &at("none/room.toml")), None);
        assert_eq!(seen_from(folder.path(), &at("a\nb.toml")), None);
    }
}
