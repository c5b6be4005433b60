//! The statistics of one run, as written by `--stats FILE.json`.

use crate::compare::TruthDifference;
use serde::{Deserialize, Serialize};

/// Everything counted in one run. The JSON has exactly these fields; see `docs/stats.md`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Stats {
    /// `"embree"` or `"fallback"`.
    pub tracer: String,
    /// Such as `"4.4.0"`; absent with the fallback tracer.
    pub embree_version: Option<String>,
    /// `all`, `root`, `shaft`, `adaptive` or `sampled`.
    pub strategy: String,
    /// Worker threads.
    pub threads: usize,
    /// Sizes of the scene.
    pub scene: SceneStats,
    /// Links of the final solution.
    pub links: LinkStats,
    /// Work done to decide visibility.
    pub visibility: VisibilityStats,
    /// Gather and push-pull iterations.
    pub iterations: u32,
    /// Power that still changed in the last iteration, watts.
    pub energy_error_w: f64,
    /// Where the power went.
    pub energy: EnergyStats,
    /// Pictures that were made of the solution.
    pub frames: u32,
    /// Of these a second, from the first to the last written; what is done once for all of them is not in it.
    pub frames_per_second: f64,
    /// How far the picture is from a reference; absent without one.
    pub reference: Option<TruthDifference>,
    /// How far links fit other light; of `relight` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relit: Option<RelitStats>,
    /// Elements for display; of `solve` and `relight` with `--local-pass` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub local_pass: Option<LocalPassStats>,
    /// Bytes.
    pub memory: MemoryStats,
    /// Wall-clock seconds by phase.
    pub seconds: PhaseSeconds,
}

/// Elements that light was gathered at for display.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct LocalPassStats {
    /// Elements, inner and leaf.
    pub elements: u64,
    /// What they take in memory.
    pub bytes: u64,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// How far links that are there already fit other light.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct RelitStats {
    /// Links that were not tested, since their source was dark, and had to be.
    pub untested: u64,
    /// Share of the light that comes over links which it would have divided further.
    pub coarse: f64,
    /// Share of the light that falls where there was little before.
    pub moved: f64,
    /// Rays that visibility took anew.
    pub rays_cast: u64,
}

/// Sizes of the scene.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SceneStats {
    /// Triangles in the input, after triangulation.
    pub triangles_initial: u64,
    /// Triangles of the final mesh (leaf elements, triangulated).
    pub triangles_final: u64,
    /// Surface sides that are roots of element trees.
    pub patches: u64,
    /// Elements, inner and leaf.
    pub elements: u64,
    /// Inner nodes of the hierarchy of bounding boxes.
    pub clusters: u64,
    /// Convex facets.
    pub facets: u64,
    /// Facets that lay in others, and were cut to what those leave or dropped.
    pub covered_facets: u64,
    /// Materials.
    pub materials: u64,
    /// Zero-area triangles dropped.
    pub dropped_degenerate: u64,
    /// Duplicate triangles dropped.
    pub dropped_duplicate: u64,
}

/// Links by class, and how each class is known.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct LinkStats {
    /// All pairs the refinement ended at, stored or not: `visible + invisible + partial`.
    pub total: u64,
    /// Stored: nothing in between, or a dark source that was not tested.
    pub visible: u64,
    /// Not stored: nothing gets through.
    pub invisible: u64,
    /// Stored with a fraction.
    pub partial: u64,
    /// Of `visible`: proved by an empty shaft.
    pub certified_visible: u64,
    /// Of `invisible`: proved by a single blocker.
    pub certified_invisible: u64,
    /// Links whose class was inherited from an ancestor pair.
    pub inherited: u64,
}

/// Work done to decide visibility.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct VisibilityStats {
    /// Pairs that were tested (not inherited).
    pub pairs_tested: u64,
    /// Shafts built.
    pub shafts_built: u64,
    /// Hierarchy nodes tested against shafts.
    pub nodes_tested: u64,
    /// Shafts found empty: certified visible.
    pub empty_shafts: u64,
    /// Pairs one occluder blocks: certified invisible.
    pub single_blockers: u64,
    /// Pairs found blocked by several facets in one plane together.
    pub fused_blockers: u64,
    /// Rays cast.
    pub rays_cast: u64,
    /// Rays that the configured number per pair would have cast in addition.
    pub rays_avoided: u64,
    /// Hits offered to the candidate filter.
    pub filter_calls: u64,
    /// Hits the filter rejected.
    pub filter_rejects: u64,
    /// Hits inside a shaft on something its candidates do not hold; a fault when not 0.
    pub culling_anomalies: u64,
    /// Mean number of candidate facets over non-empty shafts.
    pub candidates_mean: f64,
    /// Seconds in visibility tests, summed over threads.
    pub seconds: f64,
}

/// Where the power went, watts (sum over channels).
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct EnergyStats {
    /// Emitted by all sources.
    pub emitted_w: f64,
    /// Absorbed by surfaces.
    pub absorbed_w: f64,
    /// Left the scene.
    pub escaped_w: f64,
    /// Added to what links bring, so that none is lost; negative when taken away.
    pub corrected_w: f64,
    /// What links lose or make, before it is made up for: `|emitted + corrected − absorbed − escaped| / emitted`.
    pub balance_error: f64,
}

/// Bytes.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct MemoryStats {
    /// Peak resident set of the process.
    pub peak_rss_bytes: u64,
    /// Links.
    pub links_bytes: u64,
    /// Elements and clusters.
    pub elements_bytes: u64,
}

/// Wall-clock seconds by phase.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct PhaseSeconds {
    /// Reading and checking files.
    pub load: f64,
    /// Facets, hierarchy, tracer.
    pub build: f64,
    /// Refinement with visibility.
    pub refine: f64,
    /// Gather and push-pull.
    pub solve: f64,
    /// Pictures, with what is done once for all of them.
    pub render: f64,
    /// All of it.
    pub total: f64,
}
