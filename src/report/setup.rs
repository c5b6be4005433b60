//! What a run was made with, so that it can be made again; pages and records have it.

use serde::Serialize;

/// What a run was made with.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Setup {
    /// Version of lightshaft.
    pub lightshaft: String,
    /// Version of Embree and its instruction set, such as `4.4.0 (AVX2)`; none where it was not used.
    pub embree: Option<String>,
    /// As typed, in a form that a shell takes.
    pub command: String,
    /// The scene and the settings.
    pub values: Vec<Setting>,
}

/// What one setting was, for people.
#[derive(Clone, Debug, Serialize)]
pub struct Setting {
    /// What was set.
    pub name: &'static str,
    /// To what.
    pub value: String,
}

impl Setting {
    /// Of this name.
    pub fn new(name: &'static str, value: impl Into<String>) -> Setting {
        Setting { name, value: value.into() }
    }
}
