//! Is a solution physically right: what can be known without a reference. Links are judged by rays that
//! know nothing of them, form factors by another formula, and light by what it is made of. \[CW93\]
//!
//! Everything is sampled in the same way for any number of threads. `docs/check.md` explains every
//! finding and its limit.

mod audit;
mod carried;
mod contour;
mod factors;
mod finding;
mod flights;
mod groups;
mod judge;
mod light;
mod limits;
mod rows;
mod subject;

pub use finding::{Finding, Unit, Verdict};
pub use limits::{Limits, UNBALANCED, UNSETTLED};

use crate::hierarchy::Hierarchy;
use crate::progress::Progress;
use crate::radiosity::Solution;
use crate::tracer::Tracer;
use serde::Serialize;
use subject::Subject;

/// Light over links that are alike, as shares of all light that surfaces send out.
#[derive(Clone, Debug, Serialize)]
pub struct KindOfLink {
    /// From what to what, and how the visibility is known.
    pub name: String,
    /// What the links carry.
    pub linked: f64,
    /// What rays carry between the same nodes.
    pub found: f64,
}

/// The answer.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    /// Links, then form factors, then light.
    pub findings: Vec<Finding>,
    /// Where the light goes.
    pub kinds: Vec<KindOfLink>,
}

impl Check {
    /// Whether nothing failed.
    pub fn passed(&self) -> bool {
        self.findings.iter().all(|finding| finding.verdict != Verdict::Failed)
    }
}

/// Steps that report to the progress.
const STEPS: u64 = 7;

/// Checks a solution, against the limits of the quality it was computed with.
pub fn check(
    hierarchy: &Hierarchy,
    tracer: &dyn Tracer,
    solution: &Solution,
    limits: &Limits,
    progress: &dyn Progress,
) -> Check {
    progress.start("check", STEPS);
    let subject = &Subject::new(hierarchy, tracer, solution);
    let flights = flights::flights(subject, flights::RAYS);
    progress.advance(1);
    let audit = audit::audit(subject, &flights);
    progress.advance(1);
    let balance = light::Balance::of(subject, &flights);
    let mut findings = judge::links(subject, &audit, &balance, limits);
    progress.advance(1);
    findings.extend(judge::factors(subject, &balance, limits));
    progress.advance(1);
    findings.extend(judge::row_sums(subject, limits));
    progress.advance(1);
    findings.extend(judge::elements(subject));
    progress.advance(1);
    findings.extend(judge::power(subject, &balance, limits));
    progress.finish();
    let kinds = audit.kinds.iter().map(|(kind, power)| KindOfLink {
        name: judge::name(*kind),
        linked: balance.share(power.linked),
        found: balance.share(power.found),
    });
    Check { findings, kinds: kinds.collect() }
}
