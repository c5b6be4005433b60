//! How a solution was made, for those who find its file later.

use crate::radiosity::SolveOptions;
use serde::{Deserialize, Serialize};
use std::fmt;

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

/// How a solution was made. The light does not depend on any of it any more.
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
}

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
        }
    }

    /// Whether every name in it is one, and can be shown as it is.
    pub(super) fn is_sound(&self) -> bool {
        [&self.program, &self.tracer, &self.strategy].iter().all(|name| is_name(name))
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Origin { program, tracer, strategy, epsilon, rays, .. } = self;
        let quality = self.quality.name();
        write!(
            f,
            "solved by lightshaft {program} on {tracer}: quality {quality}, epsilon {epsilon}, {rays} rays, {strategy}"
        )
    }
}

/// Short, and of characters that no terminal takes for anything else.
pub(super) fn is_name(text: &str) -> bool {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-.+_".contains(c);
    (1..=32).contains(&text.len()) && text.chars().all(is_plain)
}
