//! The checked configuration of a profile.

use std::path::PathBuf;

use super::super::args::{ProfileArgs, TracerArg, VisibilityArg};
use super::super::errors::CliError;
use super::{Preset, RunConfig, SolveConfig, check_distinct, check_extension, usage};
use crate::radiosity::Record;

/// Everything a profile needs to know.
#[derive(Clone, Debug)]
pub(in crate::cli) struct ProfileConfig {
    /// With the first of the settings.
    pub(in crate::cli) run: RunConfig,
    pub(in crate::cli) tracers: Vec<TracerArg>,
    pub(in crate::cli) settings: Vec<SolveConfig>,
    pub(in crate::cli) repeats: u32,
    /// Points, and the reference there.
    pub(in crate::cli) reference: Option<(PathBuf, PathBuf)>,
    pub(in crate::cli) samples: u32,
    pub(in crate::cli) output: Option<PathBuf>,
    pub(in crate::cli) plot: Option<PathBuf>,
    pub(in crate::cli) trace: Option<PathBuf>,
    pub(in crate::cli) html: Option<PathBuf>,
}

impl ProfileConfig {
    /// Makes the settings and checks what depends on several options.
    ///
    /// # Errors
    /// [`CliError::Usage`] when options contradict each other. No file is touched.
    pub(in crate::cli) fn check(typed: ProfileArgs) -> Result<Self, CliError> {
        check_extension("--output", typed.output.as_deref(), "json")?;
        check_extension("--plot", typed.plot.as_deref(), "svg")?;
        check_extension("--trace", typed.trace.as_deref(), "json")?;
        check_extension("--html", typed.html.as_deref(), "html")?;
        let outputs = [&typed.output, &typed.plot, &typed.trace, &typed.html].map(Option::as_ref);
        let inputs = [Some(&typed.scene), typed.points.as_ref(), typed.reference.as_ref()];
        check_distinct(&[&inputs[..], &outputs[..]].concat())?;
        if typed.exactness.certify && typed.strategies.contains(&VisibilityArg::Sampled) {
            return usage("--certify needs proofs, and the strategy sampled makes none");
        }
        let preset = Preset::of(typed.exactness.quality);
        let rays = if typed.rays.is_empty() { vec![preset.rays] } else { each_once(typed.rays) };
        let tracers = each_once(typed.tracers);
        let settings: Vec<SolveConfig> = each_once(typed.strategies)
            .iter()
            .flat_map(|&strategy| rays.iter().map(move |&rays| (strategy, rays)))
            .map(|(strategy, rays)| SolveConfig {
                record: Record::Steps,
                ..SolveConfig::with(&typed.exactness, &preset, Some(rays), strategy)
            })
            .collect();
        let Some(first) = settings.first().cloned() else { return usage("--strategies is empty") };
        // Embree is looked for as the most demanding of the tracers wants it.
        let demanding = [TracerArg::Embree, TracerArg::Auto].into_iter().find(|t| tracers.contains(t));
        let run = RunConfig {
            scene: typed.scene,
            outputs: outputs.into_iter().flatten().cloned().collect(),
            solve: first,
            stored: None,
            tracer: demanding.unwrap_or(TracerArg::Fallback),
            embree_lib: typed.machine.embree_lib,
            threads: typed.machine.threads,
            quiet: typed.quiet,
        };
        Ok(Self {
            run,
            tracers,
            settings,
            repeats: typed.repeat,
            reference: typed.points.zip(typed.reference),
            samples: typed.samples,
            output: typed.output,
            plot: typed.plot,
            trace: typed.trace,
            html: typed.html,
        })
    }
}

/// What is named again is the same: the first counts.
fn each_once<T: PartialEq>(typed: Vec<T>) -> Vec<T> {
    let mut kept = Vec::with_capacity(typed.len());
    for one in typed {
        if !kept.contains(&one) {
            kept.push(one);
        }
    }
    kept
}
