//! From what was measured to findings: each value beside its limit, with the worst place.

use super::audit::{Audit, Kind, Power};
use super::factors;
use super::finding::Finding;
use super::flights::RAYS;
use super::groups;
use super::light::{self, Balance};
use super::limits::{LOST, Limits, PROOF, RECIPROCITY, REFLECTION, RESIDUAL, UNOBSTRUCTED, UNSETTLED};
use super::rows::{self, Sums};
use super::subject::Subject;
use crate::radiosity::Link;

const LINKS: &str = "links";
const FACTORS: &str = "form factors";
const LIGHT: &str = "light";

/// The name of a kind of link, or of pairs that no link covers.
pub(super) fn name(kind: Option<Kind>) -> String {
    kind.map_or_else(|| "no link".to_owned(), |kind| kind.to_string())
}

/// What the audit found.
pub(super) fn links(
    subject: &Subject<'_>,
    audit: &Audit,
    balance: &Balance,
    limits: &Limits,
) -> Vec<Finding> {
    let off = |power: &Power| balance.share(power.linked - power.found);
    let unlinked = audit.kinds.get(&None).map_or(0.0, |power| balance.share(power.found));
    let by_kind: f64 = audit.kinds.values().map(|power| off(power).abs()).sum();
    let worst = audit.kinds.iter().max_by(|a, b| off(a.1).abs().total_cmp(&off(b.1).abs()));
    let worst = worst.map(|(kind, power)| format!("{}: {:+.2} %", name(*kind), 100.0 * off(power)));
    let doubled = audit.doubled.map(|(receiver, source)| {
        let [to, from] = [receiver, source].map(|leaf| subject.place(leaf));
        format!("to {to} from {from}")
    });
    let proofs = factors::against_proofs(subject);
    let disproved =
        proofs.worst.map(|link| format!("{:.1} % {}", 100.0 * proofs.largest, subject.places(&link)));
    vec![
        Finding::none(LINKS, "pairs of elements with several links", audit.twice).of(audit.pairs).at(doubled),
        Finding::share(LINKS, "light between pairs without a link", unlinked, limits.unlinked)
            .of(audit.pairs)
            .unless_rough(limits),
        Finding::share(LINKS, "light lost or made by kind of link", by_kind, limits.by_kind)
            .of(audit.pairs)
            .unless_rough(limits)
            .at(worst),
        Finding::share(LINKS, "proved visible, yet blocked", proofs.mean(), PROOF)
            .of(proofs.count)
            .at(disproved),
    ]
}

/// Range, exactness and reciprocity of form factors.
pub(super) fn factors(subject: &Subject<'_>, balance: &Balance, limits: &Limits) -> Vec<Finding> {
    let all = subject.solution.links.links.len() as u64;
    let described = |link: Option<Link>| {
        link.map(|link| format!("{:.3e} × {:.3} {}", link.factor, link.visibility, subject.places(&link)))
    };
    let (signs, above_one) = (factors::signs(subject), factors::above_one(subject));
    let beyond = factors::beyond_unobstructed(subject);
    let contours = factors::against_contours(subject);
    let (relative, power) = (contours.relative, contours.power);
    let reverse = factors::against_reverse(subject);
    vec![
        Finding::none(FACTORS, "negative or no number", signs.count).of(all).at(described(signs.one)),
        Finding::none(FACTORS, "above 1 between elements", above_one.count)
            .of(all)
            .at(described(above_one.one)),
        Finding::share(FACTORS, "light beyond the unobstructed", balance.share(beyond.sum), UNOBSTRUCTED)
            .of(all)
            .at(described(beyond.worst)),
        Finding::share(FACTORS, "against contour integrals, mean", relative.mean(), limits.factor)
            .of(relative.count)
            .unless_rough(limits)
            .at(described(relative.worst)),
        Finding::share(
            FACTORS,
            "light that one of them gets wrong",
            balance.share(power.largest),
            limits.one_factor,
        )
        .of(power.count)
        .unless_rough(limits)
        .at(described(power.worst)),
        Finding::share(FACTORS, "reciprocity, mean difference", reverse.mean(), RECIPROCITY)
            .of(reverse.count)
            .unless_rough(limits)
            .at(described(reverse.worst)),
    ]
}

/// Row sums, by themselves and against rays.
pub(super) fn row_sums(subject: &Subject<'_>, limits: &Limits) -> Vec<Finding> {
    let excess = rows::excess(subject);
    let most = (excess.largest > rows::MOST)
        .then(|| format!("{:.3} at {}", excess.largest, subject.place(excess.element)));
    let rows = rows::rows(subject);
    let (count, sums) = (rows.len() as u64, Sums::of(&rows));
    let worst = rows.iter().max_by(|a, b| a.off().abs().total_cmp(&b.off().abs())).map(|row| {
        let place = subject.place(row.element);
        format!("{:.3} for {:.3} at {place}", row.linked, row.found)
    });
    let means = (count > 0).then(|| format!("mean {:.4} for {:.4}", sums.linked, sums.found));
    vec![
        Finding::share(FACTORS, "row sums above 1.05, mean excess", excess.mean, limits.balance)
            .of(subject.leaves.len() as u64)
            .unless_rough(limits)
            .at(most)
            .telling(),
        Finding::share(FACTORS, "row sums against rays", (sums.linked - sums.found).abs(), limits.row_sum)
            .of(count)
            .unless_rough(limits)
            .at(means)
            .telling(),
        Finding::share(FACTORS, "row sums of single elements", sums.deviation, limits.single_row)
            .of(count)
            .unless_rough(limits)
            .at(worst)
            .telling(),
    ]
}

/// Light of single elements.
pub(super) fn elements(subject: &Subject<'_>) -> Vec<Finding> {
    let found = light::elements(subject);
    let count = subject.leaves.len() as u64;
    let place = |leaf: Option<u32>| leaf.map(|leaf| subject.place(leaf));
    vec![
        Finding::none(LIGHT, "exitance negative or no number", found.not_finite)
            .of(count)
            .at(place(found.one_not_finite)),
        Finding::none(LIGHT, "darker than its emission", found.darker).of(count).at(place(found.one_darker)),
        Finding::share(LIGHT, "exitance against irradiance", found.reflection, REFLECTION)
            .of(count)
            .at(place(found.one_reflection)),
    ]
}

/// Where all light goes.
pub(super) fn power(subject: &Subject<'_>, balance: &Balance, limits: &Limits) -> Vec<Finding> {
    let spread = groups::spread(subject);
    let worst_group =
        spread.worst.map(|(off, element)| format!("{:+.1} % around {}", 100.0 * off, subject.place(element)));
    let residual = light::residual(subject);
    let count = subject.leaves.len() as u64;
    let energy = subject.solution.energy;
    let about_balance = format!(
        "{:+.2} % of the emitted light lost; {:.1} % of all light escapes",
        100.0 * balance.lost() / balance.emitted.max(f64::MIN_POSITIVE),
        100.0 * balance.share(balance.escaped)
    );
    let lost = energy.lost().abs() / energy.emitted.max(f64::MIN_POSITIVE);
    let changing = energy.error / energy.emitted.max(f64::MIN_POSITIVE);
    vec![
        Finding::share(LIGHT, "irradiance against links", balance.share(residual.changing), RESIDUAL)
            .of(count),
        Finding::share(LIGHT, "held back by row sums", balance.share(residual.withheld), limits.balance)
            .of(count)
            .unless_rough(limits)
            .at(residual.most_withheld.map(|leaf| subject.place(leaf))),
        Finding::share(LIGHT, "energy balance", balance.share(balance.lost().abs()), limits.balance)
            .of(RAYS as u64)
            .unless_rough(limits)
            .at(Some(about_balance)),
        Finding::share(LIGHT, "light on groups of surfaces", spread.deviation, limits.group)
            .of(spread.count)
            .unless_rough(limits)
            .at(worst_group)
            .telling(),
        Finding::share(LIGHT, "emitted light lost or made", lost, LOST).of(count),
        Finding::share(LIGHT, "still changing", changing, UNSETTLED).of(count),
    ]
}
