//! How a solution was made, for those who find its file later.

use crate::radiosity::SolveOptions;
use serde::{Deserialize, Serialize};
use std::fmt;

/// How a solution was made. The light does not depend on any of it any more.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Version of lightshaft.
    pub program: String,
    /// `embree` or `fallback`.
    pub tracer: String,
    /// `draft`, `normal` or `high`.
    pub quality: String,
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
    /// Made by this program with these options; `quality` and `tracer` by name.
    pub fn new(options: &SolveOptions, quality: &str, tracer: &str) -> Origin {
        Origin {
            program: env!("CARGO_PKG_VERSION").to_owned(),
            tracer: tracer.to_owned(),
            quality: quality.to_owned(),
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
        [&self.program, &self.tracer, &self.quality, &self.strategy].iter().all(|name| is_name(name))
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Origin { program, tracer, quality, strategy, epsilon, rays, .. } = self;
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
