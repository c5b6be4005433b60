//! The checked configuration of a profile.

use std::path::PathBuf;

use super::super::args::{ProfileArgs, TracerArg, VisibilityArg};
use super::super::errors::CliError;
use super::{Preset, RunConfig, SolveConfig, check_distinct, check_extension, usage};
use crate::radiosity::Record;

/// Everything a profile needs to know.
#[derive(Clone, Debug)]
pub(in crate::cli) struct ProfileConfig {
    /// With the settings of the aim.
    pub(in crate::cli) run: RunConfig,
    pub(in crate::cli) tracers: Vec<TracerArg>,
    pub(in crate::cli) settings: Vec<SolveConfig>,
    /// Which of the settings the others have to be as exact as.
    pub(in crate::cli) aim: usize,
    pub(in crate::cli) repeats: u32,
    /// Points, and the reference there.
    pub(in crate::cli) reference: Option<(PathBuf, PathBuf)>,
    pub(in crate::cli) samples: u32,
    pub(in crate::cli) json: Option<PathBuf>,
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
        check_extension("--json", typed.json.as_deref(), "json")?;
        check_extension("--plot", typed.plot.as_deref(), "svg")?;
        check_extension("--trace", typed.trace.as_deref(), "json")?;
        check_extension("--html", typed.html.as_deref(), "html")?;
        let outputs = [&typed.json, &typed.plot, &typed.trace, &typed.html].map(Option::as_ref);
        let inputs = [Some(&typed.scene), typed.points.as_ref(), typed.reference.as_ref()];
        check_distinct(&[&inputs[..], &outputs[..]].concat())?;
        let certify = typed.exactness.certify;
        if certify && typed.strategies.contains(&VisibilityArg::Sampled) {
            return usage("--certify needs proofs, and the strategy sampled makes none");
        }
        let strategies = match typed.strategies.is_empty() {
            true => STRATEGIES.into_iter().filter(|&s| !(certify && s == VisibilityArg::Sampled)).collect(),
            false => each_once(typed.strategies),
        };
        let preset = Preset::of(typed.exactness.quality);
        let is_typed = !typed.rays.is_empty();
        let rays = if is_typed { each_once(typed.rays) } else { rays_with(preset.rays) };
        let aim = rays.iter().position(|&rays| !is_typed && rays == preset.rays).unwrap_or(0);
        let tracers = each_once(typed.tracers);
        let settings: Vec<SolveConfig> = strategies
            .iter()
            .flat_map(|&strategy| rays.iter().map(move |&rays| (strategy, rays)))
            .map(|(strategy, rays)| SolveConfig {
                record: Record::Steps,
                ..SolveConfig::with(&typed.exactness, &preset, Some(rays), strategy)
            })
            .collect();
        let Some(first) = settings.get(aim).cloned() else { return usage("--strategies is empty") };
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
            quiet: typed.print.quiet,
        };
        Ok(Self {
            run,
            tracers,
            settings,
            aim,
            repeats: typed.repeat,
            reference: typed.points.zip(typed.reference),
            samples: typed.samples,
            json: typed.json,
            plot: typed.plot,
            trace: typed.trace,
            html: typed.html,
        })
    }
}

/// What is compared where nothing is typed.
const STRATEGIES: [VisibilityArg; 3] = [VisibilityArg::Adaptive, VisibilityArg::Root, VisibilityArg::Sampled];

/// Numbers of rays that are compared where none is typed: so far apart that each strategy comes near to the error of
/// another, and those of the quality.
fn rays_with(own: u32) -> Vec<u32> {
    let mut rays = each_once(vec![4, 16, 64, own]);
    rays.sort_unstable();
    rays
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
