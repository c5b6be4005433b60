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
mod light;
mod limits;
mod rows;
mod subject;

pub use finding::{Finding, Unit, Verdict};
pub use limits::Limits;

use crate::hierarchy::Hierarchy;
use crate::progress::Progress;
use crate::radiosity::{Link, Solution};
use crate::tracer::Tracer;
use limits::{PROOF, RECIPROCITY, REFLECTION, RESIDUAL, UNOBSTRUCTED, UNSETTLED};
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
    let flights = flights::flights(subject);
    progress.advance(1);
    let audit = audit::audit(subject, &flights);
    progress.advance(1);
    let balance = light::Balance::of(subject, &flights);
    let mut findings = links(subject, &audit, &balance, limits);
    progress.advance(1);
    findings.extend(factors(subject, &balance, limits));
    progress.advance(1);
    findings.extend(row_sums(subject, limits));
    progress.advance(1);
    findings.extend(elements(subject));
    progress.advance(1);
    findings.extend(power(subject, &balance, limits));
    progress.finish();
    let share = |power: f64| power / balance.sent.max(f64::MIN_POSITIVE);
    let kinds = audit.kinds.iter().map(|(kind, power)| KindOfLink {
        name: kind.map_or_else(|| "no link".to_owned(), |kind| kind.to_string()),
        linked: share(power.linked),
        found: share(power.found),
    });
    Check { findings, kinds: kinds.collect() }
}

const LINKS: &str = "links";
const FACTORS: &str = "form factors";
const LIGHT: &str = "light";

fn links(
    subject: &Subject<'_>,
    audit: &audit::Audit,
    balance: &light::Balance,
    limits: &Limits,
) -> Vec<Finding> {
    let sent = balance.sent.max(f64::MIN_POSITIVE);
    let off = |power: &audit::Power| power.linked - power.found;
    let unlinked = audit.kinds.get(&None).map_or(0.0, |power| power.found);
    let by_kind: f64 = audit.kinds.values().map(|power| off(power).abs()).sum();
    let worst = audit.kinds.iter().max_by(|a, b| off(a.1).abs().total_cmp(&off(b.1).abs()));
    let proofs = factors::against_proofs(subject);
    let doubled = audit.doubled.map(|(to, from)| {
        format!("to {} from {}", subject.place(to), subject.place(from)) //
    });
    vec![
        Finding::none(LINKS, "pairs of elements with several links", audit.twice, audit.pairs, doubled),
        Finding::exact(
            LINKS,
            "light between pairs without a link",
            unlinked / sent,
            limits.unlinked,
            audit.pairs,
        )
        .unless_rough(limits.is_binding),
        Finding::exact(
            LINKS,
            "light lost or made by kind of link",
            by_kind / sent,
            limits.by_kind,
            audit.pairs,
        )
        .unless_rough(limits.is_binding)
        .at(worst.map(|(kind, power)| {
            let name = kind.map_or_else(|| "no link".to_owned(), |kind| kind.to_string());
            format!("{name}: {:+.2} %", 100.0 * off(power) / sent)
        })),
        Finding::exact(LINKS, "proved visible, yet blocked", proofs.mean, PROOF, proofs.count)
            .at(proofs.worst.map(|link| subject.places(&link))),
    ]
}

fn factors(subject: &Subject<'_>, balance: &light::Balance, limits: &Limits) -> Vec<Finding> {
    let sent = balance.sent.max(f64::MIN_POSITIVE);
    let all = subject.solution.links.links.len() as u64;
    let described = |link: Option<Link>| {
        link.map(|link| {
            let Link { factor, visibility, .. } = link;
            format!("{factor:.3e} × {visibility:.3} {}", subject.places(&link))
        })
    };
    let (signs, above_one) = (factors::signs(subject), factors::above_one(subject));
    let beyond = factors::beyond_unobstructed(subject);
    let contours = factors::against_contours(subject);
    let reverse = factors::against_reverse(subject);
    vec![
        Finding::none(FACTORS, "negative or no number", signs.count, all, described(signs.one)),
        Finding::none(FACTORS, "above 1 between elements", above_one.count, all, described(above_one.one)),
        Finding::exact(
            FACTORS,
            "light beyond the unobstructed",
            beyond.mean * beyond.count as f64 / sent,
            UNOBSTRUCTED,
            beyond.count,
        )
        .at(described(beyond.worst)),
        Finding::exact(
            FACTORS,
            "against contour integrals, mean",
            contours.relative.mean,
            limits.factor,
            contours.relative.count,
        )
        .unless_rough(limits.is_binding)
        .at(described(contours.relative.worst)),
        Finding::exact(
            FACTORS,
            "light that one of them gets wrong",
            contours.power.largest / sent,
            limits.one_factor,
            contours.power.count,
        )
        .unless_rough(limits.is_binding)
        .at(described(contours.power.worst)),
        Finding::exact(
            FACTORS,
            "reciprocity, largest difference",
            reverse.largest,
            RECIPROCITY,
            reverse.count,
        )
        .at(described(reverse.worst)),
    ]
}

fn row_sums(subject: &Subject<'_>, limits: &Limits) -> Vec<Finding> {
    let excess = rows::excess(subject);
    let rows = rows::rows(subject);
    let count = rows.len() as u64;
    let mean = |of: fn(&rows::Row) -> f64| rows.iter().map(of).sum::<f64>() / count.max(1) as f64;
    let (linked, found) = (mean(|row| row.linked), mean(|row| row.found));
    let off = |row: &rows::Row| (row.linked - row.found).abs();
    let worst = rows.iter().max_by(|a, b| off(a).total_cmp(&off(b)));
    vec![
        Finding::exact(
            FACTORS,
            "row sums above 1, mean excess",
            excess.mean,
            limits.row_excess,
            subject.leaves.len() as u64,
        )
        .unless_rough(limits.is_binding)
        .at((excess.largest > 1.0)
            .then(|| format!("{:.3} at {}", excess.largest, subject.place(excess.element)))),
        Finding::exact(FACTORS, "row sums against rays", (linked - found).abs(), limits.row_sum, count)
            .unless_rough(limits.is_binding)
            .at(worst.map(|row| {
                format!(
                    "mean {linked:.4} for {found:.4}; {:.3} for {:.3} at {}",
                    row.linked,
                    row.found,
                    subject.place(row.element)
                )
            })),
    ]
}

fn elements(subject: &Subject<'_>) -> Vec<Finding> {
    let found = light::elements(subject);
    let count = subject.leaves.len() as u64;
    let place = |leaf: Option<u32>| leaf.map(|leaf| subject.place(leaf));
    vec![
        Finding::none(LIGHT, "exitance negative or no number", found.not_finite, count, place(found.one_not_finite)),
        Finding::none(LIGHT, "darker than its emission", found.darker, count, place(found.one_darker)),
        Finding::exact(LIGHT, "exitance against irradiance", found.reflection, REFLECTION, count)
            .at(place(found.one_reflection)),
    ]
}

fn power(subject: &Subject<'_>, balance: &light::Balance, limits: &Limits) -> Vec<Finding> {
    let sent = balance.sent.max(f64::MIN_POSITIVE);
    let residual = light::residual(subject);
    let count = subject.leaves.len() as u64;
    let energy = subject.solution.energy;
    let emitted = balance.emitted.max(f64::MIN_POSITIVE);
    vec![
        Finding::exact(LIGHT, "irradiance against links", residual.changing / sent, RESIDUAL, count),
        Finding::exact(LIGHT, "held back by row sums", residual.withheld / sent, limits.withheld, count)
            .unless_rough(limits.is_binding)
            .at(residual.most_withheld.map(|leaf| subject.place(leaf))),
        Finding::exact(
            LIGHT,
            "energy balance",
            balance.lost().abs() / sent,
            limits.balance,
            flights::RAYS as u64,
        )
        .unless_rough(limits.is_binding)
        .at(Some(format!(
            "{:+.2} % of the emitted light lost; {:.1} % of all light escapes",
            100.0 * balance.lost() / emitted,
            100.0 * balance.escaped / sent
        ))),
        Finding::exact(
            LIGHT,
            "still changing",
            energy.error / energy.emitted.max(f64::MIN_POSITIVE),
            UNSETTLED,
            1,
        ),
    ]
}
